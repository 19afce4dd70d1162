#include <gtest/gtest.h>

#include "experiments/benchmarks/growth.h"
#include "experiments/benchmarks/ratios.h"

namespace voxcarve::bench {
namespace {

using Cells = std::vector<std::string>;

/// Medians 0.25 and 5: a ratio of 20.
RatioRow twentyfold() {
  RatioRow row;
  row.stage = "voxelization";
  row.work = "512^3";
  row.threads = 2;
  row.ours_seconds = {0.3, 0.25, 9, 0.2, 0.1};
  row.peer = "VTK";
  row.peer_seconds = {4, 5, 6, 0.5, 50};
  return row;
}

TEST(BenchRatios, TheMedianIsTheMiddleAndOfAnEvenNumberTheMeanOfTwo) {
  EXPECT_EQ(median({3}), 3);
  EXPECT_EQ(median({9, 1, 5}), 5);
  EXPECT_EQ(median({8, 1, 2, 4}), 3);  // of 2 and 4
}

TEST(BenchRatios, TheRatioIsThePeersMedianOverOurs) {
  const RatioRow row = twentyfold();
  ASSERT_TRUE(row.ratio().has_value());
  EXPECT_DOUBLE_EQ(*row.ratio(), 20);
}

TEST(BenchRatios, AGoalIsMetFromTheNumberItself) {
  RatioRow row = twentyfold();
  EXPECT_EQ(row.met(), "");
  row.goal = 20;
  EXPECT_EQ(row.met(), "yes");
  row.goal = 20.001;
  EXPECT_EQ(row.met(), "no");
}

TEST(BenchRatios, AGoalBelowOneAllowsTheRestOfTheTime) {
  // Within twice the peer's time: 0.5 of its seconds over ours.
  RatioRow row;
  row.peer = "meshoptimizer";
  row.goal = 0.5;
  row.ours_seconds = {2, 2, 2, 2, 2};
  row.peer_seconds = {1, 1, 1, 1, 1};
  EXPECT_EQ(row.met(), "yes");
  row.peer_seconds = {0.99, 0.99, 0.99, 0.99, 0.99};
  EXPECT_EQ(row.met(), "no");
}

TEST(BenchRatios, WhatCannotBeJudgedSaysWhy) {
  RatioRow row = twentyfold();
  row.goal = 20;
  row.peer_seconds.pop_back();
  EXPECT_EQ(row.met(), "too few runs");
  row.peer_seconds.clear();
  EXPECT_EQ(row.met(), "not run");
  EXPECT_FALSE(row.ratio().has_value());
  row.peer_present = false;
  EXPECT_EQ(row.met(), "no peer");
  row.goal.reset();
  EXPECT_EQ(row.met(), "");
  row = twentyfold();
  row.goal = 20;
  row.ours_seconds.clear();
  EXPECT_EQ(row.met(), "not run");
}

TEST(BenchRatios, TheCsvHasItsColumnsWhateverIsKnown) {
  RatioRow judged = twentyfold();
  judged.goal = 20;
  judged.note = "not in the file";
  RatioRow absent = judged;
  absent.peer_present = false;
  absent.peer_seconds.clear();
  RatioRow alone;
  alone.stage = "isosurface";
  alone.work = "128^3";
  alone.ours_seconds = {0.004};
  const std::vector<RatioRow> rows{judged, absent, alone};
  const Table table = ratio_csv(rows);
  EXPECT_EQ(table.header,
            (Cells{"stage", "work", "threads", "ours_seconds", "peer", "peer_seconds", "ratio", "goal", "met"}));
  ASSERT_EQ(table.rows.size(), 3U);
  EXPECT_EQ(table.rows[0], (Cells{"voxelization", "512^3", "2", "0.25", "VTK", "5", "20", ">= 20", "yes"}));
  EXPECT_EQ(table.rows[1], (Cells{"voxelization", "512^3", "2", "0.25", "VTK", "", "", ">= 20", "no peer"}));
  EXPECT_EQ(table.rows[2], (Cells{"isosurface", "128^3", "1", "0.004", "", "", "", "", ""}));
}

TEST(BenchRatios, TheSummaryTellsRunsSpreadAndNotes) {
  RatioRow row = twentyfold();
  row.ours_seconds = {1, 2, 3};  // from 1 to 3 about 2: half of the range is half of the median
  row.note = "a note";
  const std::vector<RatioRow> rows{row};
  const Table table = ratio_summary(rows);
  ASSERT_EQ(table.rows.size(), 1U);
  EXPECT_EQ(table.rows[0].size(), table.header.size());
  EXPECT_EQ(table.rows[0][3], "2 (3, 50 %)");
  EXPECT_EQ(table.rows[0].back(), "a note");
}

TEST(BenchRatios, ErrorsAreBetterWhenSmaller) {
  ErrorRow row{"reduction hausdorff (voxels)", "1M to 10k", 2.0, "CGAL", 2.5, 1.0, {}};
  EXPECT_DOUBLE_EQ(row.ratio().value(), 1.25);
  EXPECT_EQ(row.met(), "yes");
  row.peer_value = 1.9;
  EXPECT_EQ(row.met(), "no");
  row.peer_value.reset();
  EXPECT_EQ(row.met(), "not run");
  row.ratio_goal.reset();
  EXPECT_EQ(row.met(), "");
  const ErrorRow exact{"reduction hausdorff (voxels)", "a cube", 0.0, "CGAL", 0.0, 1.0, {}};
  EXPECT_FALSE(exact.ratio().has_value());
  EXPECT_EQ(exact.met(), "yes");  // no larger
}

TEST(BenchRatios, ALimitIsStayedBelow) {
  ErrorRow row{"pipeline memory (bytes a voxel)", "643 x 300 x 382", 11.9, "", {}, {}, 12.0};
  EXPECT_EQ(row.met(), "yes");
  row.ours = 12;
  EXPECT_EQ(row.met(), "no");
  const std::vector<ErrorRow> rows{row};
  const Table table = error_csv(rows);
  EXPECT_EQ(table.header, (Cells{"stage", "work", "ours", "peer", "peer_value", "ratio", "goal", "met"}));
  EXPECT_EQ(table.rows.at(0),
            (Cells{"pipeline memory (bytes a voxel)", "643 x 300 x 382", "12", "", "", "", "< 12", "no"}));
}

TEST(BenchRatios, ThePipelineHasItsColumns) {
  const std::vector<PipelineRow> rows{{"voxelization", 1.5, 0.75, 1000}};
  const Table table = pipeline_csv(rows);
  EXPECT_EQ(table.header, (Cells{"stage", "seconds", "share", "bytes"}));
  EXPECT_EQ(table.rows.at(0), (Cells{"voxelization", "1.5", "0.75", "1000"}));
}

TEST(BenchGrowth, CostsComeBackFromTheTimesTheyMake) {
  // 40 ns a triangle, 15 ns a column, 0.125 ns a voxel, over three directions.
  std::vector<VoxelizationSample> samples;
  const auto add = [&](double triangles, double side) {
    const double columns = 3 * side * side;
    const double voxels = side * side * side;
    samples.push_back({triangles, columns, voxels, 1e-9 * (40 * triangles + 15 * columns + 0.125 * voxels)});
  };
  for (const double triangles : {1e4, 1e5, 1e6}) add(triangles, 256);
  for (const double side : {128.0, 384.0, 512.0}) add(1e5, side);
  const VoxelizationCosts costs = fit_costs(samples);
  EXPECT_NEAR(costs.per_triangle, 40, 1e-9);
  EXPECT_NEAR(costs.per_column, 15, 1e-9);
  EXPECT_NEAR(costs.per_voxel, 0.125, 1e-11);
  EXPECT_NEAR(costs.worst, 0, 1e-12);
}

TEST(BenchGrowth, NoCostIsNegative) {
  // Linear in the triangles but for a saving with the columns, which a plain fit would call a negative cost.
  std::vector<VoxelizationSample> samples;
  for (const double side : {128.0, 256.0, 512.0}) {
    samples.push_back({1e6, side * side, side * side * side, 1 - 1e-7 * side * side});
  }
  const VoxelizationCosts costs = fit_costs(samples);
  EXPECT_GT(costs.per_triangle, 900);
  EXPECT_EQ(costs.per_column, 0);
  EXPECT_EQ(costs.per_voxel, 0);
  EXPECT_GT(costs.worst, 0);
}

TEST(BenchGrowth, TheExponentIsOneForLinearGrowth) {
  EXPECT_DOUBLE_EQ(growth_exponent(10, 1, 1000, 100), 1);
  EXPECT_DOUBLE_EQ(growth_exponent(10, 1, 100, 100), 2);
  EXPECT_DOUBLE_EQ(growth_exponent(8, 3, 64, 3), 0);
}

}  // namespace
}  // namespace voxcarve::bench
