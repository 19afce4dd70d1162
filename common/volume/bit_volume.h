// Binary volumes of one bit a voxel.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>

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

/// Bit i of the result is set where bytes[i], 0 or 1, is 1; of 64 bytes.
inline BitWord gather_bits(const std::uint8_t* bytes) {
  BitWord word = 0;
  for (int byte = 0; byte < 8; ++byte) {
    std::uint64_t eight;
    std::memcpy(&eight, bytes + 8 * byte, sizeof(eight));
    word |= (eight * 0x0102040810204080U >> 56)
            << 8 * byte;  // collects the lowest bit of every byte in the highest one
  }
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
  std::int64_t words() const { return static_cast<std::int64_t>(words_.size()); }
  BitWord& word(std::int64_t index) { return words_[static_cast<std::size_t>(index)]; }
  bool get(std::int64_t i, std::int64_t j, std::int64_t k) const { return (row(j, k)[i / kWordBits] & bit_of(i)) != 0; }
  void clear() { words_.assign(words_.size(), 0); }
  bool operator==(const BitVolume& other) const { return (dims_ == other.dims_) && words_ == other.words_; }

  /// Bytes that a volume of these dimensions holds.
  static std::uint64_t memory(const Index3& dims) {
    return static_cast<std::uint64_t>(words_for(dims[0]) * dims[1] * dims[2]) * sizeof(BitWord);
  }

 private:
  Index3 dims_ = Index3::Zero();
  std::int64_t row_words_ = 0;
  GridValues<BitWord> words_;
};

/// One bit a voxel, with `margin` more voxels on every side along each axis, which are `outside`.
BitVolume packed(const BinaryVolume& volume, const Index3& margin, bool outside, RunContext& context);

/// One byte a voxel. `frame` has the dimensions of `bits`.
BinaryVolume expanded(const BitVolume& bits, const GridFrame& frame, RunContext& context);

/// Likewise the part of `bits` that is left when `margin` voxels are taken off on every side: `frame` has its
/// dimensions.
BinaryVolume expanded(const BitVolume& bits, const GridFrame& frame, const Index3& margin, RunContext& context);

/// Number of set bits.
std::int64_t count_set(const BitVolume& bits, const RunContext& context);

/// Calls combine(words, row_words, j, k) for every row of `bits`, on several threads: for operations word by word. The
/// bits beyond a row's end must stay 0; `last_word_mask` tells them.
template <class Combine>
void for_each_row(BitVolume& bits, const RunContext& context, const Combine& combine) {
  constexpr std::int64_t kWordsPerChunk = 1 << 14;
  const std::int64_t rows = bits.dims()[1] * bits.dims()[2];
  const std::int64_t grain = std::max<std::int64_t>(1, kWordsPerChunk / std::max<std::int64_t>(bits.row_words(), 1));
  parallel_for(context, 0, rows, grain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t row = begin; row < end; ++row) {
      const std::int64_t j = row % bits.dims()[1];
      const std::int64_t k = row / bits.dims()[1];
      combine(bits.row(j, k), bits.row_words(), j, k);
    }
  });
}

}  // namespace voxcarve
