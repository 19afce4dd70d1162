// What the indices of a soup say about its surface: edges, components, boundary, genus, and cutting into a manifold.
// Connectivity is by vertex index throughout: nothing is welded, since surfaces that were cut on purpose touch in equal
// positions. A triangle that names a vertex twice is no piece of surface; it is left out and counted apart.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/mesh/triangle_soup.h"
#include "common/run/context.h"

namespace voxcarve {

/// True when a triangle names three different vertices.
inline bool has_distinct_corners(const Triangle& triangle) {
  return triangle[0] != triangle[1] && triangle[1] != triangle[2] && triangle[2] != triangle[0];
}

/// Disjoint sets of 0 .. n-1. The representative of a set is its smallest element.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count);
  std::uint32_t find(std::uint32_t item);
  void join(std::uint32_t first, std::uint32_t second);

 private:
  std::vector<std::uint32_t> parent_;
};

/// One side of a triangle: `corner` c is the side from corner c to corner c + 1 (mod 3). `forward` when it runs from
/// the edge's smaller vertex index to the larger one.
struct EdgeUse {
  std::uint32_t triangle = 0;
  std::uint8_t corner = 0;
  bool forward = false;
};

/// The undirected edges of a soup with the triangles around each, ordered by (low, high); the uses of an edge are in
/// the order of the triangles. Takes O(n + m log d) for m triangles with at most d at a vertex.
class EdgeTable {
 public:
  /// Throws Cancelled when the run that it belongs to, if any, is.
  explicit EdgeTable(const TriangleSoup& soup, const RunContext* run = nullptr);

  std::size_t size() const { return low_.size(); }
  std::uint32_t low(std::size_t edge) const { return low_[edge]; }    ///< smaller vertex index
  std::uint32_t high(std::size_t edge) const { return high_[edge]; }  ///< larger vertex index
  std::span<const EdgeUse> uses(std::size_t edge) const {
    return std::span(uses_).subspan(first_[edge], first_[edge + 1] - first_[edge]);
  }
  /// Uses from low to high minus uses from high to low: the edge's coefficient in the boundary of the soup as a chain.
  std::int64_t signed_incidence(std::size_t edge) const;

 private:
  std::vector<std::uint32_t> low_;
  std::vector<std::uint32_t> high_;
  std::vector<std::size_t> first_;  ///< size() + 1 offsets into uses_
  std::vector<EdgeUse> uses_;
};

/// Cuts a soup into an oriented manifold with boundary, the cutting of [GTLH98, 4]: triangles stay glued at an edge iff
/// exactly these two use it, in opposite directions; a vertex becomes one copy for every fan of triangles so joined.
/// Copies are numbered in order of first use, triangles keep their order, and triangles that name a vertex twice are
/// dropped. Vertex and triangle colours are kept. In the result every edge has at most two triangles, which use it in
/// opposite directions, and the link of every vertex is one path or one cycle. A manifold comes back as it was, apart
/// from the order of vertices and unused ones. Throws Cancelled when the run that it belongs to, if any, is.
TriangleSoup cut_to_manifold(const TriangleSoup& soup, const RunContext* run = nullptr);

/// Bytes that `cut_to_manifold` takes at most beside `soup`, its result included: when every triangle comes off.
std::uint64_t cut_memory_estimate(const TriangleSoup& soup);

/// The part of a surface that is connected through shared vertices.
struct ComponentTopology {
  std::int64_t vertices = 0;
  std::int64_t edges = 0;
  std::int64_t triangles = 0;
  std::int64_t boundary_edges = 0;
  std::int64_t nonmanifold_edges = 0;
  std::int64_t nonmanifold_vertices = 0;
  bool oriented = true;    ///< no edge is used twice in one direction
  bool orientable = true;  ///< becomes oriented by flipping triangles
  /// Defined for a closed orientable 2-manifold; `genus_reason` says why it is not.
  std::optional<std::int64_t> genus;
  std::string genus_reason;

  std::int64_t euler_characteristic() const { return vertices - edges + triangles; }
};

/// Counts of a whole surface. Those of an empty one are zero, and it is closed and oriented.
struct SurfaceTopology {
  std::int64_t vertices = 0;  ///< used by triangles
  std::int64_t edges = 0;
  std::int64_t triangles = 0;            ///< with three different vertices
  std::int64_t collapsed_triangles = 0;  ///< that name a vertex twice; they take part in nothing else here
  std::int64_t components = 0;           ///< of triangles connected through shared vertices
  bool closed = true;                    ///< every edge has exactly two triangles
  bool oriented = true;                  ///< no edge is used more than once in either direction
  std::int64_t boundary_edges = 0;       ///< with exactly one triangle
  /// Closed chains of boundary edges. A chain goes on around the fan of triangles at a vertex, so fans that touch in
  /// one vertex have chains of their own.
  std::int64_t boundary_loops = 0;
  std::int64_t nonmanifold_edges = 0;  ///< with three triangles or more
  /// Vertices whose link is not one path or one cycle; the ends of every non-manifold edge are among them.
  std::int64_t nonmanifold_vertices = 0;
  std::int64_t euler_characteristic = 0;  ///< vertices - edges + triangles
  /// Sum over the components, defined where each of them is a closed orientable 2-manifold; else `genus_reason` says
  /// which condition failed.
  std::optional<std::int64_t> genus;
  std::string genus_reason;

  std::vector<ComponentTopology> component_list;     ///< in the order of their first triangles
  std::vector<std::uint32_t> component_of_triangle;  ///< index into component_list; kNoComponent for collapsed ones

  static constexpr std::uint32_t kNoComponent = 0xffffffffU;
};

/// Topology of a soup by its indices, in O(n + m log d).
SurfaceTopology analyze_topology(const TriangleSoup& soup);

}  // namespace voxcarve
