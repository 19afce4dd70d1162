// Binary volumes of one bit a voxel.
#pragma once

#include <cstdint>

#include "common/run/context.h"
#include "common/volume/grid.h"

namespace voxcarve {

using BitWord = std::uint64_t;  ///< 64 voxels along x, the first in the lowest bit
inline constexpr std::int64_t kWordBits = 64;
inline constexpr BitWord kAllBits = ~BitWord{0};

/// Words that hold `bits` bits.
constexpr std::int64_t words_for(std::int64_t bits) {
  return (bits + kWordBits - 1) / kWordBits;
}

/// The bit of voxel i within its word.
constexpr BitWord bit_of(std::int64_t i) {
  return BitWord{1} << (i % kWordBits);
}

/// The bits of a row's last word that are voxels.
constexpr BitWord last_word_mask(std::int64_t bits) {
  return bits % kWordBits == 0 ? kAllBits : bit_of(bits) - 1;
}

/// All bits of the word when `bit`, else none.
constexpr BitWord spread(bool bit) {
  return bit ? kAllBits : 0;
}

/// Bit i of the result is the parity of bits 0 ... i.
constexpr BitWord prefix_parity(BitWord word) {
  for (int shift = 1; shift < kWordBits; shift *= 2) word ^= word << shift;
  return word;
}

/// Rows along x of whole words; the bits of a row's last word beyond the grid are 0.
class BitVolume {
 public:
  BitVolume() = default;
  /// Every word has yet to be written.
  explicit BitVolume(const Index3& dims)
      : dims_(dims), row_words_(words_for(dims[0])), words_(static_cast<std::size_t>(row_words_ * dims[1] * dims[2])) {}

  const Index3& dims() const { return dims_; }
  std::int64_t row_words() const { return row_words_; }
  BitWord* row(std::int64_t j, std::int64_t k) { return words_.data() + (k * dims_[1] + j) * row_words_; }
  const BitWord* row(std::int64_t j, std::int64_t k) const { return words_.data() + (k * dims_[1] + j) * row_words_; }
  BitWord& word(std::int64_t index) { return words_[static_cast<std::size_t>(index)]; }
  void clear() { words_.assign(words_.size(), 0); }

  /// Bytes that a volume of these dimensions holds.
  static std::uint64_t memory(const Index3& dims) {
    return static_cast<std::uint64_t>(words_for(dims[0]) * dims[1] * dims[2]) * sizeof(BitWord);
  }

 private:
  Index3 dims_ = Index3::Zero();
  std::int64_t row_words_ = 0;
  GridValues<BitWord> words_;
};

/// One byte a voxel. `frame` has the dimensions of `bits`.
BinaryVolume expanded(const BitVolume& bits, const GridFrame& frame, RunContext& context);

}  // namespace voxcarve
