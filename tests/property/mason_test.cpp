// The theorems of Williams and Rossignac on random volumes, beside slow twins that follow the definitions.
#include <gtest/gtest.h>

#include <cmath>

#include "common/run/errors.h"
#include "common/volume/bit_morphology.h"
#include "common/volume/labelling.h"
#include "common/volume/models/volume_models.h"
#include "common/volume/morphology.h"
#include "methods/mason/distance_surface.h"
#include "methods/mason/invariants.h"
#include "methods/mason/regular_filters.h"
#include "methods/registry.h"
#include "tests/support/shapes.h"

namespace voxcarve {
namespace {

using test::frame_of;
using test::random_volume;

constexpr MorphologicalFilter kAllFilters[] = {MorphologicalFilter::kDilate, MorphologicalFilter::kErode,
                                               MorphologicalFilter::kRound,  MorphologicalFilter::kFillet,
                                               MorphologicalFilter::kRf,     MorphologicalFilter::kFr,
                                               MorphologicalFilter::kMason};

struct Sample {
  BinaryVolume volume;
  double radius = 0;
};

/// Random volumes and images of several densities, noise of single voxels and of blobs, foreground at the border.
std::vector<Sample> samples() {
  std::vector<Sample> all;
  std::uint64_t seed = 0;
  RunContext context;
  for (const Index3& dims :
       {Index3(40, 30, 1), Index3(13, 12, 11), Index3(66, 5, 1), Index3(9, 1, 14), Index3(25, 1, 1)}) {
    for (const double fill : {0.05, 0.2, 0.5, 0.8, 0.95}) {
      for (const double radius : {1.0, 1.5, 2.0, 3.0, 4.2}) {
        all.push_back({random_volume(dims, fill, ++seed), radius});
        const BinaryVolume seeds = random_volume(dims, fill / 8, ++seed);
        all.push_back({resized(dilate(seeds, 1.5, context), seeds.frame), radius});
      }
    }
  }
  for (const double radius : {0.0, 2.0, 100.0}) {
    all.push_back({BinaryVolume(frame_of({7, 6, 5})), radius});
    all.push_back({BinaryVolume(frame_of({7, 6, 5}), 1), radius});
    all.push_back({BinaryVolume(frame_of({7, 6, 1}), 1), radius});
  }
  return all;
}

BitVolume room_for(const Sample& sample, bool outside, RunContext& context) {
  return packed(sample.volume, ball_margin(sample.volume.frame.dims, sample.radius), outside, context);
}

TEST(Mason, TheoremsHoldOfEveryFilterOnRandomVolumes) {
  std::size_t volumes = 0;
  for (const Sample& sample : samples()) {
    RunContext context;
    context.threads = volumes % 20 == 0 ? 2 : 1;  // threads that wait for each other cost more than such small volumes
    const BitVolume shape = room_for(sample, false, context);
    const std::int64_t reach = squared_reach(sample.radius);
    for (const MorphologicalFilter filter : kAllFilters) {
      for (const TieRule tie : {TieRule::kPaper, TieRule::kSelfDual}) {
        if (tie == TieRule::kSelfDual && filter != MorphologicalFilter::kMason) continue;
        const BitVolume result = RegularFilters(shape, reach, false, context).apply(filter, tie);
        for (const InvariantCheck& check : check_theorems(shape, result, reach, filter, tie, context)) {
          ASSERT_TRUE(check.holds) << check.name << ": " << check.detail << ", dims "
                                   << sample.volume.frame.dims.transpose() << ", radius " << sample.radius;
        }
      }
    }
    ++volumes;
  }
  EXPECT_GE(volumes, 250U);
}

TEST(Mason, ChecksNoticeAWrongResult) {
  // A result that differs from S outside the mortar: a voxel in the middle of a solid cube turned.
  RunContext context;
  BinaryVolume cube(frame_of({20, 20, 20}), 1);
  const Sample sample{cube, 2};
  const BitVolume shape = room_for(sample, false, context);
  cube(10, 10, 10) = 0;
  const BitVolume wrong = room_for({cube, 2}, false, context);
  std::vector<std::string> violated;
  for (const InvariantCheck& check :
       check_theorems(shape, wrong, squared_reach(2), MorphologicalFilter::kMason, TieRule::kPaper, context)) {
    if (!check.holds) violated.push_back(check.name);
  }
  // That Mason changes no more than RF or FR stands: these round the cube's edges, and one voxel is less.
  EXPECT_EQ(violated,
            (std::vector<std::string>{"the result differs from S only in the mortar",
                                      "every changed voxel has one of the opposite colour of S within the radius",
                                      "Mason is self-dual but for components that tie"}));
}

/// Mason as the paper describes it, pixel by pixel, on byte volumes.
BinaryVolume slow_mason(const BinaryVolume& shape, double radius, TieRule tie, RunContext& context) {
  const BinaryVolume r = open(shape, radius, context);
  const BinaryVolume f = close(shape, radius, context);
  const BinaryVolume rf = open(f, radius, context);
  const BinaryVolume fr = close(r, radius, context);
  BinaryVolume mortar(shape.frame);
  for (std::size_t at = 0; at < mortar.values.size(); ++at)
    mortar.values[at] = static_cast<std::uint8_t>(f.values[at] - r.values[at]);
  const Labelling labelling = label_components(mortar, 1, Connectivity::kFace, context);
  BinaryVolume result = shape;
  for (std::int32_t label = 1; label <= labelling.count; ++label) {
    std::int64_t by_fr = 0;
    std::int64_t by_rf = 0;
    std::int64_t balance = 0;
    int first = -1;
    for (std::size_t at = 0; at < mortar.values.size(); ++at) {
      if (labelling.labels.values[at] != label) continue;
      by_fr += shape.values[at] != fr.values[at] ? 1 : 0;
      by_rf += shape.values[at] != rf.values[at] ? 1 : 0;
      balance += shape.values[at] != 0 ? 1 : -1;
      if (first < 0) first = shape.values[at];
    }
    bool takes_fr = by_fr < by_rf;
    if (by_fr == by_rf && tie == TieRule::kSelfDual) takes_fr = balance < 0 || (balance == 0 && first == 0);
    for (std::size_t at = 0; at < mortar.values.size(); ++at) {
      if (labelling.labels.values[at] == label) result.values[at] = takes_fr ? fr.values[at] : rf.values[at];
    }
  }
  return result;
}

TEST(Mason, AgreesWithTheSlowTwin) {
  RunContext context;
  for (const Sample& sample : samples()) {
    const Index3 margin = ball_margin(sample.volume.frame.dims, sample.radius);
    const BitVolume shape = room_for(sample, false, context);
    for (const TieRule tie : {TieRule::kPaper, TieRule::kSelfDual}) {
      const BitVolume result = RegularFilters(shape, squared_reach(sample.radius), false, context).mason(tie);
      ASSERT_EQ(expanded(result, sample.volume.frame, margin, context),
                slow_mason(sample.volume, sample.radius, tie, context))
          << sample.volume.frame.dims.transpose() << " radius " << sample.radius;
    }
  }
}

TEST(Mason, PapersRuleBreaksDualityOnTiesAndTheOtherDoesNot) {
  RunContext context;
  int broken = 0;
  for (const Sample& sample : samples()) {
    const BitVolume shape = room_for(sample, false, context);
    const BitVolume other = complement(shape, context);
    const auto differing = [&](TieRule tie, MasonCounts* counts) {
      RegularFilters own(shape, squared_reach(sample.radius), false, context);
      RegularFilters dual(other, squared_reach(sample.radius), true, context);
      return count_difference(complement(own.mason(tie, counts), context), dual.mason(tie), context);
    };
    MasonCounts counts;
    const std::int64_t by_paper = differing(TieRule::kPaper, &counts);
    if (counts.ties == 0) {
      ASSERT_EQ(by_paper, 0);
    }
    broken += by_paper > 0 ? 1 : 0;
    ASSERT_EQ(differing(TieRule::kSelfDual, nullptr), 0);
  }
  EXPECT_GT(broken, 0);  // among hundreds of random volumes some component ties with different results
}

TEST(Mason, DistanceFieldIsPositiveExactlyOnTheResult) {
  RunContext context;
  int tried = 0;
  for (const Sample& sample : samples()) {
    if (++tried % 3 != 0) continue;
    const Index3 dims = sample.volume.frame.dims;
    Index3 margin = ball_margin(dims, sample.radius) + Index3(1, 1, dims[2] == 1 ? 0 : 1);
    GridFrame frame = sample.volume.frame;
    frame.dims += 2 * margin;
    const BitVolume shape = packed(sample.volume, margin, false, context);
    for (const MorphologicalFilter filter : kAllFilters) {
      const std::int64_t reach = squared_reach(sample.radius);
      const BitVolume result = RegularFilters(shape, reach, false, context).apply(filter, TieRule::kPaper);
      const Grid<float> field = distance_field(shape, frame, reach, filter, TieRule::kPaper, context);
      for (std::int64_t k = 0; k < frame.dims[2]; ++k)
        for (std::int64_t j = 0; j < frame.dims[1]; ++j)
          for (std::int64_t i = 0; i < frame.dims[0]; ++i)
            ASSERT_EQ(field(i, j, k) > 0, result.get(i, j, k)) << static_cast<int>(filter);
    }
  }
}

TEST(Mason, DistanceSurfaceOfADilatedVoxelIsASphere) {
  // A voxel grown by 8: every vertex of the surface lies near 8 voxels from its centre. The field is linear along rays
  // but not along the grid's edges: over a length of 1 at distance 8 it bends by up to 1 / (8 * 8), a 64th of a voxel,
  // and its zero lies at sqrt(8^2 + 1/2) = 8.0312.
  RunContext context;
  BinaryVolume voxel(frame_of({3, 3, 3}, Point(-1.5, -1.5, -1.5)));
  voxel(1, 1, 1) = 1;
  const Method& method = find_method("dilate");
  const std::vector<std::string> settings = {"radius=8", "surface=distance"};
  const Parameters parameters = Parameters::parse(method.info().parameters, settings, "dilate");
  const MethodResult result = method.run({"voxel", voxel}, parameters, context);
  const TriangleSoup sphere = result.levels->extract(0);
  ASSERT_GT(sphere.positions.size(), 500U);
  for (const Point& position : sphere.positions) EXPECT_NEAR(position.norm(), std::sqrt(64.5), 1.0 / 64);
}

TEST(Mason, LevelsAreTheRadiiFromCoarseToFine) {
  RunContext context;
  const Method& method = find_method("mason");
  const BinaryVolume volume = random_volume({30, 20, 10}, 0.6, 9);
  const std::vector<std::string> settings = {"radius=1,3,2,3", "maps=on", "smoothing=0"};
  const Parameters parameters = Parameters::parse(method.info().parameters, settings, "mason");
  const MethodResult result = method.run({"noise", volume}, parameters, context);
  ASSERT_EQ(result.levels->size(), 3);
  std::vector<std::string> names;
  for (const NamedVolume& named : result.volumes) {
    names.push_back(named.name + " " + std::to_string(named.level));
    if (named.name != "result") continue;
    const double radius = 3 - static_cast<double>(named.level);
    EXPECT_EQ(std::get<BinaryVolume>(named.volume), slow_mason(volume, radius, TieRule::kPaper, context));
  }
  EXPECT_EQ(names, (std::vector<std::string>{"stability 0", "core 0", "mortar 0", "anticore 0", "result 0", "core 1",
                                             "mortar 1", "anticore 1", "result 1", "core 2", "mortar 2", "anticore 2",
                                             "result 2"}));
}

TEST(Mason, BallCubeIsClearedByFrAndMostlyKeptByMason) {
  // WR 6: the volume is that of one cube, 150^3, and FR clears it out. The rest depends on the balls, which the paper
  // does not give; ours are of radius 35. The paper's own figures of Mason contradict each other: a volume that falls
  // from 3,375,000 to 2,591,312 changes at least 783,688 voxels, not 95,308.
  RunContext context;
  context.threads = 2;
  const BinaryVolume cube = make_volume("ball-cube");
  EXPECT_EQ(count_interior(cube), 3375000);
  const BitVolume shape = packed(cube, ball_margin(cube.frame.dims, 50), false, context);
  RegularFilters filters(shape, 2500, false, context);
  EXPECT_EQ(count_set(filters.fr(), context), 0);
  EXPECT_EQ(count_difference(shape, filters.rf(), context), 3239928);
  EXPECT_EQ(count_set(filters.rf(), context), 4750960);
  const BitVolume mason = filters.mason(TieRule::kPaper);
  EXPECT_EQ(count_set(mason, context), 2447456);
  EXPECT_EQ(count_difference(shape, mason, context), 1087112);
}

}  // namespace
}  // namespace voxcarve
