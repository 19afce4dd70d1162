// A queue in the order of costs that hardly ever fall.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>
#include <vector>

namespace voxcarve {

/// Items by cost, in buckets of equal exponent and leading digits of the cost. The cheapest bucket comes out at once,
/// its items by number: that takes 4 bytes an item and constant time a step, and what comes out lies in the order of
/// memory, which it would not from a heap. An item that enters below the bucket that came out last enters there.
class CostBuckets {
 public:
  /// `cost` may be infinite; what is not above 0 counts as 0.
  void push(std::uint32_t item, double cost) {
    constexpr double kMost = std::numeric_limits<float>::max();
    const float rounded = cost > 0 ? static_cast<float>(std::min(cost, kMost)) : 0.0F;
    const std::size_t bucket = std::bit_cast<std::uint32_t>(rounded) >> kShift;
    buckets_[std::max(bucket, current_)].push_back(item);
  }

  /// As the cheapest.
  void push_now(std::uint32_t item) { buckets_[current_].push_back(item); }

  /// Takes the items of the cheapest bucket, whose costs differ by a factor of at most 17/16, or of 2^coarseness
  /// buckets, 4 for an octave. False when there is none.
  bool take(std::vector<std::uint32_t>& items, int coarseness) {
    items.clear();
    while (buckets_[current_].empty() && current_ + 1 < kBuckets) ++current_;
    if (buckets_[current_].empty()) return false;
    items.swap(buckets_[current_]);
    const std::size_t last = current_ | ((std::size_t{1} << coarseness) - 1);
    while (current_ < last) {
      std::vector<std::uint32_t>& more = buckets_[++current_];
      items.insert(items.end(), more.begin(), more.end());
      more.clear();
    }
    std::sort(items.begin(), items.end());
    return true;
  }

  /// Gives each item the number new_number(item), or drops it where that is 0xffffffff.
  template <class NewNumber>
  void rename(NewNumber&& new_number) {
    for (auto& bucket : buckets_) {
      for (std::uint32_t& item : bucket) item = new_number(item);
      std::erase(bucket, 0xffffffffU);
    }
  }

 private:
  static constexpr int kDigits = 4;            ///< of the cost that tell buckets apart
  static constexpr int kShift = 23 - kDigits;  // a float has 8 bits of exponent above 23 of digits
  static constexpr std::size_t kBuckets = std::size_t{256} << kDigits;

  std::size_t current_ = 0;
  std::vector<std::vector<std::uint32_t>> buckets_ = std::vector<std::vector<std::uint32_t>>(kBuckets);
};

}  // namespace voxcarve
