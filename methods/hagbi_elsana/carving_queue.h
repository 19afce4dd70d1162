// Queues from which tetrahedra are carved: the highest priority first, of equal ones the smallest number.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace voxcarve {

/// A binary heap, for priorities that are known when a tetrahedron comes.
class HeapQueue {
 public:
  static constexpr bool kKnowsPriorities = false;

  bool empty() const { return heap_.empty(); }
  void push(std::uint32_t tetrahedron, double priority) {
    heap_.push_back({priority, tetrahedron});
    std::push_heap(heap_.begin(), heap_.end());
  }
  std::uint32_t pop() {
    std::pop_heap(heap_.begin(), heap_.end());
    const std::uint32_t tetrahedron = heap_.back().tetrahedron;
    heap_.pop_back();
    return tetrahedron;
  }

 private:
  struct Entry {
    double priority = 0;
    std::uint32_t tetrahedron = 0;

    bool operator<(const Entry& other) const {  // the greatest is carved first
      return priority != other.priority ? priority < other.priority : tetrahedron > other.tetrahedron;
    }
  };

  std::vector<Entry> heap_;
};

/// For priorities known beforehand: these are sorted once, and the queue is a set of places in that order, as bits with
/// one bit for every 64 of them above, and so on. Every operation takes time proportional to log64 of their number.
/// What is there already may come again; it is there once.
class RankQueue {
 public:
  static constexpr bool kKnowsPriorities = true;

  /// By tetrahedron; none is NaN.
  explicit RankQueue(const std::vector<double>& priorities);
  /// Bytes a tetrahedron while it is made, beside the priorities.
  static constexpr std::size_t kBytes = 2 * 16 + 2 * 4 + 1;

  bool empty() const { return levels_.back()[0] == 0; }
  void push(std::uint32_t tetrahedron) {
    std::size_t place = place_[tetrahedron];
    for (std::vector<std::uint64_t>& level : levels_) {
      std::uint64_t& word = level[place / 64];
      const bool known_above = word != 0;
      word |= std::uint64_t{1} << place % 64;
      if (known_above) return;
      place /= 64;
    }
  }
  std::uint32_t pop() {
    const std::size_t first = first_place();
    std::size_t place = first;
    for (std::vector<std::uint64_t>& level : levels_) {
      std::uint64_t& word = level[place / 64];
      word &= word - 1;  // the first bit
      if (word != 0) break;
      place /= 64;
    }
    return tetrahedron_[first];
  }
  /// What `pop` gives next, if nothing comes before it. The queue is not empty.
  std::uint32_t next() const { return tetrahedron_[first_place()]; }

 private:
  std::size_t first_place() const;

  std::vector<std::uint32_t> tetrahedron_;          ///< by place
  std::vector<std::uint32_t> place_;                ///< by tetrahedron
  std::vector<std::vector<std::uint64_t>> levels_;  ///< bit b of one says that word b of the one before is not 0
};

}  // namespace voxcarve
