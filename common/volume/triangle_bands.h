// Triangles sorted by the layers of voxels that they reach.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/run/context.h"
#include "common/volume/axis_scan.h"

namespace voxcarve {

/// Bands of `thickness` layers of voxels across an axis, and the triangles that may cross rays within each. A triangle
/// is listed in every band that it reaches, and in none when its box holds no sample of any of the rays.
class TriangleBands {
 public:
  /// `rays` says along which axes rays will be cast; `axis` is not one of them. `held` are the bytes that the caller
  /// holds, for the declaration of memory.
  TriangleBands(const LatticeSoup& soup, const Index3& dims, std::size_t axis, std::int64_t thickness,
                const std::array<bool, 3>& rays, std::uint64_t held, RunContext& context);

  std::int64_t count() const { return bands_; }
  /// The layers of a band.
  IndexRange layers(std::int64_t band) const {
    return {band * thickness_, std::min((band + 1) * thickness_, layers_) - 1};
  }
  /// Indices of its triangles.
  std::span<const std::uint32_t> triangles(std::int64_t band) const {
    const auto at = static_cast<std::size_t>(band);
    return std::span(items_).subspan(begin_[at], begin_[at + 1] - begin_[at]);
  }
  /// Bytes that it holds.
  std::uint64_t memory() const { return items_.size() * sizeof(std::uint32_t) + begin_.size() * sizeof(std::size_t); }

 private:
  std::int64_t layers_;
  std::int64_t thickness_;
  std::int64_t bands_;
  std::vector<std::size_t> begin_;  ///< bands + 1 offsets into items_
  std::vector<std::uint32_t> items_;
};

}  // namespace voxcarve
