#include "common/volume/supersampling.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "common/mesh/models/primitives.h"
#include "common/run/errors.h"
#include "tests/support/shapes.h"

namespace voxcarve {
namespace {

using test::frame_of;
using test::joined;

std::vector<SupersamplingOptions> all_samplings() {
  std::vector<SupersamplingOptions> all;
  for (const FilterKernel kernel : {FilterKernel::kBox, FilterKernel::kGaussian}) {
    for (int samples = 1; samples <= 3; ++samples) all.push_back({samples, kernel});
  }
  return all;
}

DensityVolume density_with(const TriangleSoup& soup, const GridFrame& frame, const SupersamplingOptions& sampling,
                           int threads = 1) {
  RunContext context;
  context.threads = threads;
  return voxelize_density(soup, frame, {}, sampling, context);
}

/// A tilted ring and a ball through it, within [0.4, 20]^3.
TriangleSoup shape() {
  const Eigen::AngleAxisd turn(0.7, Point(0.3, 1.1, -0.7).normalized());
  return joined({transformed(torus(6, 2.3, 17, 9), Eigen::Translation3d(10.13, 9.77, 9.31) * Eigen::Affine3d(turn)),
                 icosphere(Point(4.1, 10.2, 9.4), 3.2, 2)});
}

/// The same without every seventh triangle: rays disagree, votes are settled.
TriangleSoup open_shape() {
  TriangleSoup soup = shape();
  std::size_t index = 0;
  std::erase_if(soup.triangles, [&](const Triangle&) { return index++ % 7 == 0; });
  return soup;
}

/// Offsets from a voxel's centre, in voxels, of the samples that count for it along an axis.
std::vector<double> sample_offsets(const SupersamplingOptions& sampling) {
  std::vector<double> offsets;
  for (int m = -4 * sampling.samples; m <= 4 * sampling.samples; ++m) {
    const double offset = (sampling.samples % 2 == 0 ? m + 0.5 : m) / sampling.samples;
    if (std::abs(offset) <= (sampling.kernel == FilterKernel::kBox ? 0.5 : 2.0)) offsets.push_back(offset);
  }
  return offsets;
}

/// Weights that sum to 1.
std::vector<double> real_weights(const SupersamplingOptions& sampling) {
  std::vector<double> weights;
  for (const double offset : sample_offsets(sampling)) {
    weights.push_back(sampling.kernel == FilterKernel::kBox ? 1 : std::exp(-0.5 * std::pow(offset / 0.7, 2)));
  }
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  for (double& weight : weights) weight /= sum;
  return weights;
}

/// The same as integers: of the box all ones, of the Gaussian the nearest ones to 1024 times each, of which the middle
/// one takes what is missing of 1024.
std::vector<std::int64_t> integer_weights(const SupersamplingOptions& sampling) {
  std::vector<std::int64_t> weights;
  for (const double weight : real_weights(sampling)) {
    weights.push_back(sampling.kernel == FilterKernel::kBox ? 1 : std::llround(1024 * weight));
  }
  if (sampling.kernel == FilterKernel::kGaussian) {
    const std::int64_t missing = 1024 - std::accumulate(weights.begin(), weights.end(), std::int64_t{0});
    const std::size_t middle = weights.size() / 2;
    if (weights.size() % 2 != 0) {
      weights[middle] += missing;
    } else {
      EXPECT_EQ(missing, 0);
    }
  }
  return weights;
}

TEST(Supersampling, WeightsAreTheRoundedGaussian) {
  for (const SupersamplingOptions& sampling : all_samplings()) {
    const SampleKernel kernel = sample_kernel(sampling);
    const std::vector<std::int64_t> expected = integer_weights(sampling);
    ASSERT_EQ(kernel.weights.size(), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) {
      EXPECT_EQ(kernel.weights[i], expected[i]) << i;
      EXPECT_EQ(kernel.weights[i], kernel.weights[expected.size() - 1 - i]);
    }
    EXPECT_EQ(kernel.total, std::accumulate(expected.begin(), expected.end(), std::int64_t{0}));
    EXPECT_LT(std::pow(kernel.total, 3), 0x1p32);
  }
}

TEST(Supersampling, IntegerWeightsMoveNoDensityByHalfAPercent) {
  // Two densities of the same samples differ most when just those samples are interior whose weight grew: by the sum of
  // all growths. (All weights sum to one either way, so the others shrank by the same sum.)
  for (const SupersamplingOptions& sampling : all_samplings()) {
    const std::vector<double> real = real_weights(sampling);
    const SampleKernel kernel = sample_kernel(sampling);
    double growth = 0;
    for (std::size_t i = 0; i < real.size(); ++i) {
      for (std::size_t j = 0; j < real.size(); ++j) {
        for (std::size_t k = 0; k < real.size(); ++k) {
          const double weight = kernel.weights[i] * kernel.weights[j] * kernel.weights[k] / std::pow(kernel.total, 3);
          growth += std::max(weight - real[i] * real[j] * real[k], 0.0);
        }
      }
    }
    EXPECT_LT(growth, 0.005);
  }
}

/// The slow twin: for every voxel the sum over all samples in reach, at the positions that the offsets name.
DensityVolume twin(const TriangleSoup& soup, const GridFrame& frame, const VoxelizeOptions& options,
                   const SupersamplingOptions& sampling, VoxelizeReport& report) {
  const bool box = sampling.kernel == FilterKernel::kBox;
  DensityVolume density(box ? frame : padded(frame, 2));
  // Samples fill the densities' grid and, for the Gaussian, 2 voxels around it.
  const std::int64_t reach = box ? 0 : 2;
  GridFrame fine;
  fine.dims = (density.frame.dims + Index3::Constant(2 * reach)) * sampling.samples;
  fine.voxel_size = frame.voxel_size / sampling.samples;
  fine.origin = density.frame.origin - Point::Constant(static_cast<double>(reach) * frame.voxel_size);
  RunContext context;
  const BinaryVolume samples = voxelize(soup, fine, options, context, &report);
  const std::vector<double> offsets = sample_offsets(sampling);
  const std::vector<std::int64_t> weights = integer_weights(sampling);
  const std::int64_t total = std::accumulate(weights.begin(), weights.end(), std::int64_t{0});
  // Voxel i has its centre at i + 1/2 voxels, sample s at (s + 1/2) / samples - reach.
  const auto sample_at = [&](std::int64_t voxel, double offset) {
    const double position = static_cast<double>(voxel + reach) + 0.5 + offset;
    return std::llround(position * sampling.samples - 0.5);
  };
  const auto taps = offsets.size();
  for (std::int64_t k = 0; k < density.nz(); ++k) {
    for (std::int64_t j = 0; j < density.ny(); ++j) {
      for (std::int64_t i = 0; i < density.nx(); ++i) {
        std::int64_t sum = 0;
        for (std::size_t tap = 0; tap < taps * taps * taps; ++tap) {
          const std::array<std::size_t, 3> at = {tap % taps, tap / taps % taps, tap / taps / taps};
          const std::int64_t weight = weights[at[0]] * weights[at[1]] * weights[at[2]];
          sum += weight *
                 samples(sample_at(i, offsets[at[0]]), sample_at(j, offsets[at[1]]), sample_at(k, offsets[at[2]]));
        }
        density(i, j, k) = static_cast<float>(static_cast<double>(sum) / static_cast<double>(total * total * total));
      }
    }
  }
  return density;
}

TEST(Supersampling, AgreesWithTheTripleSum) {
  // Rows of 23 voxels end within a run of 16 and the words of their samples, 42 slices are more than a slab; a part of
  // the model lies outside.
  const GridFrame frame = frame_of({23, 9, 42}, Point(1, 6, 2.5), 0.4);
  for (const TriangleSoup& soup : {shape(), open_shape()}) {
    for (const SupersamplingOptions& sampling : all_samplings()) {
      SCOPED_TRACE(testing::Message() << sampling.samples << " kernel " << static_cast<int>(sampling.kernel));
      RunContext context;
      VoxelizeReport expected_report;
      VoxelizeReport report;
      const DensityVolume expected = twin(soup, frame, {}, sampling, expected_report);
      const DensityVolume density = voxelize_density(soup, frame, {}, sampling, context, &report);
      ASSERT_EQ(density, expected);
      EXPECT_EQ(report.settled_voxels, expected_report.settled_voxels);
      ASSERT_EQ(report.axes.size(), 3U);
      EXPECT_EQ(report.axes[1].columns, expected_report.axes[1].columns);
      EXPECT_EQ(report.axes[1].invalid_columns, expected_report.axes[1].invalid_columns);
    }
  }
}

TEST(Supersampling, AgreesWithTheTripleSumForOtherOptions) {
  const GridFrame frame = frame_of({20, 7, 9}, Point(0, 7, 6));
  const SupersamplingOptions sampling{3, FilterKernel::kGaussian};
  for (const VoxelizeOptions& options :
       {VoxelizeOptions{.classifier = Classifier::kStabbing, .directions = 13},
        VoxelizeOptions{.directions = 1, .axis = 0}, VoxelizeOptions{.directions = 3, .settle_sweeps = 0}}) {
    RunContext context;
    VoxelizeReport report;
    EXPECT_EQ(voxelize_density(open_shape(), frame, options, sampling, context),
              twin(open_shape(), frame, options, sampling, report));
  }
}

TEST(Supersampling, OneSampleAndTheBoxGiveTheVoxelization) {
  const GridFrame frame = frame_of({40, 38, 37}, Point(0.1, 0.2, 0.3), 0.5);
  RunContext context;
  const BinaryVolume volume = voxelize(shape(), frame, {}, context);
  const DensityVolume density = density_with(shape(), frame, {});
  EXPECT_EQ(density.frame, frame);
  EXPECT_TRUE(std::ranges::equal(density.values, volume.values));
}

TEST(Supersampling, AFlatFaceGivesTheRunningSumOfTheKernel) {
  // A face between voxels 9 and 10 of a long box, three samples. The centre of voxel 9 lies half a voxel before it, so
  // samples at offsets -6/3 ... 1/3 are interior: 3 + 11 + 32 + 70 + 124 + 174 + 196 + 174 = 784 of 1024. Voxel 10 has
  // the others' share, 240. Voxel 8, one and a half voxels before the face, misses the samples at 5/3 and 6/3, of
  // weights 11 and 3, and voxel 11 has only their mirror images.
  const TriangleSoup soup = box(Point(-10, -10, -10), Point(10, 30, 30));
  const DensityVolume density = density_with(soup, frame_of({20, 8, 8}), {3, FilterKernel::kGaussian});
  const auto at = [&](std::int64_t voxel) { return density(voxel + 2, 6, 6) * 1024; };
  EXPECT_EQ(at(7), 1024);
  EXPECT_EQ(at(8), 1024 - 14);
  EXPECT_EQ(at(9), 784);
  EXPECT_EQ(at(10), 240);
  EXPECT_EQ(at(11), 14);
  EXPECT_EQ(at(12), 0);
}

TEST(Supersampling, DensitiesLieBetweenNoneAndAll) {
  for (const SupersamplingOptions& sampling : all_samplings()) {
    const DensityVolume density = density_with(shape(), frame_of({40, 40, 40}, Point::Zero(), 0.5), sampling);
    const auto [low, high] = std::ranges::minmax(density.values);
    EXPECT_EQ(low, 0.0F);
    EXPECT_EQ(high, 1.0F);
  }
}

TEST(Supersampling, TheGaussianPadsTheGridByTwoVoxelsAndSeesBeyondIt) {
  const GridFrame whole = frame_of({24, 22, 20}, Point(-1, -1, -1));
  const GridFrame part = frame_of({7, 5, 6}, Point(3, 7, 5));  // within the model
  for (const SupersamplingOptions& sampling : all_samplings()) {
    const DensityVolume density = density_with(shape(), whole, sampling);
    if (sampling.kernel == FilterKernel::kGaussian) {
      EXPECT_EQ(density.frame.dims, Index3(28, 26, 24));
      EXPECT_EQ(density.frame.origin, Point(-3, -3, -3));
      EXPECT_EQ(density.frame.voxel_size, 1);
    } else {
      EXPECT_EQ(density.frame, whole);
    }
    const DensityVolume of_part = density_with(shape(), part, sampling);
    EXPECT_EQ(of_part, resized(density, of_part.frame));
  }
}

TEST(Supersampling, APartOfAGridHasThePartsDensityHoweverItsRowsEndAmongTheRuns) {
  // The soup fills the margin of samples, so that runs of 16 voxels see interior beyond the end of a row of any length.
  const TriangleSoup everywhere = box(Point(-100, -100, -100), Point(100, 100, 100));
  const GridFrame whole = frame_of({48, 4, 4}, Point(-4, 8, 8));
  for (const TriangleSoup& soup : {everywhere, joined({shape(), box(Point(22, -3, -3), Point(99, 30, 30))})}) {
    for (const SupersamplingOptions& sampling : all_samplings()) {
      const DensityVolume density = density_with(soup, whole, sampling);
      for (std::int64_t nx = 1; nx <= 40; ++nx) {
        const DensityVolume of_part = density_with(soup, frame_of({nx, 2, 2}, Point(0, 9, 9)), sampling);
        ASSERT_EQ(of_part, resized(density, of_part.frame)) << nx << " voxels, " << sampling.samples << " samples";
      }
    }
  }
  EXPECT_EQ(std::ranges::min(density_with(everywhere, whole, {3, FilterKernel::kGaussian}).values), 1.0F);
}

TEST(Supersampling, MovingTheModelByVoxelsMovesTheDensity) {
  // By a power of two, coordinates keep their digits on the lattice.
  const GridFrame frame = frame_of({40, 24, 24});
  const TriangleSoup moved = transformed(shape(), Eigen::Affine3d(Eigen::Translation3d(16, 2, 4)));
  for (const SupersamplingOptions& sampling : all_samplings()) {
    const DensityVolume density = density_with(shape(), frame, sampling);
    DensityVolume back = density_with(moved, frame_of({40, 24, 24}, Point(16, 2, 4)), sampling);
    EXPECT_EQ(back.values, density.values);
    back = density_with(moved, frame, sampling);
    for (std::int64_t k = 4; k < density.nz(); ++k) {
      for (std::int64_t j = 2; j < density.ny(); ++j) {
        for (std::int64_t i = 16; i < density.nx(); ++i) {
          ASSERT_EQ(back(i, j, k), density(i - 16, j - 2, k - 4));
        }
      }
    }
  }
}

TEST(Supersampling, ASymmetricModelHasASymmetricDensity) {
  // A ball of corners off the samples' lattice: mirrored in every axis, and the axes exchanged in a circle.
  const TriangleSoup ball = icosphere(Point::Constant(8), 5.37, 3);
  for (const SupersamplingOptions& sampling : all_samplings()) {
    const DensityVolume density = density_with(ball, frame_of({16, 16, 16}), sampling);
    const std::int64_t n = density.nx();
    for (std::int64_t k = 0; k < n; ++k) {
      for (std::int64_t j = 0; j < n; ++j) {
        for (std::int64_t i = 0; i < n; ++i) {
          ASSERT_EQ(density(i, j, k), density(n - 1 - i, j, k));
          ASSERT_EQ(density(i, j, k), density(i, n - 1 - j, k));
          ASSERT_EQ(density(i, j, k), density(i, j, n - 1 - k));
          ASSERT_EQ(density(i, j, k), density(j, k, i));
        }
      }
    }
  }
}

TEST(Supersampling, DensitiesSumToTheVolume) {
  // Every sample counts with weights that sum to about one voxel's share, so the sum is the number of interior samples.
  // Of these, the 4 pi r^2 about the surface are decided by chance, each with a variance of at most 1/4: with r = 19
  // voxels and one sample a voxel, five standard deviations are 5 sqrt(pi) r / (4/3 pi r^3) = 0.6 % of the volume.
  const TriangleSoup ball = icosphere(Point::Constant(20.1), 19, 4);
  for (const SupersamplingOptions& sampling : all_samplings()) {
    const DensityVolume density = density_with(ball, frame_of({40, 40, 40}), sampling);
    const double sum = std::accumulate(density.values.begin(), density.values.end(), 0.0);
    const double radius = 19.0 * sampling.samples;
    EXPECT_NEAR(sum / signed_volume(ball), 1, 5 * std::sqrt(M_PI) * radius / (4.0 / 3 * M_PI * std::pow(radius, 3)));
  }
}

TEST(Supersampling, GivesTheSameDensitiesOnAnyNumberOfThreads) {
  const GridFrame frame = frame_of({40, 38, 70}, Point(0, 0, 0), 0.3);
  for (const SupersamplingOptions& sampling : all_samplings()) {
    EXPECT_EQ(density_with(open_shape(), frame, sampling, 1), density_with(open_shape(), frame, sampling, 3));
  }
}

TEST(Supersampling, RefusesWhatItDoesNotKnow) {
  const GridFrame frame = frame_of({4, 4, 4});
  EXPECT_THROW(density_with(shape(), frame, {0, FilterKernel::kBox}), ParameterError);
  EXPECT_THROW(density_with(shape(), frame, {4, FilterKernel::kGaussian}), ParameterError);
  EXPECT_EQ(filter_kernel_from("box"), FilterKernel::kBox);
  EXPECT_EQ(filter_kernel_from("gaussian"), FilterKernel::kGaussian);
  EXPECT_THROW(filter_kernel_from("cone"), ParameterError);
}

TEST(Supersampling, RefusesAGridWithoutVoxels) {
  for (const SupersamplingOptions& sampling : all_samplings()) {
    EXPECT_THROW(density_with(shape(), frame_of({0, 4, 4}), sampling), InputError);
  }
}

TEST(Supersampling, AsksForItsMemoryBeforeItAllocates) {
  RunContext context;
  context.memory_budget = 1 << 20;
  EXPECT_THROW(voxelize_density(shape(), frame_of({2048, 2048, 2048}), {}, {3, FilterKernel::kGaussian}, context),
               ResourceError);
}

TEST(Supersampling, HoldsLessThanFourBytesAVoxelBesideTheDensities) {
  // 27 bits, in words, are 3.4 bytes; grids of 256^3 have hardly more for the margin and the workspaces.
  const GridFrame frame = frame_of({256, 256, 256}, Point::Zero(), 20.0 / 256);
  RunContext context;
  voxelize_density(shape(), frame, {}, {3, FilterKernel::kBox}, context);
  ASSERT_EQ(context.timings().size(), 2U);
  for (const StageTiming& timing : context.timings()) {
    EXPECT_LT(static_cast<double>(timing.bytes) / static_cast<double>(frame.voxels()), 4 + 4) << timing.stage;
  }
}

}  // namespace
}  // namespace voxcarve
