// Connected components of binary volumes of one bit a voxel, as runs along x.
#pragma once

#include <bit>
#include <cstdint>
#include <span>
#include <utility>

#include "common/run/context.h"
#include "common/volume/bit_volume.h"
#include "common/volume/labelling.h"

namespace voxcarve {

/// Voxels begin ... end - 1 of a row: all set, with none set beside them.
struct LabelledRun {
  std::int32_t begin, end;
  std::int32_t component;  ///< 0 ... count - 1, numbered by first voxel in the order of the grid, x fastest
};

/// The runs of a volume, row by row, with the components that they belong to; 12 bytes a run and 4 bytes a row.
class RunLabelling {
 public:
  /// Made by `label_runs`. The runs of row (j, k) begin at first_run[k * ny + j] and end where those of the next begin.
  RunLabelling(const Index3& dims, std::int64_t count, GridValues<std::int32_t> first_run, GridValues<LabelledRun> runs)
      : dims_(dims), count_(count), first_run_(std::move(first_run)), runs_(std::move(runs)) {}

  const Index3& dims() const { return dims_; }
  /// Number of components.
  std::int64_t count() const { return count_; }
  /// All runs, in the order of the grid.
  std::span<const LabelledRun> runs() const { return runs_; }
  /// The runs of a row, from left to right.
  std::span<const LabelledRun> runs_of_row(std::int64_t j, std::int64_t k) const {
    const auto row = static_cast<std::size_t>(k * dims_[1] + j);
    return {runs_.data() + first_run_[row], runs_.data() + first_run_[row + 1]};
  }
  /// Bytes held.
  std::uint64_t memory() const { return first_run_.size() * sizeof(std::int32_t) + runs_.size() * sizeof(LabelledRun); }

 private:
  Index3 dims_;
  std::int64_t count_;
  GridValues<std::int32_t> first_run_;
  GridValues<LabelledRun> runs_;
};

/// The components of the set bits; the same for every number of threads. Declares what it holds as soon as the runs are
/// counted: `held` are the bytes that the caller holds beside `bits`. Throws ResourceError for 2^31 runs and more.
RunLabelling label_runs(const BitVolume& bits, Connectivity connectivity, RunContext& context, std::uint64_t held = 0);

/// Calls visit(word index, mask) for every word of a row that bits begin ... end - 1 lie in: the mask has those bits.
template <class Visit>
void for_each_word(std::int64_t begin, std::int64_t end, const Visit& visit) {
  if (begin >= end) return;
  const std::int64_t last = (end - 1) / kWordBits;
  BitWord mask = kAllBits << (begin % kWordBits);
  for (std::int64_t w = begin / kWordBits; w < last; ++w, mask = kAllBits) visit(w, mask);
  visit(last, mask & last_word_mask(end));
}

/// Number of set bits among bits begin ... end - 1 of a row.
inline std::int64_t count_bits(const BitWord* row, std::int64_t begin, std::int64_t end) {
  std::int64_t count = 0;
  for_each_word(begin, end, [&](std::int64_t w, BitWord mask) { count += std::popcount(row[w] & mask); });
  return count;
}

/// Sets bits begin ... end - 1 of a row.
inline void set_bits(BitWord* row, std::int64_t begin, std::int64_t end) {
  for_each_word(begin, end, [&](std::int64_t w, BitWord mask) { row[w] |= mask; });
}

/// Clears bits begin ... end - 1 of a row.
inline void clear_bits(BitWord* row, std::int64_t begin, std::int64_t end) {
  for_each_word(begin, end, [&](std::int64_t w, BitWord mask) { row[w] &= ~mask; });
}

}  // namespace voxcarve
