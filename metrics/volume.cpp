#include "metrics/volume.h"

#include "common/volume/betti.h"
#include "common/volume/labelling.h"

namespace voxcarve {

const std::vector<MetricColumn>& volume_columns() {
  static const std::vector<MetricColumn> kColumns = {
      {"voxels.interior", "voxels", Direction::kNone, "voxels of the interior"},
      {"voxels.foreground_components", "", Direction::kNone, "components of the interior, 6-connected (4 in an image)"},
      {"voxels.background_components", "", Direction::kNone,
       "components of the exterior, 18-connected (8 in an image), the unbounded one included"},
      {"voxels.b0", "", Direction::kNone, "components"},
      {"voxels.b1", "", Direction::kNone, "tunnels (holes, in an image)"},
      {"voxels.b2", "", Direction::kNone, "voids"},
  };
  return kColumns;
}

std::vector<Measurement> measure_volume(const BinaryVolume& volume, RunContext& context) {
  const BettiNumbers betti = betti_numbers(volume, context);
  return {{"voxels.interior", count_interior(volume)},
          {"voxels.foreground_components", betti.b0},
          {"voxels.background_components", count_exterior_components(volume, Connectivity::kEdge, context)},
          {"voxels.b0", betti.b0},
          {"voxels.b1", betti.b1},
          {"voxels.b2", betti.b2}};
}

}  // namespace voxcarve
