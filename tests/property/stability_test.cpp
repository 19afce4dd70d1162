#include "common/volume/stability.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "common/run/errors.h"
#include "common/volume/ball_painter.h"
#include "common/volume/distance_transform.h"
#include "tests/property/stability_cases.h"
#include "tests/support/shapes.h"

namespace voxcarve {
namespace {

using test::complement;
using test::digital_ball;
using test::for_each_voxel;
using test::frame_of;
using test::random_cases;
using test::random_volume;
using test::square_of;
using test::StabilityCase;

/// Every voxel that matters to balls of a radius up to `largest` on the grid of a volume: its place and its side.
struct Surroundings {
  struct Voxel {
    Index3 place;
    bool interior;
  };
  std::vector<Voxel> centers;   ///< within ceil(largest) of the grid
  std::vector<Voxel> features;  ///< one layer more: the outside beyond is never nearer

  Surroundings(const BinaryVolume& volume, double largest, bool outside) {
    const auto margin = static_cast<std::int64_t>(std::ceil(largest));
    for (const bool wider : {false, true}) {
      const std::int64_t by = margin + (wider ? 1 : 0);
      const Index3 around(by, by, volume.frame.is_image() ? 0 : by);
      for_each_voxel(-around, volume.frame.dims + around, [&](const Index3& p) {
        const bool interior = volume.get(p[0], p[1], p[2], static_cast<std::uint8_t>(outside)) != 0;
        (wider ? features : centers).push_back({p, interior});
      });
    }
  }

  /// Squared distance to the nearest voxel of the other side; very far where there is none.
  std::int64_t clearance(const Voxel& center) const {
    std::int64_t least = std::int64_t{1} << 40;
    for (const Voxel& other : features) {
      if (other.interior != center.interior) least = std::min(least, (other.place - center.place).squaredNorm());
    }
    return least;
  }
};

/// The slow twin: the definition, over all centers and all voxels.
Grid<std::int32_t> brute_force_stability(const BinaryVolume& volume, double largest, bool outside) {
  Grid<std::int32_t> result(volume.frame, 0);
  const std::int64_t cap = square_of(largest);
  const Surroundings surroundings(volume, largest, outside);
  for (const auto& center : surroundings.centers) {
    const std::int64_t reach = std::min(surroundings.clearance(center) - 1, cap);
    for_each_voxel(Index3::Zero(), volume.frame.dims, [&](const Index3& p) {
      std::int32_t& value = result(p[0], p[1], p[2]);
      if ((p - center.place).squaredNorm() <= reach) value = std::max(value, static_cast<std::int32_t>(reach));
    });
  }
  return result;
}

/// A twin for larger volumes: every ball about every voxel, none left out, each painted over its bounding box. The
/// distances are those of the distance transform, which has a twin of its own.
Grid<std::int32_t> plain_stability(const BinaryVolume& volume, double largest, bool outside) {
  RunContext context;
  const auto cap = static_cast<std::int32_t>(square_of(largest));
  const auto margin = static_cast<std::int64_t>(std::ceil(largest));
  const Index3 around(margin, margin, volume.frame.is_image() ? 0 : margin);
  const BinaryVolume wide = resized(volume, padded(volume.frame, margin), static_cast<std::uint8_t>(outside));
  const Grid<std::int32_t> to_interior = squared_distance(wide, 1, context);
  const Grid<std::int32_t> to_exterior = squared_distance(wide, 0, context);
  Grid<std::int32_t> result(volume.frame, 0);
  for_each_voxel(Index3::Zero(), wide.frame.dims, [&](const Index3& c) {
    const std::size_t index = wide.index(c[0], c[1], c[2]);
    const std::int32_t reach = std::min(std::max(to_interior.values[index], to_exterior.values[index]) - 1, cap);
    const Index3 center = c - around;
    for_each_voxel((center - around).cwiseMax(0), (center + around + Index3::Ones()).cwiseMin(volume.frame.dims),
                   [&](const Index3& p) {
                     std::int32_t& value = result(p[0], p[1], p[2]);
                     if (reach > value && (p - center).squaredNorm() <= reach) value = reach;
                   });
  });
  return result;
}

TEST(SquaredStability, AgreesWithTheDefinitionOnRandomVolumes) {
  RunContext context;
  for (const StabilityCase& c : random_cases(300)) {
    ASSERT_EQ(squared_stability(c.volume, c.largest, c.outside, context),
              brute_force_stability(c.volume, c.largest, c.outside))
        << c.name;
  }
}

TEST(SquaredStability, AgreesWithTheDefinitionWhereBallsHoldOneAnother) {
  // Noise has none but small balls. A ball with a bite and a dent has a medial axis, and many balls to leave out; the
  // grid is wider than a brick of the painter, and at 70 pixels than a word and a node of it.
  RunContext context;
  for (const bool image : {true, false}) {
    BinaryVolume volume = digital_ball(image ? 900 : 40, image ? 5 : 2, image);
    const std::int64_t half = volume.nx() / 2;
    for_each_voxel(Index3::Zero(), volume.frame.dims, [&](const Index3& p) {
      if ((p - Index3(half / 2, half, image ? 0 : half)).squaredNorm() <= 5) volume(p[0], p[1], p[2]) = 0;
      if (p[0] > half && std::abs(p[1] - half) <= 1) volume(p[0], p[1], p[2]) = 0;
    });
    for (const double largest : {3.3, image ? 14.0 : 5.0}) {
      ASSERT_EQ(squared_stability(volume, largest, false, context), brute_force_stability(volume, largest, false))
          << image << " " << largest;
    }
  }
}

TEST(SquaredStability, AgreesWithAllBallsOfLargerVolumes) {
  // Here most balls are left out: held by others, or without a voxel that has no value yet when their round comes.
  RunContext context;
  const auto sparse = [](const Index3& dims, double fill, std::uint64_t seed) {
    BinaryVolume volume(frame_of(dims));
    const BinaryVolume seeds = random_volume(dims, fill, seed);
    for_each_voxel(Index3::Zero(), dims, [&](const Index3& q) {
      if (seeds(q[0], q[1], q[2]) == 0) return;
      const std::int64_t reach = (q[0] * 7 + q[1] * 3 + q[2]) % 90;
      for_each_voxel(Index3::Zero(), dims, [&](const Index3& p) {
        if ((p - q).squaredNorm() <= reach) volume(p[0], p[1], p[2]) = 1;
      });
    });
    return volume;
  };
  const BinaryVolume image = sparse({150, 130, 1}, 0.001, 4);
  const BinaryVolume block = sparse({34, 29, 37}, 0.0004, 5);
  for (const bool outside : {false, true}) {
    ASSERT_EQ(squared_stability(image, 24, outside, context), plain_stability(image, 24, outside)) << outside;
    ASSERT_EQ(squared_stability(block, 8.5, outside, context), plain_stability(block, 8.5, outside)) << outside;
  }
}

TEST(SquaredStability, IsTheLargestOrTheSameEverywhereWhenThereIsOnlyOneSide) {
  RunContext context;
  const GridFrame frame = frame_of({9, 7, 5});
  for (const double largest : {0.0, 1.0, 2.5, 20.0}) {
    const auto cap = static_cast<std::int32_t>(square_of(largest));
    for (const bool full : {false, true}) {
      const BinaryVolume volume(frame, static_cast<std::uint8_t>(full));
      EXPECT_EQ(squared_stability(volume, largest, full, context), Grid<std::int32_t>(frame, cap)) << largest;
    }
  }
  // A full box in an empty outside: the largest inner ball about (i, j, k) reaches to one voxel short of the nearest
  // side, min(i + 1, 9 - i, ...)^2 - 1, which is 3^2 - 1 = 8 about the voxels with 2 <= i <= 6, 2 <= j <= 4, k = 2.
  // Voxel (4, 3, 4) is 2^2 = 4 from such a center, corner (0, 0, 0) is 12 from the nearest and lies in no ball but its
  // own.
  const Grid<std::int32_t> box = squared_stability(BinaryVolume(frame, 1), 20, false, context);
  EXPECT_EQ(box(4, 3, 2), 8);
  EXPECT_EQ(box(4, 3, 4), 8);
  EXPECT_EQ(box(1, 1, 1), 8);  // 3 from (2, 2, 2)
  EXPECT_EQ(box(0, 0, 0), 3);  // the ball about (1, 1, 1) reaches 2^2 - 1 = 3, just as far as the corner
}

TEST(SquaredStability, TakesSidesBeyondTheGridIntoAccount) {
  // One interior pixel in the middle of a row of 5: its ball is itself. Beside it, the exterior at distance 1 belongs
  // to balls about pixels straight beyond: about (4, 0), two away, the ball of 2^2 - 1 = 3 contains (3, 0); about the
  // pixel n away, n^2 - 1 >= (n - 1)^2, so that only the cap bounds it. With outside interior, the same row is a slit
  // of two times two pixels, whose balls all touch the outside across y: 0 everywhere.
  RunContext context;
  BinaryVolume row(frame_of({5, 1, 1}));
  row(2, 0, 0) = 1;
  const Grid<std::int32_t> solid = squared_stability(row, 6.5, false, context);
  EXPECT_EQ(solid.values, (GridValues<std::int32_t>{42, 42, 0, 42, 42}));
  const Grid<std::int32_t> slit = squared_stability(row, 6.5, true, context);
  EXPECT_EQ(slit.values[0], 0);
  EXPECT_EQ(slit.values[1], 0);
  // The interior pixel is part of the interior outside: a ball about (2, n) has its nearest exterior at (1, 0), n^2 + 1
  // away, and reaches n^2, just as far as (2, 0): the largest n is 6.
  EXPECT_EQ(slit.values[2], 36);
}

TEST(SquaredStability, IsTheSameForAComplement) {
  RunContext context;
  for (const StabilityCase& c : random_cases(120)) {
    ASSERT_EQ(squared_stability(c.volume, c.largest, c.outside, context),
              squared_stability(complement(c.volume), c.largest, !c.outside, context))
        << c.name;
  }
}

TEST(SquaredStability, NeverFallsWhenTheLargestGrows) {
  // The ball about a voxel is never smaller for a larger cap, so what it contains it keeps.
  RunContext context;
  for (const StabilityCase& c : random_cases(120)) {
    const Grid<std::int32_t> less = squared_stability(c.volume, c.largest, c.outside, context);
    const Grid<std::int32_t> more = squared_stability(c.volume, c.largest + 1.25, c.outside, context);
    for (std::size_t v = 0; v < less.values.size(); ++v) ASSERT_LE(less.values[v], more.values[v]) << c.name;
  }
}

TEST(SquaredStability, IsCutAtTheLargestRadiusByBallsOfThatRadius) {
  // The disk of squared radius 9 is a ball, so all of it has 9. With balls cut to 4 the pixel (3, 0) lies in that about
  // (1, 0). The corner (2, 2) lies in none of them (see below), only in that about (1, 1), whose nearest exterior
  // pixels are (1, 3) and (3, 1), 2 away: it reaches 3, and the corner is at 2. That is less than min(9, 4).
  RunContext context;
  const BinaryVolume disk = digital_ball(9, 2, true);  // about (5, 5)
  const Grid<std::int32_t> three = squared_stability(disk, 3, false, context);
  const Grid<std::int32_t> two = squared_stability(disk, 2, false, context);
  EXPECT_EQ(three(8, 5, 0), 9);
  EXPECT_EQ(three(7, 7, 0), 9);
  EXPECT_EQ(two(8, 5, 0), 4);
  EXPECT_EQ(two(7, 7, 0), 3);
}

TEST(SquaredStability, GivesTheSameOnOneThreadAndOnTwo) {
  RunContext one;
  RunContext two;
  two.threads = 2;
  BinaryVolume volume = random_volume({70, 45, 40}, 0.0005, 9);
  EXPECT_EQ(squared_stability(volume, 7, false, one), squared_stability(volume, 7, false, two));
  EXPECT_EQ(first_mortar(volume, default_stability_radii(), false, one),
            first_mortar(volume, default_stability_radii(), false, two));
  volume = random_volume({400, 300, 1}, 0.002, 9);
  EXPECT_EQ(squared_stability(volume, 25, false, one), squared_stability(volume, 25, false, two));
}

TEST(SquaredStability, GoesBeyondTheRadiiOfTheBallSweep) {
  // 200^2 = 40000 is more than the sweep takes. A lone pixel is as far as can be from everything else: all the exterior
  // lies in half planes that miss it, in balls of every radius, but for the 8 pixels around it. Of a cap of 200 the
  // ball about (n, 0) away from the pixel reaches n^2 - 1 >= (n - 1)^2; about (n, n), it reaches 2 n^2 - 1 >= 2 (n -
  // 1)^2.
  RunContext context;
  BinaryVolume image(frame_of({3, 3, 1}));
  image(1, 1, 0) = 1;
  Grid<std::int32_t> expected(image.frame, 40000);
  expected(1, 1, 0) = 0;
  EXPECT_EQ(squared_stability(image, 200, false, context), expected);
  const std::vector<double> radii = {200};
  Grid<float> mortar(image.frame, 0.0F);
  mortar(1, 1, 0) = 200;
  EXPECT_EQ(first_mortar(image, radii, false, context), mortar);
}

TEST(SquaredStability, RefusesWhatItCannotTake) {
  RunContext context;
  const BinaryVolume volume = random_volume({8, 8, 8}, 0.5, 1);
  EXPECT_THROW(squared_stability(volume, -1, false, context), ParameterError);
  EXPECT_THROW(squared_stability(volume, std::nan(""), false, context), ParameterError);
  EXPECT_THROW(squared_stability(volume, 1e6, false, context), ParameterError);
  context.memory_budget = 100000;
  EXPECT_THROW(squared_stability(volume, 30, false, context), ResourceError);
  EXPECT_THROW(first_mortar(volume, std::vector<double>{3, 2}, false, context), ParameterError);
  EXPECT_THROW(first_mortar(volume, std::vector<double>{-3, 2}, false, context), ParameterError);
}

TEST(SquaredStability, StopsWhenItIsCancelled) {
  RunContext context;
  std::stop_source source;
  context.cancellation = source.get_token();
  source.request_stop();
  const BinaryVolume volume = random_volume({8, 8, 8}, 0.5, 1);
  EXPECT_THROW(squared_stability(volume, 3, false, context), Cancelled);
  EXPECT_THROW(first_mortar(volume, default_stability_radii(), false, context), Cancelled);
}

TEST(StabilityRadii, AreTheGreatestOfTheSameBall) {
  // The balls of squared radii 0, 3, 8 and 143 are those of all radii below sqrt(1), sqrt(4), sqrt(9) and sqrt(144). A
  // float has 24 bits, so below 1 the next one is 1 - 2^-24, below 2 it is 2 - 2^-23, from 2 to 4 they lie 2^-22 apart
  // and from 8 to 16 2^-20.
  RunContext context;
  Grid<std::int32_t> squared(frame_of({5, 1, 1}));
  squared.values = {0, 3, 8, 143, 144};
  const Grid<float> radii = stability_radii(squared, 12, context);
  EXPECT_EQ(radii.frame, squared.frame);
  EXPECT_EQ(radii.values, (GridValues<float>{1 - 0x1p-24F, 2 - 0x1p-23F, 3 - 0x1p-22F, 12 - 0x1p-20F, 12.0F}));
  // Of 16 the greatest float below sqrt(17): the next one has a square above 17.
  squared.values = {1, 2, 15, 16, 17};
  const Grid<float> real = stability_radii(squared, 4.2, context);
  const double greatest = static_cast<double>(real.values[3]);
  const double next = static_cast<double>(std::nextafter(real.values[3], 5.0F));
  EXPECT_LT(greatest * greatest, 17);  // exact in a double: 48 bits
  EXPECT_GT(next * next, 17);
  EXPECT_EQ(real.values[2], 4 - 0x1p-22F);
  // Radii below 1 have balls of one voxel, which fit everywhere.
  squared.values = {0, 0, 0, 0, 0};
  EXPECT_EQ(stability_radii(squared, 0, context).values, (GridValues<float>{0, 0, 0, 0, 0}));
  EXPECT_EQ(stability_radii(squared, 0.5, context).values, (GridValues<float>{0.5F, 0.5F, 0.5F, 0.5F, 0.5F}));
  EXPECT_THROW(stability_radii(squared, -1, context), ParameterError);
}

TEST(StabilityRadii, OfEverySquareAreTheSameFromATableAndWithoutOne) {
  // Up to 256 voxels the roots come from a table, beyond it each is taken by itself; 2^18 voxels are more than one
  // thread's share. A float times itself is exact in a double.
  RunContext context;
  context.threads = 2;
  Grid<std::int32_t> squared(frame_of({1 << 18, 1, 1}));
  for (const double largest : {11.3, 256.0, 256.1}) {
    const auto cap = static_cast<std::int32_t>(square_of(largest));
    for (std::size_t v = 0; v < squared.values.size(); ++v)
      squared.values[v] = static_cast<std::int32_t>(v * 37 % (static_cast<std::size_t>(cap) + 1));
    const Grid<float> radii = stability_radii(squared, largest, context);
    for (std::size_t v = 0; v < squared.values.size(); ++v) {
      const double radius = static_cast<double>(radii.values[v]);
      const double next = static_cast<double>(std::nextafter(radii.values[v], 1000.0F));
      if (squared.values[v] == cap) {
        ASSERT_GE(radius, largest);
        continue;
      }
      const double bound = std::min(largest, static_cast<double>(static_cast<float>(largest)));
      ASSERT_TRUE(radius < bound && radius * radius < squared.values[v] + 1) << squared.values[v];
      ASSERT_TRUE(next >= bound || next * next >= squared.values[v] + 1) << squared.values[v];
    }
  }
}

TEST(StabilityRadii, DeclareTheirMemoryAndStopWhenCancelled) {
  RunContext context;
  const Grid<std::int32_t> squared(frame_of({10, 10, 10}), 3);
  context.memory_budget = 1000 * 8 + 4 * 4 + 100;  // both maps, the table of 2^2 radii, and what the caller holds
  EXPECT_NO_THROW(stability_radii(squared, 2, context, 100));
  EXPECT_THROW(stability_radii(squared, 2, context, 101), ResourceError);
  std::stop_source source;
  context.cancellation = source.get_token();
  source.request_stop();
  EXPECT_THROW(stability_radii(squared, 2, context), Cancelled);
}

TEST(SquaredStability, DeclaresWithItsMemoryWhatTheCallerHolds) {
  RunContext context;
  const BinaryVolume volume = random_volume({20, 12, 9}, 0.5, 4);
  constexpr std::uint64_t kHeld = std::uint64_t{1} << 40;
  context.memory_budget = kHeld;
  EXPECT_NO_THROW(squared_stability(volume, 3, false, context));
  EXPECT_THROW(squared_stability(volume, 3, false, context, kHeld), ResourceError);
  // Beyond the ball sweep the dilation by the largest ball takes 5 bytes a voxel of a grid that is two voxels wider
  // than the one of the reaches, of 4 bytes a voxel, and of the centers, of a bit: more than the transforms before it.
  const BinaryVolume image(frame_of({8, 8, 1}));
  const std::uint64_t side = 8 + 2 * 200;
  const std::uint64_t words = (side + 63) / 64;
  const std::uint64_t least = 4 * side * side + 8 * words * side + 5 * (side + 2) * (side + 2);
  context.memory_budget = least - 1;
  EXPECT_THROW(squared_stability(image, 200, false, context), ResourceError);
  // The same of the mortar: a map of 4 bytes a voxel, the volume and the centers of balls in bits, and a transform.
  const std::uint64_t mortar = 4 * 64 + 2 * 8 * words * side + 5 * (side + 2) * (side + 2);
  const std::vector<double> radii = {200};
  context.memory_budget = mortar + 50;
  EXPECT_NO_THROW(first_mortar(image, radii, false, context, 50));
  EXPECT_THROW(first_mortar(image, radii, false, context, 51), ResourceError);
}

TEST(StabilityRadii, AreBelowTheLargestWhereItsBallDoesNotFit) {
  // As a float 4.2 is rounded down, 4.3 up, and sqrt(17), the least radius of its ball, down; 4.123105625 is so little
  // below it that it has the same ball.
  RunContext context;
  Grid<std::int32_t> squared(frame_of({2, 1, 1}));
  for (const double largest : {1.5, 4.0, 4.2, 4.3, std::sqrt(17.0), std::sqrt(18.0), 4.123105625, 0.7, 1000.1}) {
    const auto cap = static_cast<std::int32_t>(square_of(largest));
    squared.values = {cap, cap - 1};
    const Grid<float> radii = stability_radii(squared, largest, context);
    EXPECT_GE(radii.values[0], static_cast<float>(largest)) << largest;
    EXPECT_GE(static_cast<double>(radii.values[0]), largest);
    EXPECT_LT(std::nextafter(radii.values[0], 0.0F), largest) << "the least such float";
    if (cap == 0) continue;
    EXPECT_LT(radii.values[1], static_cast<float>(largest)) << largest;
    EXPECT_LT(static_cast<double>(radii.values[1]), largest);
  }
}

TEST(PaintBalls, TheFirstBallCounts) {
  // Row of 10: the ball of 4 about 2 takes 0 ... 4, then the ball of 9 about 4 takes what is left of 1 ... 7 but for 6,
  // which is not blank; 8 and 9 lie in none.
  RunContext context;
  Grid<std::int32_t> values(frame_of({10, 1, 1}), -1);
  BinaryVolume blank(values.frame, 1);
  blank(6, 0, 0) = 0;
  BitVolume bits = packed(blank, Index3::Zero(), false, context);
  paint_balls({{{2, 0, 0}, 4}, {{4, 0, 0}, 9}}, bits, values, context);
  EXPECT_EQ(values.values, (GridValues<std::int32_t>{4, 4, 4, 4, 4, 9, -1, 9, -1, -1}));
  EXPECT_EQ(count_set(bits, context), 2);  // 8 and 9
}

}  // namespace
}  // namespace voxcarve
