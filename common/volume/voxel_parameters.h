// Parameters that every voxel method shares (DESIGN names are fixed: resolution, classifier, directions, supersampling,
// kernel).
#pragma once

#include <vector>

#include "common/run/parameters.h"
#include "common/volume/voxelize.h"

namespace voxcarve {

/// Schema lines of the voxelization of a soup.
std::vector<ParameterSpec> voxelization_parameters();

/// The options that `parameters`, of a schema with the lines above, stand for.
VoxelizeOptions voxelize_options(const Parameters& parameters);
SupersamplingOptions supersampling_options(const Parameters& parameters);

/// True when these options give densities of 0 and 1 only: one sample a voxel that no kernel spreads.
bool is_binary(const SupersamplingOptions& options);

/// Densities at the parameters' resolution. Adds notices about columns that did not vote.
DensityVolume voxelize_model_density(const TriangleSoup& soup, const Parameters& parameters, RunContext& context);

/// The voxels of a density of at least `threshold`, likewise.
BinaryVolume voxelize_model(const TriangleSoup& soup, const Parameters& parameters, double threshold,
                            RunContext& context);

}  // namespace voxcarve
