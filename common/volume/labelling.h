// Connected components of binary volumes.
#pragma once

#include <cstdint>

#include "common/run/context.h"
#include "common/volume/grid.h"

namespace voxcarve {

/// Neighbours of a voxel by the largest number of coordinates in which they differ: 6, 18 or 26 of them (in an image,
/// 4, 8 and 8).
enum class Connectivity { kFace = 1, kEdge = 2, kVertex = 3 };

/// Components of the voxels with value `value`.
struct Labelling {
  Grid<std::int32_t> labels;  ///< 0 for other voxels, else 1 ... count, numbered by first voxel
  std::int32_t count = 0;
};

/// Labels the components of {volume == value} within the grid; `value` is 0 or 1. run_labelling.h gives them without a
/// grid of labels.
Labelling label_components(const BinaryVolume& volume, std::uint8_t value, Connectivity connectivity,
                           RunContext& context);

/// Components of the interior.
std::int64_t count_interior_components(const BinaryVolume& volume, Connectivity connectivity, RunContext& context);

/// Components of the exterior, the unbounded one with everything outside the grid included.
std::int64_t count_exterior_components(const BinaryVolume& volume, Connectivity connectivity, RunContext& context);

}  // namespace voxcarve
