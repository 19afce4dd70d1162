// Simplification by contracting pairs of vertices, which joins and divides components.
#pragma once

#include <cstdint>
#include <functional>

#include "common/mesh/triangle_soup.h"
#include "common/run/context.h"

namespace voxcarve {

/// What the plane of a triangle weighs in the quadrics of its corners.
enum class PlaneWeight {
  kArea,    ///< the triangle's area: the result does not depend on how finely flat parts are divided
  kUniform  ///< 1, as in [GH97, 5.1]
};

/// One contraction, for whoever watches: two vertices of the input, by index, become one.
struct PairContraction {
  std::uint32_t kept = 0;  ///< the smaller index, under which the merged vertex goes on
  std::uint32_t gone = 0;
  Point point;             ///< the merged vertex, in model units
  bool inverting = false;  ///< turns or flattens a triangle
};

struct PairCollapseOptions {
  std::int64_t triangles = 0;  ///< at most so many are left
  double threshold = 0.01;     ///< share of the bounding box's diagonal: vertices that are nearer may merge
  PlaneWeight plane_weight = PlaneWeight::kArea;
  /// What a plane through a boundary edge weighs: with area weights against a triangle as large as the edge's square.
  double boundary_weight = 10;
  std::function<void(const PairContraction&)> watcher = nullptr;  ///< called before each contraction; may be empty
};

/// Simplification by contracting pairs of vertices [GH97]: the ends of an edge, or vertices that are nearer than the
/// threshold. A pair becomes the point of least error; the pair of the least error comes first.
///
/// Connectivity is by vertex index, and any soup will do. Nothing holds the topology: parts merge, tunnels close,
/// surfaces fold together and come apart, edges of three triangles and more are made. Triangles that a contraction
/// takes a corner from vanish, and of triangles with the same three vertices, whichever way round, the first is kept.
/// A vertex that no triangle uses any more takes part no longer. Where the last triangles vanish together the result is
/// empty.
///
/// A pair whose contraction would turn a triangle by a right angle or more, or take its area, waits until no other pair
/// is left. This is decided when the turn of the pair comes, and anew when one of its ends has changed.
///
/// Triangle colours stay with the triangles; a merged vertex takes the colour of the end that it is nearer to. A soup
/// that is within the count already comes back unchanged. Otherwise vertices that did not move keep their coordinates
/// to the last bit and triangles their order; unused positions are dropped. The count is always
/// met: whatever triangle is left has an edge.
///
/// The same bytes for the same input, whatever the number of threads; it takes one. The pairs within the threshold,
/// whose number is up to quadratic in the vertices, take `kPairCollapseBytesPerPair` each. Throws ParameterError for a
/// threshold or weight that is negative or not finite, ResourceError before exceeding the memory budget (naming the
/// threshold where the pairs are too many), and Cancelled.
TriangleSoup collapse_pairs(const TriangleSoup& soup, const PairCollapseOptions& options, RunContext& context);

constexpr std::uint64_t kPairCollapseBytesPerPair = 80;

}  // namespace voxcarve
