// Connectivity of an oriented manifold of triangles under edge collapses.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/mesh/triangle_soup.h"
#include "common/run/context.h"

namespace voxcarve {

/// Half-edges of an oriented 2-manifold with boundary. Half-edge 4 t + c runs from corner c of triangle t to the next
/// one; its twin runs back in the neighbouring triangle. Triangles take 32 bytes and vertices 4; removing one leaves
/// its slot empty. Triangles number less than 2^30.
class CornerTable {
 public:
  static constexpr std::uint32_t kNone = 0xffffffffU;

  /// The table of the triangles over `vertices` vertices, in O(n + m log d) for m triangles with at most d at a vertex;
  /// nothing unless every edge has at most two triangles, which use it in opposite directions, the triangles at every
  /// vertex form one fan, and no triangle names a vertex twice. Throws Cancelled.
  static std::optional<CornerTable> build(std::span<const Triangle> triangles, std::size_t vertices,
                                          const RunContext& context);
  /// Bytes that `build` takes at its peak, the table included.
  static std::uint64_t memory_estimate(std::size_t triangles, std::size_t vertices);
  /// Bytes that the table holds, and what `compact` takes at most beside them.
  static std::uint64_t memory(std::size_t triangles, std::size_t vertices) {
    return triangles * sizeof(Face) + vertices * sizeof(std::uint32_t);
  }
  static std::uint64_t compact_memory(std::size_t triangles, std::size_t vertices) {
    return (triangles + vertices) * 2 * sizeof(std::uint32_t);
  }

  std::uint32_t slots() const { return static_cast<std::uint32_t>(faces_.size()); }  ///< triangles, removed ones too
  std::uint32_t triangles() const { return live_; }                                  ///< that are left
  std::uint32_t vertices() const { return static_cast<std::uint32_t>(leaving_.size()); }

  static std::uint32_t triangle_of(std::uint32_t half_edge) { return half_edge >> 2; }
  static std::uint32_t next(std::uint32_t half_edge) { return (half_edge & 3) == 2 ? half_edge - 2 : half_edge + 1; }
  static std::uint32_t previous(std::uint32_t half_edge) {
    return (half_edge & 3) == 0 ? half_edge + 2 : half_edge - 1;
  }

  bool removed(std::uint32_t triangle) const { return faces_[triangle].vertex[0] == kNone; }
  Triangle corners(std::uint32_t triangle) const { return faces_[triangle].vertex; }
  std::uint32_t start(std::uint32_t half_edge) const { return faces_[half_edge >> 2].vertex[half_edge & 3]; }
  std::uint32_t end(std::uint32_t half_edge) const { return start(next(half_edge)); }
  std::uint32_t apex(std::uint32_t half_edge) const { return start(previous(half_edge)); }
  /// kNone at the boundary.
  std::uint32_t twin(std::uint32_t half_edge) const { return faces_[half_edge >> 2].twin[half_edge & 3]; }
  /// The smaller of a half-edge and its twin, which stands for the edge.
  std::uint32_t edge_of(std::uint32_t half_edge) const {
    const std::uint32_t other = twin(half_edge);
    return other < half_edge ? other : half_edge;
  }
  /// A byte that the user of the table may keep at a half-edge; 0 at first.
  std::uint8_t& mark(std::uint32_t half_edge) { return faces_[half_edge >> 2].mark[half_edge & 3]; }

  /// A half-edge that starts at the vertex; of a boundary vertex the one without a twin. kNone when no triangle uses
  /// it.
  std::uint32_t leaving(std::uint32_t vertex) const { return leaving_[vertex]; }
  bool on_boundary(std::uint32_t vertex) const { return twin(leaving_[vertex]) == kNone; }

  /// Calls visit(half_edge) for the half-edges that start at the vertex, counterclockwise. A boundary vertex has one
  /// more edge, `previous` of the last of them.
  template <class Visit>
  void for_each_leaving(std::uint32_t vertex, Visit&& visit) const {
    const std::uint32_t first = leaving_[vertex];
    std::uint32_t half_edge = first;
    do {
      const std::uint32_t following = twin(previous(half_edge));
      visit(half_edge);
      half_edge = following;
    } while (half_edge != first && half_edge != kNone);
  }

  /// Calls visit(edge_of(half_edge)) for every edge at the vertex.
  template <class Visit>
  void for_each_edge(std::uint32_t vertex, Visit&& visit) const {
    std::uint32_t last = kNone;
    for_each_leaving(vertex, [&](std::uint32_t half_edge) {
      visit(edge_of(half_edge));
      last = previous(half_edge);
    });
    if (twin(last) == kNone) visit(last);
  }

  /// The half-edges that start at a vertex, and the vertices next to it.
  struct Ring {
    std::vector<std::uint32_t> half_edges;
    std::vector<std::uint32_t> neighbors;
  };
  void gather(std::uint32_t vertex, Ring& ring) const;

  /// The link condition [DEGN99]: collapsing the edge leaves a manifold of the same topology, boundary loops included.
  /// `at_start` and `at_end` are what `gather` finds there.
  bool may_collapse(std::uint32_t half_edge, const Ring& at_start, const Ring& at_end) const;

  /// Merges the half-edge's end into its start and removes the triangles at the edge. The link condition must hold.
  void collapse(std::uint32_t half_edge);

  /// Closes the gaps that removed triangles and vertices leave; those that are left keep their order and marks.
  struct Moves {
    std::vector<std::uint32_t> old_triangle;  ///< by slot: where its triangle was before
    std::vector<std::uint32_t> old_vertex;
    std::vector<std::uint32_t> new_triangle;  ///< by slot before: where its triangle is, kNone if removed
    /// A half-edge's new number, kNone if its triangle was removed.
    std::uint32_t renamed(std::uint32_t half_edge) const {
      if (half_edge == kNone || new_triangle[half_edge >> 2] == kNone) return kNone;
      return 4 * new_triangle[half_edge >> 2] + (half_edge & 3);
    }
  };
  Moves compact();

 private:
  struct alignas(32) Face {
    Triangle vertex;
    std::array<std::uint8_t, 4> mark{};
    std::array<std::uint32_t, 3> twin;
  };

  CornerTable() = default;
  bool find_twins(const RunContext& context);
  bool has_one_fan_everywhere() const;
  void glue(std::uint32_t first, std::uint32_t second);
  void remove_triangle(std::uint32_t half_edge);

  std::vector<Face> faces_;
  std::vector<std::uint32_t> leaving_;  ///< by vertex
  std::uint32_t live_ = 0;
};

}  // namespace voxcarve
