// Disputed voxels: those that the votes of the directions leave open.
#pragma once

#include <cstdint>
#include <vector>

#include "common/run/context.h"
#include "common/volume/bit_volume.h"

namespace voxcarve {

/// The disputed ones among the 64 voxels of a word.
struct DisputedWord {
  std::int64_t index = 0;  ///< of the word in the volume
  BitWord voxels = 0;      ///< which ones
  BitWord voted = 0;       ///< classes of all 64 by the votes
  BitWord next = 0;        ///< classes to come
};

/// Lets disputed voxels take the class of most of their 26 neighbours, all at once, `sweeps` times; one with as many
/// interior as exterior neighbours keeps its class, and beyond the grid is exterior. The words are lists of pieces of
/// work for threads, each word in one of them. Returns how many voxels ended in another class than they had.
std::int64_t settle(BitVolume& volume, std::vector<std::vector<DisputedWord>>& disputed, int sweeps,
                    RunContext& context);

}  // namespace voxcarve
