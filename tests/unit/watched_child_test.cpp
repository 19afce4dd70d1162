// A child process that ends in every way there is, and what its parent makes of it.
#include "methods/hagbi_elsana/watched_child.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <filesystem>
#include <functional>
#include <memory>
#include <vector>

#include "tests/unit/child_test.h"

namespace voxcarve {
namespace {

class WatchedChildTest : public test::ChildTest {};

/// What becomes of a child from which one number is expected.
struct Ending {
  bool answered = false;
  std::uint64_t answer = 0;
  std::uint64_t peak_bytes = 0;
  ChildFailure failure;
};

Ending ending_of(const std::function<void(int)>& body, double seconds = 60, std::uint64_t bytes = 1'000'000'000) {
  RunContext context;
  Stage stage(context, "test", 1);
  Ending ending;
  try {
    WatchedChild child({.seconds = seconds, .bytes = bytes}, stage, body);
    child.receive(&ending.answer, sizeof ending.answer);
    ending.answered = true;
    child.note_peak(0);
    ending.peak_bytes = child.peak_bytes();
  } catch (const ChildFailure& failure) {
    ending.failure = failure;
  }
  return ending;
}

void answer(int pipe, std::uint64_t value) {
  send_to_parent(pipe, &value, sizeof value);
}

void sleep_for_ever(int /*pipe*/) {
  for (;;) pause();
}

TEST_F(WatchedChildTest, TellsHowItEnded) {
  for (const int signal : {SIGSEGV, SIGABRT, SIGBUS, SIGFPE, SIGKILL}) {
    const Ending ending = ending_of([signal](int) { std::raise(signal); });
    EXPECT_FALSE(ending.answered);
    EXPECT_EQ(ending.failure.end, ChildEnd::kCrashed);
    EXPECT_EQ(ending.failure.signal, signal);
  }
  const std::vector<std::function<void(int)>> silent = {[](int) {}, [](int) { throw 3; },
                                                        [](int pipe) { send_to_parent(pipe, "half", 4); }};
  for (const auto& body : silent) {
    const Ending ending = ending_of(body);
    EXPECT_FALSE(ending.answered);
    EXPECT_EQ(ending.failure.end, ChildEnd::kCrashed);
    EXPECT_EQ(ending.failure.signal, 0);
  }
}

TEST_F(WatchedChildTest, AnswersThatWereWrittenBeforeACrashAreRead) {
  const Ending ending = ending_of([](int pipe) {
    answer(pipe, 42);
    std::raise(SIGSEGV);
  });
  EXPECT_TRUE(ending.answered);
  EXPECT_EQ(ending.answer, 42U);
}

TEST_F(WatchedChildTest, AChildThatHangsIsKilled) {
  EXPECT_EQ(ending_of(sleep_for_ever, 0.1).failure.end, ChildEnd::kTimeLimit);
  const auto mute = [](int pipe) {
    close(pipe);
    sleep_for_ever(pipe);
  };
  EXPECT_EQ(ending_of(mute, 0.1).failure.end, ChildEnd::kTimeLimit);
}

TEST_F(WatchedChildTest, AChildThatGrowsIsKilled) {
  const auto grow = [](int pipe) {
    const std::vector<char> block(100'000'000, 1);
    sleep_for_ever(pipe);
    answer(pipe, static_cast<std::uint64_t>(block[7]));
  };
  EXPECT_EQ(ending_of(grow, 60, 50'000'000).failure.end, ChildEnd::kMemoryLimit);
}

TEST_F(WatchedChildTest, LongAnswersArriveWhole) {
  RunContext context;
  Stage stage(context, "test", 1);
  constexpr std::size_t kCount = 1'000'000;  // 8 MB: many times what a pipe holds
  std::vector<std::uint64_t> numbers(kCount);
  for (std::size_t i = 0; i < kCount; ++i) numbers[i] = i * i;
  WatchedChild child({.seconds = 60, .bytes = 1'000'000'000}, stage,
                     [&](int pipe) { send_to_parent(pipe, numbers.data(), kCount * sizeof numbers[0]); });
  std::vector<std::uint64_t> received(kCount);
  child.receive(received.data(), kCount * sizeof received[0]);
  EXPECT_EQ(received, numbers);
}

TEST_F(WatchedChildTest, RunsNoHandlerOfItsParentAndOutlivesCtrlC) {
  struct sigaction before {};
  struct sigaction handle {};
  handle.sa_handler = [](int) { _exit(0); };
  sigaction(SIGUSR1, &handle, &before);
  const Ending handled = ending_of([](int) { std::raise(SIGUSR1); });
  sigaction(SIGUSR1, &before, nullptr);
  EXPECT_EQ(handled.failure.signal, SIGUSR1);  // the default action, not the handler's _exit
  // A terminal sends it to the parent too, which cancels if it wants to.
  const Ending interrupted = ending_of([](int pipe) {
    std::raise(SIGINT);
    answer(pipe, 1);
  });
  EXPECT_TRUE(interrupted.answered);
}

#ifndef __SANITIZE_ADDRESS__
TEST_F(WatchedChildTest, CountsMemoryThatItsParentHadFreed) {
  if (access("/proc/self/clear_refs", W_OK) != 0) GTEST_SKIP() << "the system does not forget peaks";
  constexpr std::size_t kBlocks = 60'000;
  constexpr std::size_t kBlockBytes = 1000;
  std::vector<std::unique_ptr<std::vector<char>>> blocks(kBlocks);
  for (auto& block : blocks) block = std::make_unique<std::vector<char>>(kBlockBytes, 1);
  for (std::size_t i = 0; i + 1 < kBlocks; ++i) blocks[i].reset();  // the last one keeps the heap from shrinking
  RunContext context;
  Stage stage(context, "test", 1);
  WatchedChild child({.seconds = 60, .bytes = 1'000'000'000}, stage, [&](int pipe) {
    for (auto& block : blocks) block = std::make_unique<std::vector<char>>(kBlockBytes, 2);
    answer(pipe, peak_resident_bytes());
  });
  std::uint64_t peak = 0;
  child.receive(&peak, sizeof peak);
  child.note_peak(peak);
  EXPECT_GT(child.peak_bytes(), kBlocks * kBlockBytes * 9 / 10);
  EXPECT_LT(child.peak_bytes(), kBlocks * kBlockBytes * 3 / 2);
}
#endif

}  // namespace
}  // namespace voxcarve
