#include "common/volume/bit_volume.h"

#include <algorithm>
#include <array>
#include <cstring>

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

}  // namespace

BinaryVolume expanded(const BitVolume& bits, const GridFrame& frame, RunContext& context) {
  BinaryVolume volume = BinaryVolume::uninitialized(frame);
  const std::int64_t nx = frame.dims[0];
  const std::int64_t whole = nx / kWordBits;
  parallel_for(context, 0, frame.dims[2], 4, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t k = begin; k < end; ++k) {
      for (std::int64_t j = 0; j < frame.dims[1]; ++j) {
        const BitWord* row = bits.row(j, k);
        std::uint8_t* out = volume.values.data() + volume.index(0, j, k);
        for (std::int64_t w = 0; w < whole; ++w) expand_word(row[w], out + w * kWordBits);
        if (whole == bits.row_words()) continue;
        std::array<std::uint8_t, kWordBits> tail;
        expand_word(row[whole], tail.data());
        std::memcpy(out + whole * kWordBits, tail.data(), static_cast<std::size_t>(nx - whole * kWordBits));
      }
    }
  });
  return volume;
}

}  // namespace voxcarve
