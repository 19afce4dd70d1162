// Triangle count reduction by quadric error metrics.
#pragma once

#include <cstdint>

#include "common/mesh/triangle_soup.h"
#include "common/run/context.h"

namespace voxcarve {

struct QuadricReductionOptions {
  std::int64_t triangles = 0;  ///< at most so many are left
  /// Vertex colours take part in the error [GH98]: a difference of 1 in a channel weighs as much as this share of the
  /// bounding box's diagonal. 0 reduces by shape alone and carries the colours along.
  double color_weight = 0.1;
};

/// Quadric edge collapse [GH97, GH98]: edges only, never vertex pairs; the collapsed edge becomes the point of least
/// error. An edge collapses only where the link condition holds (the surface keeps its topology), where no triangle
/// around it turns by more than a right angle or loses its area, and a boundary vertex never leaves the boundary:
/// quadrics of planes through boundary edges hold these in place, and an inner vertex goes to the boundary vertex that
/// it merges with. A surface that is not an oriented manifold is cut at its singular edges and vertices first, with a
/// notice. Triangle colours become those of the triangles that are left; vertex colours are interpolated, or optimised
/// with the position when they take part.
/// A notice says when no further edge may collapse before the count is reached: such a count costs quality, because
/// every collapse that is still allowed is made. A soup that is within the count already
/// comes back unchanged. Vertices that did not move keep their coordinates to the last bit, triangles their order. The
/// same bytes for the same input, whatever the number of threads; it takes one. Throws ParameterError for a colour
/// weight that is negative or not finite, ResourceError before exceeding the memory budget, and Cancelled.
TriangleSoup reduce_quadric(const TriangleSoup& soup, const QuadricReductionOptions& options, RunContext& context);

}  // namespace voxcarve
