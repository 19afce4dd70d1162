#include "experiments/render/render.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <thread>
#include <vector>

#include "common/run/errors.h"
#include "tests/support/shapes.h"
#include "tests/unit/rendered_image.h"

namespace voxcarve {
namespace {

using namespace std::string_literals;

using test::cube;
using test::drawn;
using test::Extent;
using test::extent_of;
using test::front_view;
using test::inside_out;
using test::moved;
using test::Pixel;
using test::pixel;
using test::small_panels;

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

/// As a side that is seen from behind.
bool reddish(const Pixel& p) {
  return p.red > 1.4 * p.blue;
}

TEST(Render, UnavailableRenderingSaysSo) {
  if (rendering_available()) GTEST_SKIP() << "rendering is available here";
  EXPECT_THROW(render_image({{cube(), ""}}, small_panels()), ResourceError);
}

TEST(Render, ACubeIsCentredAndFillsItsPanel) {
  VOXCARVE_REQUIRE_RENDERING();
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
  VOXCARVE_REQUIRE_RENDERING();
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
  VOXCARVE_REQUIRE_RENDERING();
  const auto count = [&](const TriangleSoup& shape) {
    const RenderedImage image = render_image({{shape, ""}}, small_panels());
    return extent_of(image, 0, image.width, reddish).count;
  };
  EXPECT_EQ(count(cube()), 0);
  // Inside out it is seen from behind all over; the averaged rim against the white ground may be pale.
  const int covered = drawn(render_image({{cube(), ""}}, small_panels())).count;
  EXPECT_GT(count(inside_out(cube())), 0.95 * covered);
  // Through a missing front the insides of the other faces are seen.
  TriangleSoup open = cube();
  open.triangles.erase(open.triangles.begin() + 2, open.triangles.begin() + 4);
  EXPECT_GT(count(open), 0.2 * covered);
  // A colour of the shape does not hide it.
  TriangleSoup green = inside_out(cube());
  green.vertex_colors.assign(8, Color(0, 1, 0));
  EXPECT_GT(count(green), 0.95 * covered);
}

TEST(Render, BothSidesOfAFoldShowTheirFronts) {
  VOXCARVE_REQUIRE_RENDERING();
  // Closed surfaces without a volume: two triangles, and a bent sheet of 200. The other side of each has the same
  // positions, under numbers of its own and from another corner on, as after cutting to a manifold.
  TriangleSoup triangle;
  triangle.positions = {{-1, -1, 0.3}, {1, -0.8, -0.2}, {0.1, 1, 0.1}};
  triangle.triangles = {{0, 1, 2}};
  TriangleSoup sheet;
  for (int j = 0; j <= 10; ++j) {
    for (int i = 0; i <= 10; ++i)
      sheet.positions.emplace_back(i / 5.0 - 1, j / 5.0 - 1, 0.3 * std::sin(0.7 * i - 0.4 * j));
  }
  for (std::uint32_t j = 0; j < 10; ++j) {
    for (std::uint32_t i = 0; i < 10; ++i) {
      const std::uint32_t a = 11 * j + i;
      sheet.triangles.push_back({a, a + 1, a + 12});
      sheet.triangles.push_back({a, a + 12, a + 11});
    }
  }
  for (const TriangleSoup& front : {triangle, sheet}) {
    TriangleSoup closed = front;
    const auto copies = static_cast<std::uint32_t>(front.positions.size());
    closed.positions.insert(closed.positions.end(), front.positions.begin(), front.positions.end());
    for (const auto& [a, b, c] : front.triangles) closed.triangles.push_back({c + copies, b + copies, a + copies});
    for (const double azimuth : {-150.0, -35.0, 20.0, 110.0}) {
      RenderOptions options = small_panels();
      options.azimuth = azimuth;
      const RenderedImage image = render_image({{closed, ""}}, options);
      EXPECT_EQ(extent_of(image, 0, image.width, reddish).count, 0) << azimuth;
      // It covers what the sheet alone covers, whose back is red from behind.
      const RenderedImage open = render_image({{front, ""}}, options);
      EXPECT_EQ(drawn(image).count, drawn(open).count) << azimuth;
      if (std::abs(azimuth) > 100) {
        EXPECT_GT(extent_of(open, 0, open.width, reddish).count, drawn(open).count / 4) << azimuth;
      }
    }
  }
}

TEST(Render, ShowsTheColoursOfTheShape) {
  VOXCARVE_REQUIRE_RENDERING();
  TriangleSoup green = cube();
  green.triangle_colors.assign(12, Color(0, 1, 0));
  const Pixel middle = pixel(render_image({{green, ""}}, small_panels()), 85, 90);
  EXPECT_GT(middle.green, 100);
  EXPECT_LT(middle.red, 40);
}

TEST(Render, SamePixelsTwiceAndFromTwoThreads) {
  VOXCARVE_REQUIRE_RENDERING();
  RenderOptions options = small_panels();
  options.wireframe = true;
  const std::vector<RenderItem> items = {{cube(), "cube"}, {inside_out(cube()), "inside out"}};
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
  VOXCARVE_REQUIRE_RENDERING();
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
  VOXCARVE_REQUIRE_RENDERING();
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
  VOXCARVE_REQUIRE_RENDERING();
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
  VOXCARVE_REQUIRE_RENDERING();
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
  VOXCARVE_REQUIRE_RENDERING();
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
  VOXCARVE_REQUIRE_RENDERING();
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
  VOXCARVE_REQUIRE_RENDERING();
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
  VOXCARVE_REQUIRE_RENDERING();
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
  VOXCARVE_REQUIRE_RENDERING();
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
  VOXCARVE_REQUIRE_RENDERING();
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
