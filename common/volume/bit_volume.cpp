#include "common/volume/bit_volume.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <numeric>
#include <vector>

namespace voxcarve {

namespace {

/// The bytes of eight voxels for every eight bits.
constexpr auto kBytesOf = [] {
  std::array<std::array<std::uint8_t, 8>, 256> table{};
  for (std::size_t bits = 0; bits < table.size(); ++bits) {
    for (std::size_t i = 0; i < 8; ++i) table[bits][i] = static_cast<std::uint8_t>(bits >> i & 1);
  }
  return table;
}();

void expand_word(BitWord word, std::uint8_t* out) {
  if (word == 0 || word == kAllBits) {
    std::memset(out, word == 0 ? 0 : 1, kWordBits);
    return;
  }
  for (std::size_t byte = 0; byte < 8; ++byte) std::memcpy(out + 8 * byte, kBytesOf[word >> 8 * byte & 0xff].data(), 8);
}

/// Bits `first` ... `first` + 63 of a row of `row_words` words; those beyond it are 0.
BitWord bits_from(const BitWord* row, std::int64_t row_words, std::int64_t first) {
  const std::int64_t w = first / kWordBits;
  const auto shift = static_cast<int>(first % kWordBits);
  BitWord bits = w < row_words ? row[w] >> shift : 0;
  if (shift != 0 && w + 1 < row_words) bits |= row[w + 1] << (kWordBits - shift);
  return bits;
}

/// A row of `nx` bytes as bits, `margin` places on; the places around it are `outside`.
void pack_row(const std::uint8_t* bytes, std::int64_t nx, std::int64_t margin, bool outside, BitWord* row,
              std::int64_t row_words) {
  for (std::int64_t w = 0; w < row_words; ++w) {
    const std::int64_t from = w * kWordBits - margin;
    if (from >= 0 && from + kWordBits <= nx) {
      row[w] = gather_bits(bytes + from);
      continue;
    }
    std::array<std::uint8_t, kWordBits> part;
    part.fill(outside ? 1 : 0);
    const std::int64_t begin = std::max<std::int64_t>(from, 0);
    const std::int64_t end = std::min(from + kWordBits, nx);
    if (begin < end) std::copy(bytes + begin, bytes + end, part.begin() + (begin - from));
    row[w] = gather_bits(part.data());
  }
}

}  // namespace

BitVolume packed(const BinaryVolume& volume, const Index3& margin, bool outside, RunContext& context) {
  const Index3 dims = volume.frame.dims + 2 * margin;
  BitVolume bits(dims);
  if (dims[0] == 0) return bits;
  for_each_row(bits, context, [&](BitWord* row, std::int64_t row_words, std::int64_t j, std::int64_t k) {
    const Index3 from(0, j - margin[1], k - margin[2]);
    if (volume.frame.contains(from)) {
      pack_row(volume.values.data() + volume.index(0, from[1], from[2]), volume.nx(), margin[0], outside, row,
               row_words);
    } else {
      std::fill_n(row, row_words, spread(outside));
    }
    row[row_words - 1] &= last_word_mask(dims[0]);
  });
  return bits;
}

BinaryVolume expanded(const BitVolume& bits, const GridFrame& frame, const Index3& margin, RunContext& context) {
  BinaryVolume volume = BinaryVolume::uninitialized(frame);
  const std::int64_t nx = frame.dims[0];
  parallel_for(context, 0, frame.dims[2], 4, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t k = begin; k < end; ++k) {
      for (std::int64_t j = 0; j < frame.dims[1]; ++j) {
        const BitWord* row = bits.row(j + margin[1], k + margin[2]);
        std::uint8_t* out = volume.values.data() + volume.index(0, j, k);
        std::int64_t i = 0;
        for (; i + kWordBits <= nx; i += kWordBits)
          expand_word(bits_from(row, bits.row_words(), i + margin[0]), out + i);
        if (i == nx) continue;
        std::array<std::uint8_t, kWordBits> tail;
        expand_word(bits_from(row, bits.row_words(), i + margin[0]), tail.data());
        std::memcpy(out + i, tail.data(), static_cast<std::size_t>(nx - i));
      }
    }
  });
  return volume;
}

BinaryVolume expanded(const BitVolume& bits, const GridFrame& frame, RunContext& context) {
  return expanded(bits, frame, Index3::Zero(), context);
}

std::int64_t count_set(const BitVolume& bits, const RunContext& context) {
  const std::int64_t rows = bits.dims()[1] * bits.dims()[2];
  constexpr std::int64_t kRowsPerChunk = 1 << 10;
  std::vector<std::int64_t> counts(static_cast<std::size_t>(rows / kRowsPerChunk + 1));
  parallel_for(context, 0, rows, kRowsPerChunk, [&](std::int64_t begin, std::int64_t end) {
    const BitWord* words = bits.row(0, 0) + begin * bits.row_words();
    std::int64_t count = 0;
    for (std::int64_t w = 0; w < (end - begin) * bits.row_words(); ++w) count += std::popcount(words[w]);
    counts[static_cast<std::size_t>(begin / kRowsPerChunk)] = count;
  });
  return std::accumulate(counts.begin(), counts.end(), std::int64_t{0});
}

}  // namespace voxcarve
