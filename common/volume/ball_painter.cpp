// Blank voxels are bits in bricks of 64, which are bits in nodes of 64 bricks, which are bits in rows: whatever is
// painted already is passed over at the coarsest of these levels.
#include "common/volume/ball_painter.h"

#include <algorithm>
#include <bit>

namespace voxcarve {

namespace {

struct Range {
  std::int64_t first = 0;
  std::int64_t last = -1;
};

/// 64 bricks and the voxels in them.
struct Node {
  BitWord occupied = 0;  ///< bricks with blank voxels
  std::array<BitWord, kWordBits> bricks{};
};

/// Squares of distances along each axis to the up to 8 parts that a node or a brick has along it.
using Squares = std::array<std::array<std::int64_t, 8>, 3>;

class BallPainter {
 public:
  BallPainter(BitVolume& blank, std::int32_t largest_reach, Grid<std::int32_t>& values)
      : blank_(blank),
        values_(values),
        dims_(blank.dims()),
        shift_(shift_of(dims_)),
        nodes_along_(nodes_of(dims_)),
        row_words_(words_for(nodes_along_[0])),
        nodes_(static_cast<std::size_t>(nodes_along_.prod())),
        rows_(static_cast<std::size_t>(row_words_ * nodes_along_[1] * nodes_along_[2]), 0),
        half_width_(static_cast<std::size_t>(largest_reach) + 1) {
    std::int64_t root = 0;
    for (std::int64_t squared = 0; squared <= largest_reach; ++squared) {
      if ((root + 1) * (root + 1) <= squared) ++root;
      half_width_[static_cast<std::size_t>(squared)] = static_cast<std::int32_t>(root);
    }
    // Slabs of nodes lie across the last axis that the grid extends in, and are painted apart.
    slab_axis_ = dims_[2] == 1 ? 1 : 2;
  }

  void paint(const std::vector<Ball>& balls, RunContext& context) {
    parallel_for(context, 0, nodes_along_[slab_axis_], 1, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t slab = begin; slab < end; ++slab) {
        enter(slab);
        paint_slab(balls, slab, context);
      }
    });
  }

  static std::uint64_t memory(const Index3& dims, std::int32_t largest_reach) {
    const Index3 nodes = nodes_of(dims);
    return static_cast<std::uint64_t>(nodes.prod()) * sizeof(Node) +
           static_cast<std::uint64_t>(words_for(nodes[0]) * nodes[1] * nodes[2]) * sizeof(BitWord) +
           (static_cast<std::uint64_t>(largest_reach) + 1) * sizeof(std::int32_t);
  }

 private:
  /// Bits of a coordinate within a brick: 4 x 4 x 4 voxels, or 8 x 8 on an image. Likewise bricks within a node.
  static Index3 shift_of(const Index3& dims) { return dims[2] == 1 ? Index3(3, 3, 0) : Index3(2, 2, 2); }

  static Index3 nodes_of(const Index3& dims) {
    const Index3 shift = shift_of(dims);
    Index3 nodes;
    for (int axis = 0; axis < 3; ++axis) nodes[axis] = ((dims[axis] - 1) >> (2 * shift[axis])) + 1;
    return nodes;
  }

  std::int64_t half_width(std::int64_t squared) const { return half_width_[static_cast<std::size_t>(squared)]; }

  BitWord* row(std::int64_t y, std::int64_t z) { return rows_.data() + (z * nodes_along_[1] + y) * row_words_; }

  Node& node(std::int64_t x, std::int64_t y, std::int64_t z) {
    return nodes_[static_cast<std::size_t>((z * nodes_along_[1] + y) * nodes_along_[0] + x)];
  }

  /// Place of a part among the 64 of a node or brick, by the lowest bits of its coordinates.
  std::int64_t part(std::int64_t i, std::int64_t j, std::int64_t k) const {
    const auto low = [&](std::int64_t x, int axis) { return x & ((std::int64_t{1} << shift_[axis]) - 1); };
    return low(i, 0) | low(j, 1) << shift_[0] | low(k, 2) << (shift_[0] + shift_[1]);
  }

  /// Puts the blank voxels of a slab into nodes.
  void enter(std::int64_t slab) {
    const std::int64_t thickness = std::int64_t{1} << (2 * shift_[slab_axis_]);
    Index3 begin = Index3::Zero();
    Index3 end = dims_;
    begin[slab_axis_] = slab * thickness;
    end[slab_axis_] = std::min(dims_[slab_axis_], begin[slab_axis_] + thickness);
    for (std::int64_t k = begin[2]; k < end[2]; ++k) {
      for (std::int64_t j = begin[1]; j < end[1]; ++j) {
        const std::int64_t y = j >> (2 * shift_[1]);
        const std::int64_t z = k >> (2 * shift_[2]);
        const BitWord* words = blank_.row(j, k);
        for (std::int64_t w = 0; w < blank_.row_words(); ++w) {
          for (BitWord word = words[w]; word != 0; word &= word - 1) {
            const std::int64_t i = w * kWordBits + std::countr_zero(word);
            const std::int64_t x = i >> (2 * shift_[0]);
            const std::int64_t brick = part(i >> shift_[0], j >> shift_[1], k >> shift_[2]);
            Node& at = node(x, y, z);
            at.bricks[static_cast<std::size_t>(brick)] |= bit_of(part(i, j, k));
            at.occupied |= bit_of(brick);
            row(y, z)[x / kWordBits] |= bit_of(x);
          }
        }
      }
    }
  }

  void paint_slab(const std::vector<Ball>& balls, std::int64_t slab, const RunContext& context) {
    const std::int64_t shift = 2 * shift_[slab_axis_];
    const std::int64_t begin = slab << shift;
    const std::int64_t end = std::min(begin + (std::int64_t{1} << shift), dims_[slab_axis_]);
    constexpr std::size_t kBallsPerCheck = 1 << 14;
    for (std::size_t b = 0; b < balls.size(); ++b) {
      if (b % kBallsPerCheck == 0) context.check_cancelled();
      const std::int64_t center = balls[b].center[static_cast<std::size_t>(slab_axis_)];
      const std::int64_t radius = half_width(balls[b].reach);
      if (center + radius >= begin && center - radius < end) paint_nodes(balls[b], slab);
    }
  }

  /// The nodes that hold some voxel of center - half_width ... center + half_width.
  Range nodes_within(const Ball& ball, int axis, std::int64_t half_width) const {
    const std::int64_t center = ball.center[static_cast<std::size_t>(axis)];
    return {std::max<std::int64_t>(center - half_width, 0) >> (2 * shift_[axis]),
            std::min(center + half_width, dims_[axis] - 1) >> (2 * shift_[axis])};
  }

  /// Square of the distance along an axis to a stretch of 2^shift voxels.
  static std::int64_t squared_gap(const Ball& ball, int axis, std::int64_t first, std::int64_t shift) {
    const std::int64_t center = ball.center[static_cast<std::size_t>(axis)];
    const std::int64_t last = first + (std::int64_t{1} << shift) - 1;
    const std::int64_t gap = std::max<std::int64_t>({first - center, center - last, 0});
    return gap * gap;
  }

  void paint_nodes(const Ball& ball, std::int64_t slab) {
    const std::int64_t radius = half_width(ball.reach);
    Range along_y = nodes_within(ball, 1, radius);
    Range along_z = nodes_within(ball, 2, radius);
    (slab_axis_ == 1 ? along_y : along_z) = {slab, slab};
    for (std::int64_t z = along_z.first; z <= along_z.last; ++z) {
      const std::int64_t in_layer = ball.reach - squared_gap(ball, 2, z << (2 * shift_[2]), 2 * shift_[2]);
      for (std::int64_t y = along_y.first; y <= along_y.last; ++y) {
        const std::int64_t in_row = in_layer - squared_gap(ball, 1, y << (2 * shift_[1]), 2 * shift_[1]);
        if (in_row < 0) continue;
        const Range along_x = nodes_within(ball, 0, half_width(in_row));
        if (along_x.first > along_x.last) continue;
        BitWord* words = row(y, z);
        for (std::int64_t w = along_x.first / kWordBits; w <= along_x.last / kWordBits; ++w) {
          BitWord word = words[w];
          if (w == along_x.first / kWordBits) word &= kAllBits << (along_x.first % kWordBits);
          if (w == along_x.last / kWordBits) word &= last_word_mask(along_x.last % kWordBits + 1);
          for (; word != 0; word &= word - 1) {
            const int bit = std::countr_zero(word);
            if (paint_node(ball, Index3(w * kWordBits + bit, y, z))) words[w] ^= bit_of(bit);
          }
        }
      }
    }
  }

  /// The parts of `word` whose squares add up to no more than `reach`.
  BitWord within(BitWord word, const Squares& squares, std::int64_t reach) const {
    const auto along_x = static_cast<int>(shift_[0]);
    const auto along_xy = static_cast<int>(shift_[0] + shift_[1]);
    const std::size_t mask_x = (std::size_t{1} << along_x) - 1;
    const std::size_t mask_y = (std::size_t{1} << shift_[1]) - 1;
    BitWord result = 0;
    for (; word != 0; word &= word - 1) {
      const auto bit = static_cast<std::size_t>(std::countr_zero(word));
      const std::int64_t squared =
          squares[0][bit & mask_x] + squares[1][bit >> along_x & mask_y] + squares[2][bit >> along_xy];
      if (squared <= reach) result |= BitWord{1} << bit;
    }
    return result;
  }

  /// The squares for the parts of what begins at voxel `corner` and has parts of 2^(level * shift) voxels.
  Squares squares_of(const Ball& ball, const Index3& corner, std::int64_t level) const {
    Squares squares;
    for (int axis = 0; axis < 3; ++axis) {
      const std::int64_t shift = level * shift_[axis];
      for (std::int64_t p = 0; p < std::int64_t{1} << shift_[axis]; ++p) {
        squares[static_cast<std::size_t>(axis)][static_cast<std::size_t>(p)] =
            squared_gap(ball, axis, corner[axis] + (p << shift), shift);
      }
    }
    return squares;
  }

  /// Returns true when nothing blank is left in it.
  bool paint_node(const Ball& ball, const Index3& position) {
    Node& at = node(position[0], position[1], position[2]);
    Index3 corner;
    for (int axis = 0; axis < 3; ++axis) corner[axis] = position[axis] << (2 * shift_[axis]);
    for (BitWord bricks = within(at.occupied, squares_of(ball, corner, 1), ball.reach); bricks != 0;
         bricks &= bricks - 1) {
      const int brick = std::countr_zero(bricks);
      BitWord& blank = at.bricks[static_cast<std::size_t>(brick)];
      const Index3 brick_corner = corner + shifted(brick, shift_);
      const BitWord fresh = within(blank, squares_of(ball, brick_corner, 0), ball.reach);
      for (BitWord voxels = fresh; voxels != 0; voxels &= voxels - 1) {
        const Index3 voxel = brick_corner + shifted(std::countr_zero(voxels), Index3::Zero());
        values_(voxel[0], voxel[1], voxel[2]) = ball.reach;
        blank_.row(voxel[1], voxel[2])[voxel[0] / kWordBits] ^= bit_of(voxel[0]);
      }
      blank ^= fresh;
      if (blank == 0) at.occupied ^= bit_of(brick);
    }
    return at.occupied == 0;
  }

  /// Coordinates of a part from its place, in voxels when a part has 2^scale of them along each axis.
  Index3 shifted(int place, const Index3& scale) const {
    const std::int64_t x = place & ((1 << shift_[0]) - 1);
    const std::int64_t y = place >> shift_[0] & ((1 << shift_[1]) - 1);
    const std::int64_t z = place >> (shift_[0] + shift_[1]);
    return {x << scale[0], y << scale[1], z << scale[2]};
  }

  BitVolume& blank_;
  Grid<std::int32_t>& values_;
  Index3 dims_;
  Index3 shift_;
  Index3 nodes_along_;
  std::int64_t row_words_;
  std::vector<Node> nodes_;
  std::vector<BitWord> rows_;  ///< nodes with blank voxels
  std::vector<std::int32_t> half_width_;
  int slab_axis_ = 2;
};

}  // namespace

void paint_balls(const std::vector<Ball>& balls, BitVolume& blank, Grid<std::int32_t>& values, RunContext& context) {
  if (balls.empty()) return;
  const std::int32_t largest = std::ranges::max_element(balls, {}, &Ball::reach)->reach;
  BallPainter(blank, largest, values).paint(balls, context);
}

std::uint64_t paint_balls_memory(const Index3& dims, std::int32_t largest_reach) {
  return BallPainter::memory(dims, largest_reach);
}

}  // namespace voxcarve
