// Lines of a distance transform: lower envelopes of parabolas, and the walk over a grid's columns that keeps to cache
// lines.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "common/run/context.h"
#include "common/volume/distance_transform.h"
#include "common/volume/grid.h"

namespace voxcarve {

/// Longest side on which squared distances stay exact in 32 bits: 3 * 26754^2 < 2^31.
inline constexpr std::int64_t kLongestExactSide = 26754;

/// Throws ResourceError when a side of `frame` is longer than kLongestExactSide.
void require_exact_sides(const GridFrame& frame);

/// The lower envelope of the parabolas (x - apex)^2 + value over a stretch of a line [MRH00].
class LowerEnvelope {
 public:
  /// For lines of up to `length` <= kLongestExactSide values, each of which plus `length`^2 stays below 2^31.
  explicit LowerEnvelope(std::int64_t length)
      : apex_(static_cast<std::size_t>(length)),
        height_(static_cast<std::size_t>(length)),
        start_(static_cast<std::size_t>(length)) {}

  /// Takes the values of the positions begin <= x < end of a line; those of kInfiniteDistance are no parabolas. Where
  /// several are the lowest, the one with the smallest apex is taken. False when there is no parabola at all.
  bool build(const std::int32_t* line, std::int32_t begin, std::int32_t end) {
    size_ = 0;
    end_ = end;
    for (std::int32_t x = begin; x < end; ++x) {
      const std::int32_t value = line[x];
      if (value == kInfiniteDistance) continue;
      const std::int32_t height = x * x + value;
      std::int32_t starts = begin;
      while (size_ > 0) {
        const std::int32_t rise = height - height_[size_ - 1];
        const std::int32_t run = x - apex_[size_ - 1];
        // Asked by a product: a division is needed only for the one parabola that stays below this one.
        if (rise >= 2 * run * start_[size_ - 1]) {
          starts = first_below(rise, run);
          break;
        }
        --size_;  // it is nowhere the lowest any more
      }
      if (starts >= end) continue;
      apex_[size_] = x;
      height_[size_] = height;
      start_[size_] = starts;
      ++size_;
    }
    return size_ > 0;
  }

  /// Calls visit(first, last, apex, height) for consecutive stretches first <= x < last, from the last to
  /// the first: there the parabola of `apex` is the lowest, with the value height + x (x - 2 apex).
  template <class Visit>
  void for_each_stretch(const Visit& visit) const {
    std::int32_t last = end_;
    for (std::size_t t = size_; t-- > 0;) {
      visit(start_[t], last, apex_[t], height_[t]);
      last = start_[t];
    }
  }

 private:
  /// First position at which a parabola lies strictly below another one whose apex is `run` > 0 less and whose value
  /// at 0 is `rise` >= 0 less.
  static std::int32_t first_below(std::int32_t rise, std::int32_t run) {
    // (p - x)^2 + value < (p - a)^2 + value_a  <=>  p > (height - height_a) / (2 (x - a))
    return (run == 1 ? rise / 2 : rise / (2 * run)) + 1;
  }

  std::size_t size_ = 0;
  std::int32_t end_ = 0;
  std::vector<std::int32_t> apex_;    ///< where the parabola of the stack has its minimum
  std::vector<std::int32_t> height_;  ///< its value at 0
  std::vector<std::int32_t> start_;   ///< first position at which it is the lowest
};

/// Calls visit(begin, end) for the stretches of a line in which something is to be found: from one 0 to the next, both
/// included, with other values in between. A 0 keeps everything beyond it out, and there is nothing less.
template <class Visit>
void for_each_gap(const std::int32_t* line, std::int32_t length, const Visit& visit) {
  for (std::int32_t x = 0; x < length; ++x) {
    if (line[x] == 0) continue;
    const std::int32_t begin = std::max(x - 1, 0);
    while (x < length && line[x] != 0) ++x;
    visit(begin, std::min(x + 1, length));
  }
}

/// Runs a worker over every line of `grid` along `axis`, 1 or 2. Lines that lie side by side in memory are copied
/// together into a buffer of their own and back, so that every cache line is touched once: the strided walk costs
/// several times as much. `make_worker()` gives what a thread keeps from line to line; worker(line, position) changes
/// the line in place, `position` is its index along the other axes (0 along `axis`).
template <class Value, class MakeWorker>
void transform_columns(Grid<Value>& grid, int axis, const RunContext& context, const MakeWorker& make_worker) {
  constexpr std::int64_t kTogether = 64 / sizeof(Value);
  constexpr std::int64_t kVoxelsPerChunk = 1 << 17;
  const Index3 dims = grid.frame.dims;
  const std::int64_t length = dims[axis];
  if (length == 1) return;
  const int other_axis = 3 - axis;
  const std::array<std::int64_t, 3> stride = {1, dims[0], dims[0] * dims[1]};
  const std::int64_t step = stride[static_cast<std::size_t>(axis)];
  const std::int64_t blocks = (dims[0] + kTogether - 1) / kTogether;
  const std::int64_t grain = std::max<std::int64_t>(1, kVoxelsPerChunk / (kTogether * length));
  parallel_for(context, 0, blocks * dims[other_axis], grain, [&](std::int64_t begin, std::int64_t end) {
    auto worker = make_worker();
    const std::int64_t pitch = length + kTogether;  // lines 2^n apart would share their places in the cache
    std::vector<Value> buffer(static_cast<std::size_t>(kTogether * pitch));
    for (std::int64_t block = begin; block < end; ++block) {
      Index3 position = Index3::Zero();
      position[0] = block % blocks * kTogether;
      position[other_axis] = block / blocks;
      const std::int64_t columns = std::min(kTogether, dims[0] - position[0]);
      Value* corner =
          grid.values.data() + position[0] + position[other_axis] * stride[static_cast<std::size_t>(other_axis)];
      for (std::int64_t x = 0; x < length; ++x) {
        for (std::int64_t c = 0; c < columns; ++c)
          buffer[static_cast<std::size_t>(c * pitch + x)] = corner[x * step + c];
      }
      for (std::int64_t c = 0; c < columns; ++c, ++position[0]) worker(buffer.data() + c * pitch, position);
      for (std::int64_t x = 0; x < length; ++x) {
        for (std::int64_t c = 0; c < columns; ++c)
          corner[x * step + c] = buffer[static_cast<std::size_t>(c * pitch + x)];
      }
    }
  });
}

}  // namespace voxcarve
