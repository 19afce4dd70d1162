#include "metrics/hausdorff.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/mesh/aabb_tree.h"
#include "common/run/errors.h"
#include "tests/unit/metric_shapes.h"

namespace voxcarve {
namespace {

using namespace test;

HausdorffDistances distances(const TriangleSoup& a, const TriangleSoup& b, double error = 1e-3) {
  RunContext context;
  return std::get<HausdorffDistances>(hausdorff_distances(a, b, {.error = error, .samples = 5000}, context));
}

/// The interval holds the true value and is as narrow as promised.
void expect_interval(const DistanceInterval& interval, double expected, double width) {
  EXPECT_LE(interval.lower, expected);
  EXPECT_GE(interval.upper, expected);
  EXPECT_LE(interval.upper - interval.lower, width);
}

TEST(Hausdorff, IdenticalShapesAreAtZeroExactly) {
  for (const TriangleSoup& soup : {unit_cube(), torus(2, 0.5, 24, 12), translated(sphere(1, 3), {1e7, 3, -5})}) {
    TriangleSoup shuffled = soup;
    std::reverse(shuffled.triangles.begin(), shuffled.triangles.end());
    for (Triangle& t : shuffled.triangles) std::rotate(t.begin(), t.begin() + 1, t.end());
    for (const TriangleSoup& other : {soup, shuffled, flipped(soup), joined(soup, soup)}) {
      const HausdorffDistances d = distances(soup, other);
      EXPECT_EQ(d.symmetric.lower, 0);
      EXPECT_EQ(d.symmetric.upper, 0);
      EXPECT_EQ(d.mean, 0);
      EXPECT_EQ(d.rms, 0);
    }
  }
}

TEST(Hausdorff, ShiftedCube) {
  // The face that the shift moves away is at distance shift from the other cube, and nothing is further.
  const TriangleSoup cube = unit_cube();
  for (const double shift : {1.0 / 3, 0.01, 2.0}) {
    for (int axis = 0; axis < 3; ++axis) {
      const HausdorffDistances d = distances(cube, translated(cube, shift * Point::Unit(axis)));
      const double width = 1e-3 * std::sqrt(3.0);
      expect_interval(d.a_to_b, shift, width);
      expect_interval(d.b_to_a, shift, width);
      expect_interval(d.symmetric, shift, width);
    }
  }
}

TEST(Hausdorff, SpikeOnAPlane) {
  // The spike's tip is 3 above the square. The square is covered by the other shape but for the spike's foot, a square
  // of side 0.2 whose middle is nearest to a side face: the foot's centre is at (0.1, 3) of the face's section, the
  // line from (0, 0) to (0.1, 3), so at distance 0.1 * 3 / sqrt(0.1^2 + 3^2) from it.
  TriangleSoup square;
  square.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  square.triangles = {{0, 1, 2}, {0, 2, 3}};
  TriangleSoup spike = square;
  spike.positions.insert(spike.positions.end(),
                         {{-0.1, -0.1, 0}, {0.1, -0.1, 0}, {0.1, 0.1, 0}, {-0.1, 0.1, 0}, {0, 0, 3}});
  spike.triangles = {{0, 1, 5}, {0, 5, 4}, {1, 2, 6}, {1, 6, 5}, {2, 3, 7}, {2, 7, 6},
                     {3, 0, 4}, {3, 4, 7}, {4, 5, 8}, {5, 6, 8}, {6, 7, 8}, {7, 4, 8}};
  const HausdorffDistances d = distances(square, spike, 1e-5);
  const double width = 1e-5 * std::sqrt(8.0);
  expect_interval(d.a_to_b, 0.3 / std::sqrt(9.01), width);
  expect_interval(d.b_to_a, 3, width);
  expect_interval(d.symmetric, 3, width);
}

TEST(Hausdorff, ConcentricSpheres) {
  // The same subdivision at radii 1 and 2: corresponding vertices are at distance 1. Every point of the outer
  // polyhedron is at most 2 from the centre and the inner one holds a ball of its inradius; every inner point has its
  // double on the outer polyhedron, at distance its norm <= 1.
  const TriangleSoup inner = sphere(1, 4);
  const TriangleSoup outer = sphere(2, 4);
  const HausdorffDistances d = distances(inner, outer);
  double inradius = 1;
  for (const Triangle& t : inner.triangles) {
    const Point normal = area_vector(inner, t).normalized();
    inradius = std::min(inradius, normal.dot(inner.positions[t[0]]));
  }
  EXPECT_GE(d.symmetric.upper, 1);
  EXPECT_LE(d.symmetric.lower, 2 - inradius);
  EXPECT_LE(d.symmetric.upper - d.symmetric.lower, 1e-3 * d.diagonal);
  EXPECT_LE(d.a_to_b.lower, 1);
  ASSERT_TRUE(d.mean.has_value());
  EXPECT_GT(*d.mean, inradius);
  EXPECT_LE(*d.mean, *d.rms);
  EXPECT_LE(*d.rms, d.symmetric.upper);
}

TEST(Hausdorff, MaximumInsideOfATriangle) {
  // One big triangle against its three corners (as triangles without area): the furthest point is its circumcentre.
  TriangleSoup big;
  big.positions = {{0, 0, 0}, {4, 0, 0}, {1, 3, 0}};
  big.triangles = {{0, 1, 2}};
  TriangleSoup corners = big;
  corners.triangles = {{0, 0, 0}, {1, 1, 1}, {2, 2, 2}};
  const HausdorffDistances d = distances(big, corners, 1e-4);
  // Circumcentre (2, y): 4 + y^2 = 1 + (3 - y)^2, so y = 1 and the radius is sqrt 5.
  expect_interval(d.a_to_b, std::sqrt(5.0), 1e-4 * 5);
  expect_interval(d.b_to_a, 0, 1e-4 * 5);
  EXPECT_FALSE(d.mean.has_value());  // the corners have no area to sample
}

TEST(Hausdorff, SegmentsAndPoints) {
  TriangleSoup segment;
  segment.positions = {{0, 0, 0}, {1, 0, 0}, {0.5, 0, 0}};
  segment.triangles = {{0, 1, 2}};
  TriangleSoup point;
  point.positions = {{0, 2, 0}};
  point.triangles = {{0, 0, 0}};
  const HausdorffDistances d = distances(segment, point);
  expect_interval(d.a_to_b, std::sqrt(5.0), 1e-3);
  expect_interval(d.b_to_a, 2, 1e-3);
  EXPECT_EQ(d.diagonal, 1);
  // The reference is a point: the error is a share of the box of both.
  EXPECT_DOUBLE_EQ(distances(point, segment).diagonal, std::sqrt(5.0));
  EXPECT_EQ(distances(point, point).symmetric.upper, 0);
}

TEST(Hausdorff, FineSubdivisionOfTheSameSurfaceIsNearZero) {
  // The same square in 2 and in 2 * 64^2 triangles: rounding alone is left.
  TriangleSoup fine;
  constexpr std::uint32_t n = 64;
  for (std::uint32_t j = 0; j <= n; ++j) {
    for (std::uint32_t i = 0; i <= n; ++i) fine.positions.emplace_back(i / 64.0, j / 64.0, i / 64.0 + j / 32.0);
  }
  for (std::uint32_t j = 0; j < n; ++j) {
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::uint32_t v = j * (n + 1) + i;
      fine.triangles.push_back({v, v + 1, v + n + 2});
      fine.triangles.push_back({v, v + n + 2, v + n + 1});
    }
  }
  TriangleSoup coarse;
  coarse.positions = {{0, 0, 0}, {1, 0, 1}, {1, 1, 3}, {0, 1, 2}};
  coarse.triangles = {{0, 1, 2}, {0, 2, 3}};
  const HausdorffDistances d = distances(coarse, fine, 1e-3);
  EXPECT_LE(d.b_to_a.upper, 1e-12);
  EXPECT_LE(d.a_to_b.upper, 1e-3 * d.diagonal);
  EXPECT_LE(d.a_to_b.lower, 1e-12);
}

TEST(Hausdorff, IntervalsHoldDenseSamples) {
  // Random soups against the slow, obvious twin: distances at a fine grid of points of every triangle.
  Sequence random(23);
  for (int round = 0; round < 8; ++round) {
    std::array<TriangleSoup, 2> soups;
    for (TriangleSoup& soup : soups) {
      for (std::uint32_t i = 0; i < 30; ++i) {
        soup.positions.push_back(random.point());
        if (i % 3 == 2) soup.triangles.push_back({i - 2, i - 1, i});
      }
    }
    const HausdorffDistances d = distances(soups[0], soups[1], 1e-3);
    for (const int side : {0, 1}) {
      const TriangleSoup& from = soups[static_cast<std::size_t>(side)];
      const AabbTree tree(soups[static_cast<std::size_t>(1 - side)]);
      constexpr int n = 60;
      double greatest = 0;
      for (const Triangle& t : from.triangles) {
        for (int i = 0; i <= n; ++i) {
          for (int j = 0; i + j <= n; ++j) {
            const Point p =
                (i * from.positions[t[0]] + j * from.positions[t[1]] + (n - i - j) * from.positions[t[2]]) / n;
            greatest = std::max(greatest, tree.nearest(p).squared_distance);
          }
        }
      }
      greatest = std::sqrt(greatest);
      const DistanceInterval& interval = side == 0 ? d.a_to_b : d.b_to_a;
      EXPECT_GE(interval.upper, greatest - 1e-12);
      // No point is further than sqrt(3) / n from a sample (sides are shorter than sqrt 3), nor the distance.
      EXPECT_LE(interval.lower, greatest + std::sqrt(3.0) / n);
      EXPECT_LE(interval.upper - interval.lower, 1e-3 * d.diagonal);
    }
  }
}

TEST(Hausdorff, FarFromTheOriginAndTinyAndHuge) {
  for (const double scale : {1e-12, 1e12, 1e-150}) {
    TriangleSoup cube = unit_cube();
    for (Point& p : cube.positions) p *= scale;
    const HausdorffDistances d = distances(cube, translated(cube, {scale / 4, 0, 0}));
    expect_interval(d.symmetric, scale / 4, 1e-3 * std::sqrt(3.0) * scale);
  }
  const TriangleSoup far_away = translated(unit_cube(), Point::Constant(1e9));  // 0.25 is exact there
  expect_interval(distances(far_away, translated(far_away, {0.25, 0, 0})).symmetric, 0.25, 1e-3 * std::sqrt(3.0));
}

TEST(Hausdorff, DeclaresTheMemoryOfItsSamples) {
  const TriangleSoup cube = unit_cube();
  const TriangleSoup shifted = translated(cube, Point(0.1, 0, 0));
  RunContext context;
  context.memory_budget = 16 * 100'000;  // a distance and two triangles each
  const HausdorffOptions fits{.samples = 99'000};
  const HausdorffOptions too_many{.samples = 100'000};
  EXPECT_TRUE(std::holds_alternative<HausdorffDistances>(hausdorff_distances(cube, shifted, fits, context)));
  EXPECT_THROW(hausdorff_distances(cube, shifted, too_many, context), ResourceError);
}

TEST(Hausdorff, MeanOfParallelSquares) {
  TriangleSoup square;
  square.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  square.triangles = {{0, 1, 2}, {0, 2, 3}};
  const HausdorffDistances d = distances(square, translated(square, {0, 0, 0.5}));
  EXPECT_NEAR(*d.mean, 0.5, 1e-12);  // every point is exactly opposite of another
  EXPECT_NEAR(*d.rms, 0.5, 1e-12);
}

TEST(Hausdorff, MeanIsUniformInArea) {
  // A right triangle in the plane z = x, over its shadow with legs 1 in a sheet z = 0 of area 50. The sheet is part of
  // both shapes, so the tilted triangle alone is at a distance: z = x of each point. Over a right triangle with legs 1
  // the mean of x is 1 / 3 and that of x^2 is 1 / 6.
  TriangleSoup sheet;
  sheet.positions = {{-1, -1, 0}, {9, -1, 0}, {-1, 9, 0}};
  sheet.triangles = {{0, 1, 2}};
  TriangleSoup both = sheet;
  both.positions.insert(both.positions.end(), {{0, 0, 0}, {1, 0, 1}, {0, 1, 0}});
  both.triangles.push_back({3, 4, 5});
  RunContext context;
  const auto d = std::get<HausdorffDistances>(hausdorff_distances(both, sheet, {.samples = 40000}, context));
  // The tilted triangle has area sqrt(1 / 2); the other direction is 0 and halves both averages. Some 560 samples fall
  // on it, with values of standard deviation sqrt(1 / 18), so the mean is known to 1 % of share / 2 or so: 7e-5.
  const double share = std::sqrt(0.5) / (50 + std::sqrt(0.5));
  EXPECT_NEAR(*d.mean, share / 6, 2e-4);
  EXPECT_NEAR(*d.rms, std::sqrt(share / 12), 2e-3);
}

TEST(Hausdorff, ShapesWithoutDistance) {
  RunContext context;
  const auto reason = [&](const TriangleSoup& a, const TriangleSoup& b) {
    return std::get<Undefined>(hausdorff_distances(a, b, {}, context)).reason;
  };
  EXPECT_EQ(reason(TriangleSoup(), unit_cube()), "the first shape has no triangles");
  EXPECT_EQ(reason(unit_cube(), TriangleSoup()), "the second shape has no triangles");
  TriangleSoup huge = unit_cube();
  for (Point& p : huge.positions) p = 1e308 * (2 * p - Point::Ones());
  EXPECT_EQ(reason(huge, unit_cube()), "the shapes' coordinates are too far apart for double precision");
}

}  // namespace
}  // namespace voxcarve
