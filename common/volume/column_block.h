// What rays along one axis meet in a block of voxel columns, as bits.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>
#include <vector>

#include "common/volume/axis_scan.h"
#include "common/volume/bit_volume.h"

namespace voxcarve {

/// Columns along `kAxis` through some layers of a grid: along x and y through slices across z, along z through rows
/// across y. A crossing toggles one bit, that of the first voxel behind it, so that the running parity of the toggles
/// along a column classifies its voxels. For ray stabbing the first and the last crossing alone toggle.
///
/// Columns are named by (across, layer): `across` counts along y for rays along x, along x for the others. Planes over
/// the columns have a row of words for every layer.
template <int kAxis>
class ColumnBlock {
 public:
  static constexpr Eigen::Index kLayerAxis = kAxis == 2 ? 1 : 2;
  static constexpr Eigen::Index kAcrossAxis = kAxis == 0 ? 1 : 0;

  ColumnBlock(const Index3& dims, std::int64_t layers, bool stabbing)
      : dims_(dims),
        row_words_(words_for(dims[0])),
        plane_words_(words_for(dims[kAcrossAxis])),
        rows_per_layer_(kAxis == 2 ? 1 : dims[1]),
        layer_stride_(kAxis == 2 ? layers : 1),
        toggles_(static_cast<std::size_t>(layers * dims[kAxis == 0 ? 1 : kAxis] * row_words_), 0),
        odd_(static_cast<std::size_t>(layers * plane_words_), 0),
        met_(static_cast<std::size_t>(layers * plane_words_), 0),
        spans_(stabbing ? static_cast<std::size_t>(layers * dims[kAcrossAxis]) : 0) {}

  /// Bytes that such a block holds.
  static std::uint64_t memory(const Index3& dims, std::int64_t layers, bool stabbing) {
    const std::int64_t words = dims[kAxis == 0 ? 1 : kAxis] * words_for(dims[0]) + 2 * words_for(dims[kAcrossAxis]);
    const std::uint64_t spans = stabbing ? static_cast<std::uint64_t>(dims[kAcrossAxis]) * sizeof(Span) : 0;
    return static_cast<std::uint64_t>(layers) * (static_cast<std::uint64_t>(words) * sizeof(BitWord) + spans);
  }

  /// Adds what the triangle's samples in `layers` meet; `centers` are the ranges of its box within the grid. Returns
  /// how many samples its box holds.
  std::int64_t add(const std::array<LatticePoint, 3>& corners, int bits, std::array<IndexRange, 3> centers,
                   IndexRange layers) {
    IndexRange& cut = centers[static_cast<std::size_t>(kLayerAxis)];
    cut = {std::max(cut.first, layers.first), std::min(cut.last, layers.last)};
    const IndexRange u = centers[(kAxis + 1) % 3];
    const IndexRange v = centers[(kAxis + 2) % 3];
    if (u.empty() || v.empty()) return 0;
    scan_triangle<kAxis>(corners, bits, u, v, [&](std::int64_t at_u, std::int64_t at_v, std::int64_t first) {
      const std::int64_t across = kAxis == 1 ? at_v : at_u;
      const std::int64_t layer = (kAxis == 1 ? at_u : at_v) - layers.first;
      const auto word = static_cast<std::size_t>(layer * plane_words_ + across / kWordBits);
      odd_[word] ^= bit_of(across);
      met_[word] |= bit_of(across);
      first = std::clamp<std::int64_t>(first, 0, dims_[kAxis]);
      if (spans_.empty()) {
        toggle(across, layer, first);
      } else {
        Span& span = spans_[static_cast<std::size_t>(layer * dims_[kAcrossAxis] + across)];
        span.first = std::min(span.first, static_cast<std::int32_t>(first));
        span.last = std::max(span.last, static_cast<std::int32_t>(first));
      }
    });
    return u.size() * v.size();
  }

  /// To be called when all triangles were added, before toggles are read: ray stabbing turns its spans into toggles.
  void finish() {
    if (spans_.empty()) return;
    for (std::size_t word = 0; word < met_.size(); ++word) {
      for (BitWord met = met_[word]; met != 0; met &= met - 1) {
        const std::int64_t layer = static_cast<std::int64_t>(word) / plane_words_;
        const std::int64_t across = static_cast<std::int64_t>(word) % plane_words_ * kWordBits + std::countr_zero(met);
        Span& span = spans_[static_cast<std::size_t>(layer * dims_[kAcrossAxis] + across)];
        toggle(across, layer, span.first);  // equal ones cancel
        toggle(across, layer, span.last);
        span = {};
      }
    }
  }

  /// Toggles of the row of voxels at `position` along y (along z for rays along z) in a layer. The reader zeroes them.
  BitWord* toggles(std::int64_t layer, std::int64_t position) {
    return toggles_.data() + row_of(layer, position) * row_words_;
  }
  /// Which columns of a layer have an odd number of crossings.
  const BitWord* odd(std::int64_t layer) const { return odd_.data() + layer * plane_words_; }
  bool is_odd(std::int64_t across, std::int64_t layer) const {
    return (odd(layer)[across / kWordBits] & bit_of(across)) != 0;
  }

  struct Counts {
    std::int64_t met = 0;  ///< columns that some crossing fell into
    std::int64_t odd = 0;
  };
  Counts counts() const {
    Counts counts;
    for (const BitWord word : met_) counts.met += std::popcount(word);
    for (const BitWord word : odd_) counts.odd += std::popcount(word);
    return counts;
  }

  /// Forgets the columns; toggles were zeroed by their reader.
  void clear() {
    std::ranges::fill(odd_, 0);
    std::ranges::fill(met_, 0);
  }

 private:
  struct Span {
    std::int32_t first = std::numeric_limits<std::int32_t>::max();
    std::int32_t last = -1;
  };

  std::int64_t row_of(std::int64_t layer, std::int64_t position) const {
    return layer * rows_per_layer_ + position * layer_stride_;
  }
  /// A crossing behind the last voxel centre toggles nothing.
  void toggle(std::int64_t across, std::int64_t layer, std::int64_t first) {
    if (first >= dims_[kAxis]) return;
    const std::int64_t row = kAxis == 0 ? row_of(layer, across) : row_of(layer, first);
    const std::int64_t x = kAxis == 0 ? first : across;
    toggles_[static_cast<std::size_t>(row * row_words_ + x / kWordBits)] ^= bit_of(x);
  }

  Index3 dims_;
  std::int64_t row_words_;
  std::int64_t plane_words_;
  std::int64_t rows_per_layer_;
  std::int64_t layer_stride_;
  std::vector<BitWord> toggles_;
  std::vector<BitWord> odd_;
  std::vector<BitWord> met_;
  std::vector<Span> spans_;
};

}  // namespace voxcarve
