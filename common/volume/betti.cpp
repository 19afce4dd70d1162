#include "common/volume/betti.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <vector>

#include "common/volume/labelling.h"

namespace voxcarve {

namespace {

/// What a 2 x 2 x 2 block adds whose lowest corner is bit 0: the cells that hold that corner's voxel as their lowest.
std::int64_t block_contribution(unsigned mask) {
  const auto all = [mask](unsigned cells) { return (mask & cells) == cells ? 1 : 0; };
  const int vertices = all(0x01);
  const int edges = all(0x03) + all(0x05) + all(0x11);
  const int squares = all(0x0F) + all(0x33) + all(0x55);
  const int cubes = all(0xFF);
  int separated = 0;
  for (const unsigned diagonal : {0x81U, 0x42U, 0x24U, 0x18U}) separated += mask == (0xFFU & ~diagonal) ? 1 : 0;
  return vertices - edges + squares - cubes + separated;
}

}  // namespace

std::int64_t euler_characteristic(const BinaryVolume& volume, const RunContext& context) {
  static const std::array<std::int64_t, 256> kContribution = [] {
    std::array<std::int64_t, 256> table{};
    for (unsigned mask = 0; mask < 256; ++mask) table[mask] = block_contribution(mask);
    return table;
  }();
  const std::int64_t nx = volume.nx();
  const std::int64_t ny = volume.ny();
  if (volume.values.empty()) return 0;
  const std::vector<std::uint8_t> exterior(static_cast<std::size_t>(nx), 0);  // the rows beyond the grid
  const auto row_of = [&](std::int64_t j, std::int64_t k) {
    return j < ny && k < volume.nz() ? volume.values.data() + volume.index(0, j, k) : exterior.data();
  };
  std::atomic<std::int64_t> characteristic = 0;
  // Cells are counted at their lowest corner; blocks begin inside the grid, because every cell's lowest corner does.
  constexpr std::int64_t kVoxelsPerChunk = 1 << 18;
  const std::int64_t grain = std::max<std::int64_t>(1, kVoxelsPerChunk / nx);
  parallel_for(context, 0, ny * volume.nz(), grain, [&](std::int64_t begin, std::int64_t end) {
    std::int64_t sum = 0;
    for (std::int64_t row = begin; row < end; ++row) {
      const std::int64_t j = row % ny;
      const std::int64_t k = row / ny;
      const std::array<const std::uint8_t*, 4> rows = {row_of(j, k), row_of(j + 1, k), row_of(j, k + 1),
                                                       row_of(j + 1, k + 1)};
      unsigned mask = 0;  // of the block that begins at voxel i
      for (std::int64_t i = -1; i < nx; ++i) {
        mask = mask >> 1 & 0x55U;
        for (unsigned r = 0; r < 4 && i + 1 < nx; ++r) mask |= (rows[r][i + 1] != 0 ? 2U : 0U) << 2 * r;
        if (i >= 0) sum += kContribution[mask];
      }
    }
    characteristic += sum;
  });
  return characteristic;
}

BettiNumbers betti_numbers(const BinaryVolume& volume, RunContext& context) {
  BettiNumbers betti;
  betti.b0 = count_interior_components(volume, Connectivity::kFace, context);
  const std::int64_t cavities = count_exterior_components(volume, Connectivity::kEdge, context) - 1;
  if (volume.frame.is_image()) {
    betti.b1 = cavities;
    return betti;
  }
  betti.b2 = cavities;
  betti.b1 = betti.b0 + betti.b2 - euler_characteristic(volume, context);
  return betti;
}

}  // namespace voxcarve
