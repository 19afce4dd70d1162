#include "metrics/volume.h"

#include "common/volume/betti.h"
#include "common/volume/labelling.h"

namespace voxcarve {

const std::vector<MetricColumn>& volume_columns() {
  static const std::vector<MetricColumn> kColumns = {
      {"volume.interior_voxels", "voxels", Direction::kNone, "voxels of the interior"},
      {"volume.foreground_components", "", Direction::kNone, "components of the interior, 6-connected (4 in an image)"},
      {"volume.background_components", "", Direction::kNone,
       "components of the exterior, 18-connected (8 in an image), the unbounded one included"},
      {"volume.b0", "", Direction::kNone, "components"},
      {"volume.b1", "", Direction::kNone, "tunnels (holes, in an image)"},
      {"volume.b2", "", Direction::kNone, "voids"},
  };
  return kColumns;
}

std::vector<Measurement> measure_volume(const BinaryVolume& volume, RunContext& context) {
  const BettiNumbers betti = betti_numbers(volume, context);
  return {{"volume.interior_voxels", count_interior(volume)},
          {"volume.foreground_components", betti.b0},
          {"volume.background_components", count_exterior_components(volume, Connectivity::kEdge, context)},
          {"volume.b0", betti.b0},
          {"volume.b1", betti.b1},
          {"volume.b2", betti.b2}};
}

}  // namespace voxcarve
