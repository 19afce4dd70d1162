#include "common/mesh/topology.h"

#include <gtest/gtest.h>

#include <stop_token>

#include "common/run/errors.h"
#include "tests/unit/metric_shapes.h"

namespace voxcarve {
namespace {

using namespace test;

TEST(EdgeTable, ListsEveryEdgeWithItsDirectedUses) {
  // Two triangles over the square 0 1 2 3 share the diagonal 0-2, one along it each way.
  TriangleSoup soup;
  soup.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  soup.triangles = {{0, 1, 2}, {0, 2, 3}};
  const EdgeTable edges(soup);
  ASSERT_EQ(edges.size(), 5U);  // 01 02 03 12 23
  EXPECT_EQ(edges.low(1), 0U);
  EXPECT_EQ(edges.high(1), 2U);
  ASSERT_EQ(edges.uses(1).size(), 2U);
  EXPECT_EQ(edges.uses(1)[0].triangle, 0U);
  EXPECT_EQ(edges.uses(1)[0].corner, 2);
  EXPECT_FALSE(edges.uses(1)[0].forward);
  EXPECT_EQ(edges.uses(1)[1].triangle, 1U);
  EXPECT_TRUE(edges.uses(1)[1].forward);
  EXPECT_EQ(edges.signed_incidence(1), 0);
  EXPECT_EQ(edges.signed_incidence(0), 1);   // 0 -> 1
  EXPECT_EQ(edges.signed_incidence(2), -1);  // 3 -> 0
}

TEST(Topology, Cube) {
  // V - E + F = 8 - 18 + 12 = 2, so genus 0.
  const SurfaceTopology t = analyze_topology(unit_cube());
  EXPECT_EQ(t.vertices, 8);
  EXPECT_EQ(t.edges, 18);
  EXPECT_EQ(t.triangles, 12);
  EXPECT_EQ(t.components, 1);
  EXPECT_TRUE(t.closed);
  EXPECT_TRUE(t.oriented);
  EXPECT_EQ(t.boundary_edges, 0);
  EXPECT_EQ(t.boundary_loops, 0);
  EXPECT_EQ(t.nonmanifold_vertices, 0);
  EXPECT_EQ(t.euler_characteristic, 2);
  EXPECT_EQ(t.genus, 0);
}

TEST(Topology, UnusedVerticesDoNotCount) {
  TriangleSoup soup = unit_cube();
  soup.positions.insert(soup.positions.begin(), Point(9, 9, 9));
  for (Triangle& t : soup.triangles) {
    for (std::uint32_t& v : t) ++v;
  }
  EXPECT_EQ(analyze_topology(soup).vertices, 8);
}

TEST(Topology, TorusHasGenusOne) {
  const SurfaceTopology t = analyze_topology(torus(2, 1, 9, 7));
  EXPECT_EQ(t.euler_characteristic, 0);  // 63 - 189 + 126
  EXPECT_EQ(t.genus, 1);
}

TEST(Topology, GenusAddsOverComponents) {
  const SurfaceTopology t = analyze_topology(joined(torus(2, 1, 9, 7), joined(unit_cube(), torus(5, 1, 5, 4))));
  EXPECT_EQ(t.components, 3);
  ASSERT_EQ(t.component_list.size(), 3U);
  EXPECT_EQ(t.component_list[0].genus, 1);
  EXPECT_EQ(t.component_list[1].genus, 0);
  EXPECT_EQ(t.component_list[2].genus, 1);
  EXPECT_EQ(t.genus, 2);
  EXPECT_EQ(t.component_of_triangle[126], 1U);  // the first triangle after the 2 * 9 * 7 of the torus
}

TEST(Topology, OneOpenComponentLeavesTheTotalUndefined) {
  TriangleSoup open = unit_cube();
  open.triangles.pop_back();
  const SurfaceTopology t = analyze_topology(joined(unit_cube(), open));
  EXPECT_FALSE(t.closed);
  EXPECT_EQ(t.boundary_edges, 3);
  EXPECT_EQ(t.boundary_loops, 1);
  EXPECT_FALSE(t.genus.has_value());
  EXPECT_EQ(t.genus_reason, "component 1: 3 boundary edges");
  EXPECT_EQ(t.component_list[0].genus, 0);
}

TEST(Topology, MoebiusStripIsOpenAndNotOrientable) {
  // 2n vertices; n rungs, n diagonals and 2n rim edges; 2n triangles: chi = 0. The rim is one closed curve.
  const SurfaceTopology t = analyze_topology(moebius_strip(7));
  EXPECT_EQ(t.euler_characteristic, 0);
  EXPECT_EQ(t.boundary_edges, 14);
  EXPECT_EQ(t.boundary_loops, 1);
  EXPECT_FALSE(t.oriented);
  ASSERT_EQ(t.component_list.size(), 1U);
  EXPECT_FALSE(t.component_list[0].orientable);
  EXPECT_EQ(t.nonmanifold_vertices, 0);
}

TEST(Topology, ProjectivePlaneHasNoGenus) {
  // The six-vertex triangulation of the projective plane: closed, 6 - 15 + 10 = 1, not orientable.
  TriangleSoup soup;
  for (int i = 0; i < 6; ++i) soup.positions.emplace_back(i, i * i, i * i * i);
  soup.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}, {0, 5, 1},
                    {1, 2, 4}, {2, 3, 5}, {3, 4, 1}, {4, 5, 2}, {5, 1, 3}};
  const SurfaceTopology t = analyze_topology(soup);
  EXPECT_TRUE(t.closed);
  EXPECT_EQ(t.euler_characteristic, 1);
  EXPECT_FALSE(t.oriented);
  EXPECT_FALSE(t.genus.has_value());
  EXPECT_EQ(t.genus_reason, "component 0: not orientable");
}

TEST(Topology, GenusDoesNotNeedOrientation) {
  TriangleSoup soup = torus(2, 1, 6, 5);
  std::swap(soup.triangles[4][0], soup.triangles[4][1]);
  const SurfaceTopology t = analyze_topology(soup);
  EXPECT_TRUE(t.closed);
  EXPECT_FALSE(t.oriented);
  EXPECT_EQ(t.genus, 1);
}

/// Two cubes with the edge x = y = 1 in common, as indices.
TriangleSoup cubes_sharing_an_edge() {
  return merge_equal_positions(joined(unit_cube(), make_box({1, 1, 0}, {2, 2, 1})));
}

TEST(Topology, CubesSharingAnEdge) {
  // 8 + 8 - 2 vertices, 18 + 18 - 1 edges, 24 triangles. The common edge has 4 triangles; both its ends are pinched.
  const SurfaceTopology t = analyze_topology(cubes_sharing_an_edge());
  EXPECT_EQ(t.vertices, 14);
  EXPECT_EQ(t.edges, 35);
  EXPECT_EQ(t.components, 1);
  EXPECT_FALSE(t.closed);  // not every edge has exactly two triangles
  EXPECT_EQ(t.nonmanifold_edges, 1);
  EXPECT_EQ(t.nonmanifold_vertices, 2);
  EXPECT_EQ(t.boundary_edges, 0);
  EXPECT_EQ(t.genus_reason, "component 0: 1 non-manifold edges");
}

TEST(Topology, CubesSharingAVertex) {
  // Closed by edges, but the link of the common vertex is two cycles.
  const TriangleSoup soup = merge_equal_positions(joined(unit_cube(), make_box({1, 1, 1}, {2, 2, 2})));
  const SurfaceTopology t = analyze_topology(soup);
  EXPECT_TRUE(t.closed);
  EXPECT_TRUE(t.oriented);
  EXPECT_EQ(t.components, 1);
  EXPECT_EQ(t.nonmanifold_vertices, 1);
  EXPECT_EQ(t.euler_characteristic, 3);
  EXPECT_FALSE(t.genus.has_value());
}

TEST(Topology, FansThatTouchHaveBoundaryLoopsOfTheirOwn) {
  TriangleSoup bowtie;
  bowtie.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {-1, 0, 0}, {-1, -1, 0}};
  bowtie.triangles = {{0, 1, 2}, {0, 3, 4}};
  const SurfaceTopology t = analyze_topology(bowtie);
  EXPECT_EQ(t.boundary_edges, 6);
  EXPECT_EQ(t.boundary_loops, 2);
  EXPECT_EQ(t.nonmanifold_vertices, 1);
  EXPECT_EQ(t.components, 1);
}

TEST(Topology, OpenTubeHasTwoLoops) {
  TriangleSoup tube = unit_cube();
  tube.triangles.erase(tube.triangles.begin(), tube.triangles.begin() + 4);  // without bottom and top
  const SurfaceTopology t = analyze_topology(tube);
  EXPECT_EQ(t.boundary_edges, 8);
  EXPECT_EQ(t.boundary_loops, 2);
  EXPECT_EQ(t.euler_characteristic, 0);
}

TEST(Topology, EmptySoup) {
  const SurfaceTopology t = analyze_topology(TriangleSoup());
  EXPECT_EQ(t.vertices + t.edges + t.triangles + t.components + t.euler_characteristic, 0);
  EXPECT_TRUE(t.closed);
  EXPECT_EQ(t.genus, 0);
}

TEST(Topology, CollapsedTrianglesAreLeftOut) {
  TriangleSoup soup = unit_cube();
  soup.triangles.push_back({0, 0, 5});
  const SurfaceTopology t = analyze_topology(soup);
  EXPECT_EQ(t.triangles, 12);
  EXPECT_EQ(t.collapsed_triangles, 1);
  EXPECT_EQ(t.component_of_triangle.back(), SurfaceTopology::kNoComponent);
  EXPECT_EQ(t.genus, 0);
}

TEST(Topology, DuplicateTriangleIsClosedButNotOriented) {
  TriangleSoup soup;
  soup.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  soup.triangles = {{0, 1, 2}, {0, 1, 2}};
  const SurfaceTopology same = analyze_topology(soup);
  EXPECT_TRUE(same.closed);
  EXPECT_FALSE(same.oriented);
  soup.triangles[1] = {0, 2, 1};
  const SurfaceTopology opposite = analyze_topology(soup);
  EXPECT_TRUE(opposite.oriented);
  EXPECT_EQ(opposite.genus, 0);  // 3 - 3 + 2 = 2: a sphere of two sides
}

/// What cutting promises of every soup.
void expect_oriented_manifold(const TriangleSoup& soup) {
  const EdgeTable edges(soup);
  for (std::size_t e = 0; e < edges.size(); ++e) {
    ASSERT_LE(edges.uses(e).size(), 2U);
    if (edges.uses(e).size() == 2) {
      ASSERT_NE(edges.uses(e)[0].forward, edges.uses(e)[1].forward);
    }
  }
  const SurfaceTopology t = analyze_topology(soup);
  EXPECT_EQ(t.nonmanifold_vertices, 0);
  EXPECT_EQ(t.collapsed_triangles, 0);
  EXPECT_TRUE(t.oriented);
}

TEST(Cutting, ManifoldComesBackAsItWas) {
  for (const TriangleSoup& soup : {unit_cube(), torus(2, 1, 8, 6), sphere(1, 2)}) {
    const TriangleSoup cut = cut_to_manifold(soup);
    EXPECT_EQ(cut, merge_equal_positions(soup));  // which numbers vertices by first use as well
  }
}

TEST(Cutting, CubesSharingAnEdgeComeApart) {
  // The edge has four triangles, so all are cut there: at its ends each cube's fan is cut open along that edge, with
  // one class of corners a cube still, since the fans hang together around the other side.
  const TriangleSoup cut = cut_to_manifold(cubes_sharing_an_edge());
  expect_oriented_manifold(cut);
  const SurfaceTopology t = analyze_topology(cut);
  EXPECT_EQ(t.vertices, 16);
  EXPECT_EQ(t.components, 2);
  EXPECT_TRUE(t.closed);
  EXPECT_EQ(t.genus, 0);
}

TEST(Cutting, InconsistentNeighboursComeApart) {
  TriangleSoup soup = unit_cube();
  std::swap(soup.triangles[0][0], soup.triangles[0][1]);
  const TriangleSoup cut = cut_to_manifold(soup);
  expect_oriented_manifold(cut);
  EXPECT_EQ(analyze_topology(cut).components, 2);
  EXPECT_EQ(analyze_topology(cut).boundary_edges, 6);
}

TEST(Cutting, KeepsColoursAndDropsCollapsedTriangles) {
  TriangleSoup soup;
  soup.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {-1, 0, 0}, {-1, -1, 0}};
  soup.triangles = {{0, 0, 1}, {0, 1, 2}, {0, 3, 4}};  // a collapsed one and a bow tie
  soup.vertex_colors = {{0, 0, 0}, {0.1F, 0, 0}, {0.2F, 0, 0}, {0.3F, 0, 0}, {0.4F, 0, 0}};
  soup.triangle_colors = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const TriangleSoup cut = cut_to_manifold(soup);
  EXPECT_EQ(cut.triangles, (std::vector<Triangle>{{0, 1, 2}, {3, 4, 5}}));
  ASSERT_EQ(cut.positions.size(), 6U);  // the middle vertex twice
  EXPECT_EQ(cut.positions[0], cut.positions[3]);
  EXPECT_EQ(cut.vertex_colors[4], Color(0.3F, 0, 0));
  EXPECT_EQ(cut.triangle_colors, (std::vector<Color>{{0, 1, 0}, {0, 0, 1}}));
}

TEST(Cutting, CanBeCancelled) {
  RunContext run;
  std::stop_source stop;
  run.cancellation = stop.get_token();
  EXPECT_EQ(cut_to_manifold(cubes_sharing_an_edge(), &run), cut_to_manifold(cubes_sharing_an_edge()));
  stop.request_stop();
  EXPECT_THROW(cut_to_manifold(cubes_sharing_an_edge(), &run), Cancelled);
}

TEST(Cutting, EstimatesTheMemoryOfASurfaceThatFallsApart) {
  // Two triangles run along every edge the same way, so all come off, with three vertices each.
  TriangleSoup soup;
  soup.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  soup.triangles.assign(1000, {0, 1, 2});
  const TriangleSoup cut = cut_to_manifold(soup);
  ASSERT_EQ(cut.positions.size(), 3000U);
  EXPECT_GE(cut_memory_estimate(soup), 3000 * sizeof(Point) + 1000 * sizeof(Triangle));
  soup.vertex_colors.resize(3);
  EXPECT_GE(cut_memory_estimate(soup), 3000 * (sizeof(Point) + sizeof(Color)) + 1000 * sizeof(Triangle));
}

TEST(Cutting, RandomSoupsBecomeManifolds) {
  // Few vertices and many triangles: every kind of singularity, duplicates and collapsed triangles included.
  Sequence random(1);
  for (int round = 0; round < 400; ++round) {
    TriangleSoup soup;
    const std::uint32_t vertices = 3 + random.below(8);
    for (std::uint32_t v = 0; v < vertices; ++v) soup.positions.push_back(random.point());
    const std::uint32_t triangles = random.below(30);
    std::size_t kept = 0;
    for (std::uint32_t t = 0; t < triangles; ++t) {
      soup.triangles.push_back({random.below(vertices), random.below(vertices), random.below(vertices)});
      kept += has_distinct_corners(soup.triangles.back()) ? 1 : 0;
    }
    const TriangleSoup cut = cut_to_manifold(soup);
    expect_oriented_manifold(cut);
    ASSERT_EQ(cut.triangles.size(), kept);
    EXPECT_EQ(cut_to_manifold(cut), cut);
  }
}

}  // namespace
}  // namespace voxcarve
