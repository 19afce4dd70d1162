#include "common/volume/gaussian_filter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <stop_token>

#include "common/run/errors.h"
#include "tests/support/shapes.h"

namespace voxcarve {
namespace {

using test::frame_of;

constexpr double kUnit = 0x1p-24;  ///< of rounding a float
constexpr auto kBorders = {BorderRule::kRepeat, BorderRule::kConstant};

/// Values in [-1, 1).
Grid<float> random_field(const Index3& dims, std::uint32_t seed) {
  std::mt19937 random(seed);
  Grid<float> field(frame_of(dims));
  for (float& value : field.values) value = static_cast<float>(random() >> 8) * 0x1p-23F - 1;
  return field;
}

Grid<float> filtered(const Grid<float>& field, const GaussianOptions& options, int threads = 1) {
  RunContext context;
  context.threads = threads;
  return gaussian_filtered(field, options, context);
}

std::int64_t radius_of(const GaussianOptions& options, int axis) {
  return options.sigma[axis] > 0 ? static_cast<std::int64_t>(options.support[axis]) : 0;
}

/// What a field of values of at most 1 may be off by. Of one pass over r samples on either side: rounding a weight w to
/// a float, adding the two samples, subtracting twice the middle one and multiplying are off by 1/2 4 w, 2 w, 6 w / 2
/// and 4 w / 2 units at most, together less than 14 w, and all w of a side add up to at most 1/2: 7 units. Adding the r
/// terms is off by 2 units each, as partial sums are at most 2, and adding the middle sample by 1. Passes do not
/// enlarge what earlier ones were off by.
double most_error(const GaussianOptions& options) {
  double units = 0;
  for (int axis = 0; axis < 3; ++axis) units += 2 * static_cast<double>(radius_of(options, axis)) + 8;
  constexpr double kSecondOrder = 1.001;
  return units * kUnit * kSecondOrder;
}

/// The weights of all samples along an axis in reach, first to last.
std::vector<double> slow_weights(const GaussianOptions& options, int axis) {
  const std::int64_t radius = radius_of(options, axis);
  std::vector<double> weights;
  double total = 0;
  for (std::int64_t step = -radius; step <= radius; ++step) {
    const double distance = static_cast<double>(step);
    const double sigma = options.sigma[axis];
    weights.push_back(step == 0 ? 1 : std::exp(-distance * distance / (2 * sigma * sigma)));
    total += weights.back();
  }
  for (double& weight : weights) weight /= total;
  return weights;
}

/// The slow twin: every sample in reach of every voxel, in doubles.
Grid<double> slow_gaussian(const Grid<float>& field, const GaussianOptions& options) {
  const std::array<std::vector<double>, 3> weights = {slow_weights(options, 0), slow_weights(options, 1),
                                                      slow_weights(options, 2)};
  const Index3 radius(radius_of(options, 0), radius_of(options, 1), radius_of(options, 2));
  const auto sample = [&](const Index3& at) -> double {
    if (options.border == BorderRule::kConstant) return field.get(at[0], at[1], at[2], options.outside);
    const Index3 nearest = at.cwiseMax(0).cwiseMin(field.frame.dims - Index3::Ones());
    return field(nearest[0], nearest[1], nearest[2]);
  };
  Grid<double> result(field.frame);
  Index3 at;
  for (at[2] = 0; at[2] < field.nz(); ++at[2]) {
    for (at[1] = 0; at[1] < field.ny(); ++at[1]) {
      for (at[0] = 0; at[0] < field.nx(); ++at[0]) {
        double sum = 0;
        Index3 step;
        for (step[2] = -radius[2]; step[2] <= radius[2]; ++step[2]) {
          for (step[1] = -radius[1]; step[1] <= radius[1]; ++step[1]) {
            for (step[0] = -radius[0]; step[0] <= radius[0]; ++step[0]) {
              const auto of = [&](int axis) {
                return weights.at(static_cast<std::size_t>(axis))
                    .at(static_cast<std::size_t>(step[axis] + radius[axis]));
              };
              sum += of(0) * of(1) * of(2) * sample(at + step);
            }
          }
        }
        result(at[0], at[1], at[2]) = sum;
      }
    }
  }
  return result;
}

double greatest_difference(const Grid<float>& a, const auto& b) {
  double greatest = 0;
  for (std::size_t v = 0; v < a.values.size(); ++v)
    greatest = std::max(greatest, std::abs(static_cast<double>(a.values[v]) - static_cast<double>(b.values[v])));
  return greatest;
}

/// The field with its axes in another order: axis a of the result is order[a] of the field, backward where `flip` says.
Grid<float> turned(const Grid<float>& field, const std::array<int, 3>& order, const std::array<bool, 3>& flip = {}) {
  Index3 dims;
  for (std::size_t a = 0; a < 3; ++a) dims[static_cast<int>(a)] = field.frame.dims[order[a]];
  Grid<float> result(frame_of(dims));
  Index3 at;
  for (at[2] = 0; at[2] < dims[2]; ++at[2]) {
    for (at[1] = 0; at[1] < dims[1]; ++at[1]) {
      for (at[0] = 0; at[0] < dims[0]; ++at[0]) {
        Index3 from;
        for (std::size_t a = 0; a < 3; ++a) {
          const std::int64_t i = at[static_cast<int>(a)];
          from[order[a]] = flip[a] ? dims[static_cast<int>(a)] - 1 - i : i;
        }
        result(at[0], at[1], at[2]) = field(from[0], from[1], from[2]);
      }
    }
  }
  return result;
}

TEST(GaussianWeights, AreTheNormalisedValuesOfTheGaussian) {
  // sigma 1: e^-1/2 and e^-2 over 1 + 2 e^-1/2 + 2 e^-2.
  const double total = 1 + 2 * std::exp(-0.5) + 2 * std::exp(-2);
  const std::vector<float> expected = {static_cast<float>(std::exp(-0.5) / total),
                                       static_cast<float>(std::exp(-2) / total)};
  EXPECT_EQ(gaussian_weights(1, 2), expected);
  EXPECT_EQ(gaussian_weights(1, 2.99), expected);
  EXPECT_TRUE(gaussian_weights(1, 0.99).empty());
  EXPECT_TRUE(gaussian_weights(0, 5).empty());
}

TEST(GaussianWeights, HaveTheVarianceOfTheGaussian) {
  // Sampled at integers a Gaussian keeps its variance but for 4 pi^2 sigma^4 e^(-2 pi^2 sigma^2), for sigma 1 a
  // hundred-millionth of it; cut off at 8 sigma nothing is lost to float. Every weight is rounded by a unit.
  for (const double sigma : {1.0, 1.7, 3.0}) {
    const std::vector<float> weights = gaussian_weights(sigma, 8 * sigma);
    double variance = 0;
    for (std::size_t step = 1; step <= weights.size(); ++step)
      variance += 2 * static_cast<double>(step * step) * static_cast<double>(weights[step - 1]);
    EXPECT_NEAR(variance, sigma * sigma, sigma * sigma * (kUnit + 2e-7));
  }
}

TEST(GaussianWeights, EndWhereFloatsDo) {
  // e^(-13^2 / 2) / 2.507 = 8e-38 is a normal float, e^(-14^2 / 2) / 2.507 = 1e-43 is not.
  EXPECT_EQ(gaussian_weights(1, 100).size(), 13U);
  EXPECT_EQ(gaussian_weights(1e9, 16384).size(), 16384U);
}

TEST(GaussianWeights, RefuseWhatIsNoLength) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const double sigma : {-1.0, kNaN, kInfinity}) EXPECT_THROW(gaussian_weights(sigma, 2), ParameterError);
  for (const double support : {-1.0, kNaN, kInfinity, 16385.0})
    EXPECT_THROW(gaussian_weights(1, support), ParameterError);
  RunContext context;
  GaussianOptions options;
  options.sigma[1] = -1;
  EXPECT_THROW(gaussian_filtered(Grid<float>(frame_of({2, 2, 2})), options, context), ParameterError);
}

TEST(GaussianFilter, AgreesWithTheTripleSum) {
  std::mt19937 random(1);
  const auto below = [&](std::uint32_t limit) { return static_cast<std::int64_t>(random() % limit); };
  for (std::uint32_t seed = 0; seed < test::case_count(60U); ++seed) {
    // At most 9 along z: an image would not be filtered along it, for the twin does not know images.
    const Index3 dims(1 + below(40), 1 + below(9), 2 + below(8));
    const Grid<float> field = random_field(dims, seed);
    for (const BorderRule border : kBorders) {
      GaussianOptions options;
      options.border = border;
      options.outside = 0.75F;
      for (int axis = 0; axis < 3; ++axis) {
        options.sigma[axis] = 0.3 * static_cast<double>(below(8));
        options.support[axis] = 0.5 * static_cast<double>(below(9));
      }
      EXPECT_LE(greatest_difference(filtered(field, options), slow_gaussian(field, options)), most_error(options))
          << "seed " << seed << " sigma " << options.sigma.transpose() << " support " << options.support.transpose();
    }
  }
}

TEST(GaussianFilter, AgreesWithTheTripleSumWhereItIsCutIntoPieces) {
  // Columns of at most 128 x 64 voxels, and where these are few, cut along z as well.
  for (const Index3& dims :
       {Index3(129, 3, 4), Index3(261, 66, 2), Index3(3, 131, 3), Index3(4, 3, 200), Index3(140, 3, 80)}) {
    const Grid<float> field = random_field(dims, 7);
    for (const BorderRule border : kBorders) {
      const GaussianOptions options{.sigma = {1.5, 1, 0.8}, .support = {4, 3, 2}, .border = border, .outside = -0.5F};
      EXPECT_LE(greatest_difference(filtered(field, options, 2), slow_gaussian(field, options)), most_error(options))
          << dims.transpose();
    }
  }
}

TEST(GaussianFilter, ReachesFartherThanTheGrid) {
  for (const Index3& dims : {Index3(1, 1, 2), Index3(5, 1, 3), Index3(2, 6, 4)}) {
    const Grid<float> field = random_field(dims, 3);
    for (const BorderRule border : kBorders) {
      const GaussianOptions options{
          .sigma = Point::Constant(5), .support = {20, 17, 19}, .border = border, .outside = 0.25F};
      EXPECT_LE(greatest_difference(filtered(field, options), slow_gaussian(field, options)), most_error(options))
          << dims.transpose();
    }
  }
}

TEST(GaussianFilter, KeepsConstantsToTheBit) {
  for (const float value : {0.1F, 1.0F, -3.7e5F, 1e-30F, 0.0F}) {
    for (const BorderRule border : kBorders) {
      const Grid<float> field(frame_of({37, 21, 12}), value);
      const GaussianOptions options{.sigma = {2, 0.7, 3.1}, .support = {8, 3, 11}, .border = border, .outside = value};
      EXPECT_EQ(filtered(field, options), field) << value;
    }
  }
}

TEST(GaussianFilter, ChangesNothingBeyondItsSupport) {
  // A step between x = 19 and 20: within 6 voxels of it values lie in between and rise; elsewhere they are kept.
  Grid<float> field(frame_of({40, 9, 9}), 0.3F);
  for (std::int64_t k = 0; k < 9; ++k)
    for (std::int64_t j = 0; j < 9; ++j) std::fill_n(&field(20, j, k), 20, 0.9F);
  const Grid<float> result = filtered(field, {.sigma = Point::Constant(2), .support = Point::Constant(6)});
  for (std::int64_t k = 0; k < 9; ++k) {
    for (std::int64_t j = 0; j < 9; ++j) {
      for (std::int64_t i = 0; i < 40; ++i) {
        if (i <= 13 || i >= 26) {
          EXPECT_EQ(result(i, j, k), field(i, j, k));
        }
        if (i > 13 && i <= 26) {
          EXPECT_GT(result(i, j, k), result(i - 1, j, k));
        }
      }
    }
  }
}

TEST(GaussianFilter, SpreadsAnImpulse) {
  Grid<float> field(frame_of({21, 23, 25}));
  field(10, 11, 12) = 1;
  const GaussianOptions options{.sigma = {1.2, 2, 1.6}, .support = {6, 8, 7}};
  const Grid<float> result = filtered(field, options);
  const Grid<double> expected = slow_gaussian(field, options);
  double sum = 0;
  for (std::size_t v = 0; v < result.values.size(); ++v) {
    sum += static_cast<double>(result.values[v]);
    EXPECT_EQ(result.values[v] == 0, expected.values[v] == 0);
    EXPECT_GE(result.values[v], 0);
  }
  // Weights are implied to add up to 1. Of a pass over r samples on either side, the products of an impulse are off by
  // a unit of each, which add up to less than one, and its middle by r + 1 units of the differences that are taken
  // away.
  EXPECT_NEAR(sum, 1, (6 + 8 + 7 + 6) * kUnit * 1.001);
  for (const std::array<bool, 3>& flip :
       {std::array{true, false, false}, std::array{false, true, false}, std::array{false, false, true}})
    EXPECT_EQ(turned(result, {0, 1, 2}, flip), result);
}

TEST(GaussianFilter, MirrorsWithItsField) {
  const Grid<float> field = random_field({143, 70, 37}, 11);
  for (const BorderRule border : kBorders) {
    const GaussianOptions options{.sigma = {1.2, 2, 1.6}, .support = {6, 8, 7}, .border = border};
    const Grid<float> result = filtered(field, options);
    for (const std::array<bool, 3>& flip :
         {std::array{true, false, false}, std::array{false, true, false}, std::array{true, true, true}})
      EXPECT_EQ(filtered(turned(field, {0, 1, 2}, flip), options), turned(result, {0, 1, 2}, flip));
  }
}

TEST(GaussianFilter, AgreesInAnyOrderOfAxes) {
  // Each is off by most_error at most.
  const Grid<float> field = random_field({30, 41, 22}, 12);
  for (const BorderRule border : kBorders) {
    const GaussianOptions options{.sigma = {1.2, 2, 0.9}, .support = {5, 8, 3}, .border = border, .outside = 1};
    const Grid<float> result = filtered(field, options);
    for (const std::array<int, 3>& order : {std::array{1, 2, 0}, std::array{2, 1, 0}, std::array{1, 0, 2}}) {
      GaussianOptions in_order = options;
      for (std::size_t a = 0; a < 3; ++a) {
        in_order.sigma[static_cast<int>(a)] = options.sigma[order[a]];
        in_order.support[static_cast<int>(a)] = options.support[order[a]];
      }
      EXPECT_LE(greatest_difference(filtered(turned(field, order), in_order), turned(result, order)),
                2 * most_error(options));
    }
  }
}

TEST(GaussianFilter, LeavesImagesAsTheyAreAlongZ) {
  const Grid<float> image = random_field({150, 40, 1}, 4);
  for (const BorderRule border : kBorders) {
    const GaussianOptions options{.sigma = {2, 1, 3}, .support = {7, 4, 9}, .border = border, .outside = 5};
    GaussianOptions flat = options;
    flat.sigma[2] = 0;
    flat.outside = options.outside;
    const Grid<float> result = filtered(image, options);
    EXPECT_EQ(result, filtered(image, flat));
    EXPECT_LE(greatest_difference(result, slow_gaussian(image, flat)), 5 * most_error(flat));
  }
}

TEST(GaussianFilter, LeavesAFieldThatNoAxisIsFilteredOf) {
  const Grid<float> field = random_field({33, 5, 4}, 5);
  EXPECT_EQ(filtered(field, {.sigma = Point::Zero()}), field);
  EXPECT_EQ(filtered(field, {.support = Point::Constant(0.9)}), field);
  for (const Index3& dims : {Index3(0, 0, 0), Index3(0, 3, 2), Index3(3, 0, 2), Index3(3, 2, 0)}) {
    const Grid<float> empty(frame_of(dims));
    EXPECT_EQ(filtered(empty, {}), empty);
  }
}

TEST(GaussianFilter, KeepsTheFrame) {
  Grid<float> field(frame_of({4, 3, 2}, {1, 2, 3}, 0.5), 1);
  EXPECT_EQ(filtered(field, {}).frame, field.frame);
}

TEST(GaussianFilter, GivesTheSameOnOneThreadAndOnTwo) {
  for (const Index3& dims : {Index3(290, 140, 20), Index3(40, 30, 160)}) {
    const Grid<float> field = random_field(dims, 6);
    const GaussianOptions options{.sigma = Point::Constant(1.5), .support = {6, 5, 4}};
    EXPECT_EQ(filtered(field, options, 1), filtered(field, options, 2));
  }
}

TEST(GaussianFilter, ReportsProgressToTheEndAndCanBeCancelled) {
  const Grid<float> field = random_field({140, 70, 30}, 8);
  RunContext context;
  std::int64_t last = -1;
  std::int64_t total = 0;
  context.progress = [&](const ProgressEvent& event) {
    EXPECT_GE(event.done, last);
    last = event.done;
    total = event.total;
  };
  gaussian_filtered(field, {}, context);
  EXPECT_EQ(last, total);
  EXPECT_EQ(total, 2 * 2 * 30);  // columns of 128 x 64 voxels
  std::stop_source stop;
  context.cancellation = stop.get_token();
  context.progress = [&](const ProgressEvent& event) {
    last = event.done;
    if (event.done > event.total / 2) stop.request_stop();
  };
  EXPECT_THROW(gaussian_filtered(field, {}, context), Cancelled);
  EXPECT_LT(last, total);
}

TEST(GaussianFilter, AsksForItsMemoryBeforeItTakesAny) {
  // The field and the result, 4 bytes a voxel, and for 9 slices in reach 128 x 64 samples each; rows and lists are
  // less than another slice.
  const Grid<float> field = random_field({256, 128, 20}, 9);
  RunContext context;
  gaussian_filtered(field, {}, context);
  const std::uint64_t bytes = context.timings().back().bytes;
  const std::uint64_t slices = std::uint64_t{128} * 64 * 4;
  EXPECT_GE(bytes, 8 * field.values.size() + 9 * slices);
  EXPECT_LE(bytes, 8 * field.values.size() + 11 * slices);
  context.memory_budget = bytes;
  EXPECT_NO_THROW(gaussian_filtered(field, {}, context));
  --context.memory_budget;
  EXPECT_THROW(gaussian_filtered(field, {}, context), ResourceError);
}

}  // namespace
}  // namespace voxcarve
