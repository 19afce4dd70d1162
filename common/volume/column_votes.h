// The votes of the rays along the coordinate axes on every voxel of a grid, 64 voxels at a time.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "common/run/context.h"
#include "common/volume/axis_scan.h"
#include "common/volume/bit_volume.h"

namespace voxcarve {

struct ColumnVoteOptions {
  std::array<bool, 3> axes = {true, true, true};  ///< along which rays are cast
  bool stabbing = false;                          ///< interior between the first and the last crossing, not by parity
  bool odd_abstain = true;                        ///< columns with an odd number of crossings do not vote
};

/// What the axes say of a row of voxels along x. Axes without rays have null pointers. Bits beyond the grid are
/// arbitrary.
struct RowVotes {
  std::array<const BitWord*, 3> interior{};  ///< 1 where the axis says interior
  std::array<const BitWord*, 3> abstains{};  ///< 1 where it has no vote, whatever `interior` says
};

/// Casts rays along the axes, through slabs of slices. Toggles along x and y live while their slab is in the cache;
/// columns along z cross all slabs, so they are classified before, in a volume of bits, by bands across y.
class ColumnVotes {
 public:
  /// Classifies along z into `volume`, which has the grid's dimensions; slabs read it. All must outlive this object.
  /// `held` are the bytes that the caller holds beside lattice and volume, for the declaration of memory.
  ColumnVotes(const LatticeSoup& soup, BitVolume& volume, const ColumnVoteOptions& options, std::uint64_t held,
              Stage& stage, RunContext& context);
  ~ColumnVotes();
  ColumnVotes(const ColumnVotes&) = delete;
  ColumnVotes& operator=(const ColumnVotes&) = delete;

  std::int64_t slabs() const;
  /// The slices of a slab.
  IndexRange slices(std::int64_t slab) const;

  using RowConsumer = std::function<void(std::int64_t j, std::int64_t k, const RowVotes& votes)>;
  /// Calls consume for every row of the slab, slice by slice. A row of `volume` may be overwritten when consumed. Slabs
  /// may be classified on several threads at once, each of them once.
  void classify_slab(std::int64_t slab, const RowConsumer& consume);

  /// Bytes that are held at most, in all.
  std::uint64_t memory() const { return held_; }

  /// Columns along an axis that some crossing fell into, and those with an odd number of them; once all slabs are
  /// classified.
  std::int64_t columns(std::size_t axis) const { return columns_[axis]; }
  std::int64_t odd_columns(std::size_t axis) const { return odd_columns_[axis]; }

 private:
  struct Slabs;
  void classify_along_z();

  const LatticeSoup& soup_;
  BitVolume& volume_;
  ColumnVoteOptions options_;
  std::uint64_t held_;
  Stage& stage_;
  RunContext& context_;
  std::vector<BitWord> nobody_;  ///< a row of zeros
  std::vector<BitWord> z_odd_;   ///< columns along z, rows of words along x
  std::array<std::atomic<std::int64_t>, 3> columns_{};
  std::array<std::atomic<std::int64_t>, 3> odd_columns_{};
  std::unique_ptr<Slabs> slabs_;
};

}  // namespace voxcarve
