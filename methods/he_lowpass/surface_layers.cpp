// [He95, 3] places layers by a heuristic, "more where the derivative is high". The optimum is within reach: of all
// constants for an interval the value in its middle has the least error, as d falls; and where two intervals meet,
// moving the border gains nothing iff d is there the mean of both constants. So the first border decides all that
// follow, and as the last one grows with the first, bisection finds the one that ends at the support's radius. d is
// convex, so there is no other stationary point.
#include "methods/he_lowpass/surface_layers.h"

#include <algorithm>
#include <string>

#include "common/run/errors.h"

namespace voxcarve {

namespace {

constexpr std::int64_t kMostLayers = 1000;

/// The integral of |d - d(middle)| over an interval, by Simpson's rule on each half, where the sign is the same.
double step_error(const RadialFilter& filter, double from, double to) {
  constexpr int kParts = 32;  // of each half, even
  const double middle = 0.5 * (from + to);
  const double value = filter.plane_profile(middle);
  const auto integral = [&](double a, double b) {
    double sum = 0;
    for (int i = 0; i <= kParts; ++i) {
      const double factor = i == 0 || i == kParts ? 1 : (i % 2 == 1 ? 4 : 2);
      sum += factor * (filter.plane_profile(a + (b - a) * i / kParts) - value);
    }
    return sum * (b - a) / (3 * kParts);
  };
  return integral(from, middle) - integral(middle, to);
}

/// The borders after 0 that follow from the first one, up to `count`; fewer when the support ends before.
std::vector<double> borders_after(const RadialFilter& filter, double first, std::int64_t count) {
  std::vector<double> borders = {first};
  double before = 0;
  while (static_cast<std::int64_t>(borders.size()) < count) {
    const double border = borders.back();
    const double next = 2 * filter.plane_profile(border) - filter.plane_profile(0.5 * (before + border));
    if (!(next > 0)) break;
    before = border;
    borders.push_back(2 * filter.plane_distance(next) - border);
    if (borders.back() >= 1) break;
  }
  return borders;
}

}  // namespace

LayerChoice best_layers(const RadialFilter& filter, std::int64_t count) {
  double low = 0;
  double high = 1;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    const std::vector<double> borders = borders_after(filter, middle, count);
    const bool reaches_end = static_cast<std::int64_t>(borders.size()) < count || borders.back() >= 1;
    (reaches_end ? high : low) = middle;
  }
  std::vector<double> borders = borders_after(filter, low, count);
  borders.back() = 1;
  LayerChoice choice;
  double from = 0;
  for (const double to : borders) {
    choice.layers.push_back({filter.plane_profile(0.5 * (from + to)), 1, from, to});
    choice.error += step_error(filter, from, to);
    from = to;
  }
  for (SurfaceLayer& layer : choice.layers) layer.opacity = layer.iso_density / choice.layers.front().iso_density;
  return choice;
}

LayerChoice fewest_layers(const RadialFilter& filter, double bound) {
  // The error falls with the number of layers.
  std::int64_t enough = 1;
  while (enough <= kMostLayers && best_layers(filter, enough).error > bound) enough *= 2;
  std::int64_t too_few = enough / 2;
  if (enough > kMostLayers) {
    enough = kMostLayers;
    if (best_layers(filter, enough).error > bound) {
      throw ParameterError("layer_error: " + std::to_string(bound) + " takes more than " + std::to_string(kMostLayers) +
                           " layers");
    }
  }
  while (enough - too_few > 1) {
    const std::int64_t middle = (enough + too_few) / 2;
    (best_layers(filter, middle).error > bound ? too_few : enough) = middle;
  }
  return best_layers(filter, enough);
}

}  // namespace voxcarve
