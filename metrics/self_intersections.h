// Triangles that cut through each other.
#pragma once

#include <cstdint>

#include "metrics/metric.h"

namespace voxcarve {

/// Pairs of triangles with overlapping boxes that are examined before the count is given up.
inline constexpr std::int64_t kSelfIntersectionCandidates = 100'000'000;

/// Number of pairs of triangles that intersect properly: each has corners strictly on both sides of the other's plane,
/// and they cut each other along a segment of positive length. This says nothing of indices, and leaves out every
/// contact that does not pass through: neighbours in a mesh, surfaces that were cut and touch in equal positions, folds
/// (coplanar pairs, overlapping or not), a vertex or an edge that rests on a face, edges that cross in a point.
/// Neighbours that fold through each other along a segment from a shared vertex count. Where two surfaces pass through
/// each other exactly along edges of both, no single pair does, and none is counted. Triangles without area are left
/// out. Decided with exact predicates.
///
/// Undefined, with the reason, when more than `candidate_limit` pairs of boxes overlap. Throws Cancelled.
MetricValue count_self_intersections(const TriangleSoup& soup, const RunContext& context,
                                     std::int64_t candidate_limit = kSelfIntersectionCandidates);

}  // namespace voxcarve
