// The model `engine`: the paper's number of faces, and exactly the defects that it promises.
#include <gtest/gtest.h>

#include "common/mesh/topology.h"
#include "common/run/errors.h"
#include "common/volume/voxelize.h"
#include "tests/unit/model_checks.h"

namespace voxcarve {
namespace {

using namespace test;

std::int64_t degenerate_triangles(const TriangleSoup& soup) {
  return std::ranges::count_if(soup.triangles, [&](const Triangle& t) { return is_degenerate(soup, t); });
}

TEST(Engine, HasThePapersNumberOfFacesAndItsDefects) {
  const TriangleSoup soup = make_procedural("engine");
  validate(soup, "engine");
  EXPECT_EQ(soup.triangles.size(), 140'113U);  // [NT03, Fig. 8]
  const SurfaceTopology topology = analyze_topology(soup);
  // A T-joint leaves one side whole and two halves of it open: a boundary loop of three edges.
  EXPECT_EQ(topology.boundary_loops, 121);
  EXPECT_EQ(topology.boundary_edges, 3 * 121);
  EXPECT_EQ(degenerate_triangles(soup), 60);
  // Keepers of 16 valves and four jets, cones that touch at their tips.
  EXPECT_EQ(topology.nonmanifold_vertices, 16 + 4);
  EXPECT_EQ(topology.nonmanifold_edges, 0);
  EXPECT_TRUE(topology.oriented);
  // Parts overlap but have no vertex in common: by positions there are as many defects as by indices.
  const SurfaceTopology merged = analyze_topology(merge_equal_positions(soup));
  EXPECT_EQ(merged.components, topology.components);
  EXPECT_EQ(merged.boundary_loops, 121);
  EXPECT_EQ(merged.nonmanifold_vertices, 16 + 4);
  EXPECT_EQ(merged.nonmanifold_edges, 0);
}

TEST(Engine, TJointsLieExactlyOnTheirNeighboursSides) {
  const TriangleSoup soup = make_procedural("engine?detail=0.1&zero_area_faces=0");
  const EdgeTable edges(soup);
  std::vector<std::vector<std::uint32_t>> neighbours(soup.positions.size());
  for (std::size_t e = 0; e < edges.size(); ++e) {
    if (edges.uses(e).size() != 1) continue;
    neighbours[edges.low(e)].push_back(edges.high(e));
    neighbours[edges.high(e)].push_back(edges.low(e));
  }
  std::size_t joints = 0;
  for (std::uint32_t v = 0; v < soup.positions.size(); ++v) {
    if (neighbours[v].empty()) continue;
    ASSERT_EQ(neighbours[v].size(), 2U);
    const Point& a = soup.positions[neighbours[v][0]];
    const Point& b = soup.positions[neighbours[v][1]];
    joints += soup.positions[v] == 0.5 * (a + b) ? 1 : 0;
  }
  EXPECT_EQ(joints, 121U);
}

TEST(Engine, IsClosedButForTheTJoints) {
  const TriangleSoup soup = make_procedural("engine?t_joints=0&zero_area_faces=0");
  // A T-joint adds one triangle, a zero-area face comes with another one.
  EXPECT_EQ(soup.triangles.size(), 140'113U - 121 - 2 * 60);
  const SurfaceTopology topology = analyze_topology(soup);
  EXPECT_TRUE(topology.closed);
  EXPECT_TRUE(topology.oriented);
  EXPECT_EQ(degenerate_triangles(soup), 0);
  EXPECT_GT(topology.components, 500);  // many parts
}

TEST(Engine, DetailChangesRoundPartsAlone) {
  const TriangleSoup coarse = make_procedural("engine?detail=0.1");
  const TriangleSoup fine = make_procedural("engine?detail=2");
  EXPECT_LT(coarse.triangles.size(), 40'000U);
  EXPECT_GT(fine.triangles.size(), 200'000U);
  EXPECT_EQ(analyze_topology(coarse).components, analyze_topology(fine).components);
  for (const TriangleSoup& soup : {coarse, fine}) {
    EXPECT_EQ(analyze_topology(soup).boundary_loops, 121);
    EXPECT_EQ(degenerate_triangles(soup), 60);
  }
}

TEST(Engine, MakesAsManyDefectsAsAskedOrRefuses) {
  // A defect takes two vertices of the castings for itself alone, and coarse castings have few.
  EXPECT_THROW(make_procedural("engine?detail=0.1&t_joints=200&zero_area_faces=100"), ParameterError);
  for (const char* spec : {"engine?detail=1&t_joints=200&zero_area_faces=100", "engine?detail=0.1&t_joints=20"}) {
    const bool many = std::string_view(spec).find("200") != std::string_view::npos;
    const TriangleSoup soup = make_procedural(spec);
    EXPECT_EQ(analyze_topology(soup).boundary_loops, many ? 200 : 20) << spec;
    EXPECT_EQ(degenerate_triangles(soup), many ? 100 : 60) << spec;
  }
}

TEST(Engine, IsColouredPartByPart) {
  const TriangleSoup soup = make_procedural("engine?detail=0.1");
  ASSERT_EQ(soup.triangle_colors.size(), soup.triangles.size());
  std::set<std::array<float, 3>> colors;
  for (const Color& color : soup.triangle_colors) {
    ASSERT_TRUE((color.array() >= 0).all() && (color.array() <= 1).all());
    colors.insert({color[0], color[1], color[2]});
  }
  EXPECT_GE(colors.size(), 15U);
}

TEST(Engine, RayStabbingFillsWhatParityCountLeavesHollow) {
  const TriangleSoup soup = make_procedural("engine?detail=0.1");
  const GridFrame frame = voxel_frame(bounds(soup), 64);
  RunContext context;
  const auto voxels = [&](Classifier classifier) {
    return voxelize(soup, frame, {.classifier = classifier, .directions = 3}, context);
  };
  const auto at = [&](const BinaryVolume& volume, const Point& point) {
    const Point index = (point - frame.origin) / frame.voxel_size;
    return volume(static_cast<std::int64_t>(index.x()), static_cast<std::int64_t>(index.y()),
                  static_cast<std::int64_t>(index.z()));
  };
  const BinaryVolume parity = voxels(Classifier::kParity);
  const BinaryVolume stabbing = voxels(Classifier::kStabbing);
  // Beside the crankshaft, in the cavity of the crankcase and below the banks; and where iron and oil pan overlap.
  const Point cavity(-0.5, 0.9, -0.2);
  EXPECT_EQ(at(parity, cavity), 0);
  EXPECT_EQ(at(stabbing, cavity), 1);
  EXPECT_EQ(at(stabbing, {-0.5, 0.0, -0.52}), 1);
  // Nothing but the engine: the corners of the box stay empty.
  EXPECT_EQ(at(stabbing, frame.center({1, 1, 1})), 0);
  EXPECT_GT(count_interior(stabbing), count_interior(parity));
}

}  // namespace
}  // namespace voxcarve
