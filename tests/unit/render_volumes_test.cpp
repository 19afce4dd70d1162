// Volumes and slices as the contents of a panel, alone and beside meshes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <stop_token>
#include <vector>

#include "common/run/errors.h"
#include "experiments/render/render.h"
#include "experiments/render/slice.h"
#include "tests/unit/rendered_image.h"

namespace voxcarve {
namespace {

using test::cube;
using test::drawn;
using test::Extent;
using test::extent_of;
using test::front_view;
using test::moved;
using test::Pixel;
using test::pixel;
using test::small_panels;

/// The distance to the surface of a ball about the middle of `side`^3 unit voxels, positive inside: a field whose
/// isosurface at 0 is the sphere of that radius.
ScalarVolume ball(std::int64_t side, double radius) {
  ScalarVolume volume{Grid<float>(GridFrame{Index3::Constant(side), Point::Zero(), 1}), 0};
  const Point center = Point::Constant(static_cast<double>(side) / 2);
  for (std::int64_t k = 0; k < side; ++k) {
    for (std::int64_t j = 0; j < side; ++j) {
      for (std::int64_t i = 0; i < side; ++i) {
        const double distance = (volume.grid.frame.center({i, j, k}) - center).norm();
        volume.grid(i, j, k) = static_cast<float>(radius - distance);
      }
    }
  }
  return volume;
}

BinaryVolume interior_of(const ScalarVolume& volume) {
  BinaryVolume binary(volume.grid.frame);
  std::transform(volume.grid.values.begin(), volume.grid.values.end(), binary.values.begin(),
                 [](float value) { return static_cast<std::uint8_t>(value >= 0); });
  return binary;
}

TEST(RenderVolume, ABallIsADiskOfTheRightSize) {
  VOXCARVE_REQUIRE_RENDERING();
  // A camera fitted to a ball sees it under the angle that it fills: a disk of 0.92 of the panel's half height, 73.6
  // pixels. The camera is fitted to the interior voxels as cubes, whose corners lie up to sqrt(3)/2 voxels beyond the
  // radius of 40 and at least as far out as the centres of the outermost ones, half a voxel before it.
  const double smallest = 73.6 * 40 / (40 + std::sqrt(3) / 2);
  const double largest = 73.6 * 40 / 39.5;
  const ScalarVolume scalar = ball(84, 40);
  for (const RenderContent& content : {RenderContent(scalar), RenderContent(interior_of(scalar))}) {
    const RenderedImage image = render_image({{content, ""}}, front_view());
    const Extent shape = drawn(image);
    EXPECT_GT(shape.count, std::numbers::pi * (smallest - 1) * (smallest - 1));
    EXPECT_LT(shape.count, std::numbers::pi * (largest + 1) * (largest + 1));
    EXPECT_NEAR(shape.right - shape.left + 1, 2 * (smallest + largest) / 2, 3);
    EXPECT_NEAR(shape.left + shape.right, 199, 1);  // centred, left to right and top to bottom
    EXPECT_NEAR(shape.top + shape.bottom, 159, 1);
    // As large above the middle as below, and left as right.
    const auto half = [&](int x_begin, int x_end) {
      return extent_of(image, x_begin, x_end, [](const Pixel& p) { return !p.white(); }).count;
    };
    EXPECT_NEAR(half(0, 100), half(100, 200), 80);
    const Pixel middle = pixel(image, 100, 80);
    EXPECT_GT(middle.red, middle.blue);  // warm grey, and neither black nor white
    EXPECT_GT(middle.blue, 120);
    EXPECT_LT(middle.red, 255);
  }
}

/// A sphere of many small triangles, outward.
TriangleSoup sphere(double radius, const Point& center) {
  constexpr int kSegments = 96;
  constexpr int kRings = 48;
  TriangleSoup soup;
  for (int ring = 0; ring <= kRings; ++ring) {
    for (int segment = 0; segment < kSegments; ++segment) {
      const double theta = std::numbers::pi * ring / kRings;
      const double phi = 2 * std::numbers::pi * segment / kSegments;
      soup.positions.push_back(
          center + radius * Point(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)));
    }
  }
  const auto at = [](int ring, int segment) {
    return static_cast<std::uint32_t>(ring * kSegments + segment % kSegments);
  };
  for (int ring = 0; ring < kRings; ++ring) {
    for (int segment = 0; segment < kSegments; ++segment) {
      soup.triangles.push_back({at(ring, segment), at(ring + 1, segment), at(ring + 1, segment + 1)});
      soup.triangles.push_back({at(ring, segment), at(ring + 1, segment + 1), at(ring, segment + 1)});
    }
  }
  return soup;
}

TEST(RenderVolume, LooksLikeTheMeshBesideIt) {
  VOXCARVE_REQUIRE_RENDERING();
  const RenderedImage image = render_image({{sphere(40, Point::Constant(42)), ""}, {ball(84, 40), ""}}, small_panels());
  const auto silhouette = [&](int panel) {
    return extent_of(image, 200 * panel + 2, 200 * panel + 198, [](const Pixel& p) { return !p.white(); });
  };
  const Extent mesh = silhouette(0);
  const Extent volume = silhouette(1);
  // One camera, one place; any tint counts, so rims of the average over 2 x 2 samples may make a pixel.
  EXPECT_NEAR(std::sqrt(volume.count / std::numbers::pi), std::sqrt(mesh.count / std::numbers::pi), 1);
  EXPECT_NEAR(volume.left, mesh.left + 200, 1);
  EXPECT_NEAR(volume.top, mesh.top, 1);
  // The same colour under the same lamps, up to highlights and directions that the ray caster rounds.
  for (const int x : {60, 80, 100, 120, 140}) {
    for (const int y : {50, 80, 110}) {
      EXPECT_NEAR(pixel(image, x + 200, y).red, pixel(image, x, y).red, 10) << x << ", " << y;
      EXPECT_NEAR(pixel(image, x + 200, y).blue, pixel(image, x, y).blue, 10) << x << ", " << y;
    }
  }
}

TEST(RenderVolume, SamePixelsTwice) {
  VOXCARVE_REQUIRE_RENDERING();
  const std::vector<RenderItem> items = {{ball(30, 12), "scalar"}, {interior_of(ball(30, 12)), "binary"}};
  EXPECT_EQ(render_image(items, small_panels()), render_image(items, small_panels()));
}

TEST(RenderVolume, TheBorderOfTheGridClosesTheSolid) {
  VOXCARVE_REQUIRE_RENDERING();
  // Interior up to the border: the cube [0, 8]^3.
  const GridFrame frame{Index3::Constant(8), Point::Zero(), 1};
  BinaryVolume full(frame, 1);
  ScalarVolume field{Grid<float>(frame, 3), 2};
  const RenderedImage image =
      render_image({{moved(cube(), 4, Point::Constant(4)), ""}, {full, ""}, {field, ""}}, front_view());
  const auto silhouette = [&](int panel) {
    return extent_of(image, 200 * panel + 2, 200 * panel + 198, [](const Pixel& p) { return !p.white(); });
  };
  const Extent mesh = silhouette(0);
  for (const int panel : {1, 2}) {
    const Extent volume = silhouette(panel);
    EXPECT_NEAR(volume.left - 200 * panel, mesh.left, 2);
    EXPECT_NEAR(volume.right - 200 * panel, mesh.right, 2);
    EXPECT_NEAR(volume.top, mesh.top, 2);
    EXPECT_NEAR(volume.bottom, mesh.bottom, 2);
    // Opaque all over: two pixels less on every side leave (143/147)^2 = 0.946, and interpolation rounds the corners.
    EXPECT_GT(volume.count, 0.93 * mesh.count);
  }
}

TEST(RenderVolume, IsNoBlockWhereTheIsoValueIsTheGreatestValue) {
  VOXCARVE_REQUIRE_RENDERING();
  // A ball of label 2 within a shell of label 1. Interpolation between the labels reaches 2 at the voxels' centres, so
  // the solid at an iso-value of 2 has half a voxel less on every side than the ball of voxels has, of radius 8.
  ScalarVolume labels = ball(24, 8);
  for (float& value : labels.grid.values) value = value >= 0 ? 2.0F : value >= -2 ? 1.0F : 0.0F;
  labels.iso_value = 2;
  const Extent solid = drawn(render_image({{labels, ""}}, front_view()));
  const Extent whole = drawn(render_image({{interior_of(ball(24, 8)), ""}}, front_view()));
  EXPECT_LT(solid.count, whole.count);
  EXPECT_GT(std::sqrt(solid.count), 0.8 * std::sqrt(whole.count));
}

TEST(RenderVolume, APlateOfOneVoxelIsSeen) {
  VOXCARVE_REQUIRE_RENDERING();
  BinaryVolume plate(GridFrame{{21, 21, 5}, Point::Zero(), 1});
  for (std::int64_t j = 3; j < 18; ++j) {
    for (std::int64_t i = 3; i < 18; ++i) plate(i, j, 2) = 1;
  }
  const RenderedImage image = render_image({{plate, ""}}, front_view());
  // 15 x 15 voxels seen from the front, 0.92 of the height.
  const Extent shape = drawn(image);
  EXPECT_NEAR(shape.bottom - shape.top + 1, 147, 8);
  const Pixel middle = pixel(image, 100, 80);
  EXPECT_GT(middle.red, 100);  // lit, though the gradient vanishes in its middle
  EXPECT_LT(middle.red, 250);
}

TEST(RenderVolume, AnEmptyVolumeIsAnEmptyPanel) {
  VOXCARVE_REQUIRE_RENDERING();
  const GridFrame frame{Index3::Constant(4), Point::Zero(), 1};
  EXPECT_EQ(drawn(render_image({{BinaryVolume(frame), ""}}, small_panels())).count, 0);
  EXPECT_EQ(drawn(render_image({{ScalarVolume{Grid<float>(frame, 1), 2}, ""}}, small_panels())).count, 0);
}

TEST(RenderVolume, SharesAPictureWithSlices) {
  VOXCARVE_REQUIRE_RENDERING();
  const ScalarVolume volume = ball(20, 8);
  SlicePicture slice = color_slice(extract_slice(volume.grid, 2, 10), {.low = 0, .high = 1});
  const RenderedImage image = render_image({{volume, ""}, {slice, ""}}, small_panels());
  EXPECT_EQ(image.width, 400);
  EXPECT_TRUE(pixel(image, 300, 80).white());  // the middle of the ball: 8 - sqrt(3)/2 exceeds the window
  // 20 voxels of floor(158 / 20) = 7 pixels, 140, so the slice begins 30 pixels right of the panel's left side and 10
  // below its top; its corner is far outside the ball.
  EXPECT_EQ(pixel(image, 231, 11).red, 0);
  EXPECT_EQ(pixel(image, 229, 11).red, 128);  // the line around it
  EXPECT_EQ(pixel(image, 231, 9).red, 128);
  EXPECT_TRUE(pixel(image, 228, 11).white());
  EXPECT_TRUE(pixel(image, 231, 8).white());
}

TEST(Render, AStopRequestIsObeyed) {
  VOXCARVE_REQUIRE_RENDERING();
  std::stop_source stop;
  RenderOptions options = small_panels();
  options.cancellation = stop.get_token();
  const std::vector<RenderItem> items = {{cube(), ""}, {ball(20, 8), ""}};
  EXPECT_NO_THROW(render_image(items, options));
  stop.request_stop();
  EXPECT_THROW(render_image(items, options), Cancelled);
}

}  // namespace
}  // namespace voxcarve
