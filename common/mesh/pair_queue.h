// Pairs of vertices in the order of their contraction.
#pragma once

#include <cstdint>
#include <tuple>
#include <utility>
#include <vector>

#include "common/mesh/vertex_pairs.h"

namespace voxcarve {

/// A binary heap of pairs that can be changed and removed while they stand in it. The order is total, by (postponed,
/// cost, low, high), so which pair is first does not depend on the order of the changes.
class PairQueue {
 public:
  struct Entry {
    VertexPair pair;
    double cost = 0;
    bool postponed = false;  ///< after all that are not
  };

  explicit PairQueue(std::vector<Entry> entries) : entries_(std::move(entries)) {
    heap_.resize(entries_.size());
    slot_.resize(entries_.size());
    for (std::uint32_t id = 0; id < heap_.size(); ++id) heap_[id] = slot_[id] = id;
    for (std::size_t slot = heap_.size() / 2; slot-- > 0;) sink(slot);
  }

  bool empty() const { return heap_.empty(); }
  /// The number, in the order of construction, of the pair whose turn it is.
  std::uint32_t first() const { return heap_.front(); }
  const Entry& operator[](std::uint32_t id) const { return entries_[id]; }

  /// Replaces a pair that stands in the queue.
  void change(std::uint32_t id, const Entry& entry) {
    entries_[id] = entry;
    restore(slot_[id]);
  }

  void remove(std::uint32_t id) {
    const std::size_t slot = slot_[id];
    put(slot, heap_.back());
    heap_.pop_back();
    if (slot < heap_.size()) restore(slot);
  }

 private:
  bool before(std::uint32_t a, std::uint32_t b) const {
    const Entry& x = entries_[a];
    const Entry& y = entries_[b];
    return std::tie(x.postponed, x.cost, x.pair) < std::tie(y.postponed, y.cost, y.pair);
  }

  void put(std::size_t slot, std::uint32_t id) {
    heap_[slot] = id;
    slot_[id] = static_cast<std::uint32_t>(slot);
  }

  void restore(std::size_t slot) {
    const std::uint32_t id = heap_[slot];
    while (slot > 0 && before(id, heap_[(slot - 1) / 2])) {
      put(slot, heap_[(slot - 1) / 2]);
      slot = (slot - 1) / 2;
    }
    put(slot, id);
    sink(slot);
  }

  void sink(std::size_t slot) {
    const std::uint32_t id = heap_[slot];
    for (std::size_t child = 2 * slot + 1; child < heap_.size(); child = 2 * slot + 1) {
      if (child + 1 < heap_.size() && before(heap_[child + 1], heap_[child])) ++child;
      if (!before(heap_[child], id)) break;
      put(slot, heap_[child]);
      slot = child;
    }
    put(slot, id);
  }

  std::vector<Entry> entries_;
  std::vector<std::uint32_t> heap_;  ///< numbers of pairs
  std::vector<std::uint32_t> slot_;  ///< of a pair in heap_
};

}  // namespace voxcarve
