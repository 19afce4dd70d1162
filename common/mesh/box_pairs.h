// All pairs of boxes that overlap, of one set.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/mesh/triangle_soup.h"
#include "common/run/context.h"

namespace voxcarve {

/// Boxes in an order in which near ones are mostly near, cut into blocks of consecutive ones, with a tree over the
/// blocks. Made to find every overlapping pair once, block by block; so it is built in little more than the time of
/// sorting numbers, unlike `AabbTree`, and at any scale, be it a cluster in a corner of a large model. The same boxes
/// give the same order. Queries are const and may run on several threads at once.
class BoxPairs {
 public:
  static constexpr std::size_t kBlockSize = 8;
  /// Bytes of each box, at the peak, while it is built: in blocks and in the tree, its place, and its code twice.
  static constexpr std::uint64_t kBytesABox = sizeof(Box) * 5 / 4 + sizeof(std::uint32_t) + 2 * 16;

  /// The boxes must be finite, with lower <= upper. Throws Cancelled.
  BoxPairs(const std::vector<Box>& boxes, const RunContext& context);

  /// The box, by its index in what the constructor was given, at each place of the order.
  const std::vector<std::uint32_t>& order() const { return order_; }
  std::size_t block_count() const { return levels_.empty() ? 0 : levels_[0].size(); }

  /// Calls visit(i, j) with places i < j of the order for every pair of overlapping closed boxes of which the first is
  /// in the block; over all blocks that is every pair once. Throws Cancelled.
  template <class Visit>
  void visit_pairs(std::size_t block, const RunContext& context, const Visit& visit) const {
    const Group& own = levels_[0][block];
    const std::size_t begin = block * kBlockSize;
    const std::size_t count = std::min(kBlockSize, order_.size() - begin);
    std::array<Box, kBlockSize> boxes;
    Box all;
    for (std::size_t i = 0; i < count; ++i) {
      boxes[i] = own.box(i);
      all.extend(boxes[i]);
      for (const std::size_t j : Hits(own.gaps_to(boxes[i])))
        if (j > i) visit(begin + i, begin + j);
    }
    visit_blocks(all, block + 1, [&](std::size_t other) {
      context.check_cancelled();
      const Group& facing = levels_[0][other];
      for (const std::size_t i : Hits(own.gaps_to(levels_[1][other / kBlockSize].box(other % kBlockSize)))) {
        for (const std::size_t j : Hits(facing.gaps_to(boxes[i]))) visit(begin + i, other * kBlockSize + j);
      }
      return true;
    });
  }

  /// Whether any of the boxes overlaps this one, which must be finite, too.
  bool any_overlaps(const Box& box) const {
    bool any = false;
    visit_blocks(box, 0, [&](std::size_t block) {
      const Gaps gaps = levels_[0][block].gaps_to(box);
      any = *std::min_element(gaps.begin(), gaps.end()) <= 0;
      return !any;
    });
    return any;
  }

 private:
  using Gaps = std::array<double, kBlockSize>;

  /// Where gaps are not positive, in order. Found without branches, which nobody could foretell.
  class Hits {
   public:
    explicit Hits(const Gaps& gaps) {
      for (std::size_t i = 0; i < kBlockSize; ++i) {
        hits_[count_] = static_cast<std::uint8_t>(i);
        count_ += gaps[i] <= 0 ? 1 : 0;
      }
    }
    const std::uint8_t* begin() const { return hits_.data(); }
    const std::uint8_t* end() const { return hits_.data() + count_; }

   private:
    std::array<std::uint8_t, kBlockSize> hits_;
    std::size_t count_ = 0;
  };

  static constexpr std::size_t kLevels = 11;  ///< at most: 8^11 boxes

  /// Some boxes together, coordinate by coordinate, for compilers to compare several at a time. Those beyond the last
  /// overlap nothing.
  struct Group {
    std::array<Gaps, 3> lower;
    std::array<Gaps, 3> upper;

    Box box(std::size_t i) const {
      return {Point(lower[0][i], lower[1][i], lower[2][i]), Point(upper[0][i], upper[1][i], upper[2][i])};
    }

    Box bounds() const {
      Box all;
      for (std::size_t i = 0; i < kBlockSize; ++i) all.extend(box(i));
      return all;
    }

    /// The widest gap along an axis between each of the boxes and this one: they overlap iff it is not positive. That
    /// is exact: a difference of numbers has the sign of their comparison.
    Gaps gaps_to(const Box& other) const {
      const auto larger = [](double a, double b) { return a > b ? a : b; };
      const double l0 = other.lower[0], l1 = other.lower[1], l2 = other.lower[2];
      const double u0 = other.upper[0], u1 = other.upper[1], u2 = other.upper[2];
      Gaps gaps;
      for (std::size_t i = 0; i < kBlockSize; ++i) {
        const double x = larger(lower[0][i] - u0, l0 - upper[0][i]);
        const double y = larger(lower[1][i] - u1, l1 - upper[1][i]);
        const double z = larger(lower[2][i] - u2, l2 - upper[2][i]);
        gaps[i] = larger(larger(x, y), z);
      }
      return gaps;
    }
  };

  template <class BoxAt>
  static std::vector<Group> grouped(std::size_t count, const BoxAt& box_at);

  /// Calls visit for the blocks from `first` on whose boxes overlap this one, until it returns false.
  template <class Visit>
  void visit_blocks(const Box& box, std::size_t first, const Visit& visit) const {
    struct Node {
      std::size_t level;
      std::size_t index;
    };
    std::array<Node, kLevels * kBlockSize> stack;
    std::size_t size = 0;
    if (!levels_.empty()) stack[size++] = {levels_.size() - 1, 0};
    while (size > 0) {
      const auto [level, index] = stack[--size];
      const std::size_t first_child = first >> (3 * (level - 1));  // a node has eight children
      for (const std::size_t i : Hits(levels_[level][index].gaps_to(box))) {
        const std::size_t child = index * kBlockSize + i;
        if (child < first_child) continue;
        if (level > 1) {
          stack[size++] = {level - 1, child};
        } else if (!visit(child)) {
          return;
        }
      }
    }
  }

  std::vector<std::uint32_t> order_;
  std::vector<std::vector<Group>> levels_;  ///< boxes in that order; boxes of these groups, ...; one group or none
};

}  // namespace voxcarve
