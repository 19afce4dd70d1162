// The votes of directions that are no axis.
#pragma once

#include <cstdint>
#include <vector>

#include "common/run/context.h"
#include "common/volume/bit_volume.h"
#include "common/volume/column_votes.h"
#include "common/volume/curtains.h"
#include "common/volume/grid.h"

namespace voxcarve {

/// How many directions call a voxel interior (low four bits) and exterior (high four bits).
using VoteCount = std::uint8_t;

constexpr int interior_votes(VoteCount count) {
  return count & 15;
}
constexpr int exterior_votes(VoteCount count) {
  return count >> 4;
}

/// Adds the votes of the axes on a row of voxels along x.
void count_row(const RowVotes& votes, std::int64_t voxels, VoteCount* counts);

struct ObliqueVoteOptions {
  int directions = 13;      ///< of all, axes among them; a voxel with more than half of them for a class is decided
  bool stabbing = false;    ///< interior between the first and the last crossing, not by parity; one vote decides
  bool odd_abstain = true;  ///< rays with an odd number of crossings do not vote
};

/// What spares parity count most of its rays.
struct KnownParities {
  const Curtains& curtains;
  const BitVolume& along_x;  ///< parity of the crossings in front of every voxel of the slices, along x
};

/// Lets every voxel of `slices` that is still open vote along each of `directions`, one after the other; with `known`
/// those that are decided may vote on. `counts` are those of the slices. `held` are the bytes that the caller holds,
/// for the declaration of memory.
void vote_oblique(const TriangleSoup& soup, const GridFrame& frame, IndexRange slices,
                  const std::vector<Point>& directions, const ObliqueVoteOptions& options, const KnownParities* known,
                  std::uint64_t held, GridValues<VoteCount>& counts, Stage& stage, RunContext& context);

}  // namespace voxcarve
