// Distance transforms: exact Euclidean, Danielsson's, and which feature is the nearest.
#pragma once

#include <cstdint>
#include <limits>

#include "common/run/context.h"
#include "common/volume/grid.h"

namespace voxcarve {

/// Squared distance, in voxels, of a voxel from which no feature can be reached.
inline constexpr std::int32_t kInfiniteDistance = std::numeric_limits<std::int32_t>::max();

/// Squared Euclidean distance in voxels from every voxel centre to the nearest feature voxel's centre: the voxels with
/// value `feature` (0 or 1). Features outside the grid are not seen; pad first where they matter. Exact in integers.
/// Throws ResourceError when a side is longer than 26,754 voxels or the result and `volume`, 5 bytes a voxel together,
/// exceed the memory budget. Separable lower envelopes of parabolas, one axis after the other [MRH00]: linear
/// in the number of voxels.
Grid<std::int32_t> squared_distance(const BinaryVolume& volume, std::uint8_t feature, RunContext& context);

/// The same by Danielsson's four-point sequential mapping [Dan80], in three dimensions as [NT03, 4] runs it: integer
/// vectors to a feature are handed on from neighbour to neighbour, upward and downward through rows and slices. Never
/// less than the exact distance, and at about one voxel in a thousand a little more: in the plane up to 6 - sqrt(32) =
/// 0.343 voxels where three features lie just so (the papers' 0.29 holds for far away features only), in space the
/// largest error found is sqrt(54) - sqrt(48) = 0.420. Strictly sequential, so on one thread. Takes grids of up to
/// 26,754 voxels a side and 2^32 - 1 in all, beyond which it throws ResourceError, and holds 4 bytes a voxel.
Grid<std::int32_t> squared_distance_4sed(const BinaryVolume& volume, std::uint8_t feature, RunContext& context);

/// The map that morphology thresholds.
enum class DistanceMap { kExact, kDanielsson4sed };

/// The index of the nearest feature voxel to every voxel (a feature transform), kNoFeature where there is none. Of
/// equally near ones a fixed one is taken. Exact; limits and memory as above.
inline constexpr std::uint32_t kNoFeature = std::numeric_limits<std::uint32_t>::max();
Grid<std::uint32_t> nearest_feature(const BinaryVolume& volume, std::uint8_t feature, RunContext& context);

}  // namespace voxcarve
