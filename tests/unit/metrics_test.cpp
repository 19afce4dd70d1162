#include "metrics/metric.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "common/run/errors.h"
#include "metrics/self_intersections.h"
#include "tests/unit/metric_shapes.h"

namespace voxcarve {
namespace {

using namespace test;

std::vector<Measurement> measure(const TriangleSoup& soup) {
  RunContext context;
  return measure_shape(soup, {}, context);
}

std::int64_t integer(const std::vector<Measurement>& values, std::string_view key) {
  return std::get<std::int64_t>(value_of(values, key));
}
double real(const std::vector<Measurement>& values, std::string_view key) {
  return std::get<double>(value_of(values, key));
}
bool flag(const std::vector<Measurement>& values, std::string_view key) {
  return std::get<bool>(value_of(values, key));
}
std::string reason(const std::vector<Measurement>& values, std::string_view key) {
  const auto* undefined = std::get_if<Undefined>(&value_of(values, key));
  return undefined == nullptr ? "" : undefined->reason;
}

std::array<std::int64_t, 3> betti(const std::vector<Measurement>& values) {
  return {integer(values, "solid.b0"), integer(values, "solid.b1"), integer(values, "solid.b2")};
}

TEST(MetricColumns, KeysAreDistinctAndMeasuredInOrder) {
  RunContext context;
  const TriangleSoup cube = unit_cube();
  const auto check = [](const std::vector<MetricColumn>& columns, const std::vector<Measurement>& values) {
    ASSERT_EQ(columns.size(), values.size());
    std::set<std::string> keys;
    for (std::size_t i = 0; i < columns.size(); ++i) {
      EXPECT_EQ(columns[i].key, values[i].key);
      EXPECT_FALSE(columns[i].help.empty());
      EXPECT_TRUE(keys.insert(columns[i].key).second) << columns[i].key;
      EXPECT_FALSE(std::holds_alternative<Undefined>(values[i].value)) << columns[i].key;  // all defined for a cube
    }
  };
  check(shape_columns(), measure(cube));
  check(pair_columns(), measure_pair(cube, translated(cube, {0.5, 0, 0}), {}, context));
}

TEST(MetricColumns, UnknownKeysAreNotMeasured) {
  EXPECT_EQ(std::get<Undefined>(value_of(measure(unit_cube()), "beauty")).reason, "not measured");
}

TEST(ShapeMetrics, Cube) {
  const auto m = measure(make_box({1, 2, 3}, {3, 4, 5}));  // side 2
  EXPECT_EQ(integer(m, "vertices"), 8);
  EXPECT_EQ(integer(m, "triangles"), 12);
  EXPECT_TRUE(flag(m, "closed"));
  EXPECT_EQ(integer(m, "genus"), 0);
  EXPECT_EQ(integer(m, "self_intersections"), 0);
  EXPECT_EQ(integer(m, "degenerate_triangles"), 0);
  EXPECT_DOUBLE_EQ(real(m, "area"), 24);
  EXPECT_DOUBLE_EQ(real(m, "volume"), 8);
  EXPECT_DOUBLE_EQ(real(m, "bbox_diagonal"), 2 * std::sqrt(3.0));
  EXPECT_EQ(real(m, "bbox.x_min"), 1);
  EXPECT_EQ(real(m, "bbox.z_max"), 5);
  EXPECT_DOUBLE_EQ(real(m, "edge_length.min"), 2);
  EXPECT_DOUBLE_EQ(real(m, "edge_length.max"), 2 * std::sqrt(2.0));
  EXPECT_DOUBLE_EQ(real(m, "edge_length.mean"), (12 * 2 + 6 * 2 * std::sqrt(2.0)) / 18);  // 12 sides, 6 diagonals
  // A right isosceles triangle with legs 1: r = (2 - sqrt 2) / 2, R = sqrt 2 / 2, so 2 r / R = 2 sqrt 2 - 2.
  EXPECT_DOUBLE_EQ(real(m, "quality.min"), 2 * std::sqrt(2.0) - 2);
  EXPECT_DOUBLE_EQ(real(m, "quality.mean"), 2 * std::sqrt(2.0) - 2);
  EXPECT_EQ(betti(m), (std::array<std::int64_t, 3>{1, 0, 0}));
}

TEST(ShapeMetrics, EquilateralTriangleHasQualityOne) {
  for (const double scale : {1.0, 1e-150, 1e150}) {
    TriangleSoup soup;
    soup.positions = {{0, 0, 0}, {scale, 0, 0}, {scale / 2, scale * std::sqrt(0.75), 0}};
    soup.triangles = {{0, 1, 2}};
    EXPECT_NEAR(real(measure(soup), "quality.min"), 1, 1e-15);
  }
}

TEST(ShapeMetrics, TetrahedronVolume) {
  EXPECT_DOUBLE_EQ(real(measure(tetrahedron()), "volume"), 1.0 / 6);
  EXPECT_DOUBLE_EQ(real(measure(flipped(tetrahedron())), "volume"), -1.0 / 6);
}

TEST(ShapeMetrics, VolumeNeedsAClosedOrientedSurface) {
  TriangleSoup open = unit_cube();
  open.triangles.pop_back();
  EXPECT_EQ(reason(measure(open), "volume"), "the surface is not closed");
  TriangleSoup turned = unit_cube();
  std::swap(turned.triangles[0][0], turned.triangles[0][1]);
  EXPECT_EQ(reason(measure(turned), "volume"), "the surface is not oriented");
  EXPECT_EQ(reason(measure(turned), "solid.b1"), "the surface is not oriented");
}

TEST(ShapeMetrics, DegenerateTrianglesAreCounted) {
  TriangleSoup soup = unit_cube();
  soup.positions.emplace_back(0.5, 0, 0);
  soup.triangles.push_back({0, 8, 1});  // on a line
  soup.triangles.push_back({3, 3, 4});
  const auto m = measure(soup);
  EXPECT_EQ(integer(m, "degenerate_triangles"), 2);
  EXPECT_EQ(integer(m, "triangles"), 14);
  EXPECT_EQ(real(m, "quality.min"), 0);
}

TEST(ShapeMetrics, EmptySoup) {
  const auto m = measure(TriangleSoup());
  EXPECT_EQ(integer(m, "vertices"), 0);
  EXPECT_TRUE(flag(m, "closed"));
  EXPECT_EQ(real(m, "volume"), 0);
  EXPECT_EQ(reason(m, "bbox_diagonal"), "no triangles");
  EXPECT_EQ(reason(m, "edge_length.mean"), "no edges");
  EXPECT_EQ(reason(m, "quality.mean"), "no triangles");
  EXPECT_EQ(betti(m), (std::array<std::int64_t, 3>{0, 0, 0}));
}

TEST(SolidTopology, TorusHasATunnel) {
  EXPECT_EQ(betti(measure(torus(2, 0.5, 24, 12))), (std::array<std::int64_t, 3>{1, 1, 0}));
}

TEST(SolidTopology, NestedCubesAreASolidWithAVoid) {
  const TriangleSoup shell = joined(make_box({0, 0, 0}, {4, 4, 4}), flipped(make_box({1, 1, 1}, {3, 3, 3})));
  const auto m = measure(shell);
  EXPECT_EQ(integer(m, "components"), 2);
  EXPECT_DOUBLE_EQ(real(m, "volume"), 64 - 8);
  EXPECT_EQ(betti(m), (std::array<std::int64_t, 3>{1, 0, 1}));
  // A torus in the void is a solid of its own, whose tunnel counts.
  const TriangleSoup inner = translated(torus(0.5, 0.2, 12, 8), {2, 2, 2});
  EXPECT_EQ(betti(measure(joined(shell, inner))), (std::array<std::int64_t, 3>{2, 1, 1}));
  // A void in the shape of a torus: chi of the surface is 2 + 0, so b1 = 1 + 1 - 1.
  EXPECT_EQ(betti(measure(joined(make_box({0, 0, 0}, {4, 4, 4}), flipped(inner)))),
            (std::array<std::int64_t, 3>{1, 1, 1}));
  // The components in another order.
  EXPECT_EQ(betti(measure(joined(flipped(inner), make_box({0, 0, 0}, {4, 4, 4})))),
            (std::array<std::int64_t, 3>{1, 1, 1}));
}

TEST(SolidTopology, SolidsSideBySide) {
  // The second cube's line along z passes through neither: parts above each other are not nested.
  const TriangleSoup soup = joined(unit_cube(), translated(unit_cube(), {0, 0, 3}));
  EXPECT_EQ(betti(measure(soup)), (std::array<std::int64_t, 3>{2, 0, 0}));
}

TEST(SolidTopology, TouchingSolidsAreTwo) {
  // A face in common, by position: coincident contact is no self-intersection, and neither holds the other.
  const auto m = measure(joined(unit_cube(), translated(unit_cube(), {0, 0, 1})));
  EXPECT_EQ(integer(m, "self_intersections"), 0);
  EXPECT_EQ(betti(m), (std::array<std::int64_t, 3>{2, 0, 0}));
}

TEST(SolidTopology, ReasonsWhyThereIsNone) {
  const TriangleSoup big = make_box({0, 0, 0}, {4, 4, 4});
  const TriangleSoup small = make_box({1, 1, 1}, {3, 3, 3});
  EXPECT_EQ(reason(measure(joined(big, small)), "solid.b0"), "nested shells of the same orientation");
  EXPECT_EQ(reason(measure(flipped(small)), "solid.b0"), "component 0 faces inward and lies in no solid");
  EXPECT_EQ(reason(measure(joined(unit_cube(), flipped(unit_cube()))), "solid.b0"),
            "component 0 coincides with another one");
  EXPECT_EQ(reason(measure(joined(unit_cube(), translated(unit_cube(), {0.5, 0.4, 0.3}))), "solid.b0"),
            "the surface intersects itself");
  TriangleSoup fold;
  fold.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  fold.triangles = {{0, 1, 2}, {0, 2, 1}};
  EXPECT_EQ(reason(measure(fold), "solid.b0"), "component 0 encloses no volume");
  EXPECT_EQ(reason(measure(merge_equal_positions(joined(unit_cube(), make_box({1, 1, 1}, {2, 2, 2})))), "solid.b0"),
            "component 0: 1 non-manifold vertices");
}

std::int64_t intersections(const TriangleSoup& soup) {
  RunContext context;
  return std::get<std::int64_t>(count_self_intersections(soup, context));
}

TriangleSoup two_triangles(const std::array<Point, 6>& corners) {
  TriangleSoup soup;
  soup.positions.assign(corners.begin(), corners.end());
  soup.triangles = {{0, 1, 2}, {3, 4, 5}};
  return soup;
}

TEST(SelfIntersections, PiercingTrianglesCount) {
  // The second passes through the first along the segment x = 1 / 2, 1 / 4 < y < 1 / 2 or so.
  EXPECT_EQ(intersections(
                two_triangles({Point(0, 0, 0), {2, 0, 0}, {0, 2, 0}, {0.5, 0.2, -1}, {0.5, 0.2, 1}, {0.5, 0.9, 0.5}})),
            1);
}

TEST(SelfIntersections, ContactDoesNotCount) {
  const Point a(0, 0, 0), b(2, 0, 0), c(0, 2, 0);
  const auto count = [&](const Point& p, const Point& q, const Point& r) {
    return intersections(two_triangles({a, b, c, p, q, r}));
  };
  EXPECT_EQ(count(a, b, {0, 0, 2}), 0);                          // a common side, by position
  EXPECT_EQ(count(a, b, c), 0);                                  // the same triangle
  EXPECT_EQ(count(a, c, b), 0);                                  // folded back onto it
  EXPECT_EQ(count({0.1, 0.1, 0}, {3, 0.2, 0}, {0.2, 3, 0}), 0);  // coplanar overlap
  EXPECT_EQ(count({0.5, 0.5, 0}, {0.5, 0.5, 1}, {1, 1, 1}), 0);  // a corner rests inside
  EXPECT_EQ(count({0.2, 0.2, 0}, {0.8, 0.2, 0}, {0, 0, 1}), 0);  // a side rests inside
  EXPECT_EQ(count({1, -1, -1}, {1, 1, 1}, {1, -1, 1}), 0);       // sides cross in (1, 0, 0)
  EXPECT_EQ(count(a, {0, -1, 1}, {0, -1, -1}), 0);               // a common corner, no more
}

TEST(SelfIntersections, NeighboursThatFoldThroughEachOtherCount) {
  // A common corner at the origin; the second triangle runs through the first along the diagonal from there.
  EXPECT_EQ(intersections(two_triangles({Point(0, 0, 0), {2, 0, 0}, {0, 2, 0}, {0, 0, 0}, {1, 1, -1}, {1, 1, 1}})), 1);
}

TEST(SelfIntersections, DegenerateTrianglesAreLeftOut) {
  EXPECT_EQ(intersections(
                two_triangles({Point(0, 0, 0), {2, 0, 0}, {0, 2, 0}, {0.5, 0.5, -1}, {0.5, 0.5, 0}, {0.5, 0.5, 1}})),
            0);
}

/// The slow, obvious twin on small integer coordinates: both triangles' sections with the common line of the planes.
/// Ends of sections are fractions with denominators below 2000, so unequal ones differ by more than the tolerance.
bool cross_properly(const std::array<Point, 6>& p) {
  const Point n1 = (p[1] - p[0]).cross(p[2] - p[0]);
  const Point n2 = (p[4] - p[3]).cross(p[5] - p[3]);
  const Point line = n1.cross(n2);
  if (n1.isZero(0) || n2.isZero(0) || line.isZero(0)) return false;
  const auto section = [&](std::size_t first, const Point& normal, const Point& on_plane, double& low, double& high) {
    std::array<double, 3> side{};
    for (std::size_t i = 0; i < 3; ++i) side[i] = normal.dot(p[first + i] - on_plane);
    low = std::numeric_limits<double>::infinity();
    high = -low;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t j = (i + 1) % 3;
      if (side[i] * side[j] > 0 || side[i] == side[j]) continue;
      const Point q = p[first + i] + side[i] / (side[i] - side[j]) * (p[first + j] - p[first + i]);
      low = std::min(low, q.dot(line) / line.squaredNorm());
      high = std::max(high, q.dot(line) / line.squaredNorm());
    }
    return *std::min_element(side.begin(), side.end()) < 0 && *std::max_element(side.begin(), side.end()) > 0;
  };
  double low1, high1, low2, high2;
  if (!section(0, n2, p[3], low1, high1) || !section(3, n1, p[0], low2, high2)) return false;
  return std::min(high1, high2) - std::max(low1, low2) > 1e-9;
}

TEST(SelfIntersections, AgreesWithBruteForceOnNastyIntegers) {
  Sequence random(17);
  int found = 0;
  for (int i = 0; i < 20000; ++i) {
    std::array<Point, 6> p;
    const std::uint32_t range = i % 2 == 0 ? 3 : 6;  // small ranges are full of contacts
    for (Point& q : p) q = Point(random.below(range), random.below(range), random.below(range));
    const bool expected = cross_properly(p);
    found += expected ? 1 : 0;
    ASSERT_EQ(intersections(two_triangles(p)), expected ? 1 : 0) << i;
  }
  EXPECT_GT(found, 500);  // or the comparison says little
}

TEST(SelfIntersections, InterpenetratingSpheres) {
  EXPECT_EQ(intersections(sphere(1, 3)), 0);
  const TriangleSoup both = joined(sphere(1, 3), translated(sphere(1, 3), {0.7, 0.11, 0.05}));
  std::int64_t expected = 0;
  const std::size_t half = both.triangles.size() / 2;
  for (std::size_t s = 0; s < half; ++s) {
    for (std::size_t t = half; t < 2 * half; ++t) {
      std::array<Point, 6> p;
      for (std::size_t c = 0; c < 3; ++c) {
        p[c] = both.positions[both.triangles[s][c]];
        p[3 + c] = both.positions[both.triangles[t][c]];
      }
      expected += cross_properly(p) ? 1 : 0;
    }
  }
  EXPECT_GT(expected, 50);
  EXPECT_EQ(intersections(both), expected);
}

TEST(SelfIntersections, GivesUpAboveItsLimitWithAReason) {
  RunContext context;
  TriangleSoup soup = unit_cube();
  soup.triangles.insert(soup.triangles.end(), 200, Triangle{0, 3, 5});
  const MetricValue value = count_self_intersections(soup, context, 1000);
  EXPECT_EQ(std::get<Undefined>(value).reason, "more than 1000 pairs of triangles have overlapping boxes");
}

/// No value is ever NaN or infinite, whatever the soup.
void expect_finite(const std::vector<Measurement>& values) {
  for (const Measurement& m : values) {
    if (const auto* number = std::get_if<double>(&m.value)) {
      EXPECT_TRUE(std::isfinite(*number)) << m.key;
    } else if (const auto* undefined = std::get_if<Undefined>(&m.value)) {
      EXPECT_FALSE(undefined->reason.empty()) << m.key;
    }
  }
}

TEST(Metrics, ValuesAreFiniteForEveryFiniteSoup) {
  const double huge = std::numeric_limits<double>::max();
  TriangleSoup point;
  point.positions = {{1, 1, 1}};
  point.triangles = {{0, 0, 0}};
  std::vector<TriangleSoup> soups = {TriangleSoup(), point, unit_cube(), moebius_strip(5)};
  for (const double scale : {1e-300, 1e-160, 1e-12, 1e12, 1e100, 1e160, huge}) {
    soups.push_back(unit_cube());
    for (Point& p : soups.back().positions) p = scale * (2 * p - Point::Ones());
  }
  soups.push_back(translated(unit_cube(), {1e12, 1e12, 1e12}));
  TriangleSoup flat = unit_cube();
  for (Point& p : flat.positions) p[1] = 0;
  soups.push_back(flat);
  RunContext context;
  MetricOptions options;
  options.distance_samples = 100;
  options.rays = 128;
  for (const TriangleSoup& a : soups) {
    expect_finite(measure(a));
    for (const TriangleSoup& b : soups) expect_finite(measure_pair(a, b, options, context));
  }
}

TEST(Metrics, TheSameOnAnyNumberOfThreads) {
  const TriangleSoup a = torus(2, 0.5, 40, 20);
  TriangleSoup b = joined(sphere(2, 4), unit_cube());
  b.triangles.pop_back();
  RunContext one;
  RunContext four;
  four.threads = 4;
  one.seed = four.seed = 5;
  EXPECT_EQ(measure_shape(b, {}, one), measure_shape(b, {}, four));
  EXPECT_EQ(measure_pair(a, b, {}, one), measure_pair(a, b, {}, four));
}

TEST(Metrics, TheSeedChangesTheSamplesOnly) {
  RunContext first;
  RunContext second;
  second.seed = 1;
  const auto a = measure_pair(unit_cube(), sphere(1, 2), {}, first);
  const auto b = measure_pair(unit_cube(), sphere(1, 2), {}, second);
  EXPECT_EQ(value_of(a, "hausdorff.upper"), value_of(b, "hausdorff.upper"));
  EXPECT_NE(value_of(a, "hausdorff.mean"), value_of(b, "hausdorff.mean"));
  EXPECT_NE(value_of(a, "symmetric_difference.volume"), value_of(b, "symmetric_difference.volume"));
}

TEST(Metrics, StopsWhenCancelled) {
  RunContext context;
  std::stop_source source;
  context.cancellation = source.get_token();
  source.request_stop();
  EXPECT_THROW(measure_shape(unit_cube(), {}, context), Cancelled);
  EXPECT_THROW(measure_pair(unit_cube(), sphere(1, 1), {}, context), Cancelled);
}

}  // namespace
}  // namespace voxcarve
