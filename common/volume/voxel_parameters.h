// Parameters that every voxel method shares (DESIGN names are fixed: resolution, classifier, directions).
#pragma once

#include <vector>

#include "common/run/parameters.h"
#include "common/volume/voxelize.h"

namespace voxcarve {

/// Schema lines of the voxelization of a soup.
std::vector<ParameterSpec> voxelization_parameters();

/// The options that `parameters`, of a schema with the lines above, stand for.
VoxelizeOptions voxelize_options(const Parameters& parameters);

/// Voxelizes at the parameters' resolution and adds notices about columns that did not vote.
BinaryVolume voxelize_model(const TriangleSoup& soup, const Parameters& parameters, RunContext& context);

}  // namespace voxcarve
