#include "common/volume/ball_sweep.h"

#include <gtest/gtest.h>

#include <random>

#include "common/run/errors.h"
#include "common/volume/bit_morphology.h"
#include "common/volume/distance_transform.h"
#include "common/volume/grid_passes.h"
#include "common/volume/morphology.h"
#include "tests/support/shapes.h"

namespace voxcarve {
namespace {

using test::frame_of;
using test::random_volume;
using test::slow_dilation;
using test::slow_erosion;

BitVolume bits_of(const BinaryVolume& volume, RunContext& context) {
  return packed(volume, Index3::Zero(), false, context);
}

/// The slow twin: the whole distance transform, thresholded, of a grid with one layer of what lies outside.
BinaryVolume slow_reach(const BinaryVolume& volume, const Features& features, std::int64_t reach, bool inverted,
                        RunContext& context) {
  const GridFrame wider = padded(volume.frame, features.outside ? 1 : 0);
  const auto value = static_cast<std::uint8_t>(features.value);
  Grid<std::int32_t> distance = squared_distance(resized(volume, wider, value), value, context);
  BinaryVolume near(wider);
  for (std::size_t at = 0; at < near.values.size(); ++at) {
    const bool within = distance.values[at] != kInfiniteDistance && distance.values[at] <= reach;
    near.values[at] = static_cast<std::uint8_t>(within != inverted);
  }
  return resized(near, volume.frame);
}

struct Case {
  Index3 dims;
  double fill;
  std::int64_t reach;
};

/// Widths around multiples of 64, single rows and slices, radii from 0 to the largest, more slices than the ring holds.
std::vector<Case> random_cases() {
  std::mt19937 random(7);  // std::mt19937 gives the same numbers everywhere; distributions would not
  const auto below = [&](std::uint32_t n) { return static_cast<std::int64_t>(random() % n); };
  std::vector<Case> cases;
  for (int t = 0; t < 240; ++t) {
    Index3 dims(1 + below(200), 1 + below(20), 1 + below(20));
    if (t % 5 == 0) dims[2] = 1;
    if (t % 7 == 0) dims[1] = 1;
    if (t % 9 == 0) dims = Index3(1 + below(70), 1 + below(4), 90);
    if (t % 11 == 0) dims[0] = 63 + below(3);
    constexpr double kFills[] = {0, 0.001, 0.03, 0.5, 0.98, 1};
    cases.push_back({dims, kFills[t % 6], t % 4 == 0 ? below(kLargestSweptReach + 1) : below(200)});
  }
  return cases;
}

TEST(BallSweep, AgreesWithTheDistanceTransformOnRandomVolumes) {
  std::uint64_t seed = 0;
  for (const Case& at : random_cases()) {
    RunContext context;
    context.threads = 1 + static_cast<int>(seed % 2);
    const BinaryVolume volume = random_volume(at.dims, at.fill, ++seed);
    const BitVolume bits = bits_of(volume, context);
    for (const bool value : {false, true}) {
      for (const bool outside : {false, true}) {
        const bool inverted = (seed + (value ? 1 : 0)) % 2 == 0;
        const Features features{value, outside};
        const BitVolume result = within_reach(bits, features, at.reach, inverted, context);
        ASSERT_EQ(result, bits_of(slow_reach(volume, features, at.reach, inverted, context), context))
            << at.dims.transpose() << " fill " << at.fill << " reach " << at.reach << " value " << value << " outside "
            << outside << " inverted " << inverted;
      }
    }
  }
}

TEST(BallSweep, AgreesWithTheDistanceTransformAcrossBandsOfRows) {
  // Slices of more than half a megabyte are treated in bands of rows: of 2^19 / 1024 = 512 rows, or 2^19 / 20032 = 26
  // in the widest, but of no fewer than 4 * 5 = 20 for a squared radius of 30 and 4 * 180 for the largest; the last one
  // is short. Features lie on either side of the borders, and there are none for longer than the smaller radius.
  for (const Index3& dims : {Index3(1000, 1100, 1), Index3(1024, 530, 3), Index3(20000, 800, 1)}) {
    for (const std::int64_t reach : {std::int64_t{0}, std::int64_t{30}, kLargestSweptReach}) {
      RunContext context;
      context.threads = 2;
      BinaryVolume volume(frame_of(dims));
      for (const std::int64_t row : {0, 100, 355, 365, 511, 516, 719, 1023, 1024}) {
        if (row >= dims[1]) continue;
        for (std::int64_t i = row % 7; i < dims[0]; i += 97) volume(i, row, row % dims[2]) = 1;
      }
      const BitVolume bits = bits_of(volume, context);
      for (const bool outside : {false, true}) {
        const Features features{true, outside};
        ASSERT_EQ(within_reach(bits, features, reach, false, context),
                  bits_of(slow_reach(volume, features, reach, false, context), context))
            << dims.transpose() << " reach " << reach << " outside " << outside;
      }
    }
  }
}

TEST(BallSweep, GivesNothingOnGridsWithoutVoxels) {
  RunContext context;
  for (const Index3& dims : {Index3(0, 5, 5), Index3(5, 0, 5), Index3(5, 5, 0), Index3(0, 0, 0)}) {
    const BitVolume none(dims);
    for (const std::int64_t reach : {std::int64_t{9}, squared_reach(200)}) {
      EXPECT_EQ(dilate(none, reach, true, context), none);
      EXPECT_EQ(erode(none, reach, false, context), none);
    }
    EXPECT_EQ(within_reach(none, {true, true}, 9, false, context), none);
  }
}

TEST(BallSweep, HandlesTheLargestReach) {
  // One voxel in a row of 401: 180 neighbours on each side, since 180^2 <= 32760 < 181^2.
  RunContext context;
  BinaryVolume volume(frame_of({401, 1, 1}));
  volume(200, 0, 0) = 1;
  const BitVolume result = within_reach(bits_of(volume, context), {true, false}, kLargestSweptReach, false, context);
  EXPECT_EQ(count_set(result, context), 361);
}

TEST(BitMorphology, FallsBackBeyondTheLargestReach) {
  // Rows and columns that end just inside and just outside of a radius of 200.
  RunContext context;
  BinaryVolume volume(frame_of({450, 3, 2}));
  volume(10, 1, 0) = 1;
  const BitVolume grown = dilate(bits_of(volume, context), squared_reach(200), false, context);
  // In the voxel's own row 10 to its left and 200 to its right; one row or slice beside it sqrt(200^2 - 1) reaches 199.
  const std::int64_t own = 10 + 1 + 200;
  EXPECT_EQ(count_set(grown, context), own + 5 * (own - 1));
  EXPECT_EQ(count_set(erode(bits_of(volume, context), squared_reach(200), true, context), context), 0);
}

TEST(BitMorphology, DeclaresWhatItHolds) {
  RunContext context;
  const auto needs = [&](const Index3& dims, std::int64_t reach, std::uint64_t bytes) {
    BitVolume volume(dims);
    volume.clear();
    const std::uint64_t argument = BitVolume::memory(dims);
    EXPECT_EQ(morphology_memory(dims, reach), bytes) << dims.transpose() << " reach " << reach;
    context.memory_budget = argument + bytes;
    EXPECT_NO_THROW(erode(volume, reach, false, context));
    context.memory_budget = argument + bytes - 1;
    EXPECT_THROW(erode(volume, reach, false, context), ResourceError);
  };
  // A result of a word a row; slices of 64 bytes a row, 16 and the radius of 2 of them in the ring and one carried.
  needs({60, 10, 40}, 4, 8 * 10 * 40 + (16 + 2 + 1) * 64 * 10);
  needs({60, 10, 1}, 4, 8 * 10 + 64 * 10);  // an image carries nothing on
  // Beyond the sweep 5 bytes a voxel, with a voxel more on every side that the grid extends to.
  needs({60, 10, 4}, 40000, 5 * 62 * 12 * 6);
  needs({60, 10, 1}, 40000, 5 * 62 * 12);
}

TEST(BitMorphology, AgreesWithTheDefinition) {
  RunContext context;
  std::uint64_t seed = 100;
  for (const double radius : {0.0, 0.5, 1.0, 1.5, 2.0, 2.3, 3.0}) {
    for (const Index3& dims : {Index3(9, 8, 7), Index3(17, 12, 1), Index3(70, 1, 3), Index3(5, 6, 1)}) {
      for (const double fill : {0.1, 0.5, 0.9}) {
        const BinaryVolume volume = random_volume(dims, fill, ++seed);
        const BitVolume bits = bits_of(volume, context);
        const std::int64_t reach = squared_reach(radius);
        for (const bool outside : {false, true}) {
          const BinaryVolume grown = slow_dilation(volume, radius, outside);
          const BinaryVolume shrunk = slow_erosion(volume, radius, outside);
          ASSERT_EQ(dilate(bits, reach, outside, context), bits_of(grown, context)) << radius;
          ASSERT_EQ(erode(bits, reach, outside, context), bits_of(shrunk, context)) << radius;
          ASSERT_EQ(open(bits, reach, outside, context), bits_of(slow_dilation(shrunk, radius, outside), context));
          // A closing of what lies in an exterior needs room for what the ball adds meanwhile.
          const Index3 margin = ball_margin(dims, radius);
          const BinaryVolume wider =
              resized(volume, padded(volume.frame, margin[0]), static_cast<std::uint8_t>(outside));
          const BinaryVolume closed = slow_erosion(slow_dilation(wider, radius, outside), radius, outside);
          ASSERT_EQ(close(packed(volume, margin, outside, context), reach, outside, context), bits_of(closed, context));
          if (!outside) {
            // It never leaves the grid, which is why that on bytes need not be padded.
            ASSERT_EQ(count_interior(closed), count_interior(resized(closed, volume.frame)));
            ASSERT_EQ(close(volume, radius, context), resized(closed, volume.frame));
          }
        }
      }
    }
  }
}

TEST(BitMorphology, KeepsRadiusZeroAndEmptiesWhatNoBallFits) {
  RunContext context;
  const BinaryVolume volume = random_volume({20, 11, 6}, 0.4, 3);
  EXPECT_EQ(open(volume, 0, context), volume);
  EXPECT_EQ(close(volume, 0, context), volume);
  EXPECT_EQ(count_interior(open(volume, 30, context)), 0);
  const BinaryVolume full(frame_of({20, 11, 6}), 1);
  EXPECT_EQ(close(full, 3, context), full);
  EXPECT_EQ(count_interior(dilate(BinaryVolume(frame_of({5, 5, 5})), 4, context)), 0);
}

TEST(GridPasses, GiveWhatTheirNamesakesDo) {
  // More voxels than one piece of a pass has, and parts of a lattice that lie within, across and beside each other.
  RunContext context;
  context.threads = 2;
  const BinaryVolume volume = random_volume({130, 70, 61}, 0.3, 8);
  EXPECT_EQ(count_interior(volume, context), count_interior(volume));
  Grid<float> field(volume.frame);
  for (std::size_t at = 0; at < field.values.size(); ++at) field.values[at] = static_cast<float>(at * 7919 % 1000);
  EXPECT_EQ(thresholded(field, 500, context), thresholded(field, 500));
  for (const Index3& offset : {Index3(0, 0, 0), Index3(-3, 5, 1), Index3(7, -4, -70), Index3(140, 2, 2)}) {
    for (const Index3& dims : {Index3(130, 70, 61), Index3(20, 90, 5), Index3(150, 3, 64), Index3(0, 3, 3)}) {
      GridFrame frame = volume.frame;
      frame.origin += frame.voxel_size * offset.cast<double>();
      frame.dims = dims;
      ASSERT_EQ(resized(volume, frame, std::uint8_t{1}, context), resized(volume, frame, std::uint8_t{1}))
          << offset.transpose() << " " << dims.transpose();
    }
  }
}

TEST(BitVolume, PacksAndExpandsWithEveryMargin) {
  RunContext context;
  std::uint64_t seed = 40;
  for (const std::int64_t nx : {1, 5, 63, 64, 65, 127, 128, 200}) {
    for (const std::int64_t margin : {0, 1, 7, 63, 64, 65, 100}) {
      const BinaryVolume volume = random_volume({nx, 3, 2}, 0.5, ++seed);
      for (const bool outside : {false, true}) {
        const Index3 around(margin, margin % 3, margin % 2);
        const BitVolume bits = packed(volume, around, outside, context);
        ASSERT_EQ(bits.dims(), Index3(volume.frame.dims + 2 * around));
        ASSERT_EQ(expanded(bits, volume.frame, around, context), volume) << nx << " " << margin;
        const std::int64_t more = bits.dims().prod() - volume.frame.voxels();
        ASSERT_EQ(count_set(bits, context), count_interior(volume) + (outside ? more : 0)) << nx << " " << margin;
      }
    }
  }
}

}  // namespace
}  // namespace voxcarve
