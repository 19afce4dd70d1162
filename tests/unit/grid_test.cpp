#include "common/volume/grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <thread>
#include <vector>

#include "tests/support/shapes.h"

namespace voxcarve {
namespace {

using test::frame_of;

/// Large enough to lie on huge pages.
GridFrame large() {
  return frame_of({200, 200, 100});
}

TEST(Grid, StartsFilledEvenOnMemoryThatAnotherHasLeft) {
  { const Grid<std::uint8_t> dirty(large(), 7); }
  const Grid<std::uint8_t> clean(large());
  EXPECT_EQ(std::ranges::count(clean.values, 0), large().voxels());
}

TEST(Grid, LivesBesideOthersOfItsSize) {
  const Grid<std::uint8_t> first(large(), 1);
  { const Grid<std::uint8_t> freed(large(), 2); }
  const Grid<std::uint8_t> second(large(), 3);
  const Grid<std::uint8_t> third(large(), 4);
  EXPECT_EQ(std::ranges::count(first.values, 1), large().voxels());
  EXPECT_EQ(std::ranges::count(second.values, 3), large().voxels());
  EXPECT_EQ(std::ranges::count(third.values, 4), large().voxels());
}

TEST(Grid, IsAllocatedOnSeveralThreadsAtOnce) {
  std::vector<std::thread> threads;
  std::vector<char> intact(4, 1);
  for (std::size_t t = 0; t < intact.size(); ++t) {
    threads.emplace_back([t, &intact] {
      for (int round = 0; round < 20; ++round) {
        const auto value = static_cast<std::uint8_t>(10 * t + static_cast<std::size_t>(round) % 10 + 1);
        const Grid<std::uint8_t> grid(frame_of({200, 200, 60 + 60 * (round % 2)}), value);
        if (std::ranges::count(grid.values, value) != grid.frame.voxels()) intact[t] = 0;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(intact, std::vector<char>(4, 1));
}

}  // namespace
}  // namespace voxcarve
