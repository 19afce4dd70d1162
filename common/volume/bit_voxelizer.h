// `voxelize` with one bit a voxel, for all who need no bytes.
#pragma once

#include "common/volume/bit_volume.h"
#include "common/volume/voxelize.h"

namespace voxcarve {

/// Throws InputError for a grid without voxels.
void require_voxels(const GridFrame& frame);

/// What `voxelize` returns, as bits, without a stage of its own. `frame` has voxels. `held` are the bytes that the
/// caller holds or is about to hold beside the volume, for the declaration of memory.
BitVolume voxelize_bits(const TriangleSoup& soup, const GridFrame& frame, const VoxelizeOptions& options,
                        std::uint64_t held, Stage& stage, RunContext& context, VoxelizeReport* report);

/// The items of progress that it advances its stage by.
std::int64_t voxelization_items(const TriangleSoup& soup, const GridFrame& frame, const VoxelizeOptions& options);

}  // namespace voxcarve
