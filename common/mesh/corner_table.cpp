// The link condition is that of [DEGN99]: Dey, Edelsbrunner, Guha, Nekhayev, "Topology preserving edge contraction",
// for 2-manifolds with boundary, where the boundary counts as if a cone with one more vertex closed it.
#include "common/mesh/corner_table.h"

#include <algorithm>
#include <numeric>

namespace voxcarve {

namespace {

constexpr std::uint32_t kCheckInterval = 1U << 16;  // items between two looks at the cancellation

}  // namespace

std::optional<CornerTable> CornerTable::build(std::span<const Triangle> triangles, std::size_t vertices,
                                              const RunContext& context) {
  CornerTable table;
  table.faces_.resize(triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const Triangle& corner = triangles[t];
    if (corner[0] == corner[1] || corner[1] == corner[2] || corner[2] == corner[0]) return std::nullopt;
    table.faces_[t].vertex = corner;
  }
  table.live_ = static_cast<std::uint32_t>(triangles.size());
  table.leaving_.assign(vertices, kNone);
  if (!table.find_twins(context) || !table.has_one_fan_everywhere()) return std::nullopt;
  return table;
}

std::uint64_t CornerTable::memory_estimate(std::size_t triangles, std::size_t vertices) {
  constexpr std::size_t kSides = 3 * 2 * sizeof(std::uint32_t);  // of a triangle, while twins are sought
  return triangles * (sizeof(Face) + kSides) + vertices * 2 * sizeof(std::uint32_t);
}

bool CornerTable::find_twins(const RunContext& context) {
  struct Side {
    std::uint32_t end;
    std::uint32_t half_edge;
    bool operator<(const Side& other) const { return end < other.end; }
  };
  // The sides that leave each vertex, by where they end.
  std::vector<std::uint32_t> first(leaving_.size() + 1, 0);
  for (const Face& face : faces_) {
    for (const std::uint32_t vertex : face.vertex) ++first[vertex + std::size_t{1}];
  }
  std::partial_sum(first.begin(), first.end(), first.begin());
  std::vector<Side> sides(first.back());
  for (std::uint32_t t = 0; t < faces_.size(); ++t) {  // `first` runs ahead to the next vertex's and is set back below
    for (std::uint32_t c = 0; c < 3; ++c) sides[first[start(4 * t + c)]++] = {end(4 * t + c), 4 * t + c};
  }
  std::rotate(first.begin(), first.end() - 1, first.end());
  first[0] = 0;
  const auto leaving = [&](std::uint32_t vertex) {
    return std::span(sides).subspan(first[vertex], first[vertex + std::size_t{1}] - first[vertex]);
  };
  for (std::uint32_t v = 0; v < leaving_.size(); ++v) {
    if (v % kCheckInterval == 0) context.check_cancelled();
    const auto own = leaving(v);
    std::sort(own.begin(), own.end());
    for (std::size_t i = 1; i < own.size(); ++i) {
      if (own[i - 1].end == own[i].end) return false;
    }
  }
  for (std::uint32_t v = 0; v < leaving_.size(); ++v) {
    if (v % kCheckInterval == 0) context.check_cancelled();
    for (const Side& side : leaving(v)) {
      const auto others = leaving(side.end);
      const auto back = std::lower_bound(others.begin(), others.end(), Side{v, 0});
      const bool found = back != others.end() && back->end == v;
      faces_[side.half_edge >> 2].twin[side.half_edge & 3] = found ? back->half_edge : kNone;
      if (leaving_[v] == kNone || !found) leaving_[v] = side.half_edge;
    }
  }
  return true;
}

bool CornerTable::has_one_fan_everywhere() const {
  // Around each vertex one fan is counted, from a boundary edge where there is one; further fans are left over.
  std::size_t counted = 0;
  for (std::uint32_t v = 0; v < leaving_.size(); ++v) {
    if (leaving_[v] != kNone) for_each_leaving(v, [&](std::uint32_t) { ++counted; });
  }
  return counted == 3 * faces_.size();
}

void CornerTable::gather(std::uint32_t vertex, Ring& ring) const {
  ring.half_edges.clear();
  ring.neighbors.clear();
  for_each_leaving(vertex, [&](std::uint32_t half_edge) {
    ring.half_edges.push_back(half_edge);
    ring.neighbors.push_back(end(half_edge));
  });
  const std::uint32_t last = previous(ring.half_edges.back());
  if (twin(last) == kNone) ring.neighbors.push_back(start(last));
}

// Vertices common to both links must be those of the edge's own link, its apexes. An edge common to both links can only
// join the two apexes, and then both ends have three triangles: a tetrahedron. With the cone over the boundary an inner
// edge between two boundary vertices has the cone's tip in common, and the only edge that two links of a boundary
// edge's ends can share runs from that tip to the apex: a triangle on its own.
bool CornerTable::may_collapse(std::uint32_t half_edge, const Ring& at_start, const Ring& at_end) const {
  const bool boundary_edge = twin(half_edge) == kNone;
  if (boundary_edge) {
    if (twin(next(half_edge)) == kNone && twin(previous(half_edge)) == kNone) return false;
  } else {
    if (on_boundary(start(half_edge)) && on_boundary(end(half_edge))) return false;
    if (apex(half_edge) == apex(twin(half_edge))) return false;
    const auto has_three_triangles = [](const Ring& ring) {
      return ring.half_edges.size() == 3 && ring.neighbors.size() == 3;
    };
    if (has_three_triangles(at_start) && has_three_triangles(at_end)) return false;
  }
  int common = 0;
  for (const std::uint32_t neighbor : at_start.neighbors) {
    common += static_cast<int>(std::count(at_end.neighbors.begin(), at_end.neighbors.end(), neighbor));
  }
  return common == (boundary_edge ? 1 : 2);
}

void CornerTable::glue(std::uint32_t first, std::uint32_t second) {
  if (first != kNone) faces_[first >> 2].twin[first & 3] = second;
  if (second != kNone) faces_[second >> 2].twin[second & 3] = first;
}

void CornerTable::remove_triangle(std::uint32_t half_edge) {
  // The other two sides become one edge. At most one of them lies on the boundary, or the link condition failed.
  const std::uint32_t after = twin(next(half_edge));
  const std::uint32_t before = twin(previous(half_edge));
  const std::uint32_t top = apex(half_edge);
  glue(after, before);
  // `after` runs from the apex. Where it is missing, the apex's boundary leaves elsewhere.
  if (triangle_of(leaving_[top]) == triangle_of(half_edge)) leaving_[top] = after;
  faces_[half_edge >> 2].vertex[0] = kNone;
  --live_;
}

void CornerTable::collapse(std::uint32_t half_edge) {
  const std::uint32_t kept = start(half_edge);
  const std::uint32_t gone = end(half_edge);
  const std::uint32_t other = twin(half_edge);
  const bool boundary = on_boundary(kept) || on_boundary(gone);
  for_each_leaving(gone, [&](std::uint32_t h) { faces_[h >> 2].vertex[h & 3] = kept; });
  // A half-edge that leaves the merged vertex and stays: across one of the sides that run from or to it.
  const std::uint32_t into_apex = twin(previous(half_edge));
  const std::uint32_t from_apex = twin(next(half_edge));
  std::uint32_t leaving = into_apex != kNone ? into_apex : next(from_apex);
  remove_triangle(half_edge);
  if (other != kNone) remove_triangle(other);
  while (boundary && twin(leaving) != kNone) leaving = next(twin(leaving));  // clockwise
  leaving_[kept] = leaving;
  leaving_[gone] = kNone;
}

CornerTable::Moves CornerTable::compact() {
  Moves moves;
  moves.new_triangle.assign(faces_.size(), kNone);
  std::vector<std::uint32_t> new_vertex(leaving_.size(), kNone);
  moves.old_triangle.reserve(live_);
  moves.old_vertex.reserve(leaving_.size());
  for (std::uint32_t t = 0; t < faces_.size(); ++t) {
    if (removed(t)) continue;
    moves.new_triangle[t] = static_cast<std::uint32_t>(moves.old_triangle.size());
    moves.old_triangle.push_back(t);
  }
  for (std::uint32_t v = 0; v < leaving_.size(); ++v) {
    if (leaving_[v] == kNone) continue;
    new_vertex[v] = static_cast<std::uint32_t>(moves.old_vertex.size());
    moves.old_vertex.push_back(v);
  }
  for (std::size_t t = 0; t < moves.old_triangle.size(); ++t) {
    Face face = faces_[moves.old_triangle[t]];
    for (std::uint32_t& vertex : face.vertex) vertex = new_vertex[vertex];
    for (std::uint32_t& half_edge : face.twin) half_edge = moves.renamed(half_edge);
    faces_[t] = face;
  }
  for (std::size_t v = 0; v < moves.old_vertex.size(); ++v) {
    leaving_[v] = moves.renamed(leaving_[moves.old_vertex[v]]);
  }
  faces_.resize(moves.old_triangle.size());
  leaving_.resize(moves.old_vertex.size());
  return moves;
}

}  // namespace voxcarve
