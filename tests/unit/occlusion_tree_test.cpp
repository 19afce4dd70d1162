#include "metrics/occlusion_tree.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "metrics/visibility.h"
#include "tests/unit/metric_shapes.h"

namespace voxcarve {
namespace {

using namespace test;

void add_quad(TriangleSoup& soup, const Point& a, const Point& b, const Point& c, const Point& d) {
  const auto first = static_cast<std::uint32_t>(soup.positions.size());
  soup.positions.insert(soup.positions.end(), {a, b, c, d});
  soup.triangles.push_back({first, first + 1, first + 2});
  soup.triangles.push_back({first, first + 2, first + 3});
}

/// The slow, obvious twin: the signs of the volumes that the ray spans with the sides.
bool ray_meets(const Point& origin, const Point& direction, const Point& a, const Point& b, const Point& c) {
  const auto side = [&](const Point& p, const Point& q) { return direction.dot((p - origin).cross(q - origin)); };
  const double ab = side(a, b);
  const double bc = side(b, c);
  const double ca = side(c, a);
  if (!((ab > 0 && bc > 0 && ca > 0) || (ab < 0 && bc < 0 && ca < 0))) return false;
  const Point normal = (b - a).cross(c - a);
  return normal.dot(a - origin) / normal.dot(direction) > 0;
}

TEST(OcclusionTree, AgreesWithBruteForceWhateverTheHint) {
  Sequence random(5);
  for (const std::uint32_t triangles : {1U, 4U, 5U, 17U, 300U}) {
    TriangleSoup soup;
    for (std::uint32_t i = 0; i < triangles; ++i) {
      const Point middle = 1.6 * random.point() - Point::Constant(0.8);
      for (int c = 0; c < 3; ++c) soup.positions.push_back(middle + 0.4 * (random.point() - Point::Constant(0.5)));
      soup.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    RunContext context;
    const OcclusionTree tree(soup, 0, context);
    std::vector<Point> vectors = view_directions(30);
    for (int axis = 0; axis < 3; ++axis) vectors.insert(vectors.end(), {Point::Unit(axis), -Point::Unit(axis)});
    int blocked = 0;
    for (const Point& vector : vectors) {
      const OcclusionTree::Direction direction(vector);
      OcclusionTree::Hint kept;
      for (int i = 0; i < 50; ++i) {
        const Point origin = 2 * random.point() - Point::Ones();
        bool expected = false;
        for (const Triangle& t : soup.triangles) {
          expected =
              expected || ray_meets(origin, vector, soup.positions[t[0]], soup.positions[t[1]], soup.positions[t[2]]);
        }
        OcclusionTree::Hint fresh;
        ASSERT_EQ(tree.blocks(origin, direction, fresh), expected);
        ASSERT_EQ(tree.blocks(origin, direction, kept), expected);
        ASSERT_EQ(tree.blocks(origin, direction, kept), expected);
        blocked += expected ? 1 : 0;
      }
    }
    EXPECT_TRUE(triangles < 300 || (blocked > 300 && blocked < 1500)) << blocked;  // of 1800: both answers occur
  }
}

TEST(OcclusionTree, HoldsNoMoreThanItsEstimate) {
  // 5 * 4^j triangles make the most nodes a triangle: 1 + 4 + ... + 4^j, that is 4/15 of a node each.
  Sequence random(3);
  TriangleSoup soup;
  RunContext context;
  for (std::uint32_t n = 1; n <= 1300; ++n) {
    for (int c = 0; c < 3; ++c) soup.positions.push_back(2 * random.point() - Point::Ones());
    soup.triangles.push_back({3 * n - 3, 3 * n - 2, 3 * n - 1});
    if (n > 90 && n % 5 != 0) continue;
    ASSERT_LE(OcclusionTree(soup, 0, context).memory(), OcclusionTree::memory_estimate(n)) << n;
  }
}

TEST(OcclusionTree, GrowthClosesCracksAndClipsSpikes) {
  TriangleSoup soup;
  add_quad(soup, {-1, -1, 0}, {-1e-6, -1, 0}, {-1e-6, 1, 0}, {-1, 1, 0});
  add_quad(soup, {1e-6, -1, 0}, {1, -1, 0}, {1, 1, 0}, {1e-6, 1, 0});
  RunContext context;
  const OcclusionTree::Direction up(Point::UnitZ());
  const auto blocks = [&](double growth, const Point& origin) {
    OcclusionTree::Hint hint;
    return OcclusionTree(soup, growth, context).blocks(origin, up, hint);
  };
  EXPECT_FALSE(blocks(0, {0, 0.3, -1}));
  EXPECT_FALSE(blocks(0.5e-6, {0, 0.3, -1}));
  EXPECT_TRUE(blocks(1.5e-6, {0, 0.3, -1}));
  EXPECT_FALSE(blocks(1.5e-6, {0, 0.3, 1}));  // behind the origin
  // A needle along y, 2e-6 wide: moving its sides alone would move its tip from y = 1 to y = 2.
  soup = TriangleSoup();
  soup.positions = {{-1e-6, 0, 0}, {1e-6, 0, 0}, {0, 1, 0}};
  soup.triangles = {{0, 1, 2}};
  EXPECT_TRUE(blocks(1e-6, {0, 0.999999, -1}));
  EXPECT_FALSE(blocks(1e-6, {0, 1.00001, -1}));
}

}  // namespace
}  // namespace voxcarve
