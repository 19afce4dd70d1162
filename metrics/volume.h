// Metrics of binary volumes.
#pragma once

#include <vector>

#include "common/run/context.h"
#include "common/volume/grid.h"
#include "metrics/metric.h"

namespace voxcarve {

/// Columns of `measure_volume`, in its order.
const std::vector<MetricColumn>& volume_columns();

/// Voxels, interior and exterior components and Betti numbers of a volume or image, in the digital topology of
/// common/volume/betti.h. The interior components count 6-connected (in an image 4-connected), the exterior ones
/// 18-connected (8-connected), the unbounded one included. Keys begin with "voxels.".
std::vector<Measurement> measure_volume(const BinaryVolume& volume, RunContext& context);

}  // namespace voxcarve
