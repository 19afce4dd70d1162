#include "methods/hagbi_elsana/carving_queue.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <set>
#include <utility>
#include <vector>

namespace voxcarve {
namespace {

/// A set of all that is in the queue, in the order in which it comes out.
class SlowQueue {
 public:
  void push(std::uint32_t tetrahedron, double priority) { items_.insert({-priority, tetrahedron}); }
  std::uint32_t pop() {
    const std::uint32_t tetrahedron = items_.begin()->second;
    items_.erase(items_.begin());
    return tetrahedron;
  }
  bool empty() const { return items_.empty(); }

 private:
  std::set<std::pair<double, std::uint32_t>> items_;
};

/// Numbers of every kind but NaN, many of them equal.
std::vector<double> priorities(std::size_t count, std::uint64_t seed) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const std::vector<double> special = {0.0, -0.0, kInfinity, -kInfinity, 1, -1, 5e-324, -5e-324, 1e308, -1e308};
  std::mt19937_64 generator(seed);
  std::vector<double> result;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint64_t bits = generator();
    if (bits % 4 == 0) {
      result.push_back(special[bits / 4 % special.size()]);
    } else if (bits % 4 == 1) {
      result.push_back(static_cast<double>(bits / 4 % 16));
    } else {
      result.push_back(std::ldexp(static_cast<double>(bits >> 11) - 0x1p52, static_cast<int>(bits % 97) - 48));
    }
  }
  return result;
}

/// Random tetrahedra come, twice or more often too, and the first ones go, until all that came are gone.
template <class Come>
void expect_as_slow(const std::vector<double>& priority, auto& queue, const Come& come, std::uint64_t seed) {
  std::mt19937_64 generator(seed);
  SlowQueue slow;
  const auto go = [&] {
    ASSERT_FALSE(queue.empty());
    ASSERT_EQ(queue.pop(), slow.pop());
  };
  for (std::size_t round = 0; round < 3 * priority.size(); ++round) {
    const auto t = static_cast<std::uint32_t>(generator() % priority.size());
    come(t);
    slow.push(t, priority[t]);
    for (std::uint64_t times = generator() % 3; times > 0 && !slow.empty(); --times) ASSERT_NO_FATAL_FAILURE(go());
  }
  while (!slow.empty()) ASSERT_NO_FATAL_FAILURE(go());
  EXPECT_TRUE(queue.empty());
}

TEST(RankQueue, GivesWhatASetGives) {
  // One word of 64 places, two words, two levels, three levels.
  for (const std::size_t count : {1U, 2U, 63U, 64U, 65U, 4095U, 4096U, 4097U, 9000U}) {
    SCOPED_TRACE(count);
    const std::vector<double> priority = priorities(count, count);
    RankQueue queue(priority);
    EXPECT_TRUE(queue.empty());
    expect_as_slow(
        priority, queue,
        [&](std::uint32_t t) {
          queue.push(t);
          // Nothing comes before the next one until another comes.
          if (count > 100) return;
          RankQueue copy = queue;
          EXPECT_EQ(queue.next(), copy.pop());
        },
        7 * count);
  }
}

TEST(RankQueue, IsEmptyOfNothing) {
  EXPECT_TRUE(RankQueue({}).empty());
}

TEST(HeapQueue, GivesWhatASetGives) {
  for (const std::size_t count : {1U, 2U, 100U, 3000U}) {
    SCOPED_TRACE(count);
    const std::vector<double> priority = priorities(count, count);
    std::vector<bool> there(count, false);  // unlike the set, a heap keeps what comes twice twice
    struct Once {
      HeapQueue heap;
      std::vector<bool>& there;
      bool empty() const { return heap.empty(); }
      std::uint32_t pop() {
        const std::uint32_t t = heap.pop();
        there[t] = false;
        return t;
      }
    } queue{{}, there};
    expect_as_slow(
        priority, queue,
        [&](std::uint32_t t) {
          if (!there[t]) queue.heap.push(t, priority[t]);
          there[t] = true;
        },
        7 * count);
  }
}

}  // namespace
}  // namespace voxcarve
