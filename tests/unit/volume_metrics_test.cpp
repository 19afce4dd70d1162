#include "metrics/volume.h"

#include <gtest/gtest.h>

#include "experiments/render/irregularity.h"
#include "tests/support/shapes.h"

namespace voxcarve {
namespace {

using test::frame_of;
using test::random_volume;

/// A 3 x 3 ring in a 5 x 5 image.
BinaryVolume ring() {
  BinaryVolume image(frame_of({5, 5, 1}));
  for (std::int64_t j = 1; j < 4; ++j)
    for (std::int64_t i = 1; i < 4; ++i) image(i, j, 0) = static_cast<std::uint8_t>(i != 2 || j != 2);
  return image;
}

MetricOptions with_radius(double radius) {
  MetricOptions options;
  options.regularity_radius = radius;
  return options;
}

TEST(VolumeMetrics, CountsIrregularVoxels) {
  RunContext context;
  // For a radius of 1 the ball is a plus of five pixels. None fits into the ring, so all of its 8 pixels are
  // inner-irregular; none fits into its hole, which is outer-irregular. Outside a plus reaches every pixel.
  const auto measured = measure_volume(ring(), with_radius(1), context);
  EXPECT_EQ(std::get<std::int64_t>(value_of(measured, "voxels.inner_irregular")), 8);
  EXPECT_EQ(std::get<std::int64_t>(value_of(measured, "voxels.outer_irregular")), 1);
  // A ball of radius 0 is a voxel and fits everywhere.
  const auto regular = measure_volume(ring(), with_radius(0), context);
  EXPECT_EQ(std::get<std::int64_t>(value_of(regular, "voxels.inner_irregular")), 0);
  EXPECT_EQ(std::get<std::int64_t>(value_of(regular, "voxels.outer_irregular")), 0);
}

TEST(VolumeMetrics, SaysWhyThereIsNoIrregularity) {
  RunContext context;
  const auto measured = measure_volume(ring(), {}, context);
  EXPECT_EQ(std::get<Undefined>(value_of(measured, "voxels.inner_irregular")).reason, "no regularity radius was given");
}

TEST(VolumeMetrics, HaveAColumnEach) {
  RunContext context;
  const auto single = measure_volume(ring(), with_radius(1), context);
  ASSERT_EQ(single.size(), volume_columns().size());
  for (std::size_t c = 0; c < single.size(); ++c) EXPECT_EQ(single[c].key, volume_columns()[c].key);
  const auto pair = measure_volume_pair(ring(), ring(), context);
  ASSERT_EQ(pair.size(), volume_pair_columns().size());
  for (std::size_t c = 0; c < pair.size(); ++c) EXPECT_EQ(pair[c].key, volume_pair_columns()[c].key);
}

TEST(VolumeMetrics, CountsChangesOverBothGrids) {
  RunContext context;
  context.threads = 2;
  // b's grid lies 2 voxels further along x, 1 back along y and 3 up along z, and is larger: a slow twin on a grid that
  // holds both.
  const BinaryVolume a = random_volume({9, 8, 7}, 0.4, 1);
  BinaryVolume b = random_volume({12, 5, 11}, 0.6, 2);
  b.frame.origin = Point(2, -1, 3);
  const GridFrame both = frame_of({14, 9, 14}, Point(0, -1, 0));
  const BinaryVolume wide_a = resized(a, both);
  const BinaryVolume wide_b = resized(b, both);
  std::int64_t a_minus_b = 0;
  std::int64_t b_minus_a = 0;
  for (std::size_t at = 0; at < wide_a.values.size(); ++at) {
    a_minus_b += wide_a.values[at] > wide_b.values[at] ? 1 : 0;
    b_minus_a += wide_a.values[at] < wide_b.values[at] ? 1 : 0;
  }
  const auto pair = measure_volume_pair(a, b, context);
  EXPECT_EQ(std::get<std::int64_t>(value_of(pair, "voxels.a_minus_b")), a_minus_b);
  EXPECT_EQ(std::get<std::int64_t>(value_of(pair, "voxels.b_minus_a")), b_minus_a);
  EXPECT_EQ(std::get<std::int64_t>(value_of(pair, "voxels.changed")), a_minus_b + b_minus_a);
}

TEST(VolumeMetrics, GridsApartHaveNothingInCommon) {
  RunContext context;
  BinaryVolume far = ring();
  far.frame.origin[0] = 100;
  const auto pair = measure_volume_pair(ring(), far, context);
  EXPECT_EQ(std::get<std::int64_t>(value_of(pair, "voxels.changed")), 16);
}

TEST(VolumeMetrics, NeedALatticeInCommon) {
  RunContext context;
  BinaryVolume shifted = ring();
  shifted.frame.origin[0] = 0.5;
  EXPECT_TRUE(
      std::holds_alternative<Undefined>(value_of(measure_volume_pair(ring(), shifted, context), "voxels.changed")));
  BinaryVolume coarser = ring();
  coarser.frame.voxel_size = 2;
  EXPECT_TRUE(
      std::holds_alternative<Undefined>(value_of(measure_volume_pair(ring(), coarser, context), "voxels.changed")));
}

TEST(Irregularity, HasTheColoursOfThePaper) {
  // A square of 11 x 11 pixels with a spur of one pixel's width and a slit of one pixel's width. For a radius of 2 the
  // spur is inner-irregular, the slit outer-irregular, the middle of the square core, and the image's corner anticore.
  BinaryVolume image(frame_of({20, 20, 1}));
  for (std::int64_t j = 4; j < 15; ++j)
    for (std::int64_t i = 4; i < 15; ++i) image(i, j, 0) = 1;
  for (std::int64_t i = 15; i < 19; ++i) image(i, 6, 0) = 1;
  for (std::int64_t j = 11; j < 15; ++j) image(9, j, 0) = 0;
  RunContext context;
  const SlicePicture picture = irregularity_slice(image, 2, 0, 2, context);
  const auto color = [&](std::int64_t i, std::int64_t j) {
    return picture.colors[static_cast<std::size_t>(j * picture.width + i)];
  };
  const Rgb8 red = color(17, 6);
  const Rgb8 green = color(9, 13);
  EXPECT_GT(red[0], 2 * red[1]);
  EXPECT_GT(green[1], 2 * green[0]);
  EXPECT_EQ(color(8, 8), (Rgb8{0, 0, 0}));
  EXPECT_EQ(color(0, 0), (Rgb8{255, 255, 255}));
}

}  // namespace
}  // namespace voxcarve
