#include "common/mesh/aabb_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/unit/metric_shapes.h"

namespace voxcarve {
namespace {

using namespace test;

const Point kA(0, 0, 0);
const Point kB(2, 0, 0);
const Point kC(0, 2, 0);

TEST(PointTriangleDistance, AllSevenRegions) {
  EXPECT_DOUBLE_EQ(squared_distance({0.5, 0.5, 3}, kA, kB, kC), 9);    // above the inside
  EXPECT_DOUBLE_EQ(squared_distance({1, -1, 0}, kA, kB, kC), 1);       // beyond ab
  EXPECT_DOUBLE_EQ(squared_distance({-2, 1, 0}, kA, kB, kC), 4);       // beyond ac
  EXPECT_DOUBLE_EQ(squared_distance({2, 2, 0}, kA, kB, kC), 2);        // beyond bc, nearest (1, 1)
  EXPECT_DOUBLE_EQ(squared_distance({-3, -4, 0}, kA, kB, kC), 25);     // corner a
  EXPECT_DOUBLE_EQ(squared_distance({5, -4, 0}, kA, kB, kC), 25);      // corner b
  EXPECT_DOUBLE_EQ(squared_distance({-3, 6, 0}, kA, kB, kC), 9 + 16);  // corner c
}

TEST(PointTriangleDistance, BeyondOneSideMayBeNearestToAnother) {
  // An obtuse triangle: the point is beyond ab and beyond bc; the nearest point is on bc.
  EXPECT_DOUBLE_EQ(squared_distance({3, 0, 0}, {0, 0, 0}, {1, 0, 0}, {2, 1, 0}), 2);
}

TEST(PointTriangleDistance, DegenerateTrianglesAreSegmentsAndPoints) {
  EXPECT_DOUBLE_EQ(squared_distance({1, 1, 0}, {0, 0, 0}, {1, 0, 0}, {4, 0, 0}), 1);
  EXPECT_DOUBLE_EQ(squared_distance({5, 0, 0}, {0, 0, 0}, {4, 0, 0}, {1, 0, 0}), 1);
  EXPECT_DOUBLE_EQ(squared_distance({3, 4, 0}, kA, kA, kA), 25);
  EXPECT_DOUBLE_EQ(squared_distance({1, 0, 2}, kA, kB, kB), 4);
}

TEST(PointTriangleDistance, ZeroAtCornersExactly) {
  Sequence random(3);
  for (int i = 0; i < 2000; ++i) {
    const Point a = random.point();
    const Point b = random.point();
    const Point c = i % 2 == 0 ? random.point() : Point(a + 0.3 * (b - a) + 1e-9 * random.point());  // slivers too
    for (const Point& p : {a, b, c}) ASSERT_EQ(squared_distance(p, a, b, c), 0);
  }
}

TEST(PointTriangleDistance, SliversKeepTheirDigits) {
  // A triangle of length 1 and height 1e-8 in the plane z = 0; the points lie straight above inner points.
  Sequence random(5);
  const Point a(0, 0, 0);
  const Point b(1, 0.3, 0);
  const Point c(0.4, 0.12 + 1e-8, 0);
  for (int i = 0; i < 1000; ++i) {
    const double s = random.next();
    const double t = random.next() * (1 - s);
    const double height = std::pow(10.0, -12 * random.next());
    const Point inner = a + s * (b - a) + t * (c - a);
    EXPECT_NEAR(std::sqrt(squared_distance(inner + Point(0, 0, height), a, b, c)), height, 1e-15);
  }
}

double brute_force(const TriangleSoup& soup, const Point& p) {
  double best = std::numeric_limits<double>::infinity();
  for (const Triangle& t : soup.triangles) {
    best = std::min(best, squared_distance(p, soup.positions[t[0]], soup.positions[t[1]], soup.positions[t[2]]));
  }
  return best;
}

TEST(AabbTree, AgreesWithBruteForce) {
  Sequence random(7);
  for (const TriangleSoup& soup : {unit_cube(), torus(2, 0.5, 24, 16), sphere(1, 3)}) {
    const AabbTree tree(soup);
    for (int i = 0; i < 300; ++i) {
      const Point p = 6 * (random.point() - Point::Constant(0.5));
      const AabbTree::Nearest nearest = tree.nearest(p);
      ASSERT_EQ(nearest.squared_distance, brute_force(soup, p));
      const Triangle& t = soup.triangles[nearest.triangle];
      ASSERT_EQ(squared_distance(p, soup.positions[t[0]], soup.positions[t[1]], soup.positions[t[2]]),
                nearest.squared_distance);
    }
  }
}

TEST(AabbTree, RespectsTheBound) {
  const AabbTree tree(unit_cube());
  EXPECT_EQ(tree.nearest({0.5, 0.5, 3}, 4).triangle, AabbTree::kNone);  // the distance is 2: not less
  EXPECT_EQ(tree.nearest({0.5, 0.5, 3}, 4.0001).squared_distance, 4);
}

TEST(AabbTree, EmptySoupHasNoNearest) {
  const AabbTree tree{TriangleSoup()};
  EXPECT_TRUE(tree.empty());
  EXPECT_EQ(tree.nearest({0, 0, 0}).triangle, AabbTree::kNone);
}

TEST(AabbTree, ManyEqualTrianglesStayShallow) {
  // No split separates equal centres; halving must take over.
  TriangleSoup soup;
  soup.positions = {kA, kB, kC};
  soup.triangles.assign(5000, Triangle{0, 1, 2});
  EXPECT_EQ(AabbTree(soup).nearest({0.5, 0.5, 1}).squared_distance, 1);
}

TEST(AabbTree, ListsOverlappingBoxes) {
  const TriangleSoup soup = torus(2, 0.5, 24, 16);
  const AabbTree tree(soup);
  Sequence random(9);
  for (int i = 0; i < 50; ++i) {
    Box query;
    query.extend(5 * (random.point() - Point::Constant(0.5)));
    query.extend(query.lower + 0.5 * random.point());
    std::vector<std::uint32_t> expected;
    for (std::uint32_t t = 0; t < soup.triangles.size(); ++t) {
      Box box;
      for (const std::uint32_t v : soup.triangles[t]) box.extend(soup.positions[v]);
      if ((box.lower.array() <= query.upper.array()).all() && (box.upper.array() >= query.lower.array()).all()) {
        expected.push_back(t);
      }
    }
    std::vector<std::uint32_t> found;
    tree.append_overlaps(query, found);
    std::sort(found.begin(), found.end());
    ASSERT_EQ(found, expected);
  }
}

}  // namespace
}  // namespace voxcarve
