// The mortars of radii: first_mortar, and the stability map against them.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "common/volume/stability.h"
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

/// The slow twin of the mortar, from the masks: closing less opening, each a loop over pairs of voxels. Written for a
/// solid; with the outside interior, it is the complement's, of which closing and opening change places.
BinaryVolume brute_force_mortar(const BinaryVolume& volume, double radius, bool outside) {
  const std::int64_t reach = square_of(radius);
  const auto margin = static_cast<std::int64_t>(std::ceil(radius));
  BinaryVolume solid = resized(volume, padded(volume.frame, 2 * margin + 1), static_cast<std::uint8_t>(outside));
  if (outside) {
    for (std::uint8_t& value : solid.values) value = static_cast<std::uint8_t>(1 - value);
  }
  // The voxels with another of value `feature` within reach; beyond the grid all are 0.
  const auto near = [&](const BinaryVolume& from, std::uint8_t feature) {
    BinaryVolume result(from.frame);
    const Index3 around(margin, margin, from.frame.is_image() ? 0 : margin);
    for_each_voxel(Index3::Zero(), from.frame.dims, [&](const Index3& p) {
      for_each_voxel(p - around, p + around + Index3::Ones(), [&](const Index3& q) {
        if (result(p[0], p[1], p[2]) != 0) return;
        if ((q - p).squaredNorm() <= reach && from.get(q[0], q[1], q[2], 0) == feature) result(p[0], p[1], p[2]) = 1;
      });
    });
    return result;
  };
  const auto inverted = [](BinaryVolume of) {
    for (std::uint8_t& value : of.values) value = static_cast<std::uint8_t>(1 - value);
    return of;
  };
  const BinaryVolume opened = near(inverted(near(solid, 0)), 1);
  const BinaryVolume closed = inverted(near(near(solid, 1), 0));
  BinaryVolume mortar(solid.frame);
  for (std::size_t v = 0; v < mortar.values.size(); ++v)
    mortar.values[v] = static_cast<std::uint8_t>(closed.values[v] != 0 && opened.values[v] == 0);
  return resized(mortar, volume.frame);
}

TEST(SquaredStability, ThatIsLessThanARadiusLiesWithinItsMortar) {
  RunContext context;
  for (const StabilityCase& c : random_cases(100)) {
    if (c.largest == 0) continue;
    const Grid<std::int32_t> stability = squared_stability(c.volume, c.largest, c.outside, context);
    for (double radius = 0.5; radius <= c.largest; radius += 0.5) {
      const BinaryVolume mortar = brute_force_mortar(c.volume, radius, c.outside);
      for (std::size_t v = 0; v < mortar.values.size(); ++v) {
        if (stability.values[v] >= square_of(radius)) continue;
        ASSERT_EQ(mortar.values[v], 1) << c.name << " radius " << radius;
      }
    }
    const BinaryVolume mortar = brute_force_mortar(c.volume, c.largest, c.outside);
    for (std::size_t v = 0; v < mortar.values.size(); ++v) {
      ASSERT_EQ(stability.values[v] < square_of(c.largest), mortar.values[v] == 1) << c.name;
    }
  }
}

TEST(SquaredStability, MissesFourPixelsOfTheMortarOfADisk) {
  // B_3 opened by B_2 loses 4 pixels. B_3 has half widths 3, 2, 2, 0 in the rows 0, 1, 2, 3 (9 - 9 = 0, 9 - 4 = 5, 9 -
  // 1 = 8). The ball of radius 2 fits about (0, 0), (+-1, 0), (0, +-1): (1, 0) + (2, 0) = (3, 0) is in B_3, and about
  // (1, 1) it is not, for (1, 1) + (0, 2) = (1, 3) has 10 > 9. So (3, 0) is reached from (1, 0), and nothing is lost
  // there; the corners (2, 2), with 8 <= 9, are not: from (1, 0) it is 1 + 4 = 5 > 4 away, likewise from (0, 1). They
  // are in the mortar of radius 2, and yet their stability is 3, because B_3 itself contains them.
  RunContext context;
  const BinaryVolume disk = digital_ball(9, 8, true);
  const Grid<std::int32_t> stability = squared_stability(disk, 3, false, context);
  const BinaryVolume mortar = brute_force_mortar(disk, 2, false);
  std::vector<Index3> missed;
  const Index3 center(11, 11, 0);
  for_each_voxel(Index3::Zero(), disk.frame.dims, [&](const Index3& p) {
    if (disk(p[0], p[1], p[2]) == 0) return;
    EXPECT_EQ(stability(p[0], p[1], p[2]), 9);
    if (mortar(p[0], p[1], p[2]) != 0 && stability(p[0], p[1], p[2]) >= 4) missed.emplace_back(p - center);
  });
  EXPECT_EQ(missed, (std::vector<Index3>{{-2, -2, 0}, {2, -2, 0}, {-2, 2, 0}, {2, 2, 0}}));
}

TEST(SquaredStability, LiesWithinTheMortarsOfTwelveRadii) {
  // One map for twelve radii. `missed` counts what the mortar has beyond {stability < r}: none at 12, where the map is
  // cut, and some below.
  RunContext context;
  BinaryVolume image = random_volume({60, 50, 1}, 0.012, 3);
  const BinaryVolume seeds = image;
  for_each_voxel(Index3::Zero(), image.frame.dims, [&](const Index3& p) {
    for_each_voxel(Index3::Zero(), image.frame.dims, [&](const Index3& q) {
      if (seeds(q[0], q[1], 0) != 0 && (p - q).squaredNorm() <= 17 + 13 * (q[0] % 7)) image(p[0], p[1], 0) = 1;
    });
  });
  const Grid<std::int32_t> stability = squared_stability(image, 12, false, context);
  std::int64_t all_missed = 0;
  for (std::int32_t radius = 1; radius <= 12; ++radius) {
    const BinaryVolume mortar = brute_force_mortar(image, radius, false);
    std::int64_t missed = 0;
    for (std::size_t v = 0; v < mortar.values.size(); ++v) {
      const bool less = stability.values[v] < radius * radius;
      ASSERT_LE(less, mortar.values[v] == 1) << radius;
      if (!less && mortar.values[v] == 1) ++missed;
    }
    RecordProperty("missed_at_" + std::to_string(radius), std::to_string(missed));
    all_missed += missed;
    if (radius < 12) continue;
    EXPECT_EQ(missed, 0);
  }
  EXPECT_GT(all_missed, 0);
}

TEST(StabilityRadii, ThatAreLessThanARealRadiusLieWithinItsMortar) {
  // Squares that are integers and others, in one map of every largest radius.
  RunContext context;
  const std::vector<double> kRadii = {0.5, 1, 1.5, 2, 2.3, 3, 4, std::sqrt(17.0), 4.2};
  int solids = 0;
  std::int64_t irregular = 0;
  for (const StabilityCase& c : random_cases(60)) {
    if (!c.volume.frame.is_image() && solids++ % 5 != 0) continue;  // the twin takes its time
    std::vector<BinaryVolume> mortars;
    for (const double radius : kRadii) mortars.push_back(brute_force_mortar(c.volume, radius, c.outside));
    for (const double largest : kRadii) {
      const Grid<float> stability =
          stability_radii(squared_stability(c.volume, largest, c.outside, context), largest, context);
      for (std::size_t r = 0; r < kRadii.size() && kRadii[r] <= largest; ++r) {
        for (std::size_t v = 0; v < stability.values.size(); ++v) {
          const bool less = static_cast<double>(stability.values[v]) < kRadii[r];
          const bool less_as_float = stability.values[v] < static_cast<float>(kRadii[r]);
          const bool in_mortar = mortars[r].values[v] != 0;
          ASSERT_LE(less, in_mortar) << c.name << " radius " << kRadii[r] << " of " << largest;
          ASSERT_LE(less_as_float, in_mortar) << c.name << " radius " << kRadii[r] << " of " << largest;
          if (kRadii[r] != largest) continue;
          ASSERT_EQ(less, in_mortar) << c.name << " radius " << largest;
          ASSERT_EQ(less_as_float, in_mortar) << c.name << " radius " << largest;
          irregular += in_mortar ? 1 : 0;
        }
      }
    }
  }
  EXPECT_GT(irregular, 1000);
}

TEST(FirstMortar, AgreesWithTheMasks) {
  RunContext context;
  const std::vector<double> kRadii = {0, 1, 1.42, 2, 3.3};
  for (const StabilityCase& c : random_cases(100)) {
    Grid<float> expected(c.volume.frame, 0.0F);
    for (const double radius : kRadii) {
      const BinaryVolume mortar = brute_force_mortar(c.volume, radius, c.outside);
      for (std::size_t v = 0; v < mortar.values.size(); ++v) {
        if (expected.values[v] == 0 && mortar.values[v] != 0) expected.values[v] = static_cast<float>(radius);
      }
    }
    ASSERT_EQ(first_mortar(c.volume, kRadii, c.outside, context), expected) << c.name;
    ASSERT_EQ(first_mortar(complement(c.volume), kRadii, !c.outside, context), expected) << c.name;
  }
}

TEST(FirstMortar, NamesTheRadiusAtWhichAStripGoes) {
  // A strip 5 pixels wide, in the middle of 31 x 21: pixel (15, 10) lies 3 from the exterior, so the ball of radius 2
  // fits about it, and that of radius 3 does not. At its end the strip's corner (0, 8) is in the mortar of radius 1 at
  // once: the ball about it leaves the strip, and so do those about (1, 8) and (0, 9).
  RunContext context;
  BinaryVolume strip(frame_of({31, 21, 1}));
  for (std::int64_t j = 8; j < 13; ++j)
    for (std::int64_t i = 0; i < 31; ++i) strip(i, j, 0) = 1;
  const Grid<float> radii = first_mortar(strip, default_stability_radii(), false, context);
  EXPECT_EQ(radii(15, 10, 0), 3);
  EXPECT_EQ(radii(0, 8, 0), 1);
  EXPECT_EQ(radii(15, 2, 0), 0);  // half a plane lies below it
  EXPECT_EQ(default_stability_radii().size(), 12U);
}

TEST(FirstMortar, IsNothingWithoutRadiiAndWithoutABoundary) {
  RunContext context;
  const BinaryVolume volume = random_volume({6, 5, 4}, 0.5, 2);
  EXPECT_EQ(first_mortar(volume, {}, false, context), Grid<float>(volume.frame, 0.0F));
  const BinaryVolume full(volume.frame, 1);
  EXPECT_EQ(first_mortar(full, default_stability_radii(), true, context), Grid<float>(volume.frame, 0.0F));
}

}  // namespace
}  // namespace voxcarve
