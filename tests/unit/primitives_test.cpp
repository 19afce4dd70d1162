// Building blocks of the procedural models.
#include <gmock/gmock-matchers.h>
#include <gtest/gtest.h>

#include "tests/unit/model_checks.h"

namespace voxcarve {
namespace {

using namespace test;

TEST(Primitives, AreClosedOutwardSpheres) {
  // Triangle counts as the header states them.
  const std::vector<Point> bend = {{0, 0, 0}, {0, 0, 1}, {0, 0.5, 2}, {1, 1, 2.5}};
  const std::vector<Eigen::Vector2d> bead = {{1, 0}, {2, 1}, {0, 3}};
  const Eigen::Affine3d mirror(Eigen::Scaling(-1.0, 1.0, 2.0));
  const std::vector<std::pair<TriangleSoup, std::size_t>> solids = {
      {box({0, 0, 0}, {1, 2, 3}), 12},
      {uv_sphere({1, 2, 3}, 2, 7, 5), 2 * 7 * 4},
      {uv_sphere({0, 0, 0}, 1, 3, 2), 6},
      {icosphere({1, 0, 0}, 2, 3), 20 * 64},
      {cylinder({1, 1, 1}, {2, 3, 4}, 0.5, 9), 4 * 8},
      {capsule({0, 0, 0}, 1, {1, 2, 3}, 0.5, 8, 6), 2 * 8 * 5},
      {capsule({0, 0, 0}, 0.2, {0, -3, 0}, 1, 5, 3), 2 * 5 * 2},
      {swept_tube(bend, 0.2, 6), 3 * 12 + 2 * 4},
      {lathe(bead, 5), 5 * 2 + 5 + 3},
      {transformed(uv_sphere({0, 0, 0}, 1, 8, 8), mirror), 2 * 8 * 7},
      {block_surface(
           {1, 2, 1}, [](int, int, int) { return true; }, 1, 3),
       10 * 9 * 2}};
  for (std::size_t i = 0; i < solids.size(); ++i) {
    const auto& [soup, triangles] = solids[i];
    expect_closed(soup, "solid " + std::to_string(i));
    EXPECT_TRUE(has_single_fans(soup)) << i;
    EXPECT_EQ(soup.triangles.size(), triangles) << i;
    EXPECT_EQ(genus_of(soup), 0) << i;
    EXPECT_GT(signed_volume(soup), 0) << i;
  }
}

TEST(Primitives, HaveTheVolumesOfTheirFormulas) {
  expect_relative(signed_volume(box({0, 0, 0}, {1, 2, 3})), 6);
  // Icosahedron of circumradius 1: edge 4 / sqrt(10 + 2 sqrt 5), volume 5 (3 + sqrt 5) / 12 edge^3.
  const double edge = 4 / std::sqrt(10 + 2 * std::sqrt(5.0));
  expect_relative(signed_volume(icosphere({0, 0, 0}, 1, 0)), 5 * (3 + std::sqrt(5.0)) / 12 * edge * edge * edge);
  expect_relative(signed_volume(cylinder({0, 0, 0}, {0, 3, 4}, 2, 6)), polygon_area(6, 2) * 5);
  // Lathe: frusta of pentagons, A h (r0^2 + r0 r1 + r1^2) / 3 with A of radius 1: (1 + 2 + 4) / 3 and 4 * 2 / 3.
  const std::vector<Eigen::Vector2d> bead = {{1, 0}, {2, 1}, {0, 3}};
  expect_relative(signed_volume(lathe(bead, 5)), polygon_area(5, 1) * (7.0 + 8.0) / 3);
  // A straight tube in three pieces is a cylinder.
  const std::vector<Point> straight = {{0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {5, 5, 5}};
  expect_relative(signed_volume(swept_tube(straight, 0.5, 8)), polygon_area(8, 0.5) * 5 * std::sqrt(3.0));
}

TEST(Primitives, SphereAndCapsuleVerticesLieOnTheirBalls) {
  for (const Point& p : uv_sphere({1, 2, 3}, 2, 9, 7).positions) EXPECT_NEAR((p - Point(1, 2, 3)).norm(), 2, 1e-14);
  for (const Point& p : icosphere({0, 0, 0}, 3, 3).positions) EXPECT_NEAR(p.norm(), 3, 1e-14);
  // Three belts: pole, touching circle, touching circle, pole. The tangent cone meets each ball at a right angle, so
  // every vertex has distance 1 or 0.5 of the centre of the ball that it lies on.
  const Point a(0, 0, 0);
  const Point b(3, 0, 0);
  for (const Point& p : capsule(a, 1, b, 0.5, 8, 3).positions) {
    EXPECT_LT(std::min(std::abs((p - a).norm() - 1), std::abs((p - b).norm() - 0.5)), 1e-14);
  }
}

TEST(Primitives, LoftRefusesRingsThatDoNotFit) {
  const Ring triangle = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const Ring square = {{0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  const Ring pole = {{0, 0, 1}};
  using Rings = std::vector<Ring>;
  EXPECT_THROW(loft(Rings{triangle}), InputError);
  EXPECT_THROW(loft(Rings{triangle, square}), InputError);
  EXPECT_THROW(loft(Rings{pole, pole}), InputError);
  EXPECT_THROW(loft(Rings{triangle, pole, triangle}), InputError);
  EXPECT_THROW(loft(Rings{pole, triangle, triangle}, LoftEnds::kJoined), InputError);
  EXPECT_NO_THROW(loft(Rings{triangle, pole}));
  EXPECT_NO_THROW(loft(Rings{pole, triangle}));
  EXPECT_THROW(capsule({0, 0, 0}, 2, {1, 0, 0}, 0.5, 8, 4), InputError);  // one ball holds the other
  EXPECT_THROW(swept_tube(std::vector<Point>{{0, 0, 0}}, 1, 8), InputError);
}

// --- every model -------------------------------------------------------------------------------------------------

}  // namespace
}  // namespace voxcarve
