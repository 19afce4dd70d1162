// Lattice ("value") noise in octaves, as common in computer graphics since Perlin, "An Image Synthesizer", 1985. The
// lattice values come from the finaliser of Steele et al., "Fast Splittable Pseudorandom Number Generators", 2014.
#include "common/volume/models/picture.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

namespace voxcarve {

namespace {

std::uint64_t mixed(std::uint64_t bits) {
  bits = (bits ^ (bits >> 30U)) * 0xbf58476d1ce4e5b9U;
  bits = (bits ^ (bits >> 27U)) * 0x94d049bb133111ebU;
  return bits ^ (bits >> 31U);
}

}  // namespace

double Noise::grain(std::int64_t i, std::int64_t j, std::uint32_t layer) const {
  constexpr std::uint64_t kGolden = 0x9e3779b97f4a7c15U;  // 2^64 over the golden ratio
  std::uint64_t bits = mixed(seed_ + kGolden * (std::uint64_t{layer} + 1));
  bits = mixed(bits + kGolden * static_cast<std::uint64_t>(i));
  bits = mixed(bits + kGolden * static_cast<std::uint64_t>(j));
  return static_cast<double>(bits >> 11U) * 0x1p-52 - 1;
}

double Noise::smooth(double x, double y, std::uint32_t layer) const {
  const double left = std::floor(x);
  const double low = std::floor(y);
  const auto i = static_cast<std::int64_t>(left);
  const auto j = static_cast<std::int64_t>(low);
  const double across = smooth_step(0, 1, x - left);
  const double up = smooth_step(0, 1, y - low);
  return interpolated(interpolated(grain(i, j, layer), grain(i + 1, j, layer), across),
                      interpolated(grain(i, j + 1, layer), grain(i + 1, j + 1, layer), across), up);
}

double Noise::fractal(double x, double y, int octaves, std::uint32_t layer) const {
  double sum = 0;
  double amplitudes = 0;
  double amplitude = 1;
  for (int octave = 0; octave < octaves; ++octave) {
    sum += amplitude * smooth(x, y, layer + static_cast<std::uint32_t>(octave));
    amplitudes += amplitude;
    amplitude /= 2;
    x *= 2;
    y *= 2;
  }
  return sum / amplitudes;
}

double smooth_step(double low, double high, double value) {
  const double share = std::clamp((value - low) / (high - low), 0.0, 1.0);
  return share * share * (3 - 2 * share);
}

BinaryVolume darkest_share(std::int64_t width, std::int64_t height, double black,
                           const std::function<double(std::int64_t i, std::int64_t j)>& darkness) {
  BinaryVolume image(GridFrame{.dims = {width, height, 1}});
  std::vector<double> grey;
  grey.reserve(image.values.size());
  for (std::int64_t j = 0; j < height; ++j) {
    for (std::int64_t i = 0; i < width; ++i) grey.push_back(darkness(i, j));
  }
  std::vector<std::uint32_t> order(grey.size());
  std::iota(order.begin(), order.end(), 0U);
  const auto count = static_cast<std::ptrdiff_t>(black * static_cast<double>(grey.size()));
  std::ranges::nth_element(order, order.begin() + count, [&](std::uint32_t a, std::uint32_t b) {
    return grey[a] != grey[b] ? grey[a] > grey[b] : a < b;
  });
  std::for_each(order.begin(), order.begin() + count, [&](std::uint32_t pixel) { image.values[pixel] = 1; });
  return image;
}

}  // namespace voxcarve
