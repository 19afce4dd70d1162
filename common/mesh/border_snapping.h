// Closing the cracks of a soup: borders that lie close to each other become one.
#pragma once

#include <cstdint>

#include "common/mesh/triangle_soup.h"
#include "common/run/context.h"

namespace voxcarve {

/// What `snap_borders` changed.
struct SnapReport {
  std::int64_t merged_vertices = 0;  ///< border vertices that became one with another
  std::int64_t split_edges = 0;      ///< border edges that took up a vertex of another border (T-joints)
  bool mixes_colors = false;         ///< merged vertices had visibly different colours
};

/// The largest difference of a channel that is not visible: merging vertices whose colours differ by more mixes
/// colours.
inline constexpr float kVisibleColor = 1.0F / 16;

/// What stitching declares, snapping included but for the pairs of near vertices: copies, edge tables, fans. Measured
/// 100 to 250.
inline constexpr std::uint64_t kStitchBytesPerTriangle = 600;

/// Merges border vertices within `tolerance` (model units, more than 0) of each other, at their mean, and splits border
/// edges at vertices of other borders within `tolerance` of them, until nothing changes or four rounds are over. A
/// border is made of the edges with one triangle. Vertices that the border itself joins by a way not much longer than
/// their distance are left apart, so a finely divided border does not collapse; nor does any triangle. Triangles that
/// have no area after it stay. Takes time and memory in proportion to the pairs of border vertices within the
/// tolerance, which may be all. Throws ResourceError when their memory exceeds the budget, and Cancelled; the soup may
/// have been changed in part then.
SnapReport snap_borders(TriangleSoup& soup, double tolerance, RunContext& context);

}  // namespace voxcarve
