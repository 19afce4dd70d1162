// Interpolated levels against the interpolation of whole volumes.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "common/mesh/models/procedural.h"
#include "common/mesh/topology.h"
#include "common/volume/isosurface.h"
#include "methods/he_lowpass/hierarchy.h"
#include "methods/he_lowpass/in_between.h"
#include "methods/he_lowpass/low_pass.h"
#include "methods/he_lowpass/value_filter.h"
#include "tests/support/shapes.h"

namespace voxcarve {
namespace {

/// Two levels of a plate with holes.
struct Pair {
  DensityVolume coarse;
  DensityVolume fine;
};

Pair two_levels() {
  const Model model{"genus-n", make_procedural("genus-n?genus=3")};
  const auto solid = make_sampler(model, {});
  RunContext context;
  const auto filtered = [&](std::int64_t resolution) {
    return low_pass(*solid, padded(level_frame(solid->box(), resolution), 2), {}, context);
  };
  return {filtered(13), filtered(26)};
}

DensityVolume slow_mean(const Pair& pair, double share) {
  RunContext context;
  DensityVolume mean = interpolated(pair.coarse, pair.fine.frame, context);
  for (std::size_t i = 0; i < mean.values.size(); ++i) {
    const auto coarse = static_cast<double>(mean.values[i]);
    const auto fine = static_cast<double>(pair.fine.values[i]);
    mean.values[i] = static_cast<float>(share == 1 ? fine : coarse + share * (fine - coarse));
  }
  return mean;
}

TEST(InBetween, SurfacesAreThoseOfTheWholeMean) {
  const Pair pair = two_levels();
  RunContext context;
  const InBetween between(pair.coarse, pair.fine, 0.5F, context);
  EXPECT_LT(between.touched_cells(), between.cells());
  for (int step = 0; step <= 10; ++step) {
    const double share = step / 10.0;
    EXPECT_EQ(isosurface(between.at(share, context), 0.5F, context), isosurface(slow_mean(pair, share), 0.5F, context));
  }
  EXPECT_EQ(isosurface(between.at(1, context), 0.5F, context), isosurface(pair.fine, 0.5F, context));
}

TEST(InBetween, TouchedCellsAreThoseThatCanHoldTheSurface) {
  const Pair pair = two_levels();
  RunContext context;
  const InBetween between(pair.coarse, pair.fine, 0.5F, context);
  const DensityVolume coarse = interpolated(pair.coarse, pair.fine.frame, context);
  // A cell can hold the surface at some share iff its sixteen samples are not all on one side.
  std::int64_t expected = 0;
  const Index3& dims = pair.fine.frame.dims;
  for (std::int64_t k = 0; k + 1 < dims[2]; ++k) {
    for (std::int64_t j = 0; j + 1 < dims[1]; ++j) {
      for (std::int64_t i = 0; i + 1 < dims[0]; ++i) {
        float low = 1;
        float high = 0;
        for (const DensityVolume* volume : {&coarse, &pair.fine}) {
          for (int corner = 0; corner < 8; ++corner) {
            const float value = (*volume)(i + corner % 2, j + corner / 2 % 2, k + corner / 4);
            low = std::min(low, value);
            high = std::max(high, value);
          }
        }
        expected += low < 0.5F && high >= 0.5F ? 1 : 0;
      }
    }
  }
  EXPECT_EQ(between.touched_cells(), expected);
}

TEST(InBetween, DensitiesAndVerticesMoveByBoundedSteps) {
  // 20 frames: a density changes by its two ends' difference over 20. A vertex on an edge from a to b lies at
  // (1/2 - a) / (b - a) of it: where both change by at most d, the crossing of a frame that the next one has too moves
  // by at most 2 d / |b - a| of the edge, with the larger |b - a| of the two frames.
  const Pair pair = two_levels();
  RunContext context;
  const InBetween between(pair.coarse, pair.fine, 0.5F, context);
  constexpr int kFrames = 20;
  const double step = between.largest_difference() / kFrames + 1e-6;
  const Index3& dims = pair.fine.frame.dims;
  std::int64_t moved = 0;
  DensityVolume before = between.at(0, context);
  for (int frame = 1; frame <= kFrames; ++frame) {
    const DensityVolume now = between.at(static_cast<double>(frame) / kFrames, context);
    for (std::int64_t k = 0; k < dims[2]; ++k) {
      for (std::int64_t j = 0; j < dims[1]; ++j) {
        for (std::int64_t i = 0; i < dims[0]; ++i) {
          const Index3 here(i, j, k);
          EXPECT_LE(std::abs(static_cast<double>(now(i, j, k)) - static_cast<double>(before(i, j, k))), step);
          for (int axis = 0; axis < 3; ++axis) {
            const Index3 next = here + Index3::Unit(axis);
            if (!pair.fine.frame.contains(next)) continue;
            const auto crossing = [&](const DensityVolume& volume) {
              const auto a = static_cast<double>(volume(i, j, k));
              const auto b = static_cast<double>(volume(next[0], next[1], next[2]));
              return std::array{(a >= 0.5) != (b >= 0.5) ? (0.5 - a) / (b - a) : -1, std::abs(b - a)};
            };
            const auto [from, from_slope] = crossing(before);
            const auto [to, to_slope] = crossing(now);
            if (from < 0 || to < 0) continue;
            ++moved;
            EXPECT_LE(std::abs(to - from), 2 * step / std::max(from_slope, to_slope));
          }
        }
      }
    }
    before = now;
  }
  EXPECT_GT(moved, 1000);
}

TEST(InBetween, FramesAreClosedManifolds) {
  const Pair pair = two_levels();
  RunContext context;
  const InBetween between(pair.coarse, pair.fine, 0.5F, context);
  for (int step = 0; step <= 4; ++step) {
    const SurfaceTopology topology = analyze_topology(isosurface(between.at(step / 4.0, context), 0.5F, context));
    EXPECT_TRUE(topology.closed);
    EXPECT_EQ(topology.nonmanifold_edges, 0);
    EXPECT_EQ(topology.nonmanifold_vertices, 0);
  }
}

}  // namespace
}  // namespace voxcarve
