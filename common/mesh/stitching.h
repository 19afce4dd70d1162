// Polygon repair: gluing the borders of a soup together.
#pragma once

#include "common/mesh/triangle_soup.h"
#include "common/run/context.h"

namespace voxcarve {

struct StitchOptions {
  double tolerance = 0;  ///< model units: borders up to so far apart are closed; 0 joins equal positions only
};

/// The polygon repair that [NT03, 3.3] puts before ray stabbing on models with cracks and interpenetrating parts:
/// merges equal positions, drops degenerate and duplicate triangles, snaps borders within the tolerance onto each
/// other, orients, cuts to a manifold, and fills the holes that are left. The result is a closed, oriented manifold,
/// and empty when every triangle was degenerate. An open sheet gets another side. Parts that cut through each other
/// stay as they are. Each step that changed something leaves a notice with its count. Colours of triangles and vertices
/// are kept where the triangles are; new triangles take a neighbour's. Throws ResourceError when it does not fit into
/// the memory budget, and Cancelled.
TriangleSoup stitch(const TriangleSoup& soup, const StitchOptions& options, RunContext& context);

}  // namespace voxcarve
