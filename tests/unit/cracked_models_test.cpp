// The models cracked-*: each has its degeneracy and no other, on a solid of the stated volume, genus and components.
#include <gtest/gtest.h>

#include "common/mesh/models/cracked.h"
#include "common/mesh/topology.h"
#include "common/volume/betti.h"
#include "common/volume/voxelize.h"
#include "tests/unit/model_checks.h"

namespace voxcarve {
namespace {

using namespace test;

// Determinant of the map from cells to model units: 13 (12^2 + 5^2) / 16^3.
constexpr double kCell = 2197.0 / 4096;
// Two rails of 27 x 5 x 5 cells and three rungs of 5 x 3 cells over a gap of 5.
constexpr double kLadder = (2 * 675 + 3 * 75) * kCell;
// Exposed squares: a rail has 4 * 135 + 2 * 25, a rung 5 (5 + 5 + 3 + 3), less its two ends of 15 on the rails.
constexpr std::int64_t kSquares = 2 * 590 + 3 * 80 - 6 * 15;

struct Findings {
  TriangleSoup soup;
  SurfaceTopology topology;  ///< after merging equal positions
  std::int64_t zero_area = 0;
};

Findings examine(const std::string& spec) {
  Findings found;
  found.soup = make_procedural(spec);
  found.topology = analyze_topology(merge_equal_positions(found.soup));
  found.zero_area =
      std::ranges::count_if(found.soup.triangles, [&](const Triangle& t) { return is_degenerate(found.soup, t); });
  return found;
}

void expect_no_other(const Findings& found, bool open, bool edges, bool vertices, std::int64_t zero_area) {
  EXPECT_EQ(found.topology.boundary_edges > 0, open);
  EXPECT_EQ(found.topology.nonmanifold_edges > 0, edges);
  EXPECT_EQ(found.topology.nonmanifold_vertices > 0, vertices);
  EXPECT_EQ(found.zero_area, zero_area);
}

TEST(Cracked, TableNamesEveryModelAndTheTextsDegeneracies) {
  std::vector<std::string> names;
  for (const CrackedSolid& solid : cracked_solids()) {
    names.push_back(solid.name);
    EXPECT_FALSE(solid.degeneracy.empty());
    EXPECT_EQ(find_procedural_model(solid.name).info.stands_for, "NT Table 1");
  }
  EXPECT_TRUE(std::ranges::is_sorted(names));
  EXPECT_EQ(names.size(), 12U);
  EXPECT_EQ(std::ranges::count_if(model_names(), [](const std::string& name) { return name.starts_with("cracked-"); }),
            12);
}

TEST(Cracked, IntactModelsAreTheStatedSolids) {
  for (const CrackedSolid& solid : cracked_solids()) {
    for (const char* halvings : {"0", "1"}) {
      const std::string spec = solid.name + "?intact=on&halvings=" + halvings;
      const TriangleSoup soup = make_procedural(spec);
      expect_closed(soup, spec);
      EXPECT_TRUE(has_single_fans(soup)) << spec;
      const SurfaceTopology topology = analyze_topology(soup);
      EXPECT_EQ(topology.components, solid.components) << spec;
      EXPECT_EQ(topology.genus, solid.genus) << spec;
      expect_relative(signed_volume(soup), solid.volume);
    }
  }
}

TEST(Cracked, SolidsAreALadderOrItsPinchedRails) {
  for (const CrackedSolid& solid : cracked_solids()) {
    const bool pinched = solid.name == "cracked-nonmanifold-vertices";
    // Spikes: six pyramids of base 3 x 3 and height 2.5 in place of the rungs.
    expect_relative(solid.volume, pinched ? (2 * 675 + 6 * 3 * 3 * 2.5 / 3) * kCell : kLadder);
    EXPECT_EQ(solid.genus, pinched ? 0 : 2);
    EXPECT_EQ(solid.components, pinched ? 2 : 1);
  }
}

TEST(Cracked, VoxelsOfTheSoundSolidsMeasureThemWithinOnePercent) {
  RunContext context;
  for (const char* name : {"cracked-holes", "cracked-nonmanifold-vertices"}) {
    const CrackedSolid& solid = *std::ranges::find(cracked_solids(), name, &CrackedSolid::name);
    const TriangleSoup soup = make_procedural(std::string(name) + "?intact=on");
    const GridFrame frame = voxel_frame(bounds(soup), 128);
    for (const Classifier classifier : {Classifier::kParity, Classifier::kStabbing}) {
      const BinaryVolume volume = voxelize(soup, frame, {.classifier = classifier, .directions = 3}, context);
      const double measured = static_cast<double>(count_interior(volume)) * std::pow(frame.voxel_size, 3);
      EXPECT_NEAR(measured / solid.volume, 1, 0.01) << name;
      EXPECT_EQ(betti_numbers(volume, context), (BettiNumbers{solid.components, solid.genus, 0})) << name;
    }
  }
}

TEST(Cracked, Holes) {
  const Findings found = examine("cracked-holes?holes=7&hole_size=3");
  expect_no_other(found, true, false, false, 0);
  EXPECT_EQ(found.topology.boundary_loops, 7);
  EXPECT_EQ(found.topology.boundary_edges, 7 * 12);
  EXPECT_EQ(static_cast<std::int64_t>(found.soup.triangles.size()), 2 * kSquares - 7 * 18);
}

TEST(Cracked, Cracks) {
  const Findings found = examine("cracked-cracks?cracks=5&crack_length=6&width=0.2");
  expect_no_other(found, true, false, false, 0);
  EXPECT_EQ(found.topology.boundary_loops, 5);
  EXPECT_EQ(found.topology.boundary_edges, 5 * 2 * 6);
  EXPECT_EQ(static_cast<std::int64_t>(found.soup.triangles.size()), 2 * kSquares);
  // A crack of n squares is open by width * (n - 1): n - 2 full squares and two halves at its ends.
  const double sound = surface_area(make_procedural("cracked-cracks?intact=on"));
  const double lost = sound - surface_area(found.soup);
  const double largest = 5 * 5 * 0.2 * (13.0 / 16) * (14.0 / 16);  // squares' sides are at most 14 / 16 long
  EXPECT_GT(lost, 0.5 * largest);
  EXPECT_LT(lost, largest);
}

TEST(Cracked, TJoints) {
  const Findings found = examine("cracked-t-joints?joints=60");
  expect_no_other(found, true, false, false, 0);
  EXPECT_EQ(found.topology.boundary_loops, 60);
  EXPECT_EQ(found.topology.boundary_edges, 3 * 60);
  // Of no width at all: the open surface still has the solid's volume.
  expect_relative(signed_volume(found.soup), kLadder);
}

TEST(Cracked, ZeroAreaFaces) {
  const Findings found = examine("cracked-zero-area?faces=60");
  expect_no_other(found, false, false, false, 60);
  EXPECT_EQ(static_cast<std::int64_t>(found.soup.triangles.size()), 2 * kSquares + 2 * 60);
  EXPECT_EQ(found.topology.genus, 2);
  expect_relative(signed_volume(found.soup), kLadder);
}

TEST(Cracked, DoubleWalls) {
  const double gap = 0.25;
  const Findings found = examine("cracked-double-walls?gap=0.25");
  expect_no_other(found, false, false, false, 0);
  EXPECT_EQ(found.topology.components, 2);
  EXPECT_EQ(found.topology.genus, 4);
  const std::vector<TriangleSoup> walls = parts_of(found.soup);
  ASSERT_EQ(walls.size(), 2U);
  // Inside, every bar is narrower by two gaps and the gaps between the rails are wider.
  const double rails = 2 * (27 - 2 * gap) * std::pow(5 - 2 * gap, 2);
  const double rungs = 3 * (5 - 2 * gap) * (3 - 2 * gap) * (5 + 2 * gap);
  expect_relative(signed_volume(walls[0]), kLadder);
  expect_relative(signed_volume(walls[1]), (rails + rungs) * kCell);
}

TEST(Cracked, RedundantPolygons) {
  const Findings found = examine("cracked-redundant-polygons?patches=9");
  // A patch of 2 x 2 squares: 8 rim edges with three triangles, 4 inner ones and 4 diagonals with four.
  expect_no_other(found, false, true, true, 0);
  EXPECT_EQ(found.topology.nonmanifold_edges, 9 * 16);
  EXPECT_EQ(static_cast<std::int64_t>(found.soup.triangles.size()), 2 * kSquares + 9 * 8);
}

TEST(Cracked, SharedWalls) {
  const Findings found = examine("cracked-shared-walls");
  expect_no_other(found, false, true, true, 0);
  const std::vector<TriangleSoup> parts = parts_of(found.soup);
  ASSERT_EQ(parts.size(), 2U);
  for (const TriangleSoup& part : parts) {
    EXPECT_EQ(genus_of(part), 1);
    EXPECT_GT(signed_volume(part), 0);
  }
  expect_relative(signed_volume(found.soup), kLadder);
  // The wall is 5 squares wide through both rails and 5 x 3 in the rung between them: 65 squares, 130 triangles more.
  EXPECT_EQ(static_cast<std::int64_t>(found.soup.triangles.size()), 2 * kSquares + 2 * 2 * 65);
}

TEST(Cracked, InterpenetratingParts) {
  const Findings found = examine("cracked-interpenetrating");
  expect_no_other(found, false, false, false, 0);
  const std::vector<TriangleSoup> parts = parts_of(found.soup);
  ASSERT_EQ(parts.size(), 5U);
  for (const TriangleSoup& part : parts) EXPECT_EQ(genus_of(part), 0);
  // A rung of 11 x 5 x 3 cells has 6 x 5 x 3 = 90 of them within the rails.
  expect_relative(signed_volume(found.soup), kLadder + 3 * 90 * kCell);
  // Even by their positions the parts have nothing in common.
  EXPECT_EQ(found.topology.components, 5);
}

TEST(Cracked, InterpenetratingPartsWithHolesOrCracks) {
  const Findings holes = examine("cracked-holes-interpenetrating");
  expect_no_other(holes, true, false, false, 0);
  EXPECT_EQ(holes.topology.components, 5);
  EXPECT_EQ(holes.topology.boundary_loops, 12);
  const Findings cracks = examine("cracked-cracks-interpenetrating");
  expect_no_other(cracks, true, false, false, 0);
  EXPECT_EQ(cracks.topology.components, 5);
  EXPECT_EQ(cracks.topology.boundary_loops, 16);
  // All of them lie outside the other bars, where a ray that passes through one meets the solid's inside: no boundary
  // vertex of a rung has its y between the rails' walls and the rung's ends.
  const Eigen::Matrix3d map = (Eigen::Matrix3d() << 12, -5, 0, 5, 12, 0, 3, -2, 13).finished() / 16;
  for (const TriangleSoup& soup : {holes.soup, cracks.soup}) {
    const EdgeTable edges(soup);
    for (std::size_t e = 0; e < edges.size(); ++e) {
      if (edges.uses(e).size() != 1) continue;
      const Point cells = map.inverse() * soup.positions[edges.low(e)];
      const bool in_rail_height = cells.z() > 1e-9 && cells.z() < 5 - 1e-9;
      const bool in_rail =
          (cells.y() > 1e-9 && cells.y() < 5 - 1e-9) || (cells.y() > 10 + 1e-9 && cells.y() < 15 - 1e-9);
      const bool in_rail_length = cells.x() > 1e-9 && cells.x() < 27 - 1e-9;
      EXPECT_FALSE(in_rail && in_rail_height && in_rail_length);
    }
  }
}

TEST(Cracked, NonManifoldEdges) {
  const Findings found = examine("cracked-nonmanifold-edges");
  expect_no_other(found, false, true, true, 0);
  // Rims of four walls of 5 x 5 and three of 5 x 3 squares, three triangles at every edge.
  EXPECT_EQ(found.topology.nonmanifold_edges, 4 * 20 + 3 * 16);
  EXPECT_EQ(static_cast<std::int64_t>(found.soup.triangles.size()), 2 * kSquares + 2 * (4 * 25 + 3 * 15));
  const EdgeTable edges(found.soup);
  for (std::size_t e = 0; e < edges.size(); ++e) EXPECT_LE(edges.uses(e).size(), 3U);
}

TEST(Cracked, NonManifoldVertices) {
  const Findings found = examine("cracked-nonmanifold-vertices");
  expect_no_other(found, false, false, true, 0);
  EXPECT_EQ(found.topology.nonmanifold_vertices, 3);
  EXPECT_EQ(found.topology.components, 1);  // in three points
  expect_relative(signed_volume(found.soup), (1350 + 45) * kCell);
}

TEST(Cracked, HalvingsRefineTheSquares) {
  const TriangleSoup soup = make_procedural("cracked-holes?halvings=2&holes=0");
  EXPECT_EQ(static_cast<std::int64_t>(soup.triangles.size()), 2 * kSquares * 16);
  expect_relative(signed_volume(soup), kLadder);
}

TEST(Cracked, TooManyDefectsAreRefused) {
  EXPECT_THAT(parameter_error("cracked-holes?holes=1000"), HasSubstr("of 1000 holes have room"));
  EXPECT_THAT(parameter_error("cracked-cracks?crack_length=20&cracks=20"), HasSubstr("cracks have room"));
  EXPECT_THAT(parameter_error("cracked-cracks?halvings=2&width=0.25"), HasSubstr("narrower than a square"));
}

}  // namespace
}  // namespace voxcarve
