#include "metrics/normal_deviation.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <numbers>

#include "tests/unit/metric_shapes.h"

namespace voxcarve {
namespace {

using namespace test;

constexpr double kDegree = std::numbers::pi / 180;

NormalDeviation deviation(const TriangleSoup& a, const TriangleSoup& b, int threads = 1) {
  RunContext context;
  context.threads = threads;
  return std::get<NormalDeviation>(normal_deviation(a, b, {}, context));
}

/// The unit square of the plane z = 0, turned about the x axis by an angle in degrees and then moved.
TriangleSoup tilted_square(double angle, const Point& shift = Point::Zero()) {
  TriangleSoup soup;
  const double y = std::cos(angle * kDegree);
  const double z = std::sin(angle * kDegree);
  soup.positions = {{0, 0, 0}, {1, 0, 0}, {1, y, z}, {0, y, z}};
  soup.triangles = {{0, 1, 2}, {0, 2, 3}};
  return translated(soup, shift);
}

TEST(NormalDeviation, IdenticalShapesDoNotDeviate) {
  for (const TriangleSoup& soup : {unit_cube(), torus(2, 0.5, 24, 12), sphere(1, 3)}) {
    for (const TriangleSoup& other : {soup, flipped(soup), joined(soup, soup)}) {
      const NormalDeviation d = deviation(soup, other);
      EXPECT_EQ(d.mean, 0);
      EXPECT_EQ(d.rms, 0);
      EXPECT_EQ(d.above_30, 0);
    }
  }
}

TEST(NormalDeviation, TiltedPlanes) {
  // Each shape has one plane, so every sample deviates by the angle between them; angles are those of lines.
  for (const double angle : {0.001, 20.0, 40.0, 90.0, 140.0}) {
    const double expected = std::min(angle, 180 - angle);
    const NormalDeviation d = deviation(tilted_square(0), tilted_square(angle));
    for (const double value : {d.mean, d.rms, d.a_to_b.mean, d.a_to_b.rms, d.b_to_a.mean, d.b_to_a.rms}) {
      EXPECT_NEAR(value, expected, 1e-9);
    }
    for (const double share : {d.above_30, d.a_to_b.above_30, d.b_to_a.above_30}) {
      EXPECT_EQ(share, expected > 30 ? 1 : 0);
    }
  }
}

TEST(NormalDeviation, WeighsByArea) {
  // Two unit squares far apart; the other shape has the first one as it is and the second one tilted by 45 degrees:
  // half of the area deviates by 45 degrees. There is one sample in each of 20,000 equal shares of the area.
  const Point far(100, 0, 0);
  const NormalDeviation d =
      deviation(joined(tilted_square(0), tilted_square(0, far)), joined(tilted_square(0), tilted_square(45, far)));
  for (const auto& side : {d.a_to_b, d.b_to_a}) {
    EXPECT_NEAR(side.mean, 22.5, 1e-9);
    EXPECT_NEAR(side.rms, 45 / std::sqrt(2.0), 1e-9);
    EXPECT_EQ(side.above_30, 0.5);
  }
  EXPECT_NEAR(d.mean, 22.5, 1e-9);
  EXPECT_NEAR(d.rms, 45 / std::sqrt(2.0), 1e-9);
  EXPECT_EQ(d.above_30, 0.5);
}

TEST(NormalDeviation, DirectionsAreToldApart) {
  // The second shape has a wall, of the same area as the floor, that stands on the floor far from its rim: samples of
  // the wall are nearest to the floor, at a right angle; those of the first shape lie on the floor that both have.
  const TriangleSoup floor = tilted_square(0);
  const NormalDeviation d = deviation(floor, joined(floor, tilted_square(90, {0, 0.5, 0})));
  EXPECT_EQ(d.a_to_b.mean, 0);
  EXPECT_NEAR(d.b_to_a.mean, 45, 1e-9);
  EXPECT_NEAR(d.b_to_a.rms, 90 / std::sqrt(2.0), 1e-9);
  EXPECT_NEAR(d.mean, 22.5, 1e-9);
  EXPECT_NEAR(d.rms, 45, 1e-9);  // the root of (0 + 90^2 / 2) / 2
}

/// Mean and root mean square of the angle, in degrees, between a polyhedron inscribed in the unit sphere and the sphere
/// in the same direction: by quadrature at the centroids of n^2 pieces of every triangle.
std::array<double, 2> angles_to_sphere(const TriangleSoup& soup, int n) {
  double sum = 0;
  double square = 0;
  double area = 0;
  for (const Triangle& t : soup.triangles) {
    const Point normal = area_vector(soup, t).normalized();
    const double piece = area_vector(soup, t).norm() / (n * n);
    for (int i = 0; i < n; ++i) {
      for (int j = 0; i + j < n; ++j) {
        for (const double third : {1.0 / 3, 2.0 / 3}) {
          if (third > 0.5 && i + j + 1 >= n) continue;  // beyond the last row
          const double u = (i + third) / n;
          const double v = (j + third) / n;
          const Point p = (1 - u - v) * soup.positions[t[0]] + u * soup.positions[t[1]] + v * soup.positions[t[2]];
          const double angle = std::atan2(normal.cross(p).norm(), normal.dot(p)) / kDegree;
          sum += piece * angle;
          square += piece * angle * angle;
          area += piece;
        }
      }
    }
  }
  return {sum / area, std::sqrt(square / area)};
}

TEST(NormalDeviation, CoarseSphereAgainstAFineOne) {
  // The deviation from the fine sphere differs from that from the smooth one by no more than the fine one's own, in the
  // mean as in the root mean square. The nearest fine point lies in the sample's direction but for the fine angle times
  // the distance of the spheres, below 0.1: a tenth more.
  const TriangleSoup coarse = sphere(1, 2);
  const TriangleSoup fine = sphere(1, 7);
  const auto [mean, rms] = angles_to_sphere(coarse, 40);
  const auto [fine_mean, fine_rms] = angles_to_sphere(fine, 2);
  ASSERT_GT(mean, 25 * fine_mean);
  const NormalDeviation d = deviation(coarse, fine);
  // 20,000 samples of angles below 20 degrees: their standard deviation is below 10, that of the mean below 0.07.
  EXPECT_NEAR(d.a_to_b.mean, mean, 1.1 * fine_mean + 0.07);
  EXPECT_NEAR(d.a_to_b.rms, rms, 1.1 * fine_rms + 0.07);
  EXPECT_EQ(d.above_30, 0);
}

TEST(NormalDeviation, ScaleDoesNotMatter) {
  const TriangleSoup a = unit_cube();
  const TriangleSoup b = sphere(0.7, 2);
  const NormalDeviation d = deviation(a, b);
  EXPECT_GT(d.mean, 5);
  for (const double factor : {0x1p-500, 0x1p-40, 0x1p40, 0x1p500}) {
    TriangleSoup small_a = a;
    TriangleSoup small_b = b;
    for (Point& p : small_a.positions) p *= factor;
    for (Point& p : small_b.positions) p *= factor;
    const NormalDeviation e = deviation(small_a, small_b);
    EXPECT_EQ(e.mean, d.mean);
    EXPECT_EQ(e.rms, d.rms);
  }
}

TEST(NormalDeviation, TheSameOnAnyNumberOfThreads) {
  const NormalDeviation one = deviation(torus(2, 0.5, 24, 12), sphere(2, 3), 1);
  const NormalDeviation four = deviation(torus(2, 0.5, 24, 12), sphere(2, 3), 4);
  EXPECT_EQ(one.mean, four.mean);
  EXPECT_EQ(one.rms, four.rms);
  EXPECT_EQ(one.a_to_b.above_30, four.a_to_b.above_30);
}

TEST(NormalDeviation, TrianglesWithoutAreaAreNeitherSampledNorCompared) {
  TriangleSoup soup = tilted_square(0);
  soup.positions.emplace_back(0.5, 0, 0);
  soup.triangles.push_back({0, 4, 1});  // on a side
  soup.triangles.push_back({2, 2, 3});
  const NormalDeviation d = deviation(soup, tilted_square(20));
  EXPECT_NEAR(d.a_to_b.mean, 20, 1e-9);
  EXPECT_NEAR(d.b_to_a.mean, 20, 1e-9);
}

TEST(NormalDeviation, ShapesWithoutOne) {
  RunContext context;
  const auto reason = [&](const TriangleSoup& a, const TriangleSoup& b) {
    return std::get<Undefined>(normal_deviation(a, b, {}, context)).reason;
  };
  EXPECT_EQ(reason(TriangleSoup(), unit_cube()), "the first shape has no triangles");
  EXPECT_EQ(reason(unit_cube(), TriangleSoup()), "the second shape has no triangles");
  TriangleSoup line = unit_cube();
  line.triangles = {{0, 1, 1}};
  EXPECT_EQ(reason(unit_cube(), line), "a shape has no area to sample");
  EXPECT_EQ(reason(line, unit_cube()), "a shape has no area to sample");
}

}  // namespace
}  // namespace voxcarve
