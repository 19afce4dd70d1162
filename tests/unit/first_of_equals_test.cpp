#include "common/mesh/first_of_equals.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <random>
#include <vector>

namespace voxcarve {
namespace {

std::vector<std::uint32_t> slow_first(const std::vector<std::uint64_t>& items) {
  std::vector<std::uint32_t> first;
  for (const std::uint64_t item : items) {
    first.push_back(static_cast<std::uint32_t>(std::find(items.begin(), items.end(), item) - items.begin()));
  }
  return first;
}

TEST(FirstOfEquals, WhateverTheHash) {
  std::mt19937_64 random(1);
  for (const std::size_t count : {0, 1, 2, 3, 100, 127, 128, 129, 1000}) {
    for (const std::uint64_t kinds : {1, 2, 50, 100000}) {
      std::vector<std::uint64_t> items(count);
      for (std::uint64_t& item : items) item = random() % kinds;
      const auto equal = [&](std::uint32_t i, std::uint32_t j) { return items[i] == items[j]; };
      const auto found_with = [&](const auto& hash_of) {
        return first_of_equals(
            count, [&](std::uint32_t i) { return hash_of(items[i]); }, equal);
      };
      const auto expected = slow_first(items);
      EXPECT_EQ(found_with([](std::uint64_t item) { return mixed(0, item); }), expected);
      // All at one place, the last of the table; most at few places; all in a row.
      EXPECT_EQ(found_with([](std::uint64_t) { return ~std::uint64_t{0}; }), expected);
      EXPECT_EQ(found_with([](std::uint64_t item) { return item % 3; }), expected);
      EXPECT_EQ(found_with([](std::uint64_t item) { return item; }), expected);
    }
  }
}

TEST(FirstOfEquals, HashesOfFewBitsAreSpread) {
  // Coordinates on a lattice differ in their highest bits only; the places of a table are the lowest ones of a hash.
  // Of 4096 balls thrown into 4096 bins, 4096 / e = 1507 bins stay empty on the average, with a deviation of
  // sqrt(4096 * (1/e - 2/e^2)) = 20; a hash that lost bits leaves at least half of them empty.
  std::vector<bool> taken(4096, false);
  for (std::uint64_t i = 0; i < 16; ++i)
    for (std::uint64_t j = 0; j < 16; ++j)
      for (std::uint64_t k = 0; k < 16; ++k) taken[mixed(mixed(mixed(0, i << 52), j << 52), k << 52) % 4096] = true;
  EXPECT_LT(std::count(taken.begin(), taken.end(), false), 1507 + 10 * 20);
}

}  // namespace
}  // namespace voxcarve
