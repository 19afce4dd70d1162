#include "common/volume/betti.h"

#include <array>
#include <bit>

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

std::int64_t euler_characteristic(const BinaryVolume& volume) {
  static const std::array<std::int64_t, 256> kContribution = [] {
    std::array<std::int64_t, 256> table{};
    for (unsigned mask = 0; mask < 256; ++mask) table[mask] = block_contribution(mask);
    return table;
  }();
  std::int64_t characteristic = 0;
  // Cells are counted at their lowest corner; blocks begin inside the grid, because every cell's lowest corner does.
  for (std::int64_t k = 0; k < volume.nz(); ++k) {
    for (std::int64_t j = 0; j < volume.ny(); ++j) {
      for (std::int64_t i = 0; i < volume.nx(); ++i) {
        unsigned mask = 0;
        for (unsigned corner = 0; corner < 8; ++corner) {
          if (volume.get(i + (corner & 1U), j + (corner >> 1 & 1U), k + (corner >> 2 & 1U), 0) != 0)
            mask |= 1U << corner;
        }
        characteristic += kContribution[mask];
      }
    }
  }
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
  betti.b1 = betti.b0 + betti.b2 - euler_characteristic(volume);
  return betti;
}

}  // namespace voxcarve
