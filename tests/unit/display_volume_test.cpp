#include "experiments/render/display_volume.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "tests/support/shapes.h"

namespace voxcarve {
namespace {

using test::frame_of;

/// Sample (i, j, k) of a display volume.
int sample(const DisplayVolume& volume, std::int64_t i, std::int64_t j, std::int64_t k) {
  return volume.samples[static_cast<std::size_t>((k * volume.dims[1] + j) * volume.dims[0] + i)];
}

TEST(DisplayVolume, IsCroppedWithAMarginOfTwo) {
  BinaryVolume volume(frame_of({20, 20, 20}, Point(1, 2, 3), 0.5));
  volume(5, 6, 7) = volume(7, 6, 7) = 1;
  const DisplayVolume display = make_display_volume(volume, UnitFrame{Point(1, 2, 3), 2});
  EXPECT_EQ(display.dims, Index3(3 + 4, 1 + 4, 1 + 4));
  // Voxel (3, 4, 5) has its centre at 0.5 (3.5, 4.5, 5.5) from the corner, which half_extent 2 halves.
  EXPECT_EQ(display.first_sample, Eigen::Vector3d(0.875, 1.125, 1.375));
  EXPECT_EQ(display.spacing, 0.25);
  ASSERT_EQ(display.samples.size(), 7U * 5U * 5U);
  EXPECT_EQ(sample(display, 2, 2, 2), 32767);
  EXPECT_EQ(sample(display, 3, 2, 2), 0);
  EXPECT_EQ(sample(display, 4, 2, 2), 32767);
  EXPECT_EQ(std::ranges::count(display.samples, 32767), 2);
  EXPECT_EQ(std::ranges::count(display.samples, 0), 7 * 5 * 5 - 2);
  EXPECT_EQ(display.iso_value, 32767 / 2.0);
}

TEST(DisplayVolume, MirrorsTheBorderAboutTheIsoValue) {
  // One voxel of value 5 over an iso-value of 2: beyond the grid -1, so that the surface lies midway.
  ScalarVolume volume{Grid<float>(frame_of({3, 1, 1})), 2};
  volume.grid.values = {0, 5, 1};
  const DisplayVolume display = make_display_volume(volume, UnitFrame{});
  ASSERT_EQ(display.dims, Index3(5, 5, 5));
  // The range from -1 to 5 becomes 0 to 32767: 2 is its middle, 0 a sixth, 1 a third.
  EXPECT_EQ(display.iso_value, 32767 / 2.0);
  EXPECT_EQ(sample(display, 2, 2, 2), 32767);
  EXPECT_EQ(sample(display, 2, 1, 2), 0);
  EXPECT_EQ(sample(display, 2, 2, 3), 0);
  EXPECT_EQ(sample(display, 1, 2, 2), 5461);  // inside the grid, as it is
  EXPECT_EQ(sample(display, 3, 2, 2), 10922);
  EXPECT_EQ(sample(display, 4, 2, 2), 10922);  // beyond: what is below the iso-value stays
  EXPECT_EQ(sample(display, 1, 0, 2), 5461);
}

TEST(DisplayVolume, IsEmptyWithoutAnInterior) {
  EXPECT_TRUE(make_display_volume(BinaryVolume(frame_of({3, 3, 3})), UnitFrame{}).samples.empty());
  EXPECT_TRUE(interior_hull(BinaryVolume(frame_of({3, 3, 3}))).empty());
  // All at the iso-value: interior, with a border below it.
  const ScalarVolume flat{Grid<float>(frame_of({2, 2, 2}), 7), 7};
  const DisplayVolume display = make_display_volume(flat, UnitFrame{});
  ASSERT_EQ(display.dims, Index3(6, 6, 6));
  EXPECT_GE(sample(display, 2, 2, 2), display.iso_value);
  EXPECT_LT(sample(display, 1, 2, 2), display.iso_value);
}

TEST(DisplayVolume, BecomesOpaqueWithinItsValues) {
  // Over an iso-value below the greatest value the rise begins there: a hundredth of the range from 0 to 2 is 327.67.
  ScalarVolume volume{Grid<float>(frame_of({3, 1, 1})), 1};
  volume.grid.values = {0, 2, 1};
  const DisplayVolume below = make_display_volume(volume, UnitFrame{});
  EXPECT_NEAR(below.band, 327.67, 1e-9);
  EXPECT_NEAR(below.opaque - below.band, below.iso_value, 1e-9);
  // At the greatest value, or within a band of it, the rise ends there: the interior is opaque, and what lies below,
  // mirrored or not, is clear.
  for (const float iso_value : {2.0F, 1.995F}) {
    volume.iso_value = iso_value;
    const DisplayVolume display = make_display_volume(volume, UnitFrame{});
    EXPECT_NEAR(display.band, 327.67, 1) << iso_value;
    EXPECT_NEAR(display.opaque, sample(display, 2, 2, 2), 0.5) << iso_value;
    const double clear = display.opaque - display.band;
    EXPECT_LT(clear, display.iso_value) << iso_value;
    EXPECT_LT(sample(display, 3, 2, 2), clear) << iso_value;
    EXPECT_LE(sample(display, 2, 1, 2), clear + 0.5) << iso_value;
  }
  const DisplayVolume flat = make_display_volume(ScalarVolume{Grid<float>(frame_of({2, 2, 2}), 7), 7}, UnitFrame{});
  EXPECT_GT(flat.band, 0);
  EXPECT_NEAR(flat.opaque, sample(flat, 2, 2, 2), 0.5);
}

TEST(InteriorHull, HoldsTheInteriorVoxelsAndNoMore) {
  const BinaryVolume volume = test::random_volume({9, 8, 7}, 0.02, 5);
  ASSERT_GT(count_interior(volume), 3);
  const std::vector<Point> hull = interior_hull(volume);
  // In any direction the farthest corner of all interior voxels is among the points, and none lies beyond it.
  for (const Point& direction :
       {Point(1, 0, 0), Point(0, -1, 0), Point(0.3, -0.8, 0.5), Point(-1, 1, 1), Point(-2, 0.1, -3)}) {
    double farthest = -1e9;
    for (std::int64_t k = 0; k < 7; ++k) {
      for (std::int64_t j = 0; j < 8; ++j) {
        for (std::int64_t i = 0; i < 9; ++i) {
          if (volume(i, j, k) == 0) continue;
          for (int corner = 0; corner < 8; ++corner) {
            const Index3 at(i + corner % 2, j + corner / 2 % 2, k + corner / 4);
            farthest = std::max(farthest, direction.dot(at.cast<double>()));
          }
        }
      }
    }
    double reached = -1e9;
    for (const Point& point : hull) reached = std::max(reached, direction.dot(point));
    EXPECT_DOUBLE_EQ(reached, farthest);
  }
}

}  // namespace
}  // namespace voxcarve
