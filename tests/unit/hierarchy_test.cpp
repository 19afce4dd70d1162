// Grids and supports of a hierarchy.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "common/run/errors.h"
#include "methods/he_lowpass/hierarchy.h"

namespace voxcarve {
namespace {

ParameterSchema schema() {
  return {hierarchy_parameters(), check_hierarchy};
}

std::vector<HierarchyLevel> levels_of(const std::vector<std::string>& assignments, const Box& box) {
  return hierarchy_levels(Parameters::parse(schema(), assignments, "test"), box);
}

Box box_of(const Point& extent) {
  Box box;
  box.extend(Point(-1, 2, 5));
  box.extend(Point(-1, 2, 5) + extent);
  return box;
}

TEST(Hierarchy, TheTablesOfThePaperFollowFromTheFinestVoxel) {
  // Table 1: resolutions and radii, in voxels of the finest level, of which 200 make the box.
  const std::vector<HierarchyLevel> levels = levels_of({"resolution=200,100,50,30,15,5"}, box_of({400, 300, 200}));
  const std::vector<std::int64_t> resolutions = {5, 15, 30, 50, 100, 200};
  const std::vector<double> radii = {40, 13.3, 6.7, 4, 2, 1};
  ASSERT_EQ(levels.size(), 6U);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(levels[i].resolution, resolutions[i]);
    EXPECT_NEAR(levels[i].support / 2, radii[i], 0.05);  // the paper gives one digit
  }
}

TEST(Hierarchy, OneSupportGrowsWithTheVoxelsAndSeveralStandForThemselves) {
  const Box box = box_of({10, 10, 10});
  for (const HierarchyLevel& level : levels_of({"resolution=100,50,20", "support=3"}, box))
    EXPECT_DOUBLE_EQ(level.support, 3 * 10.0 / static_cast<double>(level.resolution));
  const std::vector<HierarchyLevel> own = levels_of({"resolution=20,100,50", "support=2,3,2.5"}, box);
  ASSERT_EQ(own.size(), 3U);
  EXPECT_DOUBLE_EQ(own[0].support, 0.2);  // of resolution 20, in voxels of the finest, 0.1
  EXPECT_DOUBLE_EQ(own[1].support, 0.25);
  EXPECT_DOUBLE_EQ(own[2].support, 0.3);
  const std::vector<HierarchyLevel> model = levels_of({"resolution=20,100", "support_model=0.7,0.1"}, box);
  EXPECT_DOUBLE_EQ(model[0].support, 0.7);
  EXPECT_DOUBLE_EQ(model[1].support, 0.1);
  EXPECT_DOUBLE_EQ(levels_of({"resolution=40", "support_model=0.3"}, box)[0].support, 0.3);
}

TEST(Hierarchy, AFactorMakesTheLevelsOfASingleResolution) {
  const std::vector<HierarchyLevel> levels =
      levels_of({"resolution=225", "levels=6", "factor=2"}, box_of({225, 225, 225}));
  ASSERT_EQ(levels.size(), 6U);
  const std::vector<std::int64_t> resolutions = {8, 15, 29, 57, 113, 225};  // rounded up
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(levels[i].resolution, resolutions[i]);
    EXPECT_DOUBLE_EQ(levels[i].support, 225.0 / static_cast<double>(resolutions[i]));
  }
}

TEST(Hierarchy, VoxelCountsRoundUpAndHoldTheBox) {
  // Table 3: 256 x 256 x 225.
  const Box box = box_of({256, 256, 225});
  const std::vector<Index3> expected = {{256, 256, 225}, {128, 128, 113}, {64, 64, 57},
                                        {32, 32, 29},    {8, 8, 8},       {4, 4, 4}};
  for (const Index3& dims : expected) {
    const GridFrame frame = level_frame(box, dims[0]);
    EXPECT_EQ(frame.dims, dims);
    const Point upper = frame.origin + frame.voxel_size * frame.dims.cast<double>();
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_LE(frame.origin[axis], box.lower[axis] + 1e-9);
      EXPECT_GE(upper[axis], box.upper[axis] - 1e-9);
    }
  }
}

TEST(Hierarchy, AMarginGrowsTheBoxOnEverySide) {
  const Parameters parameters = Parameters::parse(schema(), std::vector<std::string>{"margin=0.25"}, "test");
  const Box grown = grid_box(parameters, box_of({4, 2, 3}));
  EXPECT_EQ(grown.lower, Point(-2, 1, 4));
  EXPECT_EQ(grown.upper, Point(4, 5, 9));
}

TEST(Hierarchy, SamplesMayLieOnTheEndsOfTheBox) {
  const Box box = box_of({8, 4, 6});
  const GridFrame frame = level_frame(box, 5, Placement::kEnds);
  EXPECT_EQ(frame.voxel_size, 2);
  EXPECT_EQ(frame.dims, Index3(5, 3, 4));
  EXPECT_EQ(frame.center({0, 0, 0}), box.lower);
  EXPECT_EQ(frame.center({4, 2, 3}), box.upper);
  const std::vector<HierarchyLevel> levels = levels_of({"resolution=5,201", "placement=ends"}, box);
  EXPECT_DOUBLE_EQ(levels[1].support, 8 / 200.0);
  EXPECT_DOUBLE_EQ(levels[0].support, 8 / 200.0 * 201 / 5);
}

TEST(Hierarchy, ParametersThatContradictEachOtherAreRefused) {
  const auto refused = [](const std::vector<std::string>& assignments) {
    EXPECT_THROW(Parameters::parse(schema(), assignments, "test"), ParameterError) << assignments[0];
  };
  refused({"resolution=10,20", "levels=3"});
  refused({"resolution=10.5"});
  refused({"resolution=10,20,30", "support=1,2"});
  refused({"resolution=10", "support=1", "support_model=1"});
  refused({"resolution=16", "levels=4"});  // 2 voxels
  EXPECT_NO_THROW(Parameters::parse(schema(), std::vector<std::string>{"resolution=16", "levels=3"}, "test"));
}

}  // namespace
}  // namespace voxcarve
