#include "common/volume/grid_allocator.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <new>
#include <random>
#include <vector>

#ifdef __linux__
#include <sys/resource.h>
#include <unistd.h>

#include <fstream>
#endif

#include "common/run/address_sanitizer.h"

namespace voxcarve {
namespace {

constexpr std::size_t kMebibyte = std::size_t{1} << 20;

constexpr bool kKeepsBlocks = !kAddressSanitizer;  // so that a use after it was freed shows

TEST(GridAllocator, BlocksInUseAreApartAndKeepWhatIsInThem) {
  struct Block {
    unsigned char* memory;
    std::size_t bytes;
    unsigned char mark;
  };
  const auto holds_its_mark = [](const Block& block) {
    for (std::size_t at = 0; at < block.bytes; at += 4096) {
      if (block.memory[at] != block.mark) return false;
    }
    return block.memory[block.bytes - 1] == block.mark;
  };
  std::mt19937 random(7);
  std::vector<Block> used;
  for (int step = 0; step < 400; ++step) {
    if (used.size() < 12 && random() % 2 == 0) {
      const std::size_t bytes = 1 + random() % (8 * kMebibyte);
      const Block block{static_cast<unsigned char*>(allocate_grid(bytes)), bytes, static_cast<unsigned char>(step)};
      std::memset(block.memory, block.mark, bytes);
      used.push_back(block);
    } else if (!used.empty()) {
      const auto gone = used.begin() + static_cast<std::ptrdiff_t>(random() % used.size());
      ASSERT_TRUE(holds_its_mark(*gone)) << "step " << step;
      free_grid(gone->memory, gone->bytes);
      used.erase(gone);
    }
  }
  for (const Block& block : used) {
    EXPECT_TRUE(holds_its_mark(block));
    free_grid(block.memory, block.bytes);
  }
}

TEST(GridAllocator, GivesOutAgainWhatOtherSizesDidNotReplace) {
  void* const large = allocate_grid(100 * kMebibyte);
  void* const small = allocate_grid(20 * kMebibyte);
  free_grid(small, 20 * kMebibyte);
  free_grid(large, 100 * kMebibyte);
  void* const small_again = allocate_grid(20 * kMebibyte);
  void* const large_again = allocate_grid(100 * kMebibyte);
  if (kKeepsBlocks) {
    EXPECT_EQ(small_again, small);
    EXPECT_EQ(large_again, large);
  }
  free_grid(small_again, 20 * kMebibyte);
  free_grid(large_again, 100 * kMebibyte);
}

TEST(GridAllocator, GivesBlocksOfNothing) {
  void* const first = allocate_grid(0);
  void* const second = allocate_grid(0);
  EXPECT_NE(first, nullptr);
  EXPECT_NE(second, nullptr);
  EXPECT_NE(first, second);
  free_grid(first, 0);
  free_grid(second, 0);
}

#ifdef __linux__
TEST(GridAllocator, GivesBackWhatItKeepsWhenTheSystemHasNoMore) {
  if (!kKeepsBlocks) GTEST_SKIP() << "nothing is kept, and the sanitizer takes addresses by the terabyte";
  // 300 MiB in use at once, so that a kept block of 200 MiB and a new one of 96 MiB may lie side by side; then room for
  // 50 MiB more, so that the system refuses the new one until the kept one is gone.
  void* const large = allocate_grid(200 * kMebibyte);
  void* const other = allocate_grid(100 * kMebibyte);
  free_grid(other, 100 * kMebibyte);
  free_grid(large, 200 * kMebibyte);
  std::size_t pages = 0;
  ASSERT_TRUE(std::ifstream("/proc/self/statm") >> pages);  // of addresses
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_AS, &before), 0);
  rlimit limit = before;
  limit.rlim_cur = pages * static_cast<std::size_t>(sysconf(_SC_PAGESIZE)) + 50 * kMebibyte;
  ASSERT_EQ(setrlimit(RLIMIT_AS, &limit), 0);
  void* block = nullptr;
  EXPECT_NO_THROW(block = allocate_grid(96 * kMebibyte));
  EXPECT_THROW(free_grid(allocate_grid(400 * kMebibyte), 400 * kMebibyte), std::bad_alloc);
  ASSERT_EQ(setrlimit(RLIMIT_AS, &before), 0);
  if (block != nullptr) free_grid(block, 96 * kMebibyte);
}
#endif

}  // namespace
}  // namespace voxcarve
