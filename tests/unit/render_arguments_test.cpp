// The arguments of a picture are checked by every build, before any context is asked for.
#include <gtest/gtest.h>

#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include "common/run/errors.h"
#include "experiments/render/layout.h"
#include "experiments/render/render.h"

namespace voxcarve {
namespace {

TriangleSoup triangle() {
  TriangleSoup soup;
  soup.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  soup.triangles = {{0, 1, 2}};
  return soup;
}

TEST(RenderArguments, RefusesNothingAndAbsurdSizes) {
  EXPECT_THROW(render_image({}, {}), ParameterError);
  const std::vector<RenderItem> items = {{triangle(), ""}};
  for (const int size : {-1, 0, kMinPanelSize - 1, kMaxPanelSize + 1, 100000, std::numeric_limits<int>::max()}) {
    RenderOptions wide;
    wide.panel_width = size;
    EXPECT_THROW(render_image(items, wide), ParameterError) << size;
    RenderOptions high;
    high.panel_height = size;
    EXPECT_THROW(render_image(items, high), ParameterError) << size;
  }
}

TEST(RenderArguments, RefusesAPictureOfTooManyPixels) {
  RenderOptions options;
  options.panel_width = options.panel_height = kMaxPanelSize;
  // 2^28 pixels are 16 panels of 2^24: 16 pass, 17 in 5 columns make a grid of 20.
  const TriangleSoup none;
  EXPECT_NO_THROW(check_render_arguments(std::vector<RenderItem>(16, {none, ""}), options));
  EXPECT_THROW(check_render_arguments(std::vector<RenderItem>(17, {none, ""}), options), ParameterError);
}

TEST(RenderArguments, RefusesOptionsOutOfRange) {
  const std::vector<RenderItem> items = {{triangle(), ""}};
  const auto refused = [&](auto change) {
    RenderOptions options;
    change(options);
    EXPECT_THROW(render_image(items, options), ParameterError);
  };
  refused([](RenderOptions& o) { o.columns = -1; });
  refused([](RenderOptions& o) { o.crease_angle = -1; });
  refused([](RenderOptions& o) { o.crease_angle = 181; });
  refused([](RenderOptions& o) { o.azimuth = std::numeric_limits<double>::quiet_NaN(); });
  refused([](RenderOptions& o) { o.elevation = 91; });
  refused([](RenderOptions& o) { o.up_axis = "x"; });
}

TEST(RenderArguments, RefusesAShapeThatMakesNoSense) {
  TriangleSoup bad = triangle();
  bad.triangles[0][1] = 3;  // there are vertices 0 to 2
  EXPECT_THROW(render_image({{triangle(), ""}, {bad, ""}}, {}), InputError);
}

TEST(RenderArguments, RefusesVolumesThatMakeNoSense) {
  const GridFrame frame{{2, 2, 2}, Point::Zero(), 1};
  EXPECT_THROW(render_image({{BinaryVolume{}, ""}}, {}), InputError);
  EXPECT_THROW(render_image({{ScalarVolume{}, ""}}, {}), InputError);
  BinaryVolume unfilled(frame);
  unfilled.values.pop_back();
  EXPECT_THROW(render_image({{unfilled, ""}}, {}), InputError);
  ScalarVolume infinite{Grid<float>(frame), 0.5F};
  EXPECT_NO_THROW(check_render_arguments({{infinite, ""}}, {}));
  infinite.grid.values[3] = std::numeric_limits<float>::infinity();
  EXPECT_THROW(render_image({{infinite, ""}}, {}), InputError);
}

TEST(PanelGrid, ChoosesColumnsAndRows) {
  const auto shape = [](std::size_t items, int columns) {
    const PanelGrid grid = PanelGrid::of(items, columns);
    return std::pair(grid.columns, grid.rows);
  };
  EXPECT_EQ(shape(1, 0), std::pair(1, 1));
  EXPECT_EQ(shape(4, 0), std::pair(4, 1));
  EXPECT_EQ(shape(5, 0), std::pair(3, 2));  // ceil(sqrt(5)) = 3
  EXPECT_EQ(shape(10, 0), std::pair(4, 3));
  EXPECT_EQ(shape(5, 2), std::pair(2, 3));
  EXPECT_EQ(shape(2, 7), std::pair(2, 1));  // no empty columns
}

}  // namespace
}  // namespace voxcarve
