// Painting balls one over the other, where the first one counts.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/run/context.h"
#include "common/volume/bit_volume.h"
#include "common/volume/grid.h"

namespace voxcarve {

/// The voxels {|x - center|^2 <= reach}, a disk on an image; the center may lie outside the grid.
struct Ball {
  std::array<std::int32_t, 3> center{};
  std::int32_t reach = 0;  ///< squared radius in voxels
};

/// Gives every voxel of `blank` the reach of the first of `balls` that contains it, after which it is no longer blank;
/// `values` of other voxels, and of those that lie in no ball, are left alone. Exact, and the same on any number of
/// threads. A ball costs about as much as the blank voxels near it, however large it is.
void paint_balls(const std::vector<Ball>& balls, BitVolume& blank, Grid<std::int32_t>& values, RunContext& context);

/// Bytes that painting holds beside its arguments, for balls of squared radii up to `largest_reach`.
std::uint64_t paint_balls_memory(const Index3& dims, std::int32_t largest_reach);

}  // namespace voxcarve
