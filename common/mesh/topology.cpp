// Cutting follows [GTLH98, 4]: Gueziec, Taubin, Lazarus, Horn, "Converting sets of polygons to manifold surfaces by
// cutting and stitching", local method. It differs in that inconsistently oriented neighbours are cut apart too, so
// that the result is oriented, and that nothing is stitched again.
#include "common/mesh/topology.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace voxcarve {

DisjointSets::DisjointSets(std::size_t count) : parent_(count) {
  std::iota(parent_.begin(), parent_.end(), 0U);
}

std::uint32_t DisjointSets::find(std::uint32_t item) {
  while (parent_[item] != item) {
    parent_[item] = parent_[parent_[item]];
    item = parent_[item];
  }
  return item;
}

void DisjointSets::join(std::uint32_t first, std::uint32_t second) {
  const std::uint32_t a = find(first);
  const std::uint32_t b = find(second);
  parent_[std::max(a, b)] = std::min(a, b);
}

namespace {

constexpr std::size_t kCheckEvery = 4096;  // triangles, vertices or edges

/// Looks for cancellation at some of the steps of a loop.
void poll(const RunContext* run, std::size_t step) {
  if (run != nullptr && step % kCheckEvery == 0) run->check_cancelled();
}

/// A side of a triangle on its way into an EdgeTable.
struct SideRecord {
  std::uint32_t high;
  EdgeUse use;
};

constexpr std::uint32_t next_corner(std::uint32_t corner) {
  return corner == 2 ? 0 : corner + 1;
}

/// The corner of `triangle` that lies at `vertex`, as an index 3 * triangle + corner.
std::uint32_t corner_at(const TriangleSoup& soup, std::uint32_t triangle, std::uint32_t vertex) {
  const Triangle& t = soup.triangles[triangle];
  return 3 * triangle + (t[0] == vertex ? 0U : t[1] == vertex ? 1U : 2U);
}

/// Joins the corners of two triangles at both ends of an edge that they share.
void join_across(DisjointSets& corners, const TriangleSoup& soup, const EdgeTable& edges, std::size_t edge,
                 std::uint32_t first, std::uint32_t second) {
  for (const std::uint32_t vertex : {edges.low(edge), edges.high(edge)}) {
    corners.join(corner_at(soup, first, vertex), corner_at(soup, second, vertex));
  }
}

}  // namespace

EdgeTable::EdgeTable(const TriangleSoup& soup, const RunContext* run) {
  // Bucket the sides by their smaller vertex, then sort each bucket: stable, so uses stay in triangle order.
  std::vector<std::size_t> bucket(soup.positions.size() + 1, 0);
  const auto for_each_side = [&soup, run](auto&& visit) {
    for (std::uint32_t t = 0; t < soup.triangles.size(); ++t) {
      poll(run, t);
      const Triangle& triangle = soup.triangles[t];
      if (!has_distinct_corners(triangle)) continue;
      for (std::uint8_t c = 0; c < 3; ++c) visit(triangle[c], triangle[next_corner(c)], t, c);
    }
  };
  for_each_side([&](std::uint32_t from, std::uint32_t to, std::uint32_t, std::uint8_t) {
    ++bucket[std::min(from, to) + std::size_t{1}];
  });
  std::partial_sum(bucket.begin(), bucket.end(), bucket.begin());
  std::vector<SideRecord> records(bucket.back());
  std::vector<std::size_t> fill(bucket.begin(), bucket.end() - 1);
  for_each_side([&](std::uint32_t from, std::uint32_t to, std::uint32_t t, std::uint8_t c) {
    records[fill[std::min(from, to)]++] = {std::max(from, to), {t, c, from < to}};
  });
  std::size_t edges = 0;
  const auto begins_edge = [&](std::size_t vertex, std::size_t record) {
    return record == bucket[vertex] || records[record].high != records[record - 1].high;
  };
  for (std::size_t v = 0; v + 1 < bucket.size(); ++v) {
    poll(run, v);
    std::sort(records.begin() + static_cast<std::ptrdiff_t>(bucket[v]),
              records.begin() + static_cast<std::ptrdiff_t>(bucket[v + 1]),
              [](const SideRecord& a, const SideRecord& b) {
                return a.high != b.high ? a.high < b.high : a.use.triangle < b.use.triangle;
              });
    for (std::size_t r = bucket[v]; r < bucket[v + 1]; ++r) edges += begins_edge(v, r) ? 1 : 0;
  }
  low_.reserve(edges);
  high_.reserve(edges);
  first_.reserve(edges + 1);
  uses_.reserve(records.size());
  for (std::size_t v = 0; v + 1 < bucket.size(); ++v) {
    poll(run, v);
    for (std::size_t r = bucket[v]; r < bucket[v + 1]; ++r) {
      if (begins_edge(v, r)) {
        low_.push_back(static_cast<std::uint32_t>(v));
        high_.push_back(records[r].high);
        first_.push_back(uses_.size());
      }
      uses_.push_back(records[r].use);
    }
  }
  first_.push_back(uses_.size());
}

std::int64_t EdgeTable::signed_incidence(std::size_t edge) const {
  std::int64_t sum = 0;
  for (const EdgeUse& use : uses(edge)) sum += use.forward ? 1 : -1;
  return sum;
}

// Why the result is a manifold: a corner has two sides, each glued to at most one other corner, so the corners of a
// copy form one path or cycle, along which orientation carries on. An edge that is glued has two triangles. An edge
// that is not glued ends paths at both of its vertices; a path has two ends, one leaving and one arriving, so between
// two copies at most one triangle runs in each direction.
TriangleSoup cut_to_manifold(const TriangleSoup& soup, const RunContext* run) {
  DisjointSets corners(3 * soup.triangles.size());
  {
    const EdgeTable edges(soup, run);
    for (std::size_t e = 0; e < edges.size(); ++e) {
      poll(run, e);
      const auto uses = edges.uses(e);
      if (uses.size() != 2 || uses[0].forward == uses[1].forward) continue;
      join_across(corners, soup, edges, e, uses[0].triangle, uses[1].triangle);
    }
  }
  const auto for_each_corner = [&](auto&& visit) {
    for (std::uint32_t t = 0; t < soup.triangles.size(); ++t) {
      poll(run, t);
      if (!has_distinct_corners(soup.triangles[t])) continue;
      for (std::uint32_t c = 0; c < 3; ++c) visit(t, c);
    }
  };
  std::size_t vertices = 0;
  for_each_corner([&](std::uint32_t t, std::uint32_t c) { vertices += corners.find(3 * t + c) == 3 * t + c ? 1 : 0; });
  TriangleSoup result;
  result.triangles.reserve(soup.triangles.size());
  result.positions.reserve(vertices);
  if (!soup.vertex_colors.empty()) result.vertex_colors.reserve(vertices);
  if (!soup.triangle_colors.empty()) result.triangle_colors.reserve(soup.triangles.size());
  std::vector<std::uint32_t> copy(3 * soup.triangles.size());  // at a class's smallest corner: its vertex
  Triangle triangle{};
  for_each_corner([&](std::uint32_t t, std::uint32_t c) {
    const std::uint32_t corner = 3 * t + c;
    const std::uint32_t representative = corners.find(corner);
    if (representative == corner) {  // the smallest corner of its class comes first
      copy[corner] = static_cast<std::uint32_t>(result.positions.size());
      result.positions.push_back(soup.positions[soup.triangles[t][c]]);
      if (!soup.vertex_colors.empty()) result.vertex_colors.push_back(soup.vertex_colors[soup.triangles[t][c]]);
    }
    triangle[c] = copy[representative];
    if (c < 2) return;
    result.triangles.push_back(triangle);
    if (!soup.triangle_colors.empty()) result.triangle_colors.push_back(soup.triangle_colors[t]);
  });
  return result;
}

std::uint64_t cut_memory_estimate(const TriangleSoup& soup) {
  const std::uint64_t corners = 3 * soup.triangles.size();  // as many sides, edges and vertices at most
  const std::uint64_t edge_table =
      corners * (sizeof(EdgeUse) + 2 * sizeof(std::uint32_t) + sizeof(std::size_t) + sizeof(SideRecord)) +
      (soup.positions.size() + 1) * 2 * sizeof(std::size_t);
  const std::uint64_t vertex = sizeof(Point) + (soup.vertex_colors.empty() ? 0 : sizeof(Color));
  const std::uint64_t triangle = sizeof(Triangle) + (soup.triangle_colors.empty() ? 0 : sizeof(Color));
  const std::uint64_t result = corners * (sizeof(std::uint32_t) + vertex) + soup.triangles.size() * triangle;
  return corners * sizeof(std::uint32_t) + std::max(edge_table, result);
}

namespace {

/// Disjoint sets that remember whether an item is turned against its representative.
class SignedSets {
 public:
  explicit SignedSets(std::size_t count) : parent_(count), turned_(count, 0) {
    std::iota(parent_.begin(), parent_.end(), 0U);
  }
  /// Joins two items that lie the same way (or opposite ways). False when that contradicts what is known.
  bool join(std::uint32_t first, std::uint32_t second, bool opposite) {
    const auto [a, turn_a] = find(first);
    const auto [b, turn_b] = find(second);
    const bool turn = (turn_a != turn_b) != opposite;
    if (a == b) return !turn;
    parent_[std::max(a, b)] = std::min(a, b);
    turned_[std::max(a, b)] = turn ? 1 : 0;
    return true;
  }

 private:
  std::pair<std::uint32_t, bool> find(std::uint32_t item) {
    bool turn = false;
    while (parent_[item] != item) {
      const std::uint32_t up = parent_[item];
      turned_[item] = static_cast<std::uint8_t>(turned_[item] ^ turned_[up]);
      parent_[item] = parent_[up];
      turn = turn != (turned_[item] != 0);
      item = parent_[item];
    }
    return {item, turn};
  }
  std::vector<std::uint32_t> parent_;
  std::vector<std::uint8_t> turned_;  ///< against the parent; 0 for a representative
};

/// The analysis, step by step; each step fills part of the result.
class Analysis {
 public:
  explicit Analysis(const TriangleSoup& soup)
      : soup_(soup), edges_(soup), corners_(3 * soup.triangles.size()), bad_(soup.positions.size(), 0) {}

  SurfaceTopology run() {
    find_components();
    visit_edges();
    count_vertices();
    count_loops();
    sum_up();
    return std::move(result_);
  }

 private:
  ComponentTopology& component_of_vertex(std::uint32_t vertex) { return result_.component_list[component_[vertex]]; }

  void find_components() {
    constexpr std::uint32_t kNone = SurfaceTopology::kNoComponent;
    DisjointSets sets(soup_.positions.size());
    for (const Triangle& t : soup_.triangles) {
      if (!has_distinct_corners(t)) continue;
      sets.join(t[0], t[1]);
      sets.join(t[0], t[2]);
    }
    component_.assign(soup_.positions.size(), kNone);
    result_.component_of_triangle.assign(soup_.triangles.size(), kNone);
    for (std::size_t i = 0; i < soup_.triangles.size(); ++i) {
      const Triangle& t = soup_.triangles[i];
      if (!has_distinct_corners(t)) {
        ++result_.collapsed_triangles;
        continue;
      }
      std::uint32_t& label = component_[sets.find(t[0])];
      if (label == kNone) {
        label = static_cast<std::uint32_t>(result_.component_list.size());
        result_.component_list.emplace_back();
      }
      const std::uint32_t value = label;
      for (const std::uint32_t vertex : t) component_[vertex] = value;
      result_.component_of_triangle[i] = value;
      ++result_.component_list[value].triangles;
    }
  }

  void visit_edges() {
    SignedSets sides(soup_.triangles.size());
    for (std::size_t e = 0; e < edges_.size(); ++e) {
      const auto uses = edges_.uses(e);
      ComponentTopology& component = component_of_vertex(edges_.low(e));
      ++component.edges;
      if (uses.size() == 1) ++component.boundary_edges;
      if (uses.size() > 2) {
        ++component.nonmanifold_edges;
        bad_[edges_.low(e)] = bad_[edges_.high(e)] = 1;
      }
      if (uses.size() > 2 || (uses.size() == 2 && uses[0].forward == uses[1].forward)) component.oriented = false;
      if (uses.size() == 2 && !sides.join(uses[0].triangle, uses[1].triangle, uses[0].forward == uses[1].forward)) {
        component.orientable = false;
      }
      for (std::size_t i = 1; i < uses.size(); ++i) {
        join_across(corners_, soup_, edges_, e, uses[0].triangle, uses[i].triangle);
      }
    }
  }

  /// A vertex is non-manifold when it lies on a non-manifold edge or has more than one fan.
  void count_vertices() {
    std::vector<std::uint8_t> fans(soup_.positions.size(), 0);
    for (std::uint32_t t = 0; t < soup_.triangles.size(); ++t) {
      if (!has_distinct_corners(soup_.triangles[t])) continue;
      for (std::uint32_t c = 0; c < 3; ++c) {
        const std::uint32_t vertex = soup_.triangles[t][c];
        if (corners_.find(3 * t + c) == 3 * t + c && fans[vertex] < 2) ++fans[vertex];
      }
    }
    for (std::uint32_t v = 0; v < fans.size(); ++v) {
      if (fans[v] == 0) continue;
      ComponentTopology& component = component_of_vertex(v);
      ++component.vertices;
      if (fans[v] > 1 || bad_[v] != 0) ++component.nonmanifold_vertices;
    }
  }

  /// Boundary edges that end the same fan follow each other.
  void count_loops() {
    constexpr std::uint32_t kNone = 0xffffffffU;
    std::vector<std::uint32_t> last(3 * soup_.triangles.size(), kNone);  // boundary edge seen last, by fan
    DisjointSets chains(edges_.size());
    for (std::uint32_t e = 0; e < edges_.size(); ++e) {
      if (edges_.uses(e).size() != 1) continue;
      for (const std::uint32_t vertex : {edges_.low(e), edges_.high(e)}) {
        std::uint32_t& seen = last[corners_.find(corner_at(soup_, edges_.uses(e)[0].triangle, vertex))];
        if (seen != kNone) chains.join(seen, e);
        seen = e;
      }
    }
    for (std::uint32_t e = 0; e < edges_.size(); ++e) {
      if (edges_.uses(e).size() == 1 && chains.find(e) == e) ++result_.boundary_loops;
    }
  }

  static void find_genus(ComponentTopology& component) {
    if (component.nonmanifold_edges > 0) {
      component.genus_reason = std::to_string(component.nonmanifold_edges) + " non-manifold edges";
    } else if (component.nonmanifold_vertices > 0) {
      component.genus_reason = std::to_string(component.nonmanifold_vertices) + " non-manifold vertices";
    } else if (component.boundary_edges > 0) {
      component.genus_reason = std::to_string(component.boundary_edges) + " boundary edges";
    } else if (!component.orientable) {
      component.genus_reason = "not orientable";
    } else {
      component.genus = (2 - component.euler_characteristic()) / 2;
    }
  }

  void sum_up() {
    SurfaceTopology& r = result_;
    r.genus = 0;
    for (ComponentTopology& c : r.component_list) {
      find_genus(c);
      r.vertices += c.vertices;
      r.edges += c.edges;
      r.triangles += c.triangles;
      r.boundary_edges += c.boundary_edges;
      r.nonmanifold_edges += c.nonmanifold_edges;
      r.nonmanifold_vertices += c.nonmanifold_vertices;
      r.oriented = r.oriented && c.oriented;
      r.euler_characteristic += c.euler_characteristic();
      if (r.genus && c.genus) {
        *r.genus += *c.genus;
      } else if (r.genus) {
        r.genus.reset();
        r.genus_reason = "component " + std::to_string(r.components) + ": " + c.genus_reason;
      }
      ++r.components;
    }
    r.closed = r.boundary_edges == 0 && r.nonmanifold_edges == 0;
  }

  const TriangleSoup& soup_;
  EdgeTable edges_;
  DisjointSets corners_;                  ///< fans: corners at one vertex joined across shared edges
  std::vector<std::uint8_t> bad_;         ///< by vertex: on a non-manifold edge
  std::vector<std::uint32_t> component_;  ///< by vertex
  SurfaceTopology result_;
};

}  // namespace

SurfaceTopology analyze_topology(const TriangleSoup& soup) {
  return Analysis(soup).run();
}

}  // namespace voxcarve
