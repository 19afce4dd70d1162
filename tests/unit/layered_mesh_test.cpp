// Layers of a surface: the order of their triangles, and how they blend.
#include "experiments/render/layered_mesh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <set>
#include <vector>

#include "common/run/errors.h"
#include "tests/unit/rendered_image.h"

namespace voxcarve {
namespace {

using test::cube;
using test::front_view;
using test::moved;
using test::Pixel;
using test::pixel;

/// The square [-1, 1]^2 at height z, seen from +z counterclockwise, of one colour.
TriangleSoup sheet(double z, const Color& color) {
  TriangleSoup soup;
  soup.positions = {{-1, -1, z}, {1, -1, z}, {1, 1, z}, {-1, 1, z}};
  soup.triangles = {{0, 1, 2}, {0, 2, 3}};
  soup.vertex_colors.assign(4, color);
  return soup;
}

const Color kRed(1, 0, 0);
const Color kGreen(0, 1, 0);

View view_from_front() {
  View view;  // the unit frame is the model's
  view.camera = {Eigen::Vector3d(0, 0, 10), 8, 12};
  return view;
}

TEST(LayeredMesh, SortsTrianglesOfAllLayersFromFarToNear) {
  // Of five sheets in no order, two of them at one place: there the inner layer, green, comes first.
  LayeredSurface surface;
  surface.layers = {
      {sheet(0.5, kGreen), 0.5}, {sheet(-0.5, kRed), 0.25}, {sheet(0.5, kRed), 0.75}, {sheet(0, kRed), 0}};
  const LayeredMesh mesh = make_layered_mesh(surface, view_from_front(), 40);
  EXPECT_TRUE(mesh.opaque.triangles.empty());
  ASSERT_EQ(mesh.translucent.triangles.size(), 8U);
  std::vector<float> heights;
  std::vector<int> opacities;
  for (const Triangle& triangle : mesh.translucent.triangles) {
    heights.push_back(mesh.translucent.positions[triangle[0]].z());
    opacities.push_back(mesh.opacities[triangle[0]]);
  }
  EXPECT_EQ(heights, (std::vector<float>{-0.5, -0.5, 0, 0, 0.5, 0.5, 0.5, 0.5}));
  // 255 / 4 = 63.75, 255 / 2 = 127.5 and 3 / 4 of 255 = 191.25, to the nearest.
  EXPECT_EQ(opacities, (std::vector<int>{64, 64, 0, 0, 128, 128, 191, 191}));
  EXPECT_EQ(mesh.opacities.size(), mesh.translucent.positions.size());
}

TEST(LayeredMesh, KeepsOpaqueLayersApartAndPassesOverEmptyOnes) {
  LayeredSurface surface;
  surface.layers = {{cube(), 1}, {TriangleSoup{}, 0.5}, {sheet(2, kRed), 0.5}};
  const LayeredMesh mesh = make_layered_mesh(surface, view_from_front(), 40);
  EXPECT_EQ(mesh.opaque.triangles.size(), 12U);
  EXPECT_EQ(mesh.translucent.triangles.size(), 2U);
}

/// The colour in the middle of a picture from the front, of layers between z = -1 and 1.
Pixel middle_of(const std::vector<LayeredSurface::Layer>& layers) {
  RenderOptions options = front_view();
  options.framed = cube().positions;
  return pixel(render_image({{LayeredSurface{layers}, ""}}, options), 100, 80);
}

/// `over` blended over `under`, rounded opacities and all.
double blended(double opacity, double over, double under) {
  const double share = std::round(255 * opacity) / 255;
  return share * over + (1 - share) * under;
}

TEST(Layers, TheNearerIsBlendedOverTheFarther) {
  VOXCARVE_REQUIRE_RENDERING();
  const Pixel red = middle_of({{sheet(-0.5, kRed), 1}});
  const Pixel green = middle_of({{sheet(0.5, kGreen), 1}});
  // Listed in either order: what counts is where they are. A mean that knows no order would be as red as green.
  const LayeredSurface::Layer far = {sheet(-0.5, kRed), 0.6};
  const LayeredSurface::Layer near = {sheet(0.5, kGreen), 0.6};
  for (const auto& layers : {std::vector{far, near}, std::vector{near, far}}) {
    const Pixel both = middle_of(layers);
    EXPECT_NEAR(both.red, blended(0.6, green.red, blended(0.6, red.red, 255)), 2);
    EXPECT_NEAR(both.green, blended(0.6, green.green, blended(0.6, red.green, 255)), 2);
    EXPECT_NEAR(both.blue, blended(0.6, green.blue, blended(0.6, red.blue, 255)), 2);
    EXPECT_GT(both.green, both.red + 40);
  }
}

TEST(Layers, OnlyFrontsAreDrawnAndNothingBehindWhatIsOpaque) {
  VOXCARVE_REQUIRE_RENDERING();
  const Pixel opaque = middle_of({{cube(), 1}});
  // A closed layer is passed once, not again on the way out.
  const Pixel once = middle_of({{cube(), 0.5}});
  EXPECT_NEAR(once.red, blended(0.5, opaque.red, 255), 2);
  // An opaque cube hides a layer behind it and shows one in front.
  const Pixel hidden = middle_of({{moved(cube(), 0.5, Point::Zero()), 1}, {sheet(-0.9, kGreen), 0.5}});
  EXPECT_NEAR(hidden.green, opaque.green, 2);
  const Pixel shown = middle_of({{moved(cube(), 0.5, Point::Zero()), 1}, {sheet(0.9, kGreen), 0.5}});
  EXPECT_NEAR(shown.red, blended(0.5, middle_of({{sheet(0.9, kGreen), 1}}).red, opaque.red), 2);
}

TEST(Layers, AnOpaqueLayerAloneIsAMesh) {
  VOXCARVE_REQUIRE_RENDERING();
  const RenderedImage mesh = render_image({{cube(), "cube"}}, test::small_panels());
  EXPECT_EQ(render_image({{LayeredSurface{{{cube(), 1}}}, "cube"}}, test::small_panels()), mesh);
}

TEST(Layers, SmoothASilhouetteThatOneSampleAPixelLeavesAliased) {
  VOXCARVE_REQUIRE_RENDERING();
  // A turned cube's outline, three pixels wide in four layers.
  RenderOptions options = test::small_panels();
  options.aliased = true;
  std::vector<LayeredSurface::Layer> layers;
  for (int i = 0; i < 4; ++i) layers.push_back({moved(cube(), 1 + 0.02 * i, Point::Zero()), 1 - 0.25 * i});
  options.framed = layers.back().surface.positions;
  const auto levels = [](const RenderedImage& image) {
    std::set<int> values;
    for (std::size_t i = 0; i < image.rgb.size(); i += 3) values.insert(image.rgb[i]);
    return values.size();
  };
  const RenderedImage single = render_image({{cube(), ""}}, options);
  const RenderedImage layered = render_image({{LayeredSurface{layers}, ""}}, options);
  EXPECT_GT(levels(layered), 2 * levels(single));
  EXPECT_EQ(render_image({{LayeredSurface{layers}, ""}}, options), layered);
}

TEST(Layers, RefusesAnOpacityThatIsNone) {
  for (const double opacity : {-0.1, 1.1, std::nan("")})
    EXPECT_THROW(render_image({{LayeredSurface{{{cube(), opacity}}}, ""}}), InputError) << opacity;
}

TEST(Samples, AliasedPixelsAreTheSamplesOfSmoothOnes) {
  VOXCARVE_REQUIRE_RENDERING();
  const RenderedImage smooth = render_image({{cube(), ""}}, test::small_panels());
  RenderOptions options = test::small_panels();
  options.panel_width *= 2;
  options.panel_height *= 2;
  options.aliased = true;
  const RenderedImage samples = render_image({{cube(), ""}}, options);
  for (int y = 0; y < smooth.height; ++y) {
    for (int x = 0; x < smooth.width; ++x) {
      int sum = 2;  // rounds
      for (const int dy : {0, 1}) {
        for (const int dx : {0, 1}) sum += pixel(samples, 2 * x + dx, 2 * y + dy).green;
      }
      ASSERT_EQ(pixel(smooth, x, y).green, sum / 4) << x << ", " << y;
    }
  }
}

TEST(Samples, MagnifiedPixelsAreSquares) {
  VOXCARVE_REQUIRE_RENDERING();
  const RenderedImage small = render_image({{cube(), ""}}, test::small_panels());
  RenderOptions options = test::small_panels();
  options.panel_width *= 3;
  options.panel_height *= 3;
  options.magnification = 3;
  const RenderedImage large = render_image({{cube(), ""}}, options);
  ASSERT_EQ(large.width, 600);
  ASSERT_EQ(large.height, 480);
  for (int y = 0; y < large.height; ++y) {
    for (int x = 0; x < large.width; ++x)
      ASSERT_EQ(pixel(large, x, y).red, pixel(small, x / 3, y / 3).red) << x << ", " << y;
  }
  options.magnification = 17;
  EXPECT_THROW(render_image({{cube(), ""}}, options), ParameterError);
}

TEST(Samples, TheCameraHoldsWhatIsFramed) {
  VOXCARVE_REQUIRE_RENDERING();
  // Twice the cube is framed: half its height, 2, takes 0.92 tan 12 of the distance from its front at z = 2, so the
  // camera is 2 / 0.19556 before that. The cube's own front lies one further: 1 / 11.227 / tan 12 x 80 pixels, twice.
  RenderOptions options = front_view();
  options.framed = moved(cube(), 2, Point::Zero()).positions;
  const test::Extent shape = test::drawn(render_image({{cube(), ""}}, options));
  EXPECT_NEAR(shape.bottom - shape.top + 1, 67.05, 1.01);
  EXPECT_NEAR(shape.right - shape.left + 1, 67.05, 1.01);
}

}  // namespace
}  // namespace voxcarve
