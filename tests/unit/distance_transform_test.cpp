#include "common/volume/distance_transform.h"

#include <gtest/gtest.h>

#include <limits>

#include "common/run/errors.h"
#include "common/volume/morphology.h"
#include "tests/support/shapes.h"

namespace voxcarve {
namespace {

using test::frame_of;
using test::random_volume;

/// The slow twin: every pair of voxels.
Grid<std::int32_t> brute_force_distance(const BinaryVolume& volume, std::uint8_t feature) {
  Grid<std::int32_t> result(volume.frame, kInfiniteDistance);
  std::vector<Index3> features;
  for (std::int64_t k = 0; k < volume.nz(); ++k)
    for (std::int64_t j = 0; j < volume.ny(); ++j)
      for (std::int64_t i = 0; i < volume.nx(); ++i)
        if (volume(i, j, k) == feature) features.emplace_back(i, j, k);
  for (std::int64_t k = 0; k < volume.nz(); ++k)
    for (std::int64_t j = 0; j < volume.ny(); ++j)
      for (std::int64_t i = 0; i < volume.nx(); ++i)
        for (const Index3& f : features) {
          result(i, j, k) = std::min(result(i, j, k), static_cast<std::int32_t>((f - Index3(i, j, k)).squaredNorm()));
        }
  return result;
}

TEST(SquaredDistance, AgreesWithBruteForceOnRandomVolumes) {
  RunContext context;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const Index3 dims(1 + static_cast<std::int64_t>(seed * 7 % 13), 1 + static_cast<std::int64_t>(seed * 5 % 11),
                      1 + static_cast<std::int64_t>(seed * 3 % 9));
    const double fill = seed % 3 == 0 ? 0.01 : seed % 3 == 1 ? 0.1 : 0.6;
    const BinaryVolume volume = random_volume(dims, fill, seed);
    for (const std::uint8_t feature : {std::uint8_t{0}, std::uint8_t{1}}) {
      ASSERT_EQ(squared_distance(volume, feature, context), brute_force_distance(volume, feature)) << "seed " << seed;
    }
  }
}

TEST(SquaredDistance, AgreesWithBruteForceNearAndFar) {
  // Minima up to 40 rows off are found by looking, farther ones by envelopes: sparse features in long columns, dense
  // ones, a distance of exactly 39 to 42, and widths that are no multiple of the 16 columns taken together.
  RunContext context;
  context.threads = 2;
  std::uint64_t seed = 500;
  for (const Index3& dims : {Index3(17, 130, 2), Index3(33, 3, 120), Index3(5, 100, 1), Index3(16, 60, 60)}) {
    for (const double fill : {0.0003, 0.002, 0.02}) {
      const BinaryVolume volume = random_volume(dims, fill, ++seed);
      ASSERT_EQ(squared_distance(volume, 1, context), brute_force_distance(volume, 1)) << dims.transpose();
    }
  }
  for (std::int64_t row = 38; row < 44; ++row) {
    BinaryVolume volume(frame_of({20, 50, 1}));
    for (std::int64_t i = 0; i < 20; ++i) volume(i, i % 3 == 0 ? 0 : row, 0) = 1;
    ASSERT_EQ(squared_distance(volume, 1, context), brute_force_distance(volume, 1)) << row;
  }
}

TEST(SquaredDistance, IsInfiniteWithoutAnyFeature) {
  RunContext context;
  const Grid<std::int32_t> distance = squared_distance(BinaryVolume(frame_of({3, 4, 5})), 1, context);
  for (const std::int32_t value : distance.values) EXPECT_EQ(value, kInfiniteDistance);
}

TEST(SquaredDistance, OfAnEmptyVolumeIsEmpty) {
  RunContext context;
  for (const Index3& dims : {Index3(0, 0, 0), Index3(0, 3, 2), Index3(3, 0, 2), Index3(3, 2, 0)}) {
    const BinaryVolume volume(frame_of(dims));
    EXPECT_TRUE(squared_distance(volume, 1, context).values.empty());
    EXPECT_TRUE(squared_distance_4sed(volume, 1, context).values.empty());
    EXPECT_TRUE(nearest_feature(volume, 1, context).values.empty());
  }
}

TEST(SquaredDistance, GivesTheSameOnOneThreadAndOnTwo) {
  const BinaryVolume volume = random_volume({40, 31, 23}, 0.02, 5);
  RunContext one;
  RunContext two;
  two.threads = 2;
  EXPECT_EQ(squared_distance(volume, 1, one), squared_distance(volume, 1, two));
}

TEST(SquaredDistance, IsExactOnLinesLongerThanABlockOfColumns) {
  // Sides around the number of columns that are processed together, and gaps between features of every length.
  RunContext context;
  context.threads = 2;
  for (const Index3& dims : {Index3(15, 40, 3), Index3(16, 3, 40), Index3(17, 33, 2), Index3(33, 2, 31)}) {
    const BinaryVolume volume = random_volume(dims, 0.3, static_cast<std::uint64_t>(dims[0]));
    EXPECT_EQ(squared_distance(volume, 1, context), brute_force_distance(volume, 1)) << dims.transpose();
  }
}

TEST(NearestFeature, IsAFeatureAtTheExactDistance) {
  RunContext context;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const Index3 dims(1 + static_cast<std::int64_t>(seed * 7 % 19), 1 + static_cast<std::int64_t>(seed * 5 % 11),
                      1 + static_cast<std::int64_t>(seed * 3 % 9));
    const double fill = seed % 3 == 0 ? 0.01 : seed % 3 == 1 ? 0.1 : 0.6;
    const BinaryVolume volume = random_volume(dims, fill, seed);
    const Grid<std::int32_t> distance = brute_force_distance(volume, 1);
    const Grid<std::uint32_t> nearest = nearest_feature(volume, 1, context);
    for (std::int64_t k = 0; k < dims[2]; ++k) {
      for (std::int64_t j = 0; j < dims[1]; ++j) {
        for (std::int64_t i = 0; i < dims[0]; ++i) {
          const std::uint32_t index = nearest(i, j, k);
          if (distance(i, j, k) == kInfiniteDistance) {
            ASSERT_EQ(index, kNoFeature);
            continue;
          }
          ASSERT_LT(index, volume.values.size());
          ASSERT_EQ(volume.values[index], 1);
          const Index3 found(index % dims[0], index / dims[0] % dims[1], index / (dims[0] * dims[1]));
          ASSERT_EQ((found - Index3(i, j, k)).squaredNorm(), distance(i, j, k)) << "seed " << seed;
        }
      }
    }
  }
}

TEST(NearestFeature, TakesTheSameOfEquallyNearOnesOnOneThreadAndOnTwo) {
  const BinaryVolume volume = random_volume({40, 31, 23}, 0.02, 5);
  RunContext one;
  RunContext two;
  two.threads = 2;
  EXPECT_EQ(nearest_feature(volume, 1, one), nearest_feature(volume, 1, two));
  // Of two at the ends of an odd line, the middle takes the first.
  BinaryVolume line(frame_of({1, 5, 1}));
  line(0, 0, 0) = line(0, 4, 0) = 1;
  EXPECT_EQ(nearest_feature(line, 1, one).values, (GridValues<std::uint32_t>{0, 0, 0, 4, 4}));
}

TEST(SquaredDistance, DeclaresItsMemoryBeforeItAllocates) {
  RunContext context;
  context.memory_budget = 1000;
  const BinaryVolume volume(frame_of({10, 10, 10}));
  EXPECT_THROW(squared_distance(volume, 1, context), ResourceError);
  EXPECT_THROW(squared_distance_4sed(volume, 1, context), ResourceError);
  EXPECT_THROW(nearest_feature(volume, 1, context), ResourceError);
  EXPECT_THROW(close(volume, 1, context), ResourceError);
}

/// Voxels of the ball {|x| <= r} about the origin, by counting.
std::int64_t ball_voxels(double radius) {
  std::int64_t count = 0;
  const auto reach = static_cast<std::int64_t>(radius) + 1;
  for (std::int64_t x = -reach; x <= reach; ++x)
    for (std::int64_t y = -reach; y <= reach; ++y)
      for (std::int64_t z = -reach; z <= reach; ++z)
        count += static_cast<double>(x * x + y * y + z * z) <= radius * radius;
  return count;
}

TEST(Morphology, DilatingAVoxelGivesTheBallAndGrowsTheGrid) {
  RunContext context;
  const BinaryVolume voxel(frame_of({1, 1, 2}), 0);
  BinaryVolume one = voxel;
  one(0, 0, 0) = 1;
  for (const double radius : {0.0, 1.0, 1.5, 3.0, 4.2}) {
    const BinaryVolume ball = dilate(one, radius, context);
    EXPECT_EQ(count_interior(ball), ball_voxels(radius)) << radius;
    EXPECT_EQ(ball.nx(), 1 + 2 * static_cast<std::int64_t>(std::ceil(radius)));
  }
  EXPECT_EQ(ball_voxels(1), 7);  // the centre and its six face neighbours
}

TEST(Morphology, ErosionSeesTheExteriorBeyondTheGrid) {
  // A full 5^3 grid: eroding by 1 takes one layer of every side, by 2 two.
  RunContext context;
  const BinaryVolume full(frame_of({5, 5, 5}), 1);
  EXPECT_EQ(count_interior(erode(full, 1, context)), 27);
  EXPECT_EQ(count_interior(erode(full, 2, context)), 1);
  EXPECT_EQ(count_interior(erode(full, 3, context)), 0);
  EXPECT_EQ(erode(full, 1, context).frame, full.frame);
}

TEST(Morphology, ClosingFillsAGapOfTwiceTheDistanceAndNotMore) {
  // Two slabs 4 x 20 x 20, 6 voxels apart: a ball of radius r enters the gap from its side unless 2 r >= 6 + something;
  // in the middle of the gap, planes of gap voxels lie at most 3.5 from the nearest slab centre: filled iff no ball of
  // radius r placed in the gap avoids both slabs, i.e. iff its centre, 3 or 4 from a slab's voxels, is within r: r
  // >= 3.
  RunContext context;
  BinaryVolume slabs(frame_of({14, 20, 20}), 1);
  for (std::int64_t k = 0; k < 20; ++k)
    for (std::int64_t j = 0; j < 20; ++j)
      for (std::int64_t i = 4; i < 10; ++i) slabs(i, j, k) = 0;
  const BinaryVolume closed = close(slabs, 4, context);
  EXPECT_EQ(closed.frame, slabs.frame);
  EXPECT_EQ(closed(6, 10, 10), 1);
  EXPECT_EQ(close(slabs, 2, context), slabs);
}

TEST(Morphology, InvariantsOnRandomVolumes) {
  // Opening shrinks, closing grows, both are idempotent and increasing, and each is the other's dual by complement (on
  // a grid padded so far that its border does not matter).
  RunContext context;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const BinaryVolume volume = random_volume({12, 11, 10}, 0.3 + 0.02 * static_cast<double>(seed), seed);
    const double radius = 1 + 0.1 * static_cast<double>(seed);
    const BinaryVolume opened = open(volume, radius, context);
    const BinaryVolume closed = close(volume, radius, context);
    for (std::size_t i = 0; i < volume.values.size(); ++i) {
      ASSERT_LE(opened.values[i], volume.values[i]);
      ASSERT_GE(closed.values[i], volume.values[i]);
    }
    EXPECT_EQ(open(opened, radius, context), opened);
    EXPECT_EQ(close(closed, radius, context), closed);
    BinaryVolume complement = resized(volume, padded(volume.frame, 8));
    for (std::uint8_t& value : complement.values) value = static_cast<std::uint8_t>(1 - value);
    BinaryVolume dual = resized(open(complement, radius, context), volume.frame);
    for (std::uint8_t& value : dual.values) value = static_cast<std::uint8_t>(1 - value);
    EXPECT_EQ(dual, closed) << "seed " << seed;
  }
}

TEST(Morphology, AnImageStaysAnImage) {
  RunContext context;
  BinaryVolume image(frame_of({5, 5, 1}));
  image(2, 2, 0) = 1;
  const BinaryVolume disk = dilate(image, 1, context);
  EXPECT_EQ(disk.frame.dims, Index3(7, 7, 1));
  EXPECT_EQ(count_interior(disk), 5);
  EXPECT_EQ(erode(BinaryVolume(frame_of({3, 3, 1}), 1), 1, context), [] {
    BinaryVolume center(frame_of({3, 3, 1}));
    center(1, 1, 0) = 1;
    return center;
  }());
}

}  // namespace
}  // namespace voxcarve
