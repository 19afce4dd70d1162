// Metrics of binary volumes and images.
#pragma once

#include <vector>

#include "common/run/context.h"
#include "common/volume/grid.h"
#include "metrics/metric.h"

namespace voxcarve {

/// Columns of `measure_volume`, in its order.
const std::vector<MetricColumn>& volume_columns();
/// Columns of `measure_volume_pair`, in its order.
const std::vector<MetricColumn>& volume_pair_columns();

/// Voxels, interior and exterior components and Betti numbers of a volume or image, in the digital topology of
/// common/volume/betti.h. The interior components count 6-connected (in an image 4-connected), the exterior ones
/// 18-connected (8-connected), the unbounded one included. With `options.regularity_radius` also how many voxels are
/// irregular for a ball of that radius [WR05, 3.3]: inner ones S - R(S), outer ones F(S) - S. Keys begin with
/// "voxels.".
std::vector<Measurement> measure_volume(const BinaryVolume& volume, const MetricOptions& options, RunContext& context);

/// The voxels that changed from `reference` to `shape`: exact, over both grids, everything outside them exterior.
/// Undefined where the grids do not share a lattice of voxels. Keys begin with "voxels.".
std::vector<Measurement> measure_volume_pair(const BinaryVolume& reference, const BinaryVolume& shape,
                                             RunContext& context);

}  // namespace voxcarve
