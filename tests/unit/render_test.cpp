#include "experiments/render/render.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <numbers>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "common/run/errors.h"
#include "experiments/render/slice.h"

namespace voxcarve {
namespace {

using namespace std::string_literals;

/// The cube [-1, 1]^3, outward.
TriangleSoup cube() {
  TriangleSoup soup;
  for (int i = 0; i < 8; ++i) soup.positions.push_back({i & 1 ? 1. : -1., i & 2 ? 1. : -1., i & 4 ? 1. : -1.});
  soup.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return soup;
}

TriangleSoup reversed(TriangleSoup soup) {
  for (Triangle& triangle : soup.triangles) std::swap(triangle[1], triangle[2]);
  return soup;
}

TriangleSoup moved(TriangleSoup soup, double scale, const Point& offset) {
  for (Point& position : soup.positions) position = scale * position + offset;
  return soup;
}

RenderOptions small_panels() {
  RenderOptions options;
  options.panel_width = 200;
  options.panel_height = 160;
  return options;
}

RenderOptions front_view() {
  RenderOptions options = small_panels();
  options.azimuth = options.elevation = 0;
  return options;
}

struct Pixel {
  int red, green, blue;
  bool white() const { return red == 255 && green == 255 && blue == 255; }
  bool grey() const { return red == green && green == blue; }
};

Pixel pixel(const RenderedImage& image, int x, int y) {
  const auto at =
      3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(x));
  return {image.rgb[at], image.rgb[at + 1], image.rgb[at + 2]};
}

/// The pixels of [x_begin, x_end) that satisfy `wanted`: their number and their box, bounds included.
struct Extent {
  int count = 0;
  int left = std::numeric_limits<int>::max(), right = -1;
  int top = std::numeric_limits<int>::max(), bottom = -1;
};

template <typename Predicate>
Extent extent_of(const RenderedImage& image, int x_begin, int x_end, Predicate wanted) {
  Extent extent;
  for (int y = 0; y < image.height; ++y) {
    for (int x = x_begin; x < x_end; ++x) {
      if (!wanted(pixel(image, x, y))) continue;
      ++extent.count;
      extent.left = std::min(extent.left, x);
      extent.right = std::max(extent.right, x);
      extent.top = std::min(extent.top, y);
      extent.bottom = std::max(extent.bottom, y);
    }
  }
  return extent;
}

Extent drawn(const RenderedImage& image) {
  return extent_of(image, 0, image.width, [](const Pixel& p) { return !p.white(); });
}

/// Pixels that differ by more than a quantum or two of shading.
int differing_pixels(const RenderedImage& a, const RenderedImage& b) {
  EXPECT_EQ(a.rgb.size(), b.rgb.size());
  int count = 0;
  for (std::size_t i = 0; i + 2 < a.rgb.size(); i += 3) {
    bool differs = false;
    for (std::size_t k = 0; k < 3; ++k) differs |= std::abs(int{a.rgb[i + k]} - int{b.rgb[i + k]}) > 4;
    count += differs;
  }
  return count;
}

#define SKIP_WITHOUT_RENDERING() \
  if (!rendering_available()) GTEST_SKIP() << "this build or this machine cannot render"

TEST(Render, UnavailableRenderingSaysSo) {
  if (rendering_available()) GTEST_SKIP() << "rendering is available here";
  EXPECT_THROW(render_image({{cube(), ""}}, small_panels()), ResourceError);
}

TEST(Render, ACubeIsCentredAndFillsItsPanel) {
  SKIP_WITHOUT_RENDERING();
  RenderOptions options = small_panels();
  options.azimuth = options.elevation = 0;
  const RenderedImage image = render_image({{cube(), ""}}, options);
  ASSERT_EQ(image.width, 200);
  ASSERT_EQ(image.height, 160);
  ASSERT_EQ(image.rgb.size(), 3U * 200U * 160U);
  // Seen from the front a cube is a square of 0.92 of the height: 147.2 pixels, 6.4 above and below, 26.4 beside.
  const Extent shape = drawn(image);
  EXPECT_NEAR(shape.top, 6.4, 1);
  EXPECT_NEAR(shape.bottom, 153.6, 1);
  EXPECT_NEAR(shape.left, 26.4, 1);
  EXPECT_NEAR(shape.right, 173.6, 1);
  EXPECT_NEAR(shape.count, 147.2 * 147.2, 2 * 147.2);
  // Warm grey: red over blue, and neither black nor white.
  const Pixel middle = pixel(image, 100, 80);
  EXPECT_GT(middle.red, middle.blue);
  EXPECT_GT(middle.blue, 120);
  EXPECT_LT(middle.red, 255);
}

TEST(Render, FacesOfACubeAreFlatAndDiffer) {
  SKIP_WITHOUT_RENDERING();
  const RenderedImage image = render_image({{cube(), ""}}, small_panels());
  // From azimuth 30 and elevation 20 the front is left of the middle, the +x side right of it, and the top above.
  const Pixel front = pixel(image, 85, 90);
  const Pixel side = pixel(image, 140, 90);
  const Pixel top = pixel(image, 105, 28);
  EXPECT_GT(std::abs(front.red - side.red), 15);
  EXPECT_GT(std::abs(top.red - side.red), 15);
  EXPECT_NEAR(pixel(image, 65, 60).red, pixel(image, 65, 120).red, 12);  // sharp edges: no gradient across a face
}

TEST(Render, BackFacesAreTinted) {
  SKIP_WITHOUT_RENDERING();
  const auto reddish = [](const Pixel& p) { return p.red > 1.4 * p.blue; };
  const auto count = [&](const TriangleSoup& shape) {
    const RenderedImage image = render_image({{shape, ""}}, small_panels());
    return extent_of(image, 0, image.width, reddish).count;
  };
  EXPECT_EQ(count(cube()), 0);
  // Inside out it is seen from behind all over; the averaged rim against the white ground may be pale.
  const int covered = drawn(render_image({{cube(), ""}}, small_panels())).count;
  EXPECT_GT(count(reversed(cube())), 0.95 * covered);
  // Through a missing front the insides of the other faces are seen.
  TriangleSoup open = cube();
  open.triangles.erase(open.triangles.begin() + 2, open.triangles.begin() + 4);
  EXPECT_GT(count(open), 0.2 * covered);
  // A colour of the shape does not hide it.
  TriangleSoup green = reversed(cube());
  green.vertex_colors.assign(8, Color(0, 1, 0));
  EXPECT_GT(count(green), 0.95 * covered);
}

TEST(Render, ShowsTheColoursOfTheShape) {
  SKIP_WITHOUT_RENDERING();
  TriangleSoup green = cube();
  green.triangle_colors.assign(12, Color(0, 1, 0));
  const Pixel middle = pixel(render_image({{green, ""}}, small_panels()), 85, 90);
  EXPECT_GT(middle.green, 100);
  EXPECT_LT(middle.red, 40);
}

TEST(Render, SamePixelsTwiceAndFromTwoThreads) {
  SKIP_WITHOUT_RENDERING();
  RenderOptions options = small_panels();
  options.wireframe = true;
  const std::vector<RenderItem> items = {{cube(), "cube"}, {reversed(cube()), "inside out"}};
  const RenderedImage first = render_image(items, options);
  RenderedImage second;
  RenderedImage third;
  std::thread other([&] { second = render_image(items, options); });
  third = render_image(items, options);
  other.join();
  EXPECT_EQ(first, second);
  EXPECT_EQ(first, third);
}

TEST(Render, WireframeDrawsDarkLinesWithinTheShape) {
  SKIP_WITHOUT_RENDERING();
  RenderOptions options = small_panels();
  options.azimuth = options.elevation = 0;
  const RenderedImage plain = render_image({{cube(), ""}}, options);
  options.wireframe = true;
  const RenderedImage lines = render_image({{cube(), ""}}, options);
  const int changed = differing_pixels(plain, lines);
  // Four sides and a diagonal of 147 pixels: at least as many pixels, and far less than the face.
  EXPECT_GT(changed, 5 * 147);
  EXPECT_LT(changed, 10 * 147 + 147);
  // The diagonal of the front goes through the middle of the picture.
  int darkest = 255;
  for (int x = 98; x <= 102; ++x) darkest = std::min(darkest, pixel(lines, x, 80).red);
  EXPECT_LT(darkest, pixel(plain, 100, 80).red - 50);
}

TEST(Render, WireframeDrawsLightLinesOnDarkSurfaces) {
  SKIP_WITHOUT_RENDERING();
  TriangleSoup navy = cube();
  navy.vertex_colors.assign(8, Color(0, 0, 0.4F));  // luminance 0.114 * 102 = 12
  RenderOptions options = front_view();
  const RenderedImage plain = render_image({{navy, ""}}, options);
  options.wireframe = true;
  const RenderedImage lines = render_image({{navy, ""}}, options);
  // The diagonal of the front goes through the middle of the picture.
  int lightest = 0;
  for (int x = 98; x <= 102; ++x) lightest = std::max(lightest, pixel(lines, x, 80).red);
  EXPECT_GT(lightest, pixel(plain, 100, 80).red + 50);
}

TEST(Render, CaptionsLieBelowTheModelAndInsideThePanel) {
  SKIP_WITHOUT_RENDERING();
  const std::string caption = "a caption that is far too long for one line of this panel\nsecond line";
  const RenderedImage image = render_image({{cube(), caption}}, small_panels());
  const Extent model = extent_of(image, 0, image.width, [](const Pixel& p) { return !p.grey(); });  // ink is grey
  const Extent ink = extent_of(image, 0, image.width, [](const Pixel& p) { return p.grey() && p.red < 160; });
  ASSERT_GT(model.count, 1000);
  ASSERT_GT(ink.count, 50);
  EXPECT_LT(model.bottom, ink.top);
  EXPECT_GT(ink.left, 0);
  EXPECT_LT(ink.right, image.width - 1);
  EXPECT_LT(ink.bottom, image.height - 1);
  EXPECT_NEAR((ink.left + ink.right) / 2.0, 99.5, 3);
  EXPECT_GE(ink.bottom - ink.top, 20);  // at least three lines of 7 pixels
}

TEST(Render, StrangeCaptionsAreDrawn) {
  SKIP_WITHOUT_RENDERING();
  // Not UTF-8, control characters, markup of other text renderers, a surrogate, an e with an acute accent, a zero byte.
  const std::string bytes = "\xff\xc3 \x01\t|$x^2$ \xed\xa0\x80 \xc3\xa9\0end"s;
  for (const std::string& caption :
       {bytes, std::string(4000, 'w'), std::string("\n\n\n"), std::string(300, '\n') + "x"}) {
    const RenderedImage image = render_image({{cube(), caption}}, small_panels());
    const Extent model = extent_of(image, 0, image.width, [](const Pixel& p) { return !p.grey(); });
    EXPECT_GT(model.count, 1000);  // the caption leaves at least two thirds to the model
  }
}

TEST(Render, TheScaleAndPlaceOfCoordinatesDoNotMatter) {
  SKIP_WITHOUT_RENDERING();
  const RenderedImage reference = render_image({{cube(), ""}}, small_panels());
  const auto differing = [&](double scale, const Point& offset) {
    return differing_pixels(reference, render_image({{moved(cube(), scale, offset), ""}}, small_panels()));
  };
  EXPECT_EQ(differing(0x1p-40, Point::Zero()), 0);  // about 1e-12; a power of two changes no digit
  EXPECT_EQ(differing(0x1p40, Point::Zero()), 0);
  EXPECT_EQ(differing(0x1p-1000, Point::Zero()), 0);
  EXPECT_EQ(differing(0x1p1000, Point::Zero()), 0);
  EXPECT_EQ(differing(1, Point(1e12, -1e12, 1e12)), 0);  // +-1 is exact there
  EXPECT_LE(differing(1e-12, Point(1, 2, 3)), 60);       // 1 + 1e-12 has 4 digits left: pixels of the rim may differ
}

TEST(Render, ACommonCameraKeepsSizesAndPlaces) {
  SKIP_WITHOUT_RENDERING();
  RenderOptions options = small_panels();
  options.azimuth = options.elevation = 0;
  const std::vector<RenderItem> items = {{cube(), ""}, {moved(cube(), 0.5, Point(0, 0, 0.5)), ""}};
  const auto shape = [&](const RenderedImage& image, int panel) {
    return extent_of(image, 200 * panel + 2, 200 * panel + 198, [](const Pixel& p) { return !p.white(); });
  };
  // The front faces lie in one plane, so half the size is half the pixels.
  const RenderedImage common = render_image(items, options);
  ASSERT_EQ(common.width, 400);
  const auto width = [](const Extent& e) { return e.right - e.left + 1; };
  EXPECT_NEAR(width(shape(common, 1)), width(shape(common, 0)) / 2.0, 1);
  options.common_camera = false;
  const RenderedImage apart = render_image(items, options);
  EXPECT_NEAR(width(shape(apart, 1)), width(shape(apart, 0)), 1);
}

TEST(Render, APanelDoesNotDependOnTheOthers) {
  SKIP_WITHOUT_RENDERING();
  RenderOptions options = small_panels();
  options.common_camera = false;
  options.wireframe = true;
  TriangleSoup red = cube();
  red.vertex_colors.assign(8, Color(1, 0, 0));
  const RenderedImage alone = render_image({{cube(), "caption"}}, options);
  options.columns = 1;
  const RenderedImage both = render_image({{red, "caption"}, {cube(), "caption"}}, options);
  ASSERT_EQ(both.height, 320);
  // All rows of the second panel but the first, where the separator lies.
  const std::ptrdiff_t row = 3 * 200;
  EXPECT_TRUE(std::equal(alone.rgb.begin() + 2 * row, alone.rgb.end(), both.rgb.begin() + 162 * row));
}

TEST(Render, EmptyShapesKeepTheirPanelAndCaption) {
  SKIP_WITHOUT_RENDERING();
  const RenderedImage image = render_image({{cube(), "full"}, {TriangleSoup{}, "empty"}}, small_panels());
  const auto ink = [](const Pixel& p) { return p.grey() && p.red < 160; };
  const Extent caption = extent_of(image, 202, 400, ink);
  EXPECT_GT(caption.count, 20);
  EXPECT_GT(caption.top, 130);
  EXPECT_EQ(extent_of(image, 202, 400, [](const Pixel& p) { return !p.grey(); }).count, 0);
  // The thin line between the panels runs from top to bottom.
  for (int y = 0; y < image.height; ++y) EXPECT_FALSE(pixel(image, 200, y).white());
  EXPECT_EQ(drawn(render_image({{TriangleSoup{}, ""}}, small_panels())).count, 0);
}

TEST(Render, DegenerateShapesDoNotFail) {
  SKIP_WITHOUT_RENDERING();
  TriangleSoup point;
  point.positions = {{5, 5, 5}};
  point.triangles = {{0, 0, 0}};
  TriangleSoup edge_on;  // a flat triangle, seen from its side
  edge_on.positions = {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}};
  edge_on.triangles = {{0, 1, 2}};
  RenderOptions options = small_panels();
  options.azimuth = options.elevation = 0;
  options.wireframe = true;
  options.common_camera = false;
  const RenderedImage image = render_image({{point, ""}, {edge_on, ""}}, options);
  EXPECT_LT(drawn(image).count, 200 * 160 / 10);
}

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
  SKIP_WITHOUT_RENDERING();
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
  SKIP_WITHOUT_RENDERING();
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
  SKIP_WITHOUT_RENDERING();
  const std::vector<RenderItem> items = {{ball(30, 12), "scalar"}, {interior_of(ball(30, 12)), "binary"}};
  EXPECT_EQ(render_image(items, small_panels()), render_image(items, small_panels()));
}

TEST(RenderVolume, TheBorderOfTheGridClosesTheSolid) {
  SKIP_WITHOUT_RENDERING();
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
  SKIP_WITHOUT_RENDERING();
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
  SKIP_WITHOUT_RENDERING();
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
  SKIP_WITHOUT_RENDERING();
  const GridFrame frame{Index3::Constant(4), Point::Zero(), 1};
  EXPECT_EQ(drawn(render_image({{BinaryVolume(frame), ""}}, small_panels())).count, 0);
  EXPECT_EQ(drawn(render_image({{ScalarVolume{Grid<float>(frame, 1), 2}, ""}}, small_panels())).count, 0);
}

TEST(RenderVolume, SharesAPictureWithSlices) {
  SKIP_WITHOUT_RENDERING();
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
  SKIP_WITHOUT_RENDERING();
  std::stop_source stop;
  RenderOptions options = small_panels();
  options.cancellation = stop.get_token();
  const std::vector<RenderItem> items = {{cube(), ""}, {ball(20, 8), ""}};
  EXPECT_NO_THROW(render_image(items, options));
  stop.request_stop();
  EXPECT_THROW(render_image(items, options), Cancelled);
}

class RenderFile : public testing::Test {
 protected:
  void SetUp() override {
    const testing::TestInfo* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::temp_directory_path() /
              ("voxcarve_render_" + std::string(test->name()) + "_" + std::to_string(::getpid()));
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  static std::string bytes_of(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  std::size_t files() const {
    return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder_), {}));
  }

  std::filesystem::path folder_;
};

TEST_F(RenderFile, WritesOneCompletePngAndTheSameBytesTwice) {
  SKIP_WITHOUT_RENDERING();
  const std::vector<RenderItem> items = {{cube(), "cube"}};
  render_meshes(items, small_panels(), folder_ / "a.png");
  render_meshes(items, small_panels(), folder_ / "b.png");
  const std::string bytes = bytes_of(folder_ / "a.png");
  EXPECT_EQ(bytes, bytes_of(folder_ / "b.png"));
  EXPECT_EQ(files(), 2U);  // no temporary file stays
  // Signature, header chunk with width 200 = 0xc8 and height 160 = 0xa0, 8 bits of RGB, and the end chunk.
  EXPECT_EQ(bytes.substr(0, 26), "\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\xc8\0\0\0\xa0\x08\x02"s);
  EXPECT_EQ(bytes.substr(bytes.size() - 8, 4), "IEND");
}

TEST_F(RenderFile, AFailureLeavesNoFile) {
  EXPECT_THROW(render_meshes({}, small_panels(), folder_ / "a.png"), ParameterError);
  EXPECT_THROW(render_meshes({{cube(), ""}}, small_panels(), folder_ / "missing" / "a.png"), ResourceError);
  EXPECT_EQ(files(), 0U);
}

}  // namespace
}  // namespace voxcarve
