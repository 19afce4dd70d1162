#include "methods/hagbi_elsana/carving_queue.h"

#include <array>
#include <bit>

namespace voxcarve {

namespace {

struct Keyed {
  std::uint64_t key = 0;
  std::uint32_t tetrahedron = 0;
};

/// Smaller for greater numbers, the same for both zeros.
std::uint64_t descending_key(double value) {
  constexpr std::uint64_t kSign = std::uint64_t{1} << 63;
  const auto bits = std::bit_cast<std::uint64_t>(value + 0.0);  // -0 becomes 0
  return (bits & kSign) != 0 ? bits : ~(bits | kSign);
}

/// Stable, by digits from the last to the first; digits that are all equal are passed over.
void radix_sort(std::vector<Keyed>& items) {
  constexpr int kBits = 11;
  constexpr std::size_t kDigits = (64 + kBits - 1) / kBits;
  constexpr std::uint64_t kMask = (1U << kBits) - 1;
  const auto digit = [](std::uint64_t key, std::size_t d) {
    return static_cast<std::size_t>(key >> (static_cast<int>(d) * kBits) & kMask);
  };
  std::vector<std::array<std::size_t, kMask + 1>> counts(kDigits);
  for (const Keyed& item : items) {
    for (std::size_t d = 0; d < kDigits; ++d) ++counts[d][digit(item.key, d)];
  }
  std::vector<Keyed> sorted(items.size());
  for (std::size_t d = 0; d < kDigits; ++d) {
    std::array<std::size_t, kMask + 1>& next = counts[d];
    if (!items.empty() && next[digit(items[0].key, d)] == items.size()) continue;
    std::size_t first = 0;
    for (std::size_t& place : next) {
      const std::size_t count = place;
      place = first;
      first += count;
    }
    for (const Keyed& item : items) sorted[next[digit(item.key, d)]++] = item;
    items.swap(sorted);
  }
}

}  // namespace

RankQueue::RankQueue(const std::vector<double>& priorities)
    : tetrahedron_(priorities.size()), place_(priorities.size()) {
  std::vector<Keyed> order(priorities.size());
  for (std::uint32_t t = 0; t < order.size(); ++t) order[t] = {descending_key(priorities[t]), t};
  radix_sort(order);
  for (std::uint32_t place = 0; place < order.size(); ++place) {
    tetrahedron_[place] = order[place].tetrahedron;
    place_[order[place].tetrahedron] = place;
  }
  std::size_t words = priorities.size();
  do {
    words = words / 64 + 1;
    levels_.emplace_back(words, 0);
  } while (words > 1);
}

std::size_t RankQueue::first_place() const {
  std::size_t place = 0;
  for (std::size_t l = levels_.size(); l-- > 0;) {
    place = 64 * place + static_cast<std::size_t>(std::countr_zero(levels_[l][place]));
  }
  return place;
}

}  // namespace voxcarve
