// Morphology with the Euclidean ball on volumes of one bit a voxel.
#pragma once

#include <cstdint>

#include "common/run/context.h"
#include "common/volume/bit_volume.h"

namespace voxcarve {

/// Largest squared integer distance within `distance` voxels: the test d^2 <= r^2 in exact integers. A hair is added to
/// r^2, so that distances such as sqrt(2), typed as decimals, reach what they name. Throws ParameterError below 0 and
/// above 20000 voxels.
std::int64_t squared_reach(double distance);

/// The margin that holds whatever a ball of radius `distance` adds to a grid of these dimensions: none across an image.
Index3 ball_margin(const Index3& dims, double distance);

// The ball {|x|^2 <= reach}, in voxels. Everything outside the grid is `outside`: false for a solid, true for the
// complement of one. Results lie on the grid of `volume`, cut off at its border: for what may grow beyond it, pad first
// (`packed`). An opening never does where the outside is false, and a closing of a volume padded by the ball neither.
// What they hold is told by `morphology_memory`; they throw ResourceError when that and their argument exceed the
// memory budget, or beyond a radius of 180 voxels a side 26,752 voxels.

/// Bytes that dilating or eroding a volume of these dimensions holds at once beside it, the result among them. Up to a
/// radius of r = 180 voxels that is a volume of bits and r + max(r, 16) + 1 slices of bytes, or all there are and one;
/// beyond it 5 bytes a voxel of a grid with a layer of voxels around it. Opening and closing hold another volume of
/// bits.
std::uint64_t morphology_memory(const Index3& dims, std::int64_t reach);

/// The voxels within the ball's reach of a set one.
BitVolume dilate(const BitVolume& volume, std::int64_t reach, bool outside, RunContext& context);

/// The set voxels out of reach of all others.
BitVolume erode(const BitVolume& volume, std::int64_t reach, bool outside, RunContext& context);

/// Erosion, then dilation: rounding [WR05, 3.2].
BitVolume open(const BitVolume& volume, std::int64_t reach, bool outside, RunContext& context);

/// Dilation, then erosion: filleting [WR05, 3.2].
BitVolume close(const BitVolume& volume, std::int64_t reach, bool outside, RunContext& context);

}  // namespace voxcarve
