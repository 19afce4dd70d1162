// Volumes for the tests of the stability map and of the mortars, and what their slow twins share.
#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "common/volume/grid.h"
#include "tests/support/shapes.h"

namespace voxcarve::test {

/// Calls visit(Index3) for every voxel of [begin, end).
template <class Visit>
void for_each_voxel(const Index3& begin, const Index3& end, const Visit& visit) {
  for (std::int64_t k = begin[2]; k < end[2]; ++k)
    for (std::int64_t j = begin[1]; j < end[1]; ++j)
      for (std::int64_t i = begin[0]; i < end[0]; ++i) visit(Index3(i, j, k));
}

/// The largest integer whose square root is at most `radius`; a radius given as a root may come out a little small.
inline std::int64_t square_of(double radius) {
  return static_cast<std::int64_t>(std::floor(radius * radius * (1 + 1e-9)));
}

/// Interior and exterior changed places, within the grid.
inline BinaryVolume complement(BinaryVolume volume) {
  for (std::uint8_t& value : volume.values) value = static_cast<std::uint8_t>(1 - value);
  return volume;
}

/// The digital ball of a squared radius with `margin` voxels around it; a disk when `image`.
inline BinaryVolume digital_ball(std::int64_t reach, std::int64_t margin, bool image) {
  const std::int64_t half = static_cast<std::int64_t>(std::sqrt(static_cast<double>(reach))) + margin;
  BinaryVolume volume(frame_of({2 * half + 1, 2 * half + 1, image ? 1 : 2 * half + 1}));
  const Index3 center(half, half, image ? 0 : half);
  for_each_voxel(Index3::Zero(), volume.frame.dims, [&](const Index3& p) {
    volume(p[0], p[1], p[2]) = static_cast<std::uint8_t>((p - center).squaredNorm() <= reach);
  });
  return volume;
}

/// What the stability and the mortars are asked of.
struct StabilityCase {
  BinaryVolume volume;
  double largest = 0;
  bool outside = false;
  std::string name;
};

/// Small volumes: images, slices one voxel thick across y, rows and blocks, noise from nearly empty to nearly full and
/// unions of balls that may stick out of the grid; the border is not spared.
inline std::vector<StabilityCase> random_cases(std::uint64_t count) {
  constexpr double kFills[] = {0.01, 0.05, 0.2, 0.5, 0.8, 0.97};
  constexpr double kLargest[] = {0, 1, 1.5, 2, 2.2360679, 3, 3.7, 5, 8};
  std::vector<StabilityCase> cases;
  for (std::uint64_t seed = 0; seed < count; ++seed) {
    if (kAddressSanitizer && seed % 5 != 0) continue;  // as every case takes ten times as long
    const auto size = [&](std::uint64_t step, std::uint64_t up_to) {
      return static_cast<std::int64_t>(1 + seed * step % up_to);
    };
    Index3 dims(size(7, 6), size(5, 7), size(3, 5));
    if (seed % 3 == 0) dims = {size(7, 17), size(5, 13), 1};
    if (seed % 7 == 1) dims[1] = 1;
    StabilityCase next;
    next.volume = random_volume(dims, kFills[seed / 2 % 6], seed);
    if (seed % 2 == 1) {  // the features grow to balls
      const std::int64_t reach = static_cast<std::int64_t>(seed % 11);
      const BinaryVolume seeds = random_volume(dims, 0.04, seed);
      next.volume = BinaryVolume(frame_of(dims));
      for_each_voxel(Index3::Zero(), dims, [&](const Index3& p) {
        for_each_voxel(Index3::Zero(), dims, [&](const Index3& q) {
          if (seeds(q[0], q[1], q[2]) != 0 && (p - q).squaredNorm() <= reach) next.volume(p[0], p[1], p[2]) = 1;
        });
      });
    }
    next.largest = kLargest[seed * 5 % 9];
    if (!next.volume.frame.is_image() && next.largest > 4) next.largest = 4;  // the twin takes its time
    next.outside = seed / 3 % 2 == 1;
    next.name = "seed " + std::to_string(seed) + " largest " + std::to_string(next.largest);
    cases.push_back(std::move(next));
  }
  return cases;
}

}  // namespace voxcarve::test
