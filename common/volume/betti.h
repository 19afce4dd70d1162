// Betti numbers of binary volumes.
#pragma once

#include <cstdint>

#include "common/run/context.h"
#include "common/volume/grid.h"

namespace voxcarve {

struct BettiNumbers {
  std::int64_t b0 = 0;  ///< components
  std::int64_t b1 = 0;  ///< tunnels (holes, in an image)
  std::int64_t b2 = 0;  ///< voids
  bool operator==(const BettiNumbers&) const = default;
};

/// Betti numbers in the digital topology that the isosurface realises: the interior is 6-connected and the exterior
/// 18-connected (in an image 4 and 8), everything outside the grid is exterior. A volume and its isosurface agree on
/// them.
BettiNumbers betti_numbers(const BinaryVolume& volume, RunContext& context);

/// Euler characteristic b0 - b1 + b2 by counting cells: voxel centres, edges, squares and cubes of interior voxels, and
/// one more for every 2 x 2 x 2 block whose only exterior voxels are two opposite ones, which 18-connectivity keeps
/// apart (the interior closes between them).
std::int64_t euler_characteristic(const BinaryVolume& volume, const RunContext& context);

}  // namespace voxcarve
