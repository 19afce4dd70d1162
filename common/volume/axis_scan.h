// Scan conversion of triangles along the coordinate axes, for the voxelizer.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "common/mesh/triangle_soup.h"
#include "common/run/context.h"
#include "common/volume/grid.h"

namespace voxcarve {

using LatticePoint = std::array<std::int32_t, 3>;

/// The vertices of a soup in voxel units (voxel (i, j, k) has its centre at (i, j, k)), rounded to a lattice of
/// 2^-bits voxel so that edge functions are exact in 64 bits. The soup must outlive it.
class LatticeSoup {
 public:
  /// Throws InputError when the soup reaches 2^28 voxels or more beyond the grid.
  LatticeSoup(const TriangleSoup& soup, const GridFrame& frame, RunContext& context);

  const std::vector<LatticePoint>& points() const { return points_; }
  const std::vector<Triangle>& triangles() const { return *triangles_; }
  int bits() const { return bits_; }

 private:
  int bits_ = 16;
  std::vector<LatticePoint> points_;
  const std::vector<Triangle>* triangles_;
};

/// Indices of voxel centres, both ends included; empty when first > last.
struct IndexRange {
  std::int64_t first = 0;
  std::int64_t last = -1;

  bool empty() const { return first > last; }
  std::int64_t size() const { return last - first + 1; }
};

/// Those of `window` whose centres lie between the smallest and the largest of the corners' coordinates along `axis`.
inline IndexRange centers_between(const std::array<LatticePoint, 3>& corners, std::size_t axis, int bits,
                                  IndexRange window) {
  const auto [low, high] = std::minmax({corners[0][axis], corners[1][axis], corners[2][axis]});
  const std::int64_t before = (std::int64_t{1} << bits) - 1;  // shifts of signed numbers round down
  return {std::max((low + before) >> bits, window.first), std::min(std::int64_t{high >> bits}, window.last)};
}

/// Calls visit(u, v, first) for every ray parallel to `kAxis` within the window that crosses the triangle: (u, v) are
/// voxel indices along axes kAxis + 1 and kAxis + 2 (mod 3), and `first` is the index of the first voxel centre behind
/// the crossing, any integer. Everything is decided as if voxel centres were moved by (e, e^2, e^3) along x, y and z, e
/// an infinitesimal (simulation of simplicity [EM90]), so the three axes agree on a voxel centre that lies on the
/// surface. The ranges must not be empty, and lie within the triangle's own (`centers_between`). Defined in the header
/// because the visitor is called once a sample.
template <int kAxis, class Visit>
void scan_triangle(const std::array<LatticePoint, 3>& corners, int bits, IndexRange u, IndexRange v,
                   const Visit& visit);

// ---------------------------------------------------------------------------------------------------------------------

namespace scan_detail {

__extension__ using Wide = __int128;  ///< edge function times depth

/// A corner as rays of one axis see it; lattice steps.
struct Corner {
  std::int64_t u = 0, v = 0, depth = 0;
};

/// Twice the signed area of (a, b, p), exact: coordinates stay below 2^28.
inline std::int64_t edge_function(const Corner& a, const Corner& b, std::int64_t u, std::int64_t v) {
  return (b.u - a.u) * (v - a.v) - (b.v - a.v) * (u - a.u);
}

/// Where the edge function is zero: does the moved sample lie inside? Along y the rays' u is z and their v is x, so
/// there v is moved further than u.
template <int kAxis>
bool tie_is_inside(const Corner& a, const Corner& b) {
  const std::int64_t du = b.u - a.u;
  const std::int64_t dv = b.v - a.v;
  return kAxis == 1 ? du > 0 || (du == 0 && dv < 0) : dv < 0 || (dv == 0 && du > 0);
}

/// A side of a triangle on a raster: `value` is its edge function at the first sample, less one where a tie is outside,
/// so that samples inside are those with no negative value.
struct Side {
  std::int64_t value = 0;
  std::int64_t step_u = 0;
  std::int64_t step_v = 0;
  std::int64_t bias = 0;

  template <int kAxis>
  static Side of(const Corner& a, const Corner& b, int bits, std::int64_t first_u, std::int64_t first_v) {
    Side side;
    side.bias = tie_is_inside<kAxis>(a, b) ? 0 : 1;
    side.value = edge_function(a, b, first_u << bits, first_v << bits) - side.bias;
    side.step_u = -((b.v - a.v) << bits);
    side.step_v = (b.u - a.u) << bits;
    return side;
  }

  /// Cuts the samples with a negative value off `steps`, a range of steps along u from a sample with value `at`.
  void clip(std::int64_t at, IndexRange& steps) const {
    if (step_u > 0) {
      if (at < 0) steps.first = std::max(steps.first, (-at + step_u - 1) / step_u);
    } else if (at < 0) {
      steps.last = -1;
    } else if (step_u < 0) {
      steps.last = std::min(steps.last, at / -step_u);
    }
  }
};

/// Where rays cross the triangle's plane. Depths are tracked in units of 2^-kFraction voxel in doubles: the edge
/// functions at a sample lie between 0 and the area, so nothing cancels, and the rounding of some five operations on at
/// most 2^53 units stays below kClose. Only that close to a centre exact arithmetic has to tell the side.
template <int kAxis>
class Depth {
 public:
  Depth(const std::array<LatticePoint, 3>& corners, const std::array<Corner, 3>& p, std::int64_t area, int bits)
      : corners_(corners), p_(p), area_(area), bits_(bits) {
    constexpr double kUnit = std::int64_t{1} << kFraction;
    const double units = kUnit / static_cast<double>(std::int64_t{1} << bits);  // a lattice step, a power of two
    const double scale = units / static_cast<double>(area);
    base_ = static_cast<double>(p[0].depth) * units;
    along_e2_ = static_cast<double>(p[1].depth - p[0].depth) * scale;
    along_e0_ = static_cast<double>(p[2].depth - p[0].depth) * scale;
  }

  /// First voxel centre behind the crossing at a sample with edge functions e0 (of side 0-1) and e2 (of side 2-0).
  std::int64_t first_behind(std::int64_t e0, std::int64_t e2) const {
    const auto units =
        static_cast<std::int64_t>(base_ + static_cast<double>(e2) * along_e2_ + static_cast<double>(e0) * along_e0_);
    constexpr std::int64_t kMask = (std::int64_t{1} << kFraction) - 1;
    if (((units + kClose) & kMask) <= 2 * kClose) return exactly_behind((units + kClose) >> kFraction, e0, e2);
    return (units + kMask) >> kFraction;
  }

 private:
  std::int64_t exactly_behind(std::int64_t center, std::int64_t e0, std::int64_t e2) const {
    const Wide distance = static_cast<Wide>(p_[0].depth - (center << bits_)) * area_ +
                          static_cast<Wide>(e2) * (p_[1].depth - p_[0].depth) +
                          static_cast<Wide>(e0) * (p_[2].depth - p_[0].depth);
    const bool in_front = distance < 0 || (distance == 0 && tie_is_in_front());
    return in_front ? center : center + 1;
  }

  /// Does a crossing exactly at a voxel centre lie in front of the moved centre? Moving the centre by d moves it by
  /// (n . d) / n[axis] away from the plane; d is (e, e^2, e^3).
  bool tie_is_in_front() const {
    std::array<std::int64_t, 3> ab{};
    std::array<std::int64_t, 3> ac{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      ab[axis] = std::int64_t{corners_[1][axis]} - corners_[0][axis];
      ac[axis] = std::int64_t{corners_[2][axis]} - corners_[0][axis];
    }
    const std::array<std::int64_t, 3> normal = {ab[1] * ac[2] - ab[2] * ac[1], ab[2] * ac[0] - ab[0] * ac[2],
                                                ab[0] * ac[1] - ab[1] * ac[0]};
    const std::int64_t leading = normal[0] != 0 ? normal[0] : normal[1] != 0 ? normal[1] : normal[2];
    return (leading > 0) == (normal[kAxis] > 0);
  }

  static constexpr int kFraction = 24;
  static constexpr std::int64_t kClose = 32;
  const std::array<LatticePoint, 3>& corners_;
  const std::array<Corner, 3>& p_;
  std::int64_t area_;
  int bits_;
  double base_, along_e2_, along_e0_;
};

}  // namespace scan_detail

template <int kAxis, class Visit>
void scan_triangle(const std::array<LatticePoint, 3>& corners, int bits, IndexRange u, IndexRange v,
                   const Visit& visit) {
  using namespace scan_detail;
  constexpr std::size_t kU = (kAxis + 1) % 3;
  constexpr std::size_t kV = (kAxis + 2) % 3;
  std::array<Corner, 3> p;
  for (std::size_t i = 0; i < 3; ++i) p[i] = {corners[i][kU], corners[i][kV], corners[i][kAxis]};
  std::int64_t area = edge_function(p[0], p[1], p[2].u, p[2].v);
  if (area == 0) return;  // seen edge-on
  if (area < 0) {
    std::swap(p[1], p[2]);
    area = -area;
  }
  Side s0 = Side::of<kAxis>(p[0], p[1], bits, u.first, v.first);  // weight of corner 2
  Side s1 = Side::of<kAxis>(p[1], p[2], bits, u.first, v.first);  // of corner 0
  Side s2 = Side::of<kAxis>(p[2], p[0], bits, u.first, v.first);  // of corner 1
  if (u.size() == 1 && v.size() == 1) {                           // most triangles of a fine mesh
    if ((s0.value | s1.value | s2.value) < 0) return;
    visit(u.first, v.first, Depth<kAxis>(corners, p, area, bits).first_behind(s0.value + s0.bias, s2.value + s2.bias));
    return;
  }
  const Depth<kAxis> depth(corners, p, area, bits);
  constexpr std::int64_t kWide = 12;  // samples from which three divisions cost less than testing them all
  for (std::int64_t row = v.first; row <= v.last; ++row) {
    IndexRange steps{0, u.last - u.first};
    if (steps.last >= kWide) {
      s0.clip(s0.value, steps);
      s1.clip(s1.value, steps);
      s2.clip(s2.value, steps);
    }
    std::int64_t e0 = s0.value + steps.first * s0.step_u;
    std::int64_t e1 = s1.value + steps.first * s1.step_u;
    std::int64_t e2 = s2.value + steps.first * s2.step_u;
    for (std::int64_t step = steps.first; step <= steps.last; ++step) {
      if ((e0 | e1 | e2) >= 0) visit(u.first + step, row, depth.first_behind(e0 + s0.bias, e2 + s2.bias));
      e0 += s0.step_u;
      e1 += s1.step_u;
      e2 += s2.step_u;
    }
    s0.value += s0.step_v;
    s1.value += s1.step_v;
    s2.value += s2.step_v;
  }
}

}  // namespace voxcarve
