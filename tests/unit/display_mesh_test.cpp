// What lies between a soup and the rasteriser: normals, colours, the unit frame, and the camera. No graphics needed.
#include "experiments/render/display_mesh.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "experiments/render/camera.h"

namespace voxcarve {
namespace {

/// The cube [-1, 1]^3, outward.
TriangleSoup cube() {
  TriangleSoup soup;
  for (int i = 0; i < 8; ++i) soup.positions.push_back({i & 1 ? 1. : -1., i & 2 ? 1. : -1., i & 4 ? 1. : -1.});
  soup.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return soup;
}

TEST(DisplayMesh, SplitsACubeAtItsEdges) {
  // Dihedral angles are 90 degrees. Below that every face is a group of its own: 4 corners on each of 6 faces.
  for (const double angle : {0., 40., 89.}) {
    const DisplayMesh mesh = make_display_mesh(cube(), {}, angle, true);
    EXPECT_EQ(mesh.positions.size(), 24U) << angle;
    for (std::size_t i = 0; i < mesh.normals.size(); ++i) {
      EXPECT_NEAR(mesh.normals[i].cwiseAbs().maxCoeff(), 1, 1e-6);   // along an axis,
      EXPECT_NEAR(mesh.normals[i].dot(mesh.positions[i]), 1, 1e-6);  // outward
    }
    EXPECT_EQ(mesh.edges.size(), 18U);  // 12 sides and 6 diagonals
  }
}

TEST(DisplayMesh, SmoothsACubeAboveItsDihedralAngle) {
  const DisplayMesh mesh = make_display_mesh(cube(), {}, 91, false);
  ASSERT_EQ(mesh.positions.size(), 8U);
  // Three faces meet in right angles at each corner, however they are triangulated, so the angle-weighted mean of
  // their normals is the diagonal.
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_NEAR((mesh.normals[i] - mesh.positions[i].normalized()).norm(), 0, 1e-6);
  }
  EXPECT_TRUE(mesh.edges.empty());
}

TEST(DisplayMesh, UnweldedTrianglesAreShadedAsOneSurface) {
  TriangleSoup unwelded;
  const TriangleSoup welded = cube();
  for (const Triangle& triangle : welded.triangles) {
    const auto first = static_cast<std::uint32_t>(unwelded.positions.size());
    for (const std::uint32_t vertex : triangle) unwelded.positions.push_back(welded.positions[vertex]);
    unwelded.triangles.push_back({first, first + 1, first + 2});
  }
  EXPECT_EQ(make_display_mesh(unwelded, {}, 91, false).positions.size(), 8U);
  EXPECT_EQ(make_display_mesh(unwelded, {}, 40, true).edges.size(), 18U);
}

TEST(DisplayMesh, OppositeSidesOfAFoldKeepTheirNormals) {
  TriangleSoup sheet;
  sheet.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  sheet.triangles = {{0, 1, 2}, {0, 2, 1}};
  const DisplayMesh mesh = make_display_mesh(sheet, {}, 60, false);
  ASSERT_EQ(mesh.positions.size(), 6U);
  for (std::size_t corner = 0; corner < 3; ++corner) {
    EXPECT_EQ(mesh.normals[mesh.triangles[0][corner]], Eigen::Vector3f(0, 0, 1));
    EXPECT_EQ(mesh.normals[mesh.triangles[1][corner]], Eigen::Vector3f(0, 0, -1));
  }
}

TEST(DisplayMesh, TellsTrianglesWithAnotherSide) {
  const DisplayMesh solid = make_display_mesh(cube(), {}, 40, false);
  EXPECT_EQ(solid.two_sided, std::vector<bool>(12, false));
  TriangleSoup sheets;
  sheets.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  sheets.triangles = {{0, 1, 2},             // turned round by the third,
                      {0, 1, 3},             // only there again, the same way round, in the fourth,
                      {5, 4, 6},             // other numbers, the same positions, from another corner on
                      {1, 3, 0}, {2, 0, 1},  // once more the first
                      {0, 0, 1},             // no triangles
                      {0, 4, 1}};
  EXPECT_EQ(make_display_mesh(sheets, {}, 40, false).two_sided,
            (std::vector<bool>{true, false, true, false, true, false, false}));
}

TEST(DisplayMesh, DegenerateTrianglesHaveFiniteNormals) {
  TriangleSoup soup = cube();
  soup.triangles.push_back({0, 0, 0});
  soup.triangles.push_back({0, 1, 1});
  soup.positions.push_back({0, -1, -1});  // the middle of the side 0-1: a triangle without area
  soup.triangles.push_back({0, 8, 1});
  for (const double angle : {0., 40., 180.}) {
    const DisplayMesh mesh = make_display_mesh(soup, {}, angle, true);
    ASSERT_EQ(mesh.triangles.size(), 15U);
    for (const Eigen::Vector3f& normal : mesh.normals) EXPECT_NEAR(normal.norm(), 1, 1e-5);
  }
}

TEST(DisplayMesh, AHubOfManyFacesIsFast) {
  // 60,000 triangles at one edge: comparing all pairs would take 2e9 steps at each of its ends.
  constexpr int kFaces = 60000;
  TriangleSoup soup;
  soup.positions = {{0, 0, -1}, {0, 0, 1}};
  for (int i = 0; i < kFaces; ++i) {
    const double angle = 2 * 3.14159265358979 * i / kFaces;
    soup.positions.push_back({std::cos(angle), std::sin(angle), 0});
    soup.triangles.push_back({0, 1, static_cast<std::uint32_t>(i + 2)});
  }
  EXPECT_EQ(make_display_mesh(soup, {}, 40, true).edges.size(), 1U + 2U * kFaces);
}

TEST(DisplayMesh, ColoursAreClampedAndTheTrianglesWin) {
  TriangleSoup soup;
  soup.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  soup.triangles = {{0, 1, 2}};
  EXPECT_EQ(make_display_mesh(soup, {}, 40, false).colors[0], kNeutralColor);
  soup.vertex_colors = {{-1, 0, 0.2F}, {2, 1, 0.2F}, {0.5F, std::numeric_limits<float>::quiet_NaN(), 0}};
  const DisplayMesh by_vertex = make_display_mesh(soup, {}, 40, false);
  EXPECT_EQ(by_vertex.colors[by_vertex.triangles[0][0]], (Rgb8{0, 0, 51}));  // 0.2 * 255 = 51
  EXPECT_EQ(by_vertex.colors[by_vertex.triangles[0][1]], (Rgb8{255, 255, 51}));
  EXPECT_EQ(by_vertex.colors[by_vertex.triangles[0][2]], (Rgb8{128, 0, 0}));
  soup.triangle_colors = {{1, 0, 0}};
  const DisplayMesh by_triangle = make_display_mesh(soup, {}, 40, false);
  for (const Rgb8& color : by_triangle.colors) EXPECT_EQ(color, (Rgb8{255, 0, 0}));
}

TEST(UnitFrame, MapsAnyMagnitude) {
  for (const double scale : {1e-300, 1e-12, 1., 1e12, 8e307}) {
    const Box box{Point(-2 * scale, 0, 0), Point(2 * scale, scale, 0)};
    const UnitFrame frame = UnitFrame::of(box);
    EXPECT_NEAR((frame.to_unit(box.upper) - Point(1, 0.25, 0)).norm(), 0, 1e-15) << scale;
    EXPECT_NEAR((frame.to_unit(box.lower) - Point(-1, -0.25, 0)).norm(), 0, 1e-15) << scale;
  }
  EXPECT_EQ(UnitFrame::of({Point(7, 7, 7), Point(7, 7, 7)}).to_unit({7, 7, 7}), Point(0, 0, 0));
  EXPECT_EQ(UnitFrame::of({}).half_extent, 1);
}

TEST(Camera, FramesAreOrthonormalAtThePolesToo) {
  for (const char* up_axis : {"y", "z"}) {
    for (const double elevation : {-90., -30., 0., 90.}) {
      const ViewFrame view = ViewFrame::from_angles(33, elevation, up_axis);
      EXPECT_NEAR((view.right.cross(view.up) - view.back).norm(), 0, 1e-15);
      EXPECT_NEAR(view.right.dot(view.up), 0, 1e-15);
      EXPECT_NEAR(view.right.norm(), 1, 1e-15);
      EXPECT_NEAR(view.up.norm(), 1, 1e-15);
    }
  }
  EXPECT_NEAR((ViewFrame::from_angles(0, 0, "y").back - Point(0, 0, 1)).norm(), 0, 1e-15);
  EXPECT_NEAR((ViewFrame::from_angles(90, 0, "y").back - Point(1, 0, 0)).norm(), 0, 1e-15);
  EXPECT_NEAR((ViewFrame::from_angles(0, 0, "z").back - Point(0, -1, 0)).norm(), 0, 1e-15);
  EXPECT_NEAR((ViewFrame::from_angles(0, 0, "z").up - Point(0, 0, 1)).norm(), 0, 1e-15);
  EXPECT_NEAR((ViewFrame::from_angles(90, 0, "z").back - Point(1, 0, 0)).norm(), 0, 1e-15);
}

TEST(Camera, TouchesTheFrustumAndHoldsEveryPoint) {
  const ViewFrame view = ViewFrame::from_angles(25, 35, "y");
  constexpr double kTangentX = 0.3;
  constexpr double kTangentY = 0.2;
  CameraFitter fitter(view, kTangentX, kTangentY);
  std::vector<Point> points;
  for (int i = 0; i < 200; ++i) points.push_back({3 * std::sin(1.7 * i), std::cos(2.3 * i), std::sin(0.9 * i * i)});
  for (const Point& point : points) fitter.add(point);
  const FittedCamera camera = fitter.fit();
  double widest = 0;
  double highest = 0;
  for (const Point& point : points) {
    const Point seen = camera.position - point;
    const double depth = view.back.dot(seen);
    EXPECT_GE(depth, camera.nearest - 1e-12);
    EXPECT_LE(depth, camera.farthest + 1e-12);
    widest = std::max(widest, std::abs(view.right.dot(seen)) / depth / kTangentX);
    highest = std::max(highest, std::abs(view.up.dot(seen)) / depth / kTangentY);
  }
  // Nothing lies outside, and one of the two directions is filled to the last bit.
  EXPECT_NEAR(std::max(widest, highest), 1, 1e-12);
}

}  // namespace
}  // namespace voxcarve
