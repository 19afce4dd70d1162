// From a soup of triangles that share vertices to an oriented manifold.
#pragma once

#include <cstdint>

#include "common/mesh/triangle_soup.h"
#include "common/run/context.h"

namespace voxcarve {

/// What `orient` changed.
struct OrientReport {
  std::int64_t turned = 0;     ///< triangles
  std::int64_t one_sided = 0;  ///< edges across which no orientation agrees, as on a Moebius strip
};

/// Turns triangles so that neighbours across edges of two triangles agree. Patches that agree already stay as they are;
/// of the others each takes the side that encloses a positive volume, or that most of its triangles take where it
/// encloses none. Throws Cancelled.
OrientReport orient(TriangleSoup& soup, RunContext& context);

/// What `glue_to_manifold` met.
struct GlueReport {
  std::int64_t crowded_edges = 0;  ///< edges of three triangles and more
  std::int64_t copied_vertices = 0;
};

/// Cuts a soup into an oriented manifold with boundary as `cut_to_manifold` does, but keeps triangles together at edges
/// of three and more: around such an edge each triangle is glued to the next one behind it, across what they enclose
/// together. So solids that touch in an edge stay closed and come apart. Edges that two pairs of triangles still share
/// after that get a vertex in their middle for each pair. Throws Cancelled.
GlueReport glue_to_manifold(TriangleSoup& soup, RunContext& context);

}  // namespace voxcarve
