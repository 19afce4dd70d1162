#include "common/mesh/io/polygon.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace voxcarve {
namespace {

/// Triangulates a polygon of the plane z = 0 and checks that triangles turn as it does and areas add up to its own.
void expect_partition(const std::vector<Point>& polygon, std::span<const std::uint32_t> corners, double area) {
  std::vector<Triangle> triangles;
  ASSERT_TRUE(mesh_io::triangulate_polygon(polygon, corners, triangles));
  ASSERT_EQ(triangles.size(), corners.size() - 2);
  TriangleSoup soup{polygon, triangles, {}, {}};
  double sum = 0;
  for (const Triangle& triangle : triangles) {
    EXPECT_GE(area_vector(soup, triangle)[2], 0);
    sum += area_vector(soup, triangle)[2] / 2;
  }
  EXPECT_EQ(sum, area);  // coordinates are small integers, so that areas are exact
}

TEST(Polygon, NonConvexOnesArePartitionedFromEveryFirstCorner) {
  // A comb of four teeth, 7 x 1 base and 1 x 3 teeth: area 7 + 4 * 3 = 19.
  std::vector<Point> comb = {{0, 0, 0}, {7, 0, 0}};
  for (int tooth = 3; tooth >= 0; --tooth) {
    comb.insert(comb.end(), {{2.0 * tooth + 1, 4, 0}, {2.0 * tooth, 4, 0}});
    if (tooth > 0) comb.insert(comb.end(), {{2.0 * tooth, 1, 0}, {2.0 * tooth - 1, 1, 0}});
  }
  const auto n = static_cast<std::uint32_t>(comb.size());
  for (std::uint32_t first = 0; first < n; ++first) {
    std::vector<std::uint32_t> corners;
    for (std::uint32_t i = 0; i < n; ++i) corners.push_back((first + i) % n);
    expect_partition(comb, corners, 19);
  }
}

TEST(Polygon, HolesOnADoubledEdgeStayOpen) {
  // A square of side 4 with a hole of side 2, joined by the edge 0-4 there and back: area 16 - 4 = 12.
  const std::vector<Point> points = {{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0},
                                     {1, 1, 0}, {1, 3, 0}, {3, 3, 0}, {3, 1, 0}};
  expect_partition(points, std::vector<std::uint32_t>{0, 1, 2, 3, 0, 4, 5, 6, 7, 4}, 12);
}

TEST(Polygon, CornersOnStraightEdgesLeaveNoFlatTriangles) {
  // A 2 x 2 square with a corner at the middle of every side: a fan about the first one would start flat.
  const std::vector<Point> points = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 1, 0},
                                     {2, 2, 0}, {1, 2, 0}, {0, 2, 0}, {0, 1, 0}};
  std::vector<Triangle> triangles;
  const std::vector<std::uint32_t> corners = {0, 1, 2, 3, 4, 5, 6, 7};
  ASSERT_TRUE(mesh_io::triangulate_polygon(points, corners, triangles));
  TriangleSoup soup{points, triangles, {}, {}};
  for (const Triangle& triangle : triangles) EXPECT_GT(area_vector(soup, triangle)[2], 0);
  expect_partition(points, corners, 4);
}

TEST(Polygon, DegenerateOnesBecomeFans) {
  const std::vector<Point> line = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}};
  std::vector<Triangle> triangles;
  ASSERT_TRUE(mesh_io::triangulate_polygon(line, std::vector<std::uint32_t>{0, 1, 2, 3}, triangles));
  EXPECT_EQ(triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}}));
}

TEST(Polygon, HugeAndTinyOnesAreTreatedAlike) {
  // An arrowhead: corner 2 is reflex, so that the only diagonal inside is 0-2.
  for (const double scale : {1e-200, 1.0, 1e200}) {
    std::vector<Point> arrow = {{0, 0, 0}, {3, -3, 0}, {1, 0, 0}, {3, 3, 0}};
    for (Point& point : arrow) point *= scale;
    std::vector<Triangle> triangles;
    // Listed from corner 1, where a fan would cut across the outside.
    ASSERT_TRUE(mesh_io::triangulate_polygon(arrow, std::vector<std::uint32_t>{1, 2, 3, 0}, triangles));
    for (const Triangle& triangle : triangles) {
      EXPECT_EQ(std::ranges::count(triangle, 0U) + std::ranges::count(triangle, 2U), 2);
    }
  }
}

}  // namespace
}  // namespace voxcarve
