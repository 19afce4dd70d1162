// The filter against its definition, a sum over taps at every grid point.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "common/mesh/models/procedural.h"
#include "common/run/errors.h"
#include "methods/he_lowpass/low_pass.h"
#include "tests/support/shapes.h"

namespace voxcarve {
namespace {

Model ball_model(const Point& center, double radius) {
  ImplicitSolid ball;
  ball.inside = [=](const Point& p) { return (p - center).norm() <= radius; };
  ball.clearance = [=](const Point& p) { return std::abs((p - center).norm() - radius); };
  ball.box.extend(center - Point::Constant(radius));
  ball.box.extend(center + Point::Constant(radius));
  return {"ball", ball};
}

/// Inside is {normal . p <= offset}.
Model half_space(const Point& normal, double offset) {
  ImplicitSolid solid;
  solid.inside = [=](const Point& p) { return normal.dot(p) <= offset; };
  solid.clearance = [=](const Point& p) { return std::abs(normal.dot(p) - offset) / normal.norm() * (1 - 1e-12); };
  solid.box.extend(Point::Constant(-1));
  solid.box.extend(Point::Constant(1));
  return {"half-space", solid};
}

/// A few blobs that touch the grid's border.
ScalarVolume blobs() {
  ScalarVolume volume{Grid<float>(test::frame_of({9, 7, 8}, Point(-1, 0.5, 2), 0.7)), 0.4F};
  std::mt19937_64 random(5);
  for (float& value : volume.grid.values) value = static_cast<float>(random() % 1000) / 1000;
  return volume;
}

std::vector<Model> solids() {
  return {ball_model({0.1, 0.2, -0.3}, 1.1),
          {"torus", make_procedural("torus")},
          {"blobs", blobs()},
          {"voxels", test::random_volume({6, 5, 7}, 0.4, 9)}};
}

GridFrame frame_about(const SolidSampler& solid, std::int64_t resolution) {
  return padded(voxel_frame(solid.box(), resolution), 2);
}

/// S at every tap of every grid point, one by one: lattices of a single point.
DensityVolume slow_low_pass(const SolidSampler& solid, const GridFrame& frame, const LowPassOptions& options) {
  const TapLattice lattice = tap_lattice(options.support, options.taps);
  const LatticeKernel kernel(options.filter, lattice.radius, options.rule);
  RunContext context;
  Stage stage(context, "sampling", 1);
  const std::int64_t reach = lattice.reach(kernel);
  GridFrame whole = frame;
  whole.voxel_size = frame.voxel_size / static_cast<double>(lattice.per_voxel);
  whole.dims = (frame.dims - Index3::Ones()) * lattice.per_voxel + Index3::Constant(2 * reach + 1);
  whole.origin = frame.center(Index3::Zero()) - Point::Constant((static_cast<double>(reach) + 0.5) * whole.voxel_size);
  const BitVolume samples = solid.sample(whole, 0, stage, context);
  DensityVolume density(frame);
  for (std::int64_t k = 0; k < frame.dims[2]; ++k) {
    for (std::int64_t j = 0; j < frame.dims[1]; ++j) {
      for (std::int64_t i = 0; i < frame.dims[0]; ++i) {
        std::int64_t sum = 0;
        for (std::int64_t dz = -kernel.reach(); dz <= kernel.reach(); ++dz) {
          for (std::int64_t dy = -kernel.reach(); dy <= kernel.reach(); ++dy) {
            for (std::int64_t dx = -kernel.reach(); dx <= kernel.reach(); ++dx) {
              if (samples.get(i * lattice.per_voxel + reach + dx * lattice.stride,
                              j * lattice.per_voxel + reach + dy * lattice.stride,
                              k * lattice.per_voxel + reach + dz * lattice.stride)) {
                sum += kernel.weight(dx, dy, dz);
              }
            }
          }
        }
        density(i, j, k) = static_cast<float>(static_cast<double>(sum) / static_cast<double>(kernel.total()));
      }
    }
  }
  return density;
}

TEST(LowPass, IsTheSumOverTheTapsAtEveryGridPoint) {
  for (const Model& model : solids()) {
    const auto solid = make_sampler(model, {});
    const GridFrame frame = frame_about(*solid, 7);
    for (const double support : {0.4, 1.0, 1.7, 3.3, 9.5}) {
      for (const TapRule rule : {TapRule::kPoint, TapRule::kCell}) {
        RunContext context;
        const LowPassOptions options{{RadialShape::kHyperCone, 0}, support, 7, rule};
        const DensityVolume density = low_pass(*solid, frame, options, context);
        EXPECT_EQ(density.values, slow_low_pass(*solid, frame, options).values) << model.name << ' ' << support;
      }
    }
  }
}

TEST(LowPass, DensitiesOfNothingAndOfEverythingAreExact) {
  for (const double side : {-1.0, 1.0}) {
    const Model model = half_space(Point::UnitX(), side * 100);
    RunContext context;
    for (const double support : {0.5, 1.0, 30.0}) {
      const GridFrame frame = test::frame_of({5, 4, 3}, Point(-2, -2, -2), 1);
      const DensityVolume density = low_pass(*make_sampler(model, {}), frame, {{}, support}, context);
      for (const float value : density.values) EXPECT_EQ(value, side > 0 ? 1.0F : 0.0F);
    }
  }
}

TEST(LowPass, DensitiesAreSharesAndFallToExactlyZeroOutside) {
  for (const Model& model : solids()) {
    const auto solid = make_sampler(model, {});
    RunContext context;
    LowPassReport report;
    const GridFrame frame = frame_about(*solid, 20);
    const DensityVolume density = low_pass(*solid, frame, {}, context, &report);
    for (const float value : density.values) {
      EXPECT_GE(value, 0);
      EXPECT_LE(value, 1);
    }
    EXPECT_EQ(density(0, 0, 0), 0);  // two voxels from the box, with a support of one
    // A ball of 12 lattice points has 4 / 3 pi 12^3 = 7,238 taps, and of cells that it only touches less than one
    // layer.
    EXPECT_GT(report.taps, 7238);
    EXPECT_LT(report.taps, 4.19 * 13.4 * 13.4 * 13.4);
    EXPECT_GT(report.evaluated, 0);
    EXPECT_LT(report.evaluated, frame.voxels());
  }
}

/// A half-space whose density at (0, 0, 0) is wanted at a distance, in supports; the grid is that point and more.
double density_at(const RadialFilter& filter, const Point& normal, double distance, double taps, TapRule rule) {
  RunContext context;
  const Model model = half_space(normal.normalized(), -distance);
  const GridFrame frame = test::frame_of({1, 1, 1}, Point::Constant(-0.5), 1);
  return static_cast<double>(low_pass(*make_sampler(model, {}), frame, {filter, 1, taps, rule}, context).values[0]);
}

const std::vector<RadialFilter> kFilters = {
    {RadialShape::kGaussian, 0.4}, {RadialShape::kHyperCone, 0}, {RadialShape::kBox, 0}};

TEST(LowPass, PlanesBetweenTheSamplesHaveTheProfileOfEquationFive) {
  // The solid is then a union of lattice cells, so only the filter is approximated.
  for (const RadialFilter& filter : kFilters) {
    for (int step = -13; step <= 13; ++step) {
      const double distance = (step + 0.5) / 12;
      EXPECT_NEAR(density_at(filter, Point::UnitY(), distance, 24, TapRule::kCell), filter.plane_profile(distance),
                  1e-3);
    }
  }
}

TEST(LowPass, AnyPlaneHasTheProfileOfEquationFiveToWithinHalfACell) {
  // Moving a plane by half the spacing of the samples, 1 / 12 of the support, moves it past all that it is mistaken by.
  std::mt19937_64 random(11);
  const auto coordinate = [&random] { return static_cast<double>(random() % 2001) / 1000 - 1; };
  for (const RadialFilter& filter : kFilters) {
    double sum = 0;
    int planes = 0;
    while (planes < test::case_count(300)) {
      const Point normal(coordinate(), coordinate(), coordinate());
      if (normal.norm() < 0.1) continue;
      const double distance = coordinate();
      const double half_cell = 0.5 * normal.lpNorm<1>() / normal.norm() / 12;
      const double density = density_at(filter, normal, distance, 24, TapRule::kCell);
      EXPECT_LE(density, filter.plane_profile(distance - half_cell) + 1e-3);
      EXPECT_GE(density, filter.plane_profile(distance + half_cell) - 1e-3);
      sum += std::abs(density - filter.plane_profile(distance));
      ++planes;
    }
    EXPECT_LT(sum / planes, 1e-3);
  }
}

TEST(LowPass, ProfilesConvergeWithTheNumberOfTaps) {
  // A plane parallel to the lattice is the worst: it is taken for one half a cell away at most, 1 / taps of the
  // support. Profiles have a slope of at most 1 (the cone's; of a Gaussian of this width 0.98, of a box 0.75).
  for (const RadialFilter& filter : kFilters) {
    for (const double taps : {32, 64, 254}) {
      EXPECT_NEAR(density_at(filter, Point::UnitZ(), 0.137, taps, TapRule::kPoint), filter.plane_profile(0.137),
                  1 / taps + 1e-3);
    }
  }
  for (const RadialFilter& filter : kFilters) {
    if (kAddressSanitizer && filter.shape != RadialShape::kBox) continue;  // a thousand million taps
    EXPECT_NEAR(density_at(filter, Point::UnitZ(), 0.137, 1022, TapRule::kPoint), filter.plane_profile(0.137), 1e-3);
  }
}

}  // namespace
}  // namespace voxcarve
