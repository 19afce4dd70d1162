#include "common/volume/settling.h"

#include <array>
#include <atomic>
#include <bit>

namespace voxcarve {

namespace {

/// A row of voxels where it is in the grid; beyond it no voxel is interior.
struct Row {
  const BitWord* words = nullptr;
  std::int64_t count = 0;

  BitWord at(std::int64_t word) const { return words != nullptr && word >= 0 && word < count ? words[word] : 0; }
};

/// 64 numbers of five binary digits, digit by digit.
struct Counters {
  std::array<BitWord, 5> digits{};

  /// Adds one number of two digits to each.
  void add(BitWord low, BitWord high) {
    BitWord carry = digits[0] & low;
    digits[0] ^= low;
    const BitWord next = (digits[1] & high) | (carry & (digits[1] ^ high));
    digits[1] ^= high ^ carry;
    carry = next;
    for (std::size_t i = 2; i < digits.size(); ++i) {
      const BitWord up = digits[i] & carry;
      digits[i] ^= carry;
      carry = up;
    }
  }
  BitWord at_least_14() const { return digits[4] | (digits[3] & digits[2] & digits[1]); }
};

/// Which voxels of a word have the class "interior" after a sweep. Most of 26 neighbours, and the voxel itself where
/// they are even, is most of all 27.
BitWord most_of_27(const BitVolume& volume, std::int64_t j, std::int64_t k, std::int64_t word) {
  Counters counters;
  for (std::int64_t dk = -1; dk <= 1; ++dk) {
    for (std::int64_t dj = -1; dj <= 1; ++dj) {
      const bool in_grid = j + dj >= 0 && j + dj < volume.dims()[1] && k + dk >= 0 && k + dk < volume.dims()[2];
      if (!in_grid) continue;
      const Row row{volume.row(j + dj, k + dk), volume.row_words()};
      const BitWord here = row.at(word);
      const BitWord before = here << 1 | row.at(word - 1) >> (kWordBits - 1);
      const BitWord behind = here >> 1 | row.at(word + 1) << (kWordBits - 1);
      counters.add(before ^ here ^ behind, (before & here) | (behind & (before ^ here)));
    }
  }
  return counters.at_least_14();
}

}  // namespace

std::int64_t settle(BitVolume& volume, std::vector<std::vector<DisputedWord>>& disputed, int sweeps,
                    RunContext& context) {
  const auto for_each_word = [&](const auto& visit) {
    parallel_for(context, 0, static_cast<std::int64_t>(disputed.size()), 1, [&](std::int64_t piece, std::int64_t) {
      for (DisputedWord& word : disputed[static_cast<std::size_t>(piece)]) visit(word);
    });
  };
  std::atomic<bool> moved = true;
  for (int sweep = 0; sweep < sweeps && moved; ++sweep) {
    for_each_word([&](DisputedWord& at) {
      const std::int64_t row = at.index / volume.row_words();
      const BitWord most =
          most_of_27(volume, row % volume.dims()[1], row / volume.dims()[1], at.index % volume.row_words());
      at.next = (volume.word(at.index) & ~at.voxels) | (most & at.voxels);
    });
    moved = false;
    for_each_word([&](const DisputedWord& at) {
      if (volume.word(at.index) == at.next) return;
      volume.word(at.index) = at.next;
      moved = true;
    });
  }
  std::atomic<std::int64_t> changed = 0;
  for_each_word(
      [&](const DisputedWord& at) { changed += std::popcount((volume.word(at.index) ^ at.voted) & at.voxels); });
  return changed;
}

}  // namespace voxcarve
