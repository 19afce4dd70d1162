// TetGen in its child, where there is no result: what is refused, what limits and cancellation end, and that nothing of
// it reaches this process.
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "common/mesh/io/mesh_io.h"
#include "common/mesh/models/primitives.h"
#include "methods/hagbi_elsana/tetgen_child.h"
#include "tests/support/shapes.h"
#include "tests/support/tetgen_runs.h"
#include "tests/unit/child_test.h"

namespace voxcarve {
namespace {

using test::joined;
using test::tetrahedralized;
using test::unit_tetrahedron;
using Kind = TetgenFailure::Kind;

/// The kind of failure; fails the test when there is none.
Kind failure_of(const TriangleSoup& complex, const TetgenLimits& limits = {}, std::string* message = nullptr) {
  try {
    tetrahedralized(complex, FacetSplitting::kNone, limits);
  } catch (const TetgenFailure& failure) {
    if (message != nullptr) *message = failure.what();
    return failure.kind();
  }
  ADD_FAILURE() << "no TetgenFailure";
  return Kind::kCrashed;
}

TriangleSoup crossing_boxes() {
  return joined({box(Point(0, 0, 0), Point(2, 2, 2)), box(Point(1, 1, 1), Point(3, 3, 3))});
}

class TetgenChildFailures : public test::ChildTest {};

TEST_F(TetgenChildFailures, IntersectingTrianglesAreAFailureAndNothingMore) {
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  const Kind kind = failure_of(crossing_boxes());
  EXPECT_EQ(testing::internal::GetCapturedStdout() + testing::internal::GetCapturedStderr(), "");
  EXPECT_TRUE(kind == Kind::kRefused || kind == Kind::kCrashed);
}

TEST_F(TetgenChildFailures, FlatInputIsRefused) {
  TriangleSoup square;
  square.positions = {{0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  square.triangles = {{0, 1, 2}, {0, 2, 3}};
  std::string message;
  EXPECT_EQ(failure_of(square, {}, &message), Kind::kFlat);
  EXPECT_NE(message.find("in a plane"), std::string::npos) << message;
}

TEST_F(TetgenChildFailures, TrianglesWithoutAreaAreRefusedByNumber) {
  for (const Triangle& bad : {Triangle{0, 1, 1}, Triangle{0, 1, 4}}) {
    TriangleSoup complex = unit_tetrahedron();
    complex.positions.emplace_back(0.5, 0, 0);  // on the edge from 0 to 1
    complex.triangles.push_back(bad);
    std::string message;
    EXPECT_EQ(failure_of(complex, {}, &message), Kind::kRefused);
    EXPECT_NE(message.find("triangle 4 has no area"), std::string::npos) << message;
  }
}

TEST_F(TetgenChildFailures, InvalidInputIsAnInputError) {
  EXPECT_THROW(tetrahedralized(TriangleSoup()), InputError);
  TriangleSoup complex = unit_tetrahedron();
  complex.triangles[1][2] = 4;
  EXPECT_THROW(tetrahedralized(complex), InputError);
  complex = unit_tetrahedron();
  complex.positions[0][0] = std::nan("");
  EXPECT_THROW(tetrahedralized(complex), InputError);
}

TEST_F(TetgenChildFailures, LimitsOfTimeAndMemory) {
  const TriangleSoup sphere = icosphere(Point::Zero(), 1, 6);  // 81,920 triangles: a second, and 200 MB
  std::string message;
  EXPECT_EQ(failure_of(sphere, {.seconds = 0.05}, &message), Kind::kTimeLimit);
  EXPECT_NE(message.find("0.05 s"), std::string::npos) << message;
  EXPECT_EQ(failure_of(sphere, {.bytes = 20'000'000}, &message), Kind::kMemoryLimit);
  EXPECT_NE(message.find("19"), std::string::npos) << message;  // MiB
  EXPECT_EQ(failure_of(unit_tetrahedron(), {.bytes = 1}), Kind::kMemoryLimit);
  RunContext context;
  context.memory_budget = 1'000'000;
  EXPECT_THROW(tetrahedralize(sphere, FacetSplitting::kNone, {}, context), ResourceError);
}

TEST_F(TetgenChildFailures, CanBeCancelled) {
  const TriangleSoup sphere = icosphere(Point::Zero(), 1, 6);
  std::stop_source from_sink;
  RunContext context;
  context.cancellation = from_sink.get_token();
  context.progress = [&](const ProgressEvent&) { from_sink.request_stop(); };
  EXPECT_THROW(tetrahedralize(sphere, FacetSplitting::kNone, {}, context), Cancelled);

  std::stop_source from_thread;
  RunContext other;
  other.cancellation = from_thread.get_token();
  const std::jthread canceller([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(200));  // TetGen needs several times that
    from_thread.request_stop();
  });
  EXPECT_THROW(tetrahedralize(sphere, FacetSplitting::kNone, {}, other), Cancelled);
}

TEST_F(TetgenChildFailures, SeveralAtOnceAmongThreadsThatAllocateAndPrint) {
  const TriangleSoup complex = torus(2, 0.5, 24, 12);
  const Tetrahedralization expected = tetrahedralized(complex);
  std::atomic<bool> stop = false;
  std::vector<std::jthread> threads;
  for (int i = 0; i < 2; ++i) {
    threads.emplace_back([&] {
      while (!stop) {
        const std::vector<std::string> noise(64, std::string(200, 'x'));
        std::fprintf(stderr, "%s", noise.size() == 64 ? "" : "never");
      }
    });
  }
  std::array<Tetrahedralization, 6> results;
  std::vector<std::jthread> callers;
  for (std::size_t k = 0; k < 3; ++k) {
    callers.emplace_back([&, k] {
      results.at(k) = tetrahedralized(complex);
      try {
        tetrahedralized(crossing_boxes());
      } catch (const TetgenFailure&) {  // its end must not be hidden by a pipe that another child inherited
      }
      results.at(k + 3) = tetrahedralized(complex);
    });
  }
  callers.clear();
  stop = true;
  threads.clear();
  for (const Tetrahedralization& result : results) EXPECT_EQ(result.tetrahedra, expected.tetrahedra);
}

TEST_F(TetgenChildFailures, LeavesTheSignalHandlingOfItsCallerAlone) {
  struct sigaction before {};
  struct sigaction ignore {};
  ignore.sa_handler = SIG_IGN;
  sigaction(SIGCHLD, &ignore, &before);  // the system reaps children at once
  const Tetrahedralization result = tetrahedralized(unit_tetrahedron());
  EXPECT_EQ(result.tetrahedra.size(), 1U);
  const Kind kind = failure_of(crossing_boxes());
  EXPECT_TRUE(kind == Kind::kRefused || kind == Kind::kCrashed);
  struct sigaction after {};
  sigaction(SIGCHLD, nullptr, &after);
  EXPECT_EQ(after.sa_handler, SIG_IGN);

  static std::atomic<int> ended = 0;
  struct sigaction handle {};
  handle.sa_handler = [](int) { ++ended; };
  sigaction(SIGCHLD, &handle, nullptr);  // no SA_RESTART: system calls are interrupted
  EXPECT_EQ(tetrahedralized(unit_tetrahedron()).tetrahedra.size(), 1U);
  EXPECT_EQ(ended, 1);
  sigset_t mask;
  pthread_sigmask(SIG_SETMASK, nullptr, &mask);
  EXPECT_EQ(sigismember(&mask, SIGCHLD), 0);
  sigaction(SIGCHLD, &before, nullptr);
}

TEST_F(TetgenChildFailures, RealModelsThatIntersectAreFailures) {
  int seen = 0;
  for (const char* name : {"interpenetrating_two_spheres.stl", "tree_leaves.obj"}) {
    const auto path = test::data_file(name);
    if (!path) continue;
    SCOPED_TRACE(name);
    ++seen;
    TriangleSoup complex = merge_equal_positions(read_mesh(*path));
    std::erase_if(complex.triangles, [&](const Triangle& t) { return is_degenerate(complex, t); });
    const Kind kind = failure_of(complex);
    EXPECT_TRUE(kind == Kind::kRefused || kind == Kind::kCrashed);
  }
  if (seen == 0) GTEST_SKIP() << "needs models in the folder VOXCARVE_DATA";
}

}  // namespace
}  // namespace voxcarve
