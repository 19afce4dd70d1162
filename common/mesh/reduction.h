// Triangle count reduction.
#pragma once

#include <cstdint>

#include "common/mesh/triangle_soup.h"
#include "common/run/context.h"

namespace voxcarve {

/// Quadric edge collapse [GH97] to at most `triangles` triangles: edges only, never vertex pairs;
/// an edge is collapsed onto one of its ends, only where the link condition holds (the surface keeps its topology) and
/// no triangle around it turns by more than a right angle or loses its area. OpenMesh's decimater with its quadric
/// module; a surface that is not an oriented manifold is cut at its singular edges and vertices first, with a notice.
/// Colours are dropped. A notice says when no further edge may collapse before the count is reached. A soup that is
/// within the count already comes back unchanged. Throws Cancelled.
TriangleSoup reduce_openmesh(const TriangleSoup& soup, std::int64_t triangles, RunContext& context);

}  // namespace voxcarve
