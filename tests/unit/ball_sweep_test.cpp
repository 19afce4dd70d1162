#include "common/volume/ball_sweep.h"

#include <gtest/gtest.h>

#include <random>

#include "common/volume/bit_morphology.h"
#include "common/volume/distance_transform.h"
#include "common/volume/morphology.h"
#include "tests/support/shapes.h"

namespace voxcarve {
namespace {

using test::frame_of;
using test::random_volume;

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

/// The ball by definition, voxel by voxel.
BinaryVolume slow_dilation(const BinaryVolume& volume, double radius, bool outside) {
  const auto margin = static_cast<std::int64_t>(std::ceil(radius));
  BinaryVolume result(volume.frame);
  const std::int64_t depth = volume.frame.is_image() ? 0 : margin;
  for (std::int64_t k = 0; k < volume.nz(); ++k)
    for (std::int64_t j = 0; j < volume.ny(); ++j)
      for (std::int64_t i = 0; i < volume.nx(); ++i)
        for (std::int64_t z = -depth; z <= depth; ++z)
          for (std::int64_t y = -margin; y <= margin; ++y)
            for (std::int64_t x = -margin; x <= margin; ++x)
              if (static_cast<double>(x * x + y * y + z * z) <= radius * radius &&
                  volume.get(i + x, j + y, k + z, outside ? 1 : 0) != 0)
                result(i, j, k) = 1;
  return result;
}

BinaryVolume turned(BinaryVolume volume) {
  for (std::uint8_t& value : volume.values) value = static_cast<std::uint8_t>(1 - value);
  return volume;
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
          const BinaryVolume shrunk = turned(slow_dilation(turned(volume), radius, !outside));
          ASSERT_EQ(dilate(bits, reach, outside, context), bits_of(grown, context)) << radius;
          ASSERT_EQ(erode(bits, reach, outside, context), bits_of(shrunk, context)) << radius;
          ASSERT_EQ(open(bits, reach, outside, context), bits_of(slow_dilation(shrunk, radius, outside), context));
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
