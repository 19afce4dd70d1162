// What the image models are painted with: noise, steps and the choice of the darkest pixels.
#include "common/volume/models/picture.h"

#include <gtest/gtest.h>

#include <vector>

namespace voxcarve {
namespace {

TEST(Noise, IsUniformAndInterpolatesItsLattice) {
  const Noise noise(7);
  double sum = 0;
  double squares = 0;
  for (int j = -50; j < 50; ++j) {
    for (int i = -50; i < 50; ++i) {
      const double value = noise.grain(i, j, 3);
      EXPECT_TRUE(value >= -1 && value < 1);
      EXPECT_EQ(noise.smooth(i, j, 3), value);
      sum += value;
      squares += value * value;
    }
  }
  // 10,000 of them: the mean of a uniform value is 0 +- 0.0058 (1 / sqrt(3 n)), that of its square 1/3 +- 0.003.
  EXPECT_NEAR(sum / 10'000, 0, 5 * 0.0058);
  EXPECT_NEAR(squares / 10'000, 1.0 / 3, 5 * 0.003);
  // Halfway between two points lies their mean.
  EXPECT_DOUBLE_EQ(noise.smooth(2.5, -4, 3), (noise.grain(2, -4, 3) + noise.grain(3, -4, 3)) / 2);
  EXPECT_NE(noise.grain(1, 2, 3), noise.grain(2, 1, 3));
  EXPECT_NE(noise.grain(1, 2, 3), noise.grain(1, 2, 4));
  EXPECT_NE(noise.grain(1, 2, 3), Noise(8).grain(1, 2, 3));
  // One octave is the noise itself; the second has half the period and half the weight.
  EXPECT_EQ(noise.fractal(1.3, 2.7, 1, 3), noise.smooth(1.3, 2.7, 3));
  EXPECT_DOUBLE_EQ(noise.fractal(1.3, 2.7, 2, 3), (noise.smooth(1.3, 2.7, 3) + noise.smooth(2.6, 5.4, 4) / 2) / 1.5);
}

TEST(Picture, TakesTheDarkestPixelsAndTheFirstOfEqualOnes) {
  const auto columns = [](std::int64_t i, std::int64_t /*j*/) { return static_cast<double>(i); };
  // Half of 3 x 2 is 3: both pixels of the darkest column, and of the next the lower one.
  const BinaryVolume image = darkest_share(3, 2, 0.5, columns);
  EXPECT_EQ(image.frame.dims, Index3(3, 2, 1));
  EXPECT_EQ(std::vector<int>(image.values.begin(), image.values.end()), (std::vector<int>{0, 1, 1, 0, 0, 1}));
  EXPECT_EQ(count_interior(darkest_share(3, 2, 0, columns)), 0);
  EXPECT_EQ(count_interior(darkest_share(3, 2, 1, columns)), 6);
}

TEST(Picture, StepsSmoothly) {
  EXPECT_EQ(smooth_step(2, 4, 1), 0);
  EXPECT_EQ(smooth_step(2, 4, 2.5), 0.15625);  // 3 (1/4)^2 - 2 (1/4)^3
  EXPECT_EQ(smooth_step(2, 4, 3), 0.5);
  EXPECT_EQ(smooth_step(2, 4, 5), 1);
}

}  // namespace
}  // namespace voxcarve
