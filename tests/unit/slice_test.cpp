// Slices need no graphics library: everything here runs in every build, pixel by pixel.
#include "experiments/render/slice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stop_token>
#include <string>
#include <vector>

#include "common/run/errors.h"
#include "experiments/render/layout.h"
#include "experiments/render/render.h"
#include "tests/support/shapes.h"

namespace voxcarve {
namespace {

using test::frame_of;

constexpr Rgb8 kWhite = {255, 255, 255};
constexpr Rgb8 kBlack = {0, 0, 0};
constexpr Rgb8 kRed = {255, 0, 0};
constexpr Rgb8 kGreen = {0, 255, 0};
constexpr Rgb8 kBlue = {0, 0, 255};

/// 2 x 3 x 4 voxels with the value i + 10 j + 100 k.
Grid<float> numbered() {
  Grid<float> grid(frame_of({2, 3, 4}, Point(1, 2, 3), 0.5));
  for (std::int64_t k = 0; k < 4; ++k) {
    for (std::int64_t j = 0; j < 3; ++j) {
      for (std::int64_t i = 0; i < 2; ++i) grid(i, j, k) = static_cast<float>(i + 10 * j + 100 * k);
    }
  }
  return grid;
}

SlicePicture picture_of(std::int64_t width, std::int64_t height, std::vector<Rgb8> colors,
                        const Eigen::Vector2d& lower = {0, 0}, double voxel_size = 1) {
  SlicePicture picture;
  picture.width = width;
  picture.height = height;
  picture.colors = std::move(colors);
  picture.lower = lower;
  picture.voxel_size = voxel_size;
  return picture;
}

/// A scene as characters, rows from the top: '.' white, 'r', 'g', 'b', '#' black, 'o' mid-grey, '?' anything else.
std::vector<std::string> text_of(const std::vector<unsigned char>& rgb, int width) {
  std::vector<std::string> rows;
  for (std::size_t i = 0; i < rgb.size(); i += 3) {
    if (i % (3 * static_cast<std::size_t>(width)) == 0) rows.emplace_back();
    const Rgb8 color = {rgb[i], rgb[i + 1], rgb[i + 2]};
    rows.back() += color == kWhite                ? '.'
                   : color == kBlack              ? '#'
                   : color == kRed                ? 'r'
                   : color == kGreen              ? 'g'
                   : color == kBlue               ? 'b'
                   : color == Rgb8{128, 128, 128} ? 'o'
                                                  : '?';
  }
  return rows;
}

std::vector<std::string> painted(const std::vector<const SlicePicture*>& all, bool common, int width, int height,
                                 const SlicePicture& one) {
  return text_of(SlicePainter(all, common, width, height).paint(one), width);
}

TEST(SlicePosition, ReadsAxesIndicesAndShares) {
  EXPECT_EQ(parse_slice("x").axis, 0);
  EXPECT_EQ(parse_slice("y=7").axis, 1);
  EXPECT_EQ(parse_slice("y=7").index, 7);
  EXPECT_EQ(parse_slice("z").index, std::nullopt);
  EXPECT_EQ(parse_slice("z").share, 0.5);
  EXPECT_EQ(parse_slice("z=25%").share, 0.25);
  EXPECT_EQ(parse_slice("z=12.5%").share, 0.125);
  EXPECT_EQ(parse_slice("z=-1").index, -1);  // refused once the volume is known
  for (const char* text : {"", "w", "Z", "z=", "z=%", "zz", "z 3", "z=3.5", "z=3x", "z=101%", "z=-1%", "z=nan%",
                           "z=99999999999999999999", "=3", "z=3%%"})
    EXPECT_THROW(parse_slice(text), ParameterError) << text;
}

TEST(SlicePosition, FindsTheIndex) {
  const GridFrame frame = frame_of({4, 5, 1});
  const auto index = [&](const char* text) { return slice_index(parse_slice(text), frame, "volume"); };
  EXPECT_EQ(index("x"), 2);  // floor(4 / 2): the upper one of the two in the middle
  EXPECT_EQ(index("y"), 2);  // floor(5 / 2): the middle
  EXPECT_EQ(index("z"), 0);  // the only one
  EXPECT_EQ(index("x=0%"), 0);
  EXPECT_EQ(index("x=24%"), 0);
  EXPECT_EQ(index("x=25%"), 1);
  EXPECT_EQ(index("x=100%"), 3);
  EXPECT_EQ(index("y=4"), 4);
  for (const char* text : {"x=4", "x=-1", "z=1"}) EXPECT_THROW(index(text), ParameterError) << text;
}

TEST(SlicePosition, FindsThePlaneOfAnotherVolume) {
  // Along z 3 voxels of half a unit from 2 to 3.5.
  const GridFrame frame = frame_of({1, 1, 3}, Point(0, 0, 2), 0.5);
  EXPECT_EQ(slice_at(2, 2.25, frame, "volume"), 0);
  EXPECT_EQ(slice_at(2, 2.5, frame, "volume"), 1);
  EXPECT_EQ(slice_at(2, 3.4, frame, "volume"), 2);
  EXPECT_THROW(slice_at(2, 1.9, frame, "volume"), ParameterError);
  EXPECT_THROW(slice_at(2, 3.5, frame, "volume"), ParameterError);
}

TEST(SliceField, RunsRightAndUpAlongTheOtherAxes) {
  const Grid<float> grid = numbered();
  const SliceField z = extract_slice(grid, 2, 3);
  EXPECT_EQ(z.values, (std::vector<float>{300, 301, 310, 311, 320, 321}));  // x to the right, y up
  EXPECT_EQ(z.width, 2);
  EXPECT_EQ(z.height, 3);
  EXPECT_EQ(z.lower, Eigen::Vector2d(1, 2));
  EXPECT_EQ(z.voxel_size, 0.5);
  const SliceField y = extract_slice(grid, 1, 2);
  EXPECT_EQ(y.values, (std::vector<float>{20, 21, 120, 121, 220, 221, 320, 321}));  // x to the right, z up
  EXPECT_EQ(y.lower, Eigen::Vector2d(1, 3));
  const SliceField x = extract_slice(grid, 0, 1);
  EXPECT_EQ(x.values, (std::vector<float>{1, 11, 21, 101, 111, 121, 201, 211, 221, 301, 311, 321}));  // y, z up
  EXPECT_EQ(x.width, 3);
  EXPECT_EQ(x.height, 4);
  EXPECT_EQ(x.lower, Eigen::Vector2d(2, 3));
}

TEST(SliceColors, GreyFillsTheWindow) {
  EXPECT_EQ(grey_color(-100, 0, 200), kBlack);
  EXPECT_EQ(grey_color(0, 0, 200), kBlack);
  EXPECT_EQ(grey_color(100, 0, 200), (Rgb8{128, 128, 128}));  // 127.5, rounded up
  EXPECT_EQ(grey_color(40, 0, 200), (Rgb8{51, 51, 51}));      // a fifth of 255
  EXPECT_EQ(grey_color(200, 0, 200), kWhite);
  EXPECT_EQ(grey_color(1e30, 0, 200), kWhite);
  EXPECT_EQ(grey_color(5, 5, 5), kBlack);  // a volume of one value
  EXPECT_EQ(grey_color(6, 5, 5), kWhite);
}

TEST(SliceColors, CyclicRunsFromBlueToRedAndStartsAgain) {
  // Quarters of a period are the corners of the hue circle: blue, cyan, green, yellow; red is the end.
  EXPECT_EQ(cyclic_color(0, 16), kBlue);
  EXPECT_EQ(cyclic_color(4, 16), (Rgb8{0, 255, 255}));
  EXPECT_EQ(cyclic_color(8, 16), kGreen);
  EXPECT_EQ(cyclic_color(12, 16), (Rgb8{255, 255, 0}));
  const Rgb8 end = cyclic_color(15.99, 16);
  EXPECT_EQ(end[0], 255);
  EXPECT_LT(end[1], 2);
  EXPECT_EQ(end[2], 0);
  EXPECT_EQ(cyclic_color(16, 16), kBlue);
  for (double value = -20; value <= 40; value += 0.25) {
    EXPECT_EQ(cyclic_color(value, 16), cyclic_color(value + 16, 16)) << value;
    EXPECT_NE(cyclic_color(value, 16), cyclic_color(value + 8, 16)) << value;
  }
}

TEST(SliceColors, MarksTheInteriorOfADistanceMap) {
  SliceField field;
  field.width = 3;
  field.height = 1;
  field.values = {0, 8, 16};
  SliceColors colors;
  colors.map = ColorMap::kCyclic;
  EXPECT_EQ(color_slice(field, colors).colors, (std::vector<Rgb8>{kBlue, kGreen, kBlue}));
  colors.mark_zero = true;
  const std::vector<Rgb8> marked = color_slice(field, colors).colors;
  EXPECT_EQ(marked[0], (Rgb8{48, 48, 48}));
  EXPECT_EQ(marked[1], kGreen);
  EXPECT_EQ(marked[2], kBlue);
}

TEST(SlicePainter, EnlargesByAWholeNumberAndCentres) {
  // Margin 1: 12 x 8 pixels for 2 x 2 voxels, which become 4 x 4 pixels each; 3 columns are left on both sides, and a
  // row above and below; the grey line goes there. The first row of colours is the lowest.
  const SlicePicture slice = picture_of(2, 2, {kRed, kGreen, kBlue, kBlack});
  const std::vector<std::string> expected = {"..oooooooooo..", "..obbbb####o..", "..obbbb####o..", "..obbbb####o..",
                                             "..obbbb####o..", "..orrrrggggo..", "..orrrrggggo..", "..orrrrggggo..",
                                             "..orrrrggggo..", "..oooooooooo.."};
  EXPECT_EQ(painted({&slice}, true, 14, 10, slice), expected);
  EXPECT_EQ(painted({&slice}, false, 14, 10, slice), expected);
  // Neither the place nor the size of voxels matters for one slice.
  const SlicePicture far = picture_of(2, 2, slice.colors, {-1e6, 3e5}, 1.0 / 3);
  EXPECT_EQ(painted({&far}, true, 14, 10, far), expected);
}

TEST(SlicePainter, KeepsCommonScaleAndPlaces) {
  // Three by two voxels fill 6 x 4 of 8 x 6 pixels. The other slice is the voxel on the right in the upper row.
  const SlicePicture large = picture_of(3, 2, std::vector<Rgb8>(6, kRed), {5, 7});
  const SlicePicture small = picture_of(1, 1, {kBlue}, {7, 8});
  EXPECT_EQ(painted({&large, &small}, true, 8, 6, large),
            (std::vector<std::string>{"oooooooo", "orrrrrro", "orrrrrro", "orrrrrro", "orrrrrro", "oooooooo"}));
  EXPECT_EQ(painted({&large, &small}, true, 8, 6, small),
            (std::vector<std::string>{"....oooo", "....obbo", "....obbo", "....oooo", "........", "........"}));
  // By itself it fills what it can: 4 x 4 pixels.
  EXPECT_EQ(painted({&large, &small}, false, 8, 6, small),
            (std::vector<std::string>{".oooooo.", ".obbbbo.", ".obbbbo.", ".obbbbo.", ".obbbbo.", ".oooooo."}));
  // Voxels of twice the size take twice the pixels.
  const SlicePicture coarse = picture_of(1, 1, {kGreen}, {5, 7}, 2);
  EXPECT_EQ(painted({&large, &coarse}, true, 8, 6, coarse),
            (std::vector<std::string>{"oooooo..", "oggggo..", "oggggo..", "oggggo..", "oggggo..", "oooooo.."}));
}

TEST(SlicePainter, AveragesVoxelsSmallerThanAPixel) {
  // 8 x 4 voxels in 6 x 4 pixels with a margin of 1: pixels of 2 x 2 voxels. Two black voxels of four make 127.5.
  std::vector<Rgb8> colors(32, kRed);
  for (std::size_t i = 0; i < 4; ++i) colors[i] = i % 2 == 0 ? kBlack : kWhite;
  for (std::size_t i = 8; i < 12; ++i) colors[i] = i % 2 == 0 ? kBlack : kWhite;
  const SlicePicture slice = picture_of(8, 4, colors);
  EXPECT_EQ(painted({&slice}, true, 6, 4, slice), (std::vector<std::string>{"oooooo", "orrrro", "ooorro", "oooooo"}));
}

TEST(SlicePainter, DrawsSlicesHoweverFarApart) {
  // Two voxels, 10^7 and more of them apart, at the ends of 18 pixels: each becomes a point, and its frame covers it.
  const SlicePicture here = picture_of(1, 1, {kRed});
  for (const double distance : {1e7, 1e12, 1e300}) {
    const SlicePicture there = picture_of(1, 1, {kRed}, {distance, 0});
    for (const SlicePicture* slice : {&here, &there}) {
      const std::vector<std::string> rows = painted({&here, &there}, true, 20, 6, *slice);
      for (const std::string& row : rows) {
        const std::size_t at = row.find_first_not_of('.');
        EXPECT_TRUE(at == std::string::npos || (at < 10) == (slice == &here)) << distance << ' ' << row;
      }
      EXPECT_TRUE(std::ranges::any_of(rows, [](const std::string& row) { return row.find('o') != std::string::npos; }))
          << distance;
    }
  }
  // Differences that no double holds.
  const SlicePicture left = picture_of(1, 1, {kRed}, {-1.5e308, 0});
  const SlicePicture right = picture_of(1, 1, {kRed}, {1.5e308, 0});
  EXPECT_THROW(SlicePainter({&left, &right}, true, 20, 6), ParameterError);
}

TEST(SlicePainter, AveragesPointsWhereVoxelsAreManyAPixel) {
  // 1300 x 1300 voxels in 10 x 10 pixels, 130 a side, of which 64 are asked, every 2.03125 voxels. In stripes of two
  // points alternate between white and black, and drift through one stripe in all: half of them are white, 127.5.
  std::vector<Rgb8> colors(1300 * 1300);
  for (std::size_t i = 0; i < colors.size(); ++i) colors[i] = i % 1300 / 2 % 2 == 0 ? kWhite : kBlack;
  const SlicePicture slice = picture_of(1300, 1300, colors);
  EXPECT_EQ(painted({&slice}, true, 12, 12, slice), std::vector<std::string>(12, std::string(12, 'o')));
}

TEST(SlicePainter, ObeysAStopRequest) {
  SlicePicture slice = picture_of(2, 2, {kRed, kGreen, kBlue, kBlack});
  const SlicePainter painter({&slice}, true, 14, 10);
  std::stop_source stop;
  EXPECT_EQ(painter.paint(slice, stop.get_token()), painter.paint(slice));
  stop.request_stop();
  EXPECT_THROW(painter.paint(slice, stop.get_token()), Cancelled);
}

TEST(SlicePainter, DrawsTheLineOfTheIsoValue) {
  // Values 1 1 0 0 in 3-pixel voxels: the line lies midway between the second and the third voxel, and runs in the
  // last interior pixels; the grid's border closes it.
  SliceField field;
  field.width = 4;
  field.height = 1;
  field.values = {1, 1, 0, 0};
  SlicePicture slice = picture_of(4, 1, std::vector<Rgb8>(4, kGreen));
  add_contour(slice, field, 0.5);
  EXPECT_EQ(painted({&slice}, true, 14, 5, slice),
            (std::vector<std::string>{"oooooooooooooo", "o######ggggggo", "o#gggg#ggggggo", "o######ggggggo",
                                      "oooooooooooooo"}));
  // An iso-value of a sixth puts it five sixths of a voxel beyond the second centre: 3 (1.5 + 5/6) = 7 pixels.
  add_contour(slice, field, 1.0 / 6 - 1e-6);
  EXPECT_EQ(painted({&slice}, true, 14, 5, slice)[2], "o#ggggg#gggggo");
  add_contour(slice, field, 2);  // nowhere reached
  EXPECT_EQ(painted({&slice}, true, 14, 5, slice)[2], "oggggggggggggo");
}

TEST(DistanceSlice, AgreesWithAllPairs) {
  const BinaryVolume volume = test::random_volume({7, 6, 5}, 0.03, 3);
  ASSERT_GT(count_interior(volume), 0);
  RunContext context;
  for (int axis = 0; axis < 3; ++axis) {
    const SliceField slice = distance_slice(volume, axis, 1, "volume", context);
    for (std::int64_t row = 0; row < slice.height; ++row) {
      for (std::int64_t column = 0; column < slice.width; ++column) {
        const Index3 here = axis == 0   ? Index3(1, column, row)
                            : axis == 1 ? Index3(column, 1, row)
                                        : Index3(column, row, 1);
        std::int64_t nearest = std::numeric_limits<std::int64_t>::max();
        for (std::int64_t k = 0; k < 5; ++k) {
          for (std::int64_t j = 0; j < 6; ++j) {
            for (std::int64_t i = 0; i < 7; ++i) {
              if (volume(i, j, k) != 0) nearest = std::min(nearest, (here - Index3(i, j, k)).squaredNorm());
            }
          }
        }
        EXPECT_EQ(slice(column, row), std::sqrt(static_cast<float>(nearest)));
      }
    }
  }
}

TEST(DistanceSlice, NeedsAnInterior) {
  RunContext context;
  EXPECT_THROW(distance_slice(BinaryVolume(frame_of({3, 3, 3})), 2, 1, "volume", context), InputError);
}

/// Rows of a picture's part as text, from column `left` on.
std::vector<std::string> part(const RenderedImage& image, int left, int width) {
  std::vector<std::string> rows;
  for (const std::string& row : text_of(image.rgb, image.width))
    rows.push_back(row.substr(static_cast<std::size_t>(left), static_cast<std::size_t>(width)));
  return rows;
}

TEST(SlicePictures, AreLaidOutInPanelsInEveryBuild) {
  RenderOptions options;
  options.panel_width = 20;
  options.panel_height = 16;
  const SlicePicture a = picture_of(2, 2, {kRed, kGreen, kBlue, kBlack});
  const SlicePicture b = picture_of(1, 1, {kGreen}, {1, 1});
  const RenderedImage image = render_image({{a, ""}, {b, ""}}, options);
  ASSERT_EQ(image.width, 40);
  ASSERT_EQ(image.height, 16);
  // Without captions a scene is the panel. The line between panels takes the first column of the second.
  const SlicePainter painter({&a, &b}, true, 20, 16);
  EXPECT_EQ(part(image, 0, 20), text_of(painter.paint(a), 20));
  std::vector<std::string> second = text_of(painter.paint(b), 20);
  for (std::string& row : second) row[0] = '?';
  EXPECT_EQ(part(image, 20, 20), second);
  options.columns = 1;
  const RenderedImage column = render_image({{a, ""}, {b, ""}}, options);
  EXPECT_EQ(column.width, 20);
  EXPECT_EQ(column.height, 32);
  EXPECT_EQ(column, render_image({{a, ""}, {b, ""}}, options));
}

TEST(SlicePictures, KeepRoomForCaptions) {
  if (!captions_available()) GTEST_SKIP() << "this build cannot set captions";
  RenderOptions options;
  options.panel_width = options.panel_height = 100;
  const SlicePicture slice = picture_of(1, 1, {kGreen});
  const RenderedImage image = render_image({{slice, "caption"}}, options);
  const std::vector<std::string> rows = part(image, 0, 100);
  std::size_t last_green = 0;
  std::size_t first_ink = rows.size();
  for (std::size_t y = 0; y < rows.size(); ++y) {
    const bool green = rows[y].find('g') != std::string::npos;
    if (green) last_green = y;
    if (!green && rows[y].find_first_not_of(".o") != std::string::npos) first_ink = std::min(first_ink, y);
  }
  EXPECT_GT(last_green, 60U);  // captions take a third at most
  EXPECT_LT(last_green, first_ink);
  EXPECT_LT(first_ink, rows.size());
}

TEST(SlicePictures, RefuseWhatDoesNotFillASlice) {
  EXPECT_THROW(render_image({{SlicePicture{}, ""}}, {}), InputError);
  EXPECT_THROW(render_image({{picture_of(2, 2, {kRed}), ""}}, {}), InputError);
}

}  // namespace
}  // namespace voxcarve
