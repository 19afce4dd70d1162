#include "common/mesh/hole_filling.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "common/mesh/models/primitives.h"
#include "common/mesh/stitching.h"
#include "common/mesh/topology.h"
#include "tests/support/shapes.h"
#include "tests/unit/metric_shapes.h"
#include "tests/unit/stitching_shapes.h"

namespace voxcarve {
namespace {

using test::closed_topology;
using test::faces;
using test::has_notice;
using test::joined;
using test::moebius_strip;
using test::rectangle;
using test::unit_cube;

TEST(Stitch, FillsAMissingFace) {
  RunContext context;
  std::vector<TriangleSoup> parts = faces(0.0, [](int) { return 4; });
  parts.erase(parts.begin() + 3);
  const TriangleSoup result = stitch(joined(parts), {}, context);
  EXPECT_EQ(closed_topology(result).genus, 0);
  EXPECT_NEAR(signed_volume(result), 1, 1e-12);
  EXPECT_NEAR(surface_area(result), 6, 1e-12);  // least area: the flat square
  EXPECT_TRUE(has_notice(context, "filled 1 hole with 14 triangles"));
}

TEST(Stitch, MakesSomethingClosedOfOneSidedAndHangingSheets) {
  RunContext context;
  EXPECT_GT(closed_topology(stitch(moebius_strip(20), {.tolerance = 1e-3}, context)).triangles, 40);
  EXPECT_TRUE(has_notice(context, "one-sided"));
  // A cube with a fin on one of its edges: the cube stays, and the fin becomes a part of its own without a volume.
  const TriangleSoup fin = rectangle({1, 1, 0}, {0, 0, 1}, {1, 1, 0});
  const TriangleSoup result = stitch(joined({unit_cube(), fin}), {}, context);
  EXPECT_EQ(closed_topology(result).components, 2);
  EXPECT_NEAR(signed_volume(result), 1, 1e-12);
  TriangleSoup flat;
  flat.positions = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  flat.triangles = {{0, 1, 2}};
  EXPECT_TRUE(stitch(flat, {}, context).empty());
}

TEST(FillHoles, CutsLargeHolesInTwo) {
  // The base of a cone has 1000 edges: the flat fill closes it with 998 triangles.
  const std::uint32_t n = 1000;
  TriangleSoup cone;
  for (std::uint32_t i = 0; i < n; ++i) {
    const double angle = 2 * std::numbers::pi * i / n;
    cone.positions.emplace_back(std::cos(angle), std::sin(angle), 0);
  }
  cone.positions.emplace_back(0, 0, 1);
  for (std::uint32_t i = 0; i < n; ++i) cone.triangles.push_back({i, (i + 1) % n, n});
  RunContext context;
  const FillReport report = fill_holes(cone, context);
  EXPECT_EQ(report.holes, 1);
  EXPECT_EQ(report.triangles, n - 2);
  EXPECT_EQ(closed_topology(cone).genus, 0);
  // A cone of height 1 on the polygon inscribed in the unit circle.
  const double base = n / 2.0 * std::sin(2 * std::numbers::pi / n);
  EXPECT_NEAR(signed_volume(cone), base / 3, 1e-9);
}

TEST(FillHoles, UsesAMiddleVertexWhereEveryDiagonalIsTaken) {
  // Two triangles with a common edge use one diagonal of their outline, the fill the other; with both diagonals taken
  // (by a third sheet elsewhere) there is none left: four triangles about the mean.
  RunContext context;
  TriangleSoup sheet = rectangle(Point::Zero(), {1, 0, 0}, {0, 1, 0});
  EXPECT_EQ(fill_holes(sheet, context).triangles, 2);
  EXPECT_EQ(closed_topology(sheet).genus, 0);
  TriangleSoup taken = rectangle(Point::Zero(), {1, 0, 0}, {0, 1, 0});
  // Vertices 0 1 / 2 3 with the diagonal 0-3; a handle above makes 1-2 an edge that is already there.
  taken.positions.emplace_back(0.5, 0.5, 1);
  taken.positions.emplace_back(0.5, 0.5, 2);
  taken.triangles.push_back({1, 2, 4});
  taken.triangles.push_back({2, 1, 5});
  taken.triangles.push_back({1, 4, 5});
  taken.triangles.push_back({2, 5, 4});
  const std::size_t before = taken.positions.size();
  EXPECT_EQ(fill_holes(taken, context).triangles, 4);
  EXPECT_EQ(taken.positions.size(), before + 1);
  EXPECT_TRUE(analyze_topology(taken).closed);
}

}  // namespace
}  // namespace voxcarve
