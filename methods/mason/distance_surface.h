// Surfaces of filtered volumes from the distance field of the filter's last step.
#pragma once

#include <cstdint>

#include "common/volume/grid.h"
#include "methods/mason/regular_filters.h"

namespace voxcarve {

/// A field, in voxels, that is positive exactly on the filter's result and 0 where the ball of the last step ends
/// [WR05, 6 and Fig. 8]: of a dilation r - d(X), of an erosion d(complement of X) - r, with the exact distance d to
/// voxel centres, so that a rounding is a union of balls. Where Mason takes RF or FR it is theirs, and outside the
/// mortar whichever is nearer to 0. `frame` has the dimensions of `shape`, which is padded as RegularFilters asks and
/// lies in an exterior. Holds 8 bytes a voxel, of Mason 12, and a few bits,
/// and declares them with `held`, the bytes that are held meanwhile, `shape` among them.
Grid<float> distance_field(const BitVolume& shape, const GridFrame& frame, std::int64_t reach,
                           MorphologicalFilter filter, TieRule tie, std::uint64_t held, RunContext& context);

}  // namespace voxcarve
