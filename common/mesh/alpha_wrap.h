// Shrink-wrapping by CGAL.
#pragma once

#include "common/mesh/triangle_soup.h"
#include "common/run/context.h"

namespace voxcarve {

/// A closed, oriented 2-manifold around a soup, free of self-intersections, at about `offset` from it; openings of less
/// than `alpha` are not entered. Both are shares of the soup's diagonal. Empty when nothing is left. Throws
/// MethodFailure when no triangle has an area or CGAL fails, ResourceError and Cancelled.
TriangleSoup alpha_wrap(const TriangleSoup& soup, double alpha, double offset, RunContext& context);

}  // namespace voxcarve
