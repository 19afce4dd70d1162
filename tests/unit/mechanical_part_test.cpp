// The model mechanical-part: its genus, its volume in closed form, and that its two forms are one solid.
#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

#include "common/mesh/models/machined_part.h"
#include "tests/unit/implicit_checks.h"
#include "tests/unit/model_checks.h"

namespace voxcarve {
namespace {

using namespace test;

/// Of the default part, with disks of area `disk` r^2: pi, or n / 2 sin(2 pi / n) for polygons of n sides.
double volume(double disk) {
  // The base less its open slots; cheeks above it; the bar between them.
  double sum = (2 * 200 * 44 + 136 * 112) * 12 + 2 * 64 * 16 * 108 + 20 * 68 * 16;
  sum += disk * (26 * 26 * 16 - 18 * 18 * 12 - 11 * 11 * 16);        // boss, counterbore, and bore below it
  sum += 2 * disk * (24 * 24 * 8 - 16 * 16 * 24);                    // pin bosses and bores
  sum -= 2 * (disk * 7 * 7 + 14 * 56) * 12;                          // slots
  sum -= 2 * 4 * disk * (10 * 10 * 5 + 6 * 6 * 7);                   // bolt holes
  sum -= 2 * 6 * disk * 2.5 * 2.5 * 12 + 2 * 4 * disk * 4 * 4 * 16;  // dowel holes and vents
  return sum;
}

TEST(MechanicalPart, HasItsGenus) {
  const auto check = [](int bolt_holes, int dowel_holes, int vents, int arc_segments) {
    const std::string spec = "mechanical-part?bolt_holes=" + std::to_string(bolt_holes) +
                             "&dowel_holes=" + std::to_string(dowel_holes) + "&vents=" + std::to_string(vents) +
                             "&arc_segments=" + std::to_string(arc_segments);
    const TriangleSoup soup = make_procedural(spec);
    expect_closed(soup, spec);
    EXPECT_TRUE(has_single_fans(soup)) << spec;
    ASSERT_EQ(parts_of(soup).size(), 1U) << spec;
    // The opening between cheeks and bar, the middle bore, two pin bores and two slots; every row is there twice.
    EXPECT_EQ(genus_of(soup), 6 + 2 * (bolt_holes + dowel_holes + vents)) << spec;
  };
  check(0, 0, 0, 3);
  check(4, 6, 4, 12);
  check(1, 0, 0, 1);
  check(0, 1, 0, 2);
  check(0, 0, 1, 2);
  check(3, 7, 5, 4);
  check(9, 23, 6, 2);
  check(40, 40, 40, 1);
}

TEST(MechanicalPart, HasItsVolume) {
  for (const int arc_segments : {1, 3, 12, 50}) {
    const int sides = 4 * arc_segments;
    const TriangleSoup soup = make_procedural("mechanical-part?arc_segments=" + std::to_string(arc_segments));
    expect_relative(signed_volume(soup), volume(polygon_area(sides, 1)));
  }
  expect_volume(*make_implicit("mechanical-part?form=implicit"), volume(pi), case_count(1'000'000U));
}

TEST(MechanicalPart, FormsAgree) {
  // The boss is the widest: 48 chords of a circle of radius 26 are 26 (1 - cos(pi / 48)) = 0.056 off it.
  for (const std::string parameters : {"", "bolt_holes=9&dowel_holes=11&vents=6&"}) {
    SCOPED_TRACE(parameters);
    const ImplicitSolid solid = *make_implicit("mechanical-part?" + parameters + "form=implicit");
    expect_surface_agrees(solid, make_procedural("mechanical-part?" + parameters + "form=mesh"), 0.056,
                          case_count(20'000U));
  }
}

TEST(MechanicalPart, HasAValidClearanceAndATightBox) {
  const ImplicitSolid solid = *make_implicit("mechanical-part?width=2&form=implicit");
  expect_clearance_is_valid(solid, case_count(20'000U));
  expect_box_holds(solid, case_count(20'000U));
  // The default of 200 x 200 x 120, to scale. The base's corners and the cheeks' upper edges are in the solid.
  EXPECT_EQ(solid.box.lower, Point(-1, -1, 0));
  EXPECT_EQ(solid.box.upper, Point(1, 1, 1.2));
  EXPECT_TRUE(solid.inside({-1, -1, 0}));
  EXPECT_TRUE(solid.inside({1, 1, 0.12}));
  EXPECT_TRUE(solid.inside({0.3, 0.4, 1.2}));
  const Box mesh = bounds(make_procedural("mechanical-part?width=2"));
  EXPECT_EQ(mesh.lower, solid.box.lower);
  EXPECT_EQ(mesh.upper, solid.box.upper);
}

TEST(MechanicalPart, HolesAreOpenAtTheirFaces) {
  const ImplicitSolid solid = *make_implicit("mechanical-part?form=implicit");
  // Down the middle: no skin on the base's faces, the boss's end, or the counterbore's floor, where primitives end.
  for (const double z : {0.0, 6.0, 12.0, 16.0, 20.0, 28.0}) {
    EXPECT_FALSE(solid.inside({0, 0, z})) << z;
    EXPECT_TRUE(solid.inside({0, 19, z})) << z;
  }
  EXPECT_TRUE(solid.inside({15, 0, 15.9}));   // below the counterbore's floor
  EXPECT_FALSE(solid.inside({15, 0, 16.1}));  // in the counterbore
  for (const double y : {-58.0, -50.0, -42.0, -34.0, 34.0, 42.0, 50.0, 58.0}) {
    EXPECT_FALSE(solid.inside({0, y, 74})) << y;        // the pin's bore
    EXPECT_TRUE(solid.inside({0, y, 74 + 17.0})) << y;  // around it
    if (std::abs(y) <= 50) {
      EXPECT_FALSE(solid.inside({7.5, y, 30})) << y;  // a vent, of radius 4
    }
  }
  for (const double z : {0.0, 7.0, 12.0}) {
    EXPECT_FALSE(solid.inside({24, 82, z})) << z;     // a bolt hole at 192 / 8
    EXPECT_FALSE(solid.inside({16, -63.5, z})) << z;  // a dowel hole at 192 / 12
    EXPECT_FALSE(solid.inside({50, 34.5, z})) << z;   // the end of a slot
    EXPECT_TRUE(solid.inside({50, 35.5, z})) << z;
  }
}

TEST(MechanicalPart, HasThePapersSizeOfSurface) {
  // On the paper's finest grid marching cubes has a vertex an edge of the grid that crosses the surface and
  // 2 (vertices - Euler characteristic) triangles.
  const ImplicitSolid solid = *make_implicit("mechanical-part?form=implicit");
  constexpr int kWide = 202;  // with a layer of outer samples
  constexpr int kHigh = 122;
  std::vector<std::uint8_t> layer(kWide * kWide, 0);
  std::int64_t crossed = 0;
  for (int k = 0; k < kHigh; ++k) {
    std::vector<std::uint8_t> next(kWide * kWide, 0);
    for (int j = 0; j < kWide; ++j) {
      for (int i = 0; i < kWide; ++i) {
        const auto at = static_cast<std::size_t>(j * kWide + i);
        next[at] = solid.inside(Point(i - 100.5, j - 100.5, k - 0.5)) ? 1 : 0;
        crossed += next[at] != layer[at] ? 1 : 0;
        if (i > 0) crossed += next[at] != next[at - 1] ? 1 : 0;
        if (j > 0) crossed += next[at] != next[at - kWide] ? 1 : 0;
      }
    }
    layer = std::move(next);
  }
  const std::int64_t euler_characteristic = 2 - 2 * 34;
  const auto triangles = static_cast<double>(2 * (crossed - euler_characteristic));
  EXPECT_NEAR(triangles, 271'504, 0.02 * 271'504);  // [He95, Table 2]
}

TEST(MachinedPart, RefusesPassagesThatHaveNoFace) {
  MachinedPart part;
  part.boxes = {{Point(0, 0, 0), Point(4, 4, 1)}};
  Passage hole;
  hole.center = {2, 2};
  hole.frame = {1, 1};
  hole.high = 1;
  hole.radius = 0.5;
  part.passages = {hole};
  EXPECT_EQ(genus_of(surface_of(part, 2)), 1);
  part.passages = {hole, hole};
  EXPECT_THROW(surface_of(part, 2), InputError);
  hole.center = {4, 2};
  part.passages = {hole};
  EXPECT_THROW(surface_of(part, 2), InputError);
}

}  // namespace
}  // namespace voxcarve
