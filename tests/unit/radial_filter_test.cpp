// The filters' profiles against their definition, and the layers against all others.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "common/run/errors.h"
#include "methods/he_lowpass/radial_filter.h"
#include "methods/he_lowpass/surface_layers.h"

namespace voxcarve {
namespace {

std::vector<RadialFilter> filters() {
  return {{RadialShape::kGaussian, 0.4},
          {RadialShape::kGaussian, 0.2},
          {RadialShape::kGaussian, 1.5},
          {RadialShape::kHyperCone, 0},
          {RadialShape::kBox, 0}};
}

/// The triple integral of [He95, eq. 5] over a half-space's part of the support, normalised: by the midpoint rule on
/// slices parallel to the plane and rings in them.
double integrated_profile(const RadialFilter& filter, double x) {
  constexpr int kParts = 1000;
  double beyond = 0;
  double all = 0;
  for (int i = 0; i < kParts; ++i) {
    const double z = -1 + 2.0 * (i + 0.5) / kParts;
    const double radius = std::sqrt(1 - z * z);
    double slice = 0;
    for (int k = 0; k < kParts; ++k) {
      const double rho = radius * (k + 0.5) / kParts;
      slice += filter.weight(std::sqrt(z * z + rho * rho)) * rho * radius;
    }
    all += slice;
    if (z > x) beyond += slice;
  }
  return beyond / all;
}

TEST(RadialFilter, WeightsFallFromOneToZero) {
  for (const RadialFilter& filter : filters()) {
    EXPECT_EQ(filter.weight(0), 1);
    EXPECT_EQ(filter.weight(1.0000001), 0);
    for (int i = 1; i <= 100; ++i) EXPECT_LE(filter.weight(i / 100.0), filter.weight((i - 1) / 100.0));
  }
  EXPECT_DOUBLE_EQ((RadialFilter{RadialShape::kGaussian, 0.4}.weight(0.4)), std::exp(-0.5));
  EXPECT_DOUBLE_EQ((RadialFilter{RadialShape::kHyperCone, 0}.weight(0.25)), 0.75);
}

TEST(RadialFilter, ProfilesAreTheIntegralsOfEquationFive) {
  for (const RadialFilter& filter : filters()) {
    // Slices end at multiples of 1 / 500, so that none is cut; each sum is off by its slices' curvature, 2e-6 or less,
    // and near the pole of a box by half a slice.
    for (const double x : {-0.8, -0.3, 0.0, 0.1, 0.35, 0.6, 0.9})
      EXPECT_NEAR(filter.plane_profile(x), integrated_profile(filter, x), 5e-6) << x;
  }
}

TEST(RadialFilter, ProfilesAreSymmetricAboutAHalfAndConvexBeyondThePlane) {
  for (const RadialFilter& filter : filters()) {
    EXPECT_DOUBLE_EQ(filter.plane_profile(0), 0.5);
    EXPECT_EQ(filter.plane_profile(1), 0);
    EXPECT_EQ(filter.plane_profile(-1), 1);
    for (int i = 1; i < 100; ++i) {
      const double x = i / 100.0;
      EXPECT_DOUBLE_EQ(filter.plane_profile(x) + filter.plane_profile(-x), 1);
      EXPECT_LT(filter.plane_profile(x), filter.plane_profile(x - 0.01));
      EXPECT_GE(filter.plane_profile(x - 0.01) - 2 * filter.plane_profile(x) + filter.plane_profile(x + 0.01), -1e-15);
      EXPECT_NEAR(filter.plane_distance(filter.plane_profile(x)), x, 1e-6);
    }
  }
}

TEST(RadialFilter, NamesAreThoseOfTheParameter) {
  EXPECT_EQ(radial_shape_from("gaussian"), RadialShape::kGaussian);
  EXPECT_EQ(radial_shape_from("hyper-cone"), RadialShape::kHyperCone);
  EXPECT_EQ(radial_shape_from("box"), RadialShape::kBox);
  EXPECT_THROW(radial_shape_from("cone"), ParameterError);
}

/// The left side of [He95, eq. 6] by the midpoint rule.
double layer_error(const RadialFilter& filter, const std::vector<SurfaceLayer>& layers) {
  constexpr int kParts = 20000;
  double sum = 0;
  for (int i = 0; i < kParts; ++i) {
    const double x = (i + 0.5) / kParts;
    const auto layer = std::ranges::find_if(layers, [x](const SurfaceLayer& l) { return l.from <= x && x < l.to; });
    sum += std::abs(layer->iso_density - filter.plane_profile(x)) / kParts;
  }
  return sum;
}

/// The least error of any step function whose borders are multiples of 1 / kCells, by dynamic programming: of cells
/// [i, j) the best constant is a median, and cells are so small that d counts as constant on each.
double least_error(const RadialFilter& filter, int count) {
  constexpr std::size_t kCells = 200;
  std::vector<double> d;
  for (std::size_t i = 0; i < kCells; ++i) d.push_back(filter.plane_profile((static_cast<double>(i) + 0.5) / kCells));
  const auto cost = [&d](std::size_t i, std::size_t j) {
    double sum = 0;
    for (std::size_t at = i; at < j; ++at) sum += std::abs(d[at] - d[(i + j) / 2]) / kCells;
    return sum;
  };
  std::vector<double> best(kCells + 1, std::numeric_limits<double>::infinity());
  best[0] = 0;
  for (int layer = 0; layer < count; ++layer) {
    std::vector<double> next(kCells + 1, std::numeric_limits<double>::infinity());
    for (std::size_t j = 1; j <= kCells; ++j)
      for (std::size_t i = 0; i < j; ++i) next[j] = std::min(next[j], best[i] + cost(i, j));
    best = next;
  }
  return best[kCells];
}

TEST(SurfaceLayers, NoOtherStepFunctionIsNearer) {
  for (const RadialFilter& filter : filters()) {
    for (const int count : {1, 2, 3, 5}) {
      const LayerChoice choice = best_layers(filter, count);
      ASSERT_EQ(choice.layers.size(), static_cast<std::size_t>(count));
      EXPECT_NEAR(choice.error, layer_error(filter, choice.layers), 1e-6);
      // The twin's cells are 1/200 wide, and d falls by less than 2 a unit: it may gain or lose a quarter of
      // 2 / 200^2 a cell, 1/400 * 1/100 in all 200 cells, wherever the sign changes within one.
      EXPECT_LE(choice.error, least_error(filter, count) + 1e-4);
    }
  }
}

TEST(SurfaceLayers, AreOrderedAndTheInnermostIsOpaque) {
  for (const RadialFilter& filter : filters()) {
    const std::vector<SurfaceLayer> layers = best_layers(filter, 5).layers;
    EXPECT_EQ(layers.front().from, 0);
    EXPECT_EQ(layers.back().to, 1);
    EXPECT_EQ(layers.front().opacity, 1);
    EXPECT_LT(layers.front().iso_density, 0.5);
    for (std::size_t i = 1; i < layers.size(); ++i) {
      EXPECT_EQ(layers[i].from, layers[i - 1].to);
      EXPECT_LT(layers[i].iso_density, layers[i - 1].iso_density);
      EXPECT_DOUBLE_EQ(layers[i].opacity, layers[i].iso_density / layers[0].iso_density);  // 1 - (1 - d / m)
      EXPECT_GT(layers[i].iso_density, 0);
    }
  }
}

TEST(SurfaceLayers, TheFewestMeetTheBoundAndOneFewerDoesNot) {
  for (const RadialFilter& filter : filters()) {
    for (const double bound : {0.2, 0.05, 0.02, 0.01, 0.001}) {
      const LayerChoice choice = fewest_layers(filter, bound);
      EXPECT_LE(choice.error, bound);
      const auto count = static_cast<std::int64_t>(choice.layers.size());
      if (count > 1) {
        EXPECT_GT(best_layers(filter, count - 1).error, bound);
      }
    }
  }
  EXPECT_THROW(fewest_layers(filters()[0], 1e-9), ParameterError);
}

}  // namespace
}  // namespace voxcarve
