// From soups to tetrahedralizations of their hulls: which attempt succeeds, and what is said of it.
#include "methods/hagbi_elsana/valid_complex.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "common/mesh/io/mesh_io.h"
#include "common/mesh/models/primitives.h"
#include "tests/support/shapes.h"
#include "tests/support/tetgen_runs.h"

namespace voxcarve {
namespace {

using test::joined;
using test::unit_tetrahedron;

/// The stages that made tetrahedra, or tried to, in their order.
std::vector<std::string> attempts(const RunContext& context) {
  std::vector<std::string> stages;
  for (const StageTiming& timing : context.timings()) {
    if (timing.stage.starts_with("tetrahedralization")) stages.push_back(timing.stage);
  }
  return stages;
}

const std::string kDone = "tetrahedralization";
const std::string kFailed = "tetrahedralization (failed)";

/// True when one of the notices holds all of these, in this order.
bool noticed(const RunContext& context, const std::vector<std::string>& parts) {
  return std::ranges::any_of(context.notices(), [&](const std::string& notice) {
    std::size_t at = 0;
    for (const std::string& part : parts) {
      at = notice.find(part, at);
      if (at == std::string::npos) return false;
      at += part.size();
    }
    return true;
  });
}

/// Two tetrahedra whose tips are so far apart. At 1e-11 TetGen takes them for one point until it is told to look closer
/// than its 1e-8; at 1e-17 it always does.
TriangleSoup near_tips(double gap) {
  TriangleSoup other = unit_tetrahedron();
  for (Point& p : other.positions) p = -p;
  other.positions[0][0] = -gap;
  return joined({unit_tetrahedron(), test::inside_out(other)});
}

TEST(ValidComplex, WhatIsOneAlreadyTakesOneAttemptAndNoNotice) {
  const TriangleSoup cube = box(Point::Zero(), Point::Ones());
  RunContext context;
  const ValidComplex valid = make_valid_complex(cube, {}, context);
  EXPECT_EQ(valid.complex.triangles, cube.triangles);
  EXPECT_EQ(valid.multiplicity, std::vector<std::int32_t>(12, 1));
  EXPECT_FALSE(valid.wrapped);
  EXPECT_EQ(attempts(context), std::vector<std::string>{kDone});
  EXPECT_TRUE(context.notices().empty());
}

TEST(ValidComplex, SaysWhatWasMergedDroppedAndSplit) {
  // Two boxes that share one corner, with a copy of the first one's last triangle and a flat triangle; and a third box
  // that crosses the first: three edges of each pass through a face of the other.
  TriangleSoup soup = joined({box(Point(0, 0, 0), Point(2, 2, 2)), box(Point(2, 2, 2), Point(3, 3, 3))});
  soup.triangles.push_back(soup.triangles[11]);
  soup.triangles.push_back({0, 1, 1});
  append(soup, box(Point(-1, -1, -1), Point(1, 1, 1)));
  RunContext context;
  const ValidComplex valid = make_valid_complex(soup, {}, context);
  EXPECT_TRUE(noticed(context, {"1 vertex was merged with others at the same position"}));
  EXPECT_TRUE(noticed(context, {"1 triangle was dropped for having no area"}));
  EXPECT_TRUE(noticed(context, {"1 triangle was merged with others between the same vertices"}));
  EXPECT_TRUE(noticed(context, {"pairs of triangles cross", "triangles were split, with", "new vertices, in 1 pass"}));
  EXPECT_EQ(std::ranges::count(valid.multiplicity, 2), 1);
  EXPECT_EQ(attempts(context), std::vector<std::string>{kDone});
}

TEST(ValidComplex, TimesAndNamesAnAttemptThatFailed) {
  RunContext context;
  const ValidComplex valid = make_valid_complex(near_tips(1e-11), {}, context);
  EXPECT_FALSE(valid.wrapped);
  EXPECT_EQ(valid.complex.positions.size(), 8U);
  EXPECT_EQ(attempts(context), (std::vector<std::string>{kFailed, kDone}));
  EXPECT_TRUE(noticed(context, {"points apart", "triangles whole: TetGen refused the model"}));
  // Notices hold no times: they are the same again.
  RunContext again;
  make_valid_complex(near_tips(1e-11), {}, again);
  EXPECT_EQ(again.notices(), context.notices());
}

TEST(ValidComplex, WrapsWhatCannotBeTetrahedralizedOtherwise) {
  RunContext context;
  const ValidComplex valid = make_valid_complex(near_tips(1e-17), {}, context);
  EXPECT_TRUE(valid.wrapped);
  EXPECT_EQ(attempts(context), (std::vector<std::string>{kFailed, kFailed, kFailed, kDone}));
  // The reasons stand in the order of the attempts.
  EXPECT_TRUE(noticed(context, {"could not be tetrahedralized", "triangles whole: ", "close points told apart: ",
                                "triangles split: ", "shrink-wrapped"}));
}

TEST(ValidComplex, TheBoxHasItsCornersBeside) {
  RunContext context;
  const ValidComplex valid = make_valid_complex(unit_tetrahedron(), {.limits = {}, .box = true}, context);
  EXPECT_EQ(valid.complex.positions.size(), 4U);
  // Four of the eight corners of the unit cube are the tetrahedron's own.
  EXPECT_EQ(valid.tetrahedralization.points.size(), 4U + 8U);
  EXPECT_EQ(valid.tetrahedralization.steiner_points, 8U);
}

TEST(ValidComplex, FlatModelsAndLimitsEndTheRunAtOnce) {
  TriangleSoup square;
  square.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  square.triangles = {{0, 1, 2}, {0, 2, 3}};
  const auto kind_of = [](const TriangleSoup& soup, const TetgenLimits& limits, RunContext& context) {
    try {
      make_valid_complex(soup, {.limits = limits, .box = false}, context);
    } catch (const TetgenFailure& failure) {
      return failure.kind();
    }
    ADD_FAILURE() << "no TetgenFailure";
    return TetgenFailure::Kind::kCrashed;
  };
  RunContext context;
  EXPECT_EQ(kind_of(square, {}, context), TetgenFailure::Kind::kFlat);
  EXPECT_EQ(attempts(context), std::vector<std::string>{kFailed});
  RunContext other;
  EXPECT_EQ(kind_of(icosphere(Point::Zero(), 1, 3), {.seconds = 600, .bytes = 1}, other),
            TetgenFailure::Kind::kMemoryLimit);
  EXPECT_EQ(attempts(other), std::vector<std::string>{kFailed});
}

TEST(ValidComplex, RealModels) {
  int seen = 0;
  for (const auto& [name, failures] : {std::pair("foot_bones.ply", 0), {"motor.obj", 1}, {"airboat.obj", 2}}) {
    const auto path = test::data_file(name);
    if (!path) continue;
    SCOPED_TRACE(name);
    ++seen;
    RunContext context;
    EXPECT_FALSE(make_valid_complex(read_mesh(*path), {}, context).wrapped);
    std::vector<std::string> expected(static_cast<std::size_t>(failures), kFailed);
    expected.push_back(kDone);
    EXPECT_EQ(attempts(context), expected);
    // Where triangles are split the notice says how many became how many.
    EXPECT_EQ(noticed(context, {"triangles whole: ", "close points told apart: ", " became "}), failures == 2);
  }
  if (seen == 0) GTEST_SKIP() << "needs models in the folder VOXCARVE_DATA";
}

}  // namespace
}  // namespace voxcarve
