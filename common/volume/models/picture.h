// Pictures of seeded noise: what the image models are painted with.
#pragma once

#include <cstdint>
#include <functional>

#include "common/volume/grid.h"

namespace voxcarve {

/// Noise that is the same on every machine: integer hashes, and doubles by + - * / alone. A layer is a noise of its
/// own, independent of the others.
class Noise {
 public:
  explicit Noise(std::uint64_t seed) : seed_(seed) {}

  /// Uniform in [-1, 1), independent for every lattice point.
  double grain(std::int64_t i, std::int64_t j, std::uint32_t layer) const;
  /// Between -1 and 1: grain at the points of the integer lattice, and smoothly in between.
  double smooth(double x, double y, std::uint32_t layer) const;
  /// Octaves of smooth noise, the first with unit period and each next of half the period and amplitude; their
  /// amplitudes add up to 1. Uses the layers layer ... layer + octaves - 1.
  double fractal(double x, double y, int octaves, std::uint32_t layer) const;

 private:
  std::uint64_t seed_;
};

/// a + share (b - a).
inline double interpolated(double a, double b, double share) {
  return a + share * (b - a);
}

/// 0 up to `low`, 1 from `high` on (low < high), and between them a cubic without kinks.
double smooth_step(double low, double high, double value);

/// An image of which the darkest pixels are interior, a share `black` of all (in [0, 1], rounded down to whole pixels;
/// of pixels equally dark the lower and then the left ones come first). `darkness` is asked for the pixel in column i
/// and row j from below, and may be any finite number.
BinaryVolume darkest_share(std::int64_t width, std::int64_t height, double black,
                           const std::function<double(std::int64_t i, std::int64_t j)>& darkness);

}  // namespace voxcarve
