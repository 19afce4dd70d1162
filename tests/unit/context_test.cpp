#include "common/run/context.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <vector>

#include "common/run/errors.h"

namespace voxcarve {
namespace {

TEST(Stage, ReportsMonotoneProgressThatEndsAtTheTotal) {
  RunContext context;
  std::vector<std::int64_t> seen;
  context.progress = [&](const ProgressEvent& event) {
    EXPECT_EQ(event.stage, "work");
    EXPECT_LE(event.done, event.total);
    seen.push_back(event.done);
  };
  {
    Stage stage(context, "work", 10);
    for (int i = 0; i < 12; ++i) stage.advance(1);  // two too many are not reported
  }
  EXPECT_TRUE(std::ranges::is_sorted(seen));
  EXPECT_EQ(seen.front(), 0);
  EXPECT_EQ(seen.back(), 10);
  ASSERT_EQ(context.timings().size(), 1U);
  EXPECT_EQ(context.timings()[0].stage, "work");
  EXPECT_EQ(context.timings()[0].items, 10);
}

TEST(Stage, AFailedStageIsTimedAsOne) {
  RunContext context;
  std::vector<std::int64_t> reported;
  context.progress = [&](const ProgressEvent& event) { reported.push_back(event.done); };
  EXPECT_THROW(
      {
        Stage stage(context, "work", 10);
        context.require_memory(1000, "work");
        stage.advance(3);
        throw MethodFailure("no");
      },
      MethodFailure);
  ASSERT_EQ(context.timings().size(), 1U);
  EXPECT_EQ(context.timings()[0].stage, "work (failed)");
  EXPECT_GE(context.timings()[0].seconds, 0);
  EXPECT_EQ(context.timings()[0].items, 3);
  EXPECT_EQ(context.timings()[0].bytes, 1000U);
  EXPECT_EQ(reported, (std::vector<std::int64_t>{0, 3}));  // it never reports that it is done
  // What is tried next is a stage like any other.
  { const Stage stage(context, "other work", 5); }
  ASSERT_EQ(context.timings().size(), 2U);
  EXPECT_EQ(context.timings()[1].stage, "other work");
  EXPECT_EQ(context.timings()[1].items, 5);
}

TEST(RunContext, CancellationStopsAStageAndALoop) {
  RunContext context;
  std::stop_source source;
  context.cancellation = source.get_token();
  Stage stage(context, "work", 10);
  source.request_stop();
  EXPECT_THROW(stage.advance(1), Cancelled);
  EXPECT_THROW(parallel_for(context, 0, 10, 1, [](std::int64_t, std::int64_t) {}), Cancelled);
}

TEST(RunContext, RefusesMoreMemoryThanTheBudgetAndSaysHowMuchIsNeeded) {
  RunContext context;
  context.memory_budget = 1024;
  EXPECT_NO_THROW(context.require_memory(1024, "a grid"));
  try {
    context.require_memory(2048, "a grid");
    FAIL() << "2 KiB fit a budget of 1 KiB";
  } catch (const ResourceError& error) {
    EXPECT_EQ(std::string(error.what()),
              "a grid needs 2.0 KiB, more than the memory budget of 1.0 KiB; lower the resolution or raise --memory");
    EXPECT_EQ(error.exit_code(), ExitCode::kResource);
  }
}

TEST(ParallelFor, VisitsEveryIndexOnceInTheSameChunksOnAnyNumberOfThreads) {
  for (const int threads : {1, 2, 4}) {
    RunContext context;
    context.threads = threads;
    std::vector<int> visits(1003, 0);
    std::vector<std::int64_t> chunk_of(visits.size(), -1);
    parallel_for(context, 0, 1003, 10, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t i = begin; i < end; ++i) {
        ++visits[static_cast<std::size_t>(i)];
        chunk_of[static_cast<std::size_t>(i)] = begin;
      }
    });
    for (std::size_t i = 0; i < visits.size(); ++i) {
      EXPECT_EQ(visits[i], 1);
      EXPECT_EQ(chunk_of[i], static_cast<std::int64_t>(i / 10 * 10));
    }
  }
}

TEST(ParallelFor, PassesExceptionsOfTheBodyOn) {
  RunContext context;
  context.threads = 2;
  EXPECT_THROW(parallel_for(context, 0, 100, 1,
                            [](std::int64_t begin, std::int64_t) {
                              if (begin == 50) throw MethodFailure("no");
                            }),
               MethodFailure);
}

}  // namespace
}  // namespace voxcarve
