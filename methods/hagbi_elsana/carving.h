// The order in which a complement is carved.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "common/run/context.h"
#include "methods/hagbi_elsana/complement.h"

namespace voxcarve {

/// What a tetrahedron is carved early for [HE10, 4].
enum class CarvingPriority {
  kLongestEdge,       ///< a long edge; what the paper's results use
  kVolume,            ///< much volume
  kCircumradiusRatio  ///< a small circumradius for its shortest edge: the round before the skinny
};
enum class DepthMeasure {
  kLevel,    ///< 1 next to the hull, else one more than the tetrahedron that exposed it
  kDistance  ///< 1 + distance of the centroid from the hull in mean edge lengths
};

struct CarvingOptions {
  CarvingPriority priority = CarvingPriority::kLongestEdge;
  double depth_power = 0;  ///< dp of [HE10, eq. 2]: priorities are divided by depth^dp
  DepthMeasure depth_measure = DepthMeasure::kLevel;
  double breadth = 0;        ///< bp of [HE10, 5.4], model units: a step carves all within so far of its centroid
  bool exposed = true;       ///< carve at once what has two faces or more on the outside [HE10, 3.4]
  double smallest_void = 0;  ///< cubed model units; smaller voids are left shut
};

/// What carving says of itself, beside the order.
struct CarvingReport {
  std::uint32_t shut_voids = 0;
  /// Snaking [HE10, 5.1]: mean over carved tetrahedra of the depth in levels by which each was reached, over the least
  /// number of tetrahedra from the hull to it; 1 where no way is a detour.
  double snaking = 1;
  /// Spiking [HE10, 5.2]: share of the carved tetrahedra that had one face on the outside and are deeper behind it than
  /// twice that face's longest edge.
  double spiking = 0;
};

/// A never carved tetrahedron's step.
inline constexpr std::uint32_t kNeverCarved = 0xffffffffU;

/// The step that carves each tetrahedron: 0 for ghosts, from 1 on in the order in which the queue gives them; what goes
/// at once has the same step. kNeverCarved for voids left shut. Equal priorities go by number.
/// Takes O(s log s) for s tetrahedra with a breadth of 0. Throws Cancelled.
std::vector<std::uint32_t> carve(const Complement& complement, const std::vector<Void>& voids,
                                 const CarvingOptions& options, RunContext& context, CarvingReport* report = nullptr);

}  // namespace voxcarve
