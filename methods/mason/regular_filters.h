// The filters of Williams and Rossignac: rounding, filleting, their combinations, and Mason.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/run/context.h"
#include "common/volume/bit_volume.h"

namespace voxcarve {

/// What can be asked of the family. With the ball of radius r:
enum class MorphologicalFilter {
  kDilate,  ///< S grown by r
  kErode,   ///< S shrunk by r
  kRound,   ///< R(S), the opening: shrunk, then grown
  kFillet,  ///< F(S), the closing: grown, then shrunk
  kRf,      ///< R(F(S))
  kFr,      ///< F(R(S))
  kMason,   ///< of each component of the mortar F(S) - R(S) what either RF or FR makes of it
};

/// Which filter a component of the mortar takes when both change the same number of voxels.
enum class TieRule {
  kPaper,     ///< RF [WR05, 4.3]; complements then differ
  kSelfDual,  ///< the side that the majority of S takes in it, and where that ties too, S at its first voxel
};

/// What Mason did.
struct MasonCounts {
  std::int64_t mortar_components = 0;
  std::int64_t by_rf = 0;  ///< components that took RF because it changes less
  std::int64_t by_fr = 0;
  std::int64_t ties = 0;  ///< components decided by the tie rule, beside those two
  std::int64_t mortar_voxels = 0;
};

/// Where Mason did it: voxels of the mortar.
struct MasonMaps {
  BitVolume took_fr;  ///< of components that took FR
  BitVolume tied;     ///< of components that the tie rule decided
};

/// The sets that the filters of one radius share, each made when it is first asked for: two transforms each, so Mason
/// takes the paper's eight. Everything is one bit a voxel on the grid of `shape`, which has to be padded by the ball
/// where `outside` is on the other side than what grows (see `ball_margin`). The references stay valid while the object
/// lives.
class RegularFilters {
 public:
  /// The ball is {|x|^2 <= reach}; `outside` is the value of everything outside the grid.
  RegularFilters(const BitVolume& shape, std::int64_t reach, bool outside, RunContext& context)
      : shape_(shape), reach_(reach), outside_(outside), context_(context) {}

  const BitVolume& shape() const { return shape_; }
  const BitVolume& rounded();
  const BitVolume& filleted();
  const BitVolume& rf();
  const BitVolume& fr();
  /// F(S) - R(S).
  BitVolume mortar();
  /// Mason [WR05, 4.2 and 4.3]; components of the mortar are 6-connected, in an image 4-connected. `held` are
  /// the bytes that are held meanwhile, this object's sets among them.
  BitVolume mason(TieRule tie, MasonCounts* counts = nullptr, MasonMaps* maps = nullptr, std::uint64_t held = 0);
  /// What the filter makes of the shape; gives up the sets that it made.
  BitVolume apply(MorphologicalFilter filter, TieRule tie, MasonCounts* counts = nullptr, std::uint64_t held = 0) &&;

 private:
  const BitVolume& shape_;
  std::int64_t reach_;
  bool outside_;
  RunContext& context_;
  std::optional<BitVolume> rounded_;
  std::optional<BitVolume> filleted_;
  std::optional<BitVolume> rf_;
  std::optional<BitVolume> fr_;
};

/// Number of voxels in which two volumes of the same dimensions differ.
std::int64_t count_difference(const BitVolume& a, const BitVolume& b, const RunContext& context);

/// Number of voxels that are set in `a` and not in `b`.
std::int64_t count_beyond(const BitVolume& a, const BitVolume& b, const RunContext& context);

/// Every voxel turned to the other side.
BitVolume complement(const BitVolume& volume, const RunContext& context);

}  // namespace voxcarve
