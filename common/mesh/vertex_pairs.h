// The pairs of vertices that a contraction may merge.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/mesh/triangle_soup.h"
#include "common/run/context.h"

namespace voxcarve {

/// Two different vertices of a soup, the smaller index first.
struct VertexPair {
  std::uint32_t low = 0;
  std::uint32_t high = 0;
  auto operator<=>(const VertexPair&) const = default;
};

/// The valid pairs of [GH97, 4]: the edges of the triangles, and all vertices of triangles that are nearer to each
/// other than `threshold` (strictly, so 0 finds edges only). Every pair once, in order. Points have coordinates of at
/// most the order of 1, and `threshold` is in their unit. Triangles name three different vertices each.
/// Close vertices are many: their number grows with the square of the vertices within the threshold of each other.
/// Throws ResourceError, which tells to lower the threshold, before there are more than `most` pairs, or Cancelled.
std::vector<VertexPair> find_vertex_pairs(std::span<const Point> points, std::span<const Triangle> triangles,
                                          double threshold, std::uint64_t most, RunContext& context);

}  // namespace voxcarve
