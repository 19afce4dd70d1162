#include "common/mesh/winding_number.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <thread>
#include <vector>

#include "common/mesh/io/mesh_io.h"
#include "common/mesh/models/primitives.h"
#include "common/run/errors.h"
#include "tests/support/shapes.h"
#include "tests/unit/metric_shapes.h"

namespace voxcarve {
namespace {

using test::flipped;
using test::joined;
using test::make_box;
using test::Sequence;
using test::translated;
using test::unit_cube;

/// The slow twin: the sum over all triangles of the signed solid angle, by the formula as it is printed.
double slow_winding(const TriangleSoup& soup, const Point& point, const std::vector<std::int32_t>& multiplicity = {}) {
  double sum = 0;
  for (std::size_t t = 0; t < soup.triangles.size(); ++t) {
    const Point a = soup.positions[soup.triangles[t][0]] - point;
    const Point b = soup.positions[soup.triangles[t][1]] - point;
    const Point c = soup.positions[soup.triangles[t][2]] - point;
    const double la = a.norm();
    const double lb = b.norm();
    const double lc = c.norm();
    const double half = std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
    sum += (multiplicity.empty() ? 1 : multiplicity[t]) * 2 * half;
  }
  return sum / (4 * std::numbers::pi);
}

Point corner(const TriangleSoup& soup, std::size_t triangle, std::size_t which) {
  return soup.positions[soup.triangles[triangle][which]];
}

/// A point inside of a random triangle, away from its sides, moved along the normal by `distance`.
Point beside_surface(const TriangleSoup& soup, double distance, Sequence& random) {
  for (;;) {
    const std::size_t t = random.below(static_cast<std::uint32_t>(soup.triangles.size()));
    const Point weights = random.point() + Point::Constant(0.1);
    const Point normal = area_vector(soup, soup.triangles[t]);
    if (!(normal.norm() > 0)) continue;
    const Point on_it =
        weights[0] * corner(soup, t, 0) + weights[1] * corner(soup, t, 1) + weights[2] * corner(soup, t, 2);
    return on_it / weights.sum() + distance * normal.normalized();
  }
}

/// Points in the box and around it, far away, and close to the surface on both sides.
std::vector<Point> query_points(const TriangleSoup& soup, int count, std::uint64_t seed) {
  Sequence random(seed);
  const Box box = bounds(soup);
  const Point reach = box.extent() + Point::Constant(0.1 * box.diagonal());  // out of the plane of a flat soup
  std::vector<Point> points;
  for (int i = 0; i < test::case_count(count); ++i) {
    const double size = i % 5 == 0 ? 20 : 1.3;
    points.emplace_back(box.center() + size * (random.point() - Point::Constant(0.5)).cwiseProduct(reach));
    const double distance = (random.next() < 0.5 ? -1 : 1) * std::pow(10.0, -1 - 5 * random.next());
    points.push_back(beside_surface(soup, distance * box.diagonal(), random));
  }
  return points;
}

double largest_error(const TriangleSoup& soup, const std::vector<Point>& points, double accuracy,
                     const std::vector<std::int32_t>& multiplicity = {}) {
  const WindingNumber winding(soup, multiplicity, accuracy);
  double worst = 0;
  for (const Point& p : points) {
    const double error = std::abs(winding.at(p) - slow_winding(soup, p, multiplicity));
    if (!(error <= worst)) worst = error;
  }
  return worst;
}

/// Triangles of edges up to `size` in the unit cube, each on its own.
TriangleSoup confetti(std::uint32_t count, double size, std::uint64_t seed) {
  Sequence random(seed);
  TriangleSoup soup;
  for (std::uint32_t i = 0; i < count; ++i) {
    const Point origin = random.point();
    for (int k = 0; k < 3; ++k) soup.positions.emplace_back(origin + size * random.point());
    soup.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  return soup;
}

/// A square of n x n cells, two triangles each, over [-half, half]^2 at z = 0, its normals along +z.
TriangleSoup plate(double half, std::uint32_t n) {
  TriangleSoup soup;
  for (std::uint32_t j = 0; j <= n; ++j) {
    for (std::uint32_t i = 0; i <= n; ++i)
      soup.positions.emplace_back(half * (2.0 * i / n - 1), half * (2.0 * j / n - 1), 0);
  }
  for (std::uint32_t j = 0; j < n; ++j) {
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::uint32_t at = j * (n + 1) + i;
      soup.triangles.push_back({at, at + 1, at + n + 2});
      soup.triangles.push_back({at, at + n + 2, at + n + 1});
    }
  }
  return soup;
}

/// The plate of [models/genus.cpp]: a row of `genus` square holes.
TriangleSoup genus_plate(int genus, int subdivision) {
  const auto filled = [](int i, int j, int /*k*/) { return j != 1 || i % 2 == 0; };
  return block_surface({2 * genus + 1, 3, 1}, filled, 1.0, subdivision);
}

/// The first part of the triangles only: a surface with a large hole.
TriangleSoup torn(TriangleSoup soup, double part) {
  soup.triangles.resize(static_cast<std::size_t>(part * static_cast<double>(soup.triangles.size())));
  return soup;
}

TEST(WindingNumber, OneTriangleIsItsSolidAngle) {
  // The triangle between the axes covers one octant of the sphere seen from the origin, which is behind it.
  TriangleSoup soup;
  soup.positions = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  soup.triangles = {{0, 1, 2}};
  EXPECT_NEAR(WindingNumber(soup).at(Point::Zero()), 1.0 / 8, 1e-15);
  EXPECT_NEAR(WindingNumber(flipped(soup)).at(Point::Zero()), -1.0 / 8, 1e-15);
  // A regular tetrahedron's faces cover a quarter each of the sphere around its centre.
  soup.positions = {{1, 1, 1}, {-1, -1, 1}, {1, -1, -1}};  // the normal is (1, -1, 1) times 4, outward
  EXPECT_NEAR(WindingNumber(soup).at(Point::Zero()), 1.0 / 4, 1e-15);
}

TEST(WindingNumber, CubeInsideOutsideAndOnItsFacesEdgesAndCorners) {
  // On the surface the mean of both sides: the solid angle of the cube there, seen from the point, over the sphere's.
  const WindingNumber winding(unit_cube());
  EXPECT_NEAR(winding.at({0.5, 0.5, 0.5}), 1, 1e-14);
  EXPECT_NEAR(winding.at({0.999, 0.001, 0.5}), 1, 1e-13);
  EXPECT_NEAR(winding.at({1.001, 0.5, 0.5}), 0, 1e-13);
  EXPECT_NEAR(winding.at({1, 0.25, 0.5}), 1.0 / 2, 1e-14);  // inside of a triangle
  EXPECT_NEAR(winding.at({1, 0.5, 0.5}), 1.0 / 2, 1e-14);   // on a face's diagonal
  EXPECT_NEAR(winding.at({1, 0.25, 0}), 1.0 / 4, 1e-14);
  EXPECT_NEAR(winding.at({1, 0, 0}), 1.0 / 8, 1e-14);
  EXPECT_NEAR(WindingNumber(flipped(unit_cube())).at({0.5, 0.5, 0.5}), -1, 1e-14);
}

TEST(WindingNumber, AnOpenCubeCountsTheFacesThatAreLeft) {
  // Around the centre each of the six faces covers a sixth.
  TriangleSoup soup = unit_cube();
  soup.triangles.resize(10);
  EXPECT_NEAR(WindingNumber(soup).at({0.5, 0.5, 0.5}), 5.0 / 6, 1e-14);
}

TEST(WindingNumber, APlateIsItsPyramid) {
  // A rectangle of 2 a x 2 b at height h over its centre covers 4 atan(a b / (h sqrt(a^2 + b^2 + h^2))).
  const WindingNumber winding(plate(3, 64));
  for (const double h : {1e-9, 1e-4, 0.1, 1.0, 5.0, 40.0, 1000.0}) {
    const double expected = std::atan(9 / (h * std::sqrt(18 + h * h))) / std::numbers::pi;
    EXPECT_NEAR(winding.at({0, 0, -h}), expected, WindingNumber::kAccuracy) << h;
    EXPECT_NEAR(winding.at({0, 0, h}), -expected, WindingNumber::kAccuracy) << h;
  }
  EXPECT_NEAR(winding.at({0.3, 0.7, 0}), 0, WindingNumber::kAccuracy);  // the mean of both sides
}

TEST(WindingNumber, NestedSpheresAdd) {
  const TriangleSoup outer = icosphere(Point::Zero(), 1, 5);
  const TriangleSoup inner = icosphere(Point::Zero(), 0.5, 4);
  const WindingNumber solid(joined(outer, inner));
  const WindingNumber shell(joined(outer, as_cavity(inner)));
  const WindingNumber twice_less(joined(flipped(outer), flipped(inner)));
  Sequence random(3);
  for (int i = 0; i < test::case_count(2000); ++i) {
    const Point p = 2.4 * (random.point() - Point::Constant(0.5));
    const double radius = p.norm();
    // The icospheres' facets reach down to more than 0.98 of their radius.
    if ((radius > 0.49 && radius <= 0.5) || (radius > 0.98 && radius <= 1)) continue;
    const int expected = (radius < 0.5 ? 1 : 0) + (radius < 1 ? 1 : 0);
    ASSERT_NEAR(solid.at(p), expected, WindingNumber::kAccuracy);
    ASSERT_NEAR(shell.at(p), expected == 1 ? 1 : 0, WindingNumber::kAccuracy);
    ASSERT_NEAR(twice_less.at(p), -expected, WindingNumber::kAccuracy);
  }
}

TEST(WindingNumber, AgreesWithTheSlowTwin) {
  TriangleSoup shells;
  for (int i = 0; i < 6; ++i) append(shells, icosphere(Point::Zero(), 1 + 0.05 * i, 3));
  TriangleSoup aligned = confetti(3000, 0.1, 5);  // whose dipoles all point one way
  for (Triangle& t : aligned.triangles) {
    if (area_vector(aligned, t)[2] < 0) std::swap(t[1], t[2]);
  }
  const std::vector<TriangleSoup> soups{confetti(1, 1, 1),
                                        confetti(100, 0.5, 2),
                                        confetti(4000, 0.05, 3),
                                        confetti(4000, 1, 4),
                                        aligned,
                                        shells,
                                        torn(icosphere(Point::Zero(), 1, 5), 0.6),
                                        torn(torus(2, 0.5, 80, 40), 0.5),
                                        plate(1, 50),
                                        genus_plate(4, 6),
                                        joined(plate(100, 1), confetti(2000, 0.01, 6))};
  for (std::size_t i = 0; i < soups.size(); ++i) {
    EXPECT_LE(largest_error(soups[i], query_points(soups[i], 150, i), WindingNumber::kAccuracy),
              WindingNumber::kAccuracy)
        << i;
  }
}

TEST(WindingNumber, HoldsOtherAccuracies) {
  const std::vector<TriangleSoup> soups{torn(icosphere(Point::Zero(), 1, 5), 0.6), confetti(3000, 0.1, 7)};
  for (const TriangleSoup& soup : soups) {
    const std::vector<Point> points = query_points(soup, 100, 8);
    for (const double accuracy : {1e-1, 1e-2, 1e-4, 1e-6, 1e-8}) {
      EXPECT_LE(largest_error(soup, points, accuracy), accuracy) << accuracy;
    }
  }
  // And it is an expansion that is tested, not the sum: with little accuracy there is an error.
  EXPECT_GT(largest_error(soups[0], query_points(soups[0], 100, 8), 1e-1), 1e-6);
}

TEST(WindingNumber, RoundsRightBesideClosedSurfaces) {
  const std::vector<TriangleSoup> soups{
      unit_cube(),       icosphere({5, -3, 1}, 2, 5), torus(2, 0.5, 100, 50),
      genus_plate(7, 4), genus_plate(0, 20),          capsule({0, 0, 0}, 1, {4, 1, 0}, 0.5, 60, 60)};
  for (const TriangleSoup& soup : soups) {
    const WindingNumber winding(soup);
    const double diagonal = bounds(soup).diagonal();
    Sequence random(11);
    for (int i = 0; i < test::case_count(2000); ++i) {
      const double distance = std::pow(10.0, -6 - 3 * random.next()) * diagonal;  // down to 1e-9 of the diagonal
      ASSERT_NEAR(winding.at(beside_surface(soup, -distance, random)), 1, WindingNumber::kAccuracy) << distance;
      ASSERT_NEAR(winding.at(beside_surface(soup, distance, random)), 0, WindingNumber::kAccuracy) << distance;
    }
    for (const Point& p : query_points(soup, 100, 13)) {
      ASSERT_EQ(std::round(winding.at(p)), std::round(slow_winding(soup, p)));
      ASSERT_NEAR(winding.at(p), std::round(winding.at(p)), WindingNumber::kAccuracy);
    }
  }
}

TEST(WindingNumber, CountsMultiplicities) {
  const TriangleSoup soup = confetti(3000, 0.1, 17);
  Sequence random(19);
  std::vector<std::int32_t> multiplicity;
  for (std::size_t t = 0; t < soup.triangles.size(); ++t) {
    multiplicity.push_back(static_cast<std::int32_t>(random.below(9)) - 4);
  }
  // `accuracy` is absolute: large counts open more clusters.
  EXPECT_LE(largest_error(soup, query_points(soup, 150, 23), WindingNumber::kAccuracy, multiplicity),
            WindingNumber::kAccuracy);

  const WindingNumber counted(unit_cube(), std::vector<std::int32_t>(12, -3));
  EXPECT_NEAR(counted.at({0.3, 0.4, 0.5}), -3, 1e-13);
  const std::vector<std::int32_t> least(12, std::numeric_limits<std::int32_t>::min());
  EXPECT_NEAR(WindingNumber(unit_cube(), least).at({0.3, 0.4, 0.5}), -0x1p31, 1e-4);
  EXPECT_EQ(WindingNumber(unit_cube(), std::vector<std::int32_t>(12, 0)).at({0.3, 0.4, 0.5}), 0);
}

TEST(WindingNumber, MultiplicityIsRepetition) {
  const TriangleSoup soup = torn(icosphere(Point::Zero(), 1, 3), 0.7);
  TriangleSoup repeated;
  std::vector<std::int32_t> multiplicity;
  repeated.positions = soup.positions;
  for (std::size_t t = 0; t < soup.triangles.size(); ++t) {
    const auto [a, b, c] = soup.triangles[t];
    const int count = static_cast<int>(t % 5) - 2;
    multiplicity.push_back(count);
    for (int i = 0; i < std::abs(count); ++i)
      repeated.triangles.push_back(count > 0 ? Triangle{a, b, c} : Triangle{a, c, b});
  }
  const WindingNumber counted(soup, multiplicity);
  const WindingNumber plain(repeated);
  for (const Point& p : query_points(soup, 100, 29)) {
    ASSERT_NEAR(counted.at(p), plain.at(p), 2 * WindingNumber::kAccuracy);
  }
}

TEST(WindingNumber, IsAdditive) {
  const TriangleSoup first = torn(torus(2, 0.5, 60, 30), 0.8);
  const TriangleSoup second = translated(confetti(2000, 0.2, 31), {1, 0.5, 0});
  const WindingNumber of_first(first);
  const WindingNumber of_second(second);
  const WindingNumber of_both(joined(first, second));
  const WindingNumber of_none(joined(joined(first, second), flipped(joined(first, second))));
  for (const Point& p : query_points(joined(first, second), 150, 37)) {
    ASSERT_NEAR(of_both.at(p), of_first.at(p) + of_second.at(p), 3 * WindingNumber::kAccuracy);
    ASSERT_NEAR(of_none.at(p), 0, WindingNumber::kAccuracy);
  }
}

TEST(WindingNumber, PowersOfTwoScaleToTheSameBits) {
  const TriangleSoup soup = torn(icosphere({0.3, 0.2, 0.1}, 1, 4), 0.7);
  const WindingNumber winding(soup);
  for (const int exponent : {-900, -40, -1, 3, 40, 900}) {
    TriangleSoup scaled = soup;
    for (Point& p : scaled.positions) p *= std::ldexp(1.0, exponent);
    const WindingNumber of_scaled(scaled);
    for (const Point& p : query_points(soup, 30, 41)) {
      ASSERT_EQ(of_scaled.at(std::ldexp(1.0, exponent) * p), winding.at(p)) << exponent;
    }
  }
}

TEST(WindingNumber, IsTheSameAnywhereAtAnySize) {
  const TriangleSoup soup = torn(icosphere(Point::Zero(), 1, 4), 0.7);
  const double accuracy = 1e-5;
  const WindingNumber winding(soup, {}, accuracy);
  for (const double scale : {1e-12, 1e-3, 1e12}) {
    for (const double offset : {0.0, 1.0, 1e3}) {
      const auto moved = [&](const Point& p) { return Point(scale * (p + offset * Point(1, -2, 3))); };
      TriangleSoup image = soup;
      for (Point& p : image.positions) p = moved(p);
      const WindingNumber of_image(image, {}, accuracy);
      // At 3e3 sizes from the origin coordinates are rounded by up to 3e-13 sizes, nothing against 1e-6.
      for (const Point& p : query_points(soup, 50, 43)) ASSERT_NEAR(of_image.at(moved(p)), winding.at(p), 2 * accuracy);
    }
  }
}

TEST(WindingNumber, SizesMayDifferByManyOrders) {
  const double tiny = 1e-90;
  TriangleSoup soup = make_box(Point::Constant(-1), Point::Ones());
  append(soup, make_box(Point::Constant(-tiny), Point::Constant(tiny)));
  const WindingNumber winding(soup);
  EXPECT_NEAR(winding.at(Point::Zero()), 2, 1e-13);
  EXPECT_NEAR(winding.at({0.9 * tiny, 0.5 * tiny, 0}), 2, 1e-13);
  EXPECT_NEAR(winding.at({1.1 * tiny, 0, 0}), 1, 1e-13);
  EXPECT_NEAR(winding.at({0.5, 0, 0}), 1, 1e-13);
}

TEST(WindingNumber, FiniteOnVerticesEdgesAndFaces) {
  TriangleSoup soup = joined(torus(2, 0.5, 30, 20), confetti(500, 0.3, 47));
  soup.triangles.push_back({0, 0, 1});
  soup.triangles.push_back({2, 2, 2});
  const WindingNumber winding(soup);
  const WindingNumber closed(torus(2, 0.5, 30, 20));
  for (std::size_t t = 0; t < soup.triangles.size(); ++t) {
    const Point a = corner(soup, t, 0);
    const Point b = corner(soup, t, 1);
    const Point c = corner(soup, t, 2);
    for (const Point& p : {a, Point((a + b) / 2), Point(a + 0.3 * (c - b)), Point((a + b + c) / 3), Point(2 * b - a)}) {
      ASSERT_TRUE(std::isfinite(winding.at(p)));
      ASSERT_TRUE(std::isfinite(closed.at(p)));
    }
    if (t >= 1200) continue;  // beyond the torus
    // At a vertex the triangles around it count nothing and the others leave the share of the solid angle inside.
    ASSERT_NEAR(closed.at(a), 0.5, 0.25);
    // Inside of a triangle the limits are 0 and 1. A middle that was rounded off its edge sees either triangle under an
    // angle that is rounding itself, so the limits may be passed a little.
    ASSERT_NEAR(closed.at((a + b) / 2), 0.5, 0.6);
    ASSERT_NEAR(closed.at((a + b + c) / 3), 0.5, 0.5 + WindingNumber::kAccuracy);
  }
}

TEST(WindingNumber, DegenerateTrianglesCountNothing) {
  TriangleSoup soup = make_box(Point::Zero(), Point::Constant(4));
  const WindingNumber without(soup);
  soup.positions.insert(soup.positions.end(), {{1, 1, 1}, {2, 2, 2}, {3, 3, 3}, {1, 1, 1}});
  soup.triangles.insert(soup.triangles.end(), {{8, 9, 10}, {8, 8, 9}, {8, 11, 9}, {9, 9, 9}});
  const WindingNumber with(soup);
  TriangleSoup nothing = soup;
  nothing.triangles.erase(nothing.triangles.begin(), nothing.triangles.begin() + 12);
  const WindingNumber of_nothing(nothing);
  Sequence random(53);
  for (int i = 0; i < 100; ++i) {
    const Point p = i == 0 ? Point(2, 2, 2) : Point(5 * random.point());
    ASSERT_EQ(with.at(p), without.at(p));
    ASSERT_EQ(of_nothing.at(p), 0);
  }
}

TEST(WindingNumber, EmptyAndEndlesslyFarIsZero) {
  EXPECT_EQ(WindingNumber(TriangleSoup()).at({1, 2, 3}), 0);
  const WindingNumber winding(plate(1, 4));
  EXPECT_NEAR(winding.at({0, 0, 1e9}), 0, 1e-17);
  for (const double far : {1e30, 1e100, 1e308}) {
    EXPECT_NEAR(winding.at({0, -far, far}), 0, 1e-50) << far;
  }
  TriangleSoup point;  // one position, any number of times
  point.positions = {{7, 7, 7}};
  point.triangles = {{0, 0, 0}};
  EXPECT_EQ(WindingNumber(point).at({7, 7, 7}), 0);
  EXPECT_EQ(WindingNumber(point).at({8, 7, 7}), 0);
}

TEST(WindingNumber, RefusesWhatMakesNoSense) {
  const std::vector<std::int32_t> eleven(11, 1);
  EXPECT_THROW(WindingNumber(unit_cube(), eleven), InputError);
  EXPECT_THROW(WindingNumber(unit_cube(), {}, 0), ParameterError);
  EXPECT_THROW(WindingNumber(unit_cube(), {}, std::nan("")), ParameterError);
}

TEST(WindingNumber, SameBitsAgainAndOnTwoThreads) {
  const TriangleSoup soup = confetti(3000, 0.1, 59);
  const std::vector<Point> points = query_points(soup, 500, 61);
  const WindingNumber winding(soup);
  const WindingNumber again(soup);
  std::vector<double> first(points.size());
  std::vector<double> second(points.size());
  const auto fill = [&](std::vector<double>& values) {
    for (std::size_t i = 0; i < points.size(); ++i) values[i] = winding.at(points[i]);
  };
  std::thread other([&] { fill(second); });
  fill(first);
  other.join();
  EXPECT_EQ(first, second);
  for (std::size_t i = 0; i < points.size(); ++i) ASSERT_EQ(again.at(points[i]), first[i]);
}

TEST(WindingNumber, MemoryGrowsWithTheTriangles) {
  // A triangle is at least kept as nine coordinates.
  EXPECT_GE(WindingNumber::memory_estimate(1000), 1000 * 9 * sizeof(double));
  EXPECT_GE(WindingNumber::memory_estimate(2000), WindingNumber::memory_estimate(1000) + 1000 * 9 * sizeof(double));
  EXPECT_LE(WindingNumber::memory_estimate(1000000), 1000000 * 512ULL);
}

TEST(WindingNumber, DataModelsAgreeWithTheSlowTwin) {
  for (const std::string name : {"bunny_base_holes.ply", "chair_gothic.obj", "airboat.obj"}) {
    VOXCARVE_REQUIRE_DATA(path, name);
    const TriangleSoup soup = read_mesh(path);
    EXPECT_LE(largest_error(soup, query_points(soup, 30, 67), WindingNumber::kAccuracy), WindingNumber::kAccuracy)
        << name;
  }
}

}  // namespace
}  // namespace voxcarve
