#include "common/mesh/corner_table.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

#include "common/mesh/models/primitives.h"
#include "common/mesh/topology.h"
#include "tests/support/shapes.h"

namespace voxcarve {
namespace {

constexpr std::uint32_t kNone = CornerTable::kNone;

std::optional<CornerTable> table_of(const TriangleSoup& soup) {
  const RunContext context;
  return CornerTable::build(soup.triangles, soup.positions.size(), context);
}

TriangleSoup soup_of(const CornerTable& table) {
  TriangleSoup soup;
  soup.positions.assign(table.vertices(), Point::Zero());
  for (std::uint32_t t = 0; t < table.slots(); ++t) {
    if (!table.removed(t)) soup.triangles.push_back(table.corners(t));
  }
  return soup;
}

/// Triangles with their smallest corner first, sorted.
std::vector<Triangle> canonical(std::vector<Triangle> triangles) {
  for (Triangle& t : triangles) std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

/// What a collapse means: the end's number becomes the start's, and triangles that name it twice go.
TriangleSoup renamed_vertex(TriangleSoup soup, std::uint32_t end, std::uint32_t start) {
  for (Triangle& t : soup.triangles) std::replace(t.begin(), t.end(), end, start);
  std::erase_if(soup.triangles, [](const Triangle& t) { return !has_distinct_corners(t); });
  return soup;
}

/// True when no two triangles have the same three corners.
bool is_simplicial(const TriangleSoup& soup) {
  std::set<Triangle> seen;
  for (Triangle t : soup.triangles) {
    std::sort(t.begin(), t.end());
    if (!seen.insert(t).second) return false;
  }
  return true;
}

/// The link condition by its consequences.
bool keeps_topology(const TriangleSoup& before, const TriangleSoup& after) {
  const SurfaceTopology a = analyze_topology(before);
  const SurfaceTopology b = analyze_topology(after);
  return is_simplicial(after) && b.oriented && b.nonmanifold_edges == 0 && b.nonmanifold_vertices == 0 &&
         a.components == b.components && a.euler_characteristic == b.euler_characteristic && a.closed == b.closed &&
         a.boundary_loops == b.boundary_loops;
}

std::int64_t used_vertices(const TriangleSoup& soup) {
  return analyze_topology(soup).vertices;
}

void expect_consistent(const CornerTable& table) {
  std::vector<std::size_t> triangles_at(table.vertices(), 0);
  std::uint32_t live = 0;
  for (std::uint32_t t = 0; t < table.slots(); ++t) {
    if (table.removed(t)) continue;
    ++live;
    for (std::uint32_t h = 4 * t; h < 4 * t + 3; ++h) {
      ++triangles_at[table.start(h)];
      const std::uint32_t twin = table.twin(h);
      if (twin == kNone) {
        EXPECT_EQ(table.leaving(table.start(h)), h);
        EXPECT_EQ(table.edge_of(h), h);
        continue;
      }
      ASSERT_FALSE(table.removed(CornerTable::triangle_of(twin)));
      EXPECT_EQ(table.twin(twin), h);
      EXPECT_EQ(table.start(twin), table.end(h));
      EXPECT_EQ(table.end(twin), table.start(h));
      EXPECT_EQ(table.edge_of(h), std::min(h, twin));
    }
  }
  EXPECT_EQ(live, table.triangles());
  for (std::uint32_t v = 0; v < table.vertices(); ++v) {
    ASSERT_EQ(table.leaving(v) == kNone, triangles_at[v] == 0);
    if (triangles_at[v] == 0) continue;
    CornerTable::Ring ring;
    table.gather(v, ring);
    EXPECT_EQ(ring.half_edges.size(), triangles_at[v]);
    EXPECT_EQ(ring.neighbors.size(), triangles_at[v] + (table.on_boundary(v) ? 1 : 0));
    for (const std::uint32_t h : ring.half_edges) EXPECT_EQ(table.start(h), v);
    EXPECT_EQ(std::set<std::uint32_t>(ring.neighbors.begin(), ring.neighbors.end()).size(), ring.neighbors.size());
  }
}

/// An n x n grid of squares of two triangles, without the squares of `holes`.
TriangleSoup patch(std::uint32_t n, const std::set<std::pair<std::uint32_t, std::uint32_t>>& holes = {}) {
  TriangleSoup soup;
  for (std::uint32_t j = 0; j <= n; ++j) {
    for (std::uint32_t i = 0; i <= n; ++i) soup.positions.emplace_back(i, j, 0);
  }
  for (std::uint32_t j = 0; j < n; ++j) {
    for (std::uint32_t i = 0; i < n; ++i) {
      if (holes.contains({i, j})) continue;
      const std::uint32_t a = j * (n + 1) + i;
      soup.triangles.push_back({a, a + 1, a + n + 2});
      soup.triangles.push_back({a, a + n + 2, a + n + 1});
    }
  }
  return soup;
}

TriangleSoup from_triangles(std::uint32_t vertices, std::vector<Triangle> triangles) {
  TriangleSoup soup;
  soup.positions.assign(vertices, Point::Zero());
  soup.triangles = std::move(triangles);
  return soup;
}

/// Surfaces on which every case of the link condition occurs.
std::vector<std::pair<std::string, TriangleSoup>> surfaces() {
  const TriangleSoup tetrahedron = from_triangles(4, {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}});
  return {{"tetrahedron", tetrahedron},
          {"back to back", from_triangles(3, {{0, 1, 2}, {0, 2, 1}})},
          {"one triangle", from_triangles(3, {{0, 1, 2}})},
          {"two triangles", from_triangles(4, {{0, 1, 2}, {0, 2, 3}})},
          {"disc of three", from_triangles(4, {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}})},
          {"octahedron", icosphere(Point::Zero(), 1, 0)},
          {"bipyramid", from_triangles(5, {{0, 1, 3}, {1, 2, 3}, {2, 0, 3}, {1, 0, 4}, {2, 1, 4}, {0, 2, 4}})},
          {"small torus", torus(3, 1, 3, 3)},
          {"torus", torus(3, 1, 5, 4)},
          {"patch", patch(4)},
          {"annulus", patch(3, {{1, 1}})},
          {"two holes", patch(5, {{1, 1}, {3, 3}, {3, 2}})},
          {"two parts", test::joined({tetrahedron, patch(2), torus(3, 1, 4, 3)})}};
}

TEST(CornerTable, DescribesTheMesh) {
  for (const auto& [name, soup] : surfaces()) {
    SCOPED_TRACE(name);
    const auto table = table_of(soup);
    ASSERT_TRUE(table);
    expect_consistent(*table);
    EXPECT_EQ(soup_of(*table).triangles, soup.triangles);
  }
}

TEST(CornerTable, RefusesWhatIsNoOrientedManifold) {
  EXPECT_FALSE(table_of(from_triangles(5, {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}})));  // three at an edge
  EXPECT_FALSE(table_of(from_triangles(5, {{0, 1, 2}, {1, 0, 3}, {1, 0, 4}})));  // three, two of them one way
  EXPECT_FALSE(table_of(from_triangles(4, {{0, 1, 2}, {0, 1, 3}})));             // turned against each other
  EXPECT_FALSE(table_of(from_triangles(5, {{0, 1, 2}, {0, 3, 4}})));             // two open fans at 0
  EXPECT_FALSE(table_of(from_triangles(3, {{0, 1, 1}, {0, 1, 2}})));             // names a vertex twice
  TriangleSoup hourglass = test::joined({box(Point::Zero(), Point::Ones()), box(Point::Ones(), 2 * Point::Ones())});
  EXPECT_TRUE(table_of(hourglass));
  EXPECT_FALSE(table_of(merge_equal_positions(hourglass)));  // two closed fans at a corner
  EXPECT_TRUE(table_of(from_triangles(9, {{2, 5, 7}})));     // unused vertices do no harm
}

TEST(CornerTable, AllowsACollapseIffTheTopologyStays) {
  int allowed = 0;
  int refused = 0;
  for (const auto& [name, soup] : surfaces()) {
    SCOPED_TRACE(name);
    const auto table = table_of(soup);
    ASSERT_TRUE(table);
    for (std::uint32_t t = 0; t < table->slots(); ++t) {
      for (std::uint32_t h = 4 * t; h < 4 * t + 3; ++h) {
        CornerTable::Ring start, end;
        table->gather(table->start(h), start);
        table->gather(table->end(h), end);
        const TriangleSoup after = renamed_vertex(soup, table->end(h), table->start(h));
        // Without the last condition, an ear at the boundary could vanish with both of its outer edges.
        const bool expected = keeps_topology(soup, after) && used_vertices(after) + 1 == used_vertices(soup);
        EXPECT_EQ(table->may_collapse(h, start, end), expected) << table->start(h) << " - " << table->end(h);
        ++(expected ? allowed : refused);
        if (!expected) continue;
        CornerTable copy = *table;
        copy.collapse(h);
        expect_consistent(copy);
        EXPECT_EQ(canonical(soup_of(copy).triangles), canonical(after.triangles));
      }
    }
  }
  EXPECT_GT(allowed, 300);
  EXPECT_GT(refused, 100);
}

TEST(CornerTable, StaysTheSameSurfaceThroughRandomCollapses) {
  for (const auto& [name, soup] : surfaces()) {
    for (unsigned seed = 0; seed < 10; ++seed) {
      SCOPED_TRACE(name + " " + std::to_string(seed));
      std::mt19937 random(seed);
      CornerTable table = *table_of(soup);
      TriangleSoup twin = soup;  // follows by renaming
      int failures = 0;
      for (int step = 0; failures < 200; ++step) {
        const auto number = static_cast<std::uint32_t>(random());
        const std::uint32_t h = 4 * (number / 3 % table.slots()) + number % 3;
        if (table.removed(CornerTable::triangle_of(h))) continue;
        CornerTable::Ring start, end;
        table.gather(table.start(h), start);
        table.gather(table.end(h), end);
        if (!table.may_collapse(h, start, end)) {
          ++failures;
          continue;
        }
        twin = renamed_vertex(twin, table.end(h), table.start(h));
        table.collapse(h);
        if (step % 3 == 2) {
          const CornerTable::Moves moves = table.compact();
          EXPECT_EQ(table.slots(), table.triangles());
          for (std::uint32_t t = 0; t < table.slots(); ++t) EXPECT_EQ(moves.new_triangle[moves.old_triangle[t]], t);
          for (Triangle& t : twin.triangles) {
            for (std::uint32_t& v : t) {
              v = static_cast<std::uint32_t>(std::find(moves.old_vertex.begin(), moves.old_vertex.end(), v) -
                                             moves.old_vertex.begin());
            }
          }
        }
        expect_consistent(table);
        ASSERT_EQ(canonical(soup_of(table).triangles), canonical(twin.triangles));
      }
      EXPECT_TRUE(keeps_topology(soup, soup_of(table)) || !is_simplicial(soup));
    }
  }
}

TEST(CornerTable, KeepsMarksAndNumbersThroughCompaction) {
  CornerTable table = *table_of(patch(4));
  for (std::uint32_t t = 0; t < table.slots(); ++t) table.mark(4 * t + 1) = static_cast<std::uint8_t>(t);
  const std::uint32_t inner = 4 * 2 + 2;  // a diagonal
  table.collapse(inner);
  const CornerTable::Moves moves = table.compact();
  for (std::uint32_t t = 0; t < table.slots(); ++t) {
    EXPECT_EQ(table.mark(4 * t + 1), moves.old_triangle[t]);
    EXPECT_EQ(moves.renamed(4 * moves.old_triangle[t] + 1), 4 * t + 1);
  }
  EXPECT_EQ(moves.renamed(inner), kNone);
  EXPECT_EQ(moves.renamed(kNone), kNone);
}

TEST(CornerTable, CanBeCancelled) {
  std::stop_source source;
  RunContext context;
  context.cancellation = source.get_token();
  source.request_stop();
  const TriangleSoup soup = patch(2);
  EXPECT_ANY_THROW(CornerTable::build(soup.triangles, soup.positions.size(), context));
}

}  // namespace
}  // namespace voxcarve
