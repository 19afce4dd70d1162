// Closing the holes of a manifold.
#pragma once

#include <cstdint>

#include "common/mesh/triangle_soup.h"
#include "common/run/context.h"

namespace voxcarve {

/// What `fill_holes` added.
struct FillReport {
  std::int64_t holes = 0;
  std::int64_t triangles = 0;
};

/// Triangulates every hole of an oriented manifold with boundary, so that it becomes closed and stays a manifold: with
/// triangles of the least total area between the hole's own vertices, large holes piecewise; where these cannot do
/// without an edge that is there already, with a fan about their mean. New triangles are appended and coloured like a
/// triangle beside the hole. Throws Cancelled.
FillReport fill_holes(TriangleSoup& soup, RunContext& context);

}  // namespace voxcarve
