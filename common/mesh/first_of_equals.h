// Finding equal items without sorting.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace voxcarve {

/// For hashes of several numbers, one after the other. The low bits of the result depend on all bits of both: a product
/// carries upwards only, so what is above is brought down before it and after it.
inline std::uint64_t mixed(std::uint64_t hash, std::uint64_t number) {
  hash ^= number;
  hash = (hash ^ hash >> 32) * 0xd6e8feb86659fd93ULL;
  hash = (hash ^ hash >> 32) * 0xd6e8feb86659fd93ULL;
  return hash ^ hash >> 32;
}

/// For each of the items 0, 1, ..., count - 1 the smallest that equals it, be it itself. `equal(i, j)` is an
/// equivalence, and equal items have one hash(i). Takes O(count) calls of either where hashes are good.
template <class Hash, class Equal>
std::vector<std::uint32_t> first_of_equals(std::size_t count, const Hash& hash, const Equal& equal) {
  constexpr std::uint32_t kFree = 0xffffffffU;
  const std::size_t places = std::bit_ceil(2 * count + 1);
  std::vector<std::uint32_t> table(places, kFree);  // of first items, at the next free place after their hash
  std::vector<std::uint32_t> first(count);
  for (std::uint32_t item = 0; item < count; ++item) {
    std::size_t place = static_cast<std::size_t>(hash(item)) & (places - 1);
    while (table[place] != kFree && !equal(table[place], item)) place = (place + 1) & (places - 1);
    if (table[place] == kFree) table[place] = item;
    first[item] = table[place];
  }
  return first;
}

}  // namespace voxcarve
