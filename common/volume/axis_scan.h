// Scan conversion of a soup along a coordinate axis, for the voxelizer.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "common/mesh/triangle_soup.h"
#include "common/run/context.h"
#include "common/volume/grid.h"

namespace voxcarve {

/// The vertices of a soup in voxel units (voxel (i, j, k) has its centre at (i, j, k)), rounded to a lattice of
/// 2^-bits voxel so that edge functions are exact in 64 bits.
class LatticeSoup {
 public:
  LatticeSoup(const TriangleSoup& soup, const GridFrame& frame);

  using LatticePoint = Eigen::Matrix<std::int64_t, 3, 1>;
  const std::vector<LatticePoint>& points() const { return points_; }
  const std::vector<Triangle>& triangles() const { return *triangles_; }
  std::int64_t one() const { return std::int64_t{1} << bits_; }

 private:
  int bits_ = 16;
  std::vector<LatticePoint> points_;
  const std::vector<Triangle>* triangles_;
};

/// Calls visit(u, v, first) for every ray parallel to `axis` and triangle that cross: (u, v) are the voxel indices
/// along axes axis + 1 and axis + 2 (mod 3), and `first` is the index of the first voxel centre behind the crossing, in
/// [0, dims[axis]]. Everything is decided as if voxel centres were moved by (e, e^2, e^3) along x, y and z, e an
/// infinitesimal (simulation of simplicity [EM90]), so the three axes agree on a voxel centre that lies on the surface.
/// Defined in the header because the visitor is called once a sample.
template <class Visit>
void scan_convert(const LatticeSoup& soup, const GridFrame& frame, int axis, Stage& stage, const Visit& visit);

// ---------------------------------------------------------------------------------------------------------------------

namespace scan_detail {

struct Point2 {
  std::int64_t u = 0, v = 0;
};

/// Twice the signed area of (a, b, p), exact.
inline std::int64_t edge_function(Point2 a, Point2 b, Point2 p) {
  return (b.u - a.u) * (p.v - a.v) - (b.v - a.v) * (p.u - a.u);
}

/// Where the edge function is zero: does the moved sample lie inside? Along y the rays' u is z and their v is x, so
/// there v is moved further than u.
inline bool tie_is_inside(Point2 a, Point2 b, bool v_moves_further) {
  const std::int64_t du = b.u - a.u;
  const std::int64_t dv = b.v - a.v;
  return v_moves_further ? du > 0 || (du == 0 && dv < 0) : dv < 0 || (dv == 0 && du > 0);
}

__extension__ using Wide = __int128;  ///< edge function times depth

inline std::int64_t ceil_div(std::int64_t value, std::int64_t divisor) {
  return value >= 0 ? (value + divisor - 1) / divisor : -(-value / divisor);
}
inline std::int64_t floor_div(std::int64_t value, std::int64_t divisor) {
  return -ceil_div(-value, divisor);
}

/// A triangle prepared for one axis: corners counterclockwise in (u, v), depths in lattice steps.
struct ScanTriangle {
  std::array<Point2, 3> p;
  std::array<std::int64_t, 3> depth{};
  std::int64_t area = 0;         ///< twice the projected area; 0 when seen edge-on
  bool tie_is_in_front = false;  ///< a crossing exactly at a voxel centre lies in front of the moved centre

  ScanTriangle(const LatticeSoup::LatticePoint& a, const LatticeSoup::LatticePoint& b,
               const LatticeSoup::LatticePoint& c, int axis)
      : p{Point2{a[(axis + 1) % 3], a[(axis + 2) % 3]}, Point2{b[(axis + 1) % 3], b[(axis + 2) % 3]},
          Point2{c[(axis + 1) % 3], c[(axis + 2) % 3]}},
        depth{a[axis], b[axis], c[axis]} {
    area = edge_function(p[0], p[1], p[2]);
    if (area == 0) return;
    // Moving the centre by d moves the crossing by (n . d) / n[axis] in front of it; d is (e, e^2, e^3).
    const LatticeSoup::LatticePoint normal = (b - a).cross(c - a);
    const std::int64_t leading = normal[0] != 0 ? normal[0] : normal[1] != 0 ? normal[1] : normal[2];
    tie_is_in_front = (leading > 0) == (normal[axis] > 0);
    if (area < 0) {
      std::swap(p[1], p[2]);
      std::swap(depth[1], depth[2]);
      area = -area;
    }
  }

  /// First voxel centre behind the crossing at a sample with edge functions e0 (of side 0-1) and e2 (of side 2-0).
  std::int64_t first_behind(std::int64_t e0, std::int64_t e2, std::int64_t one) const {
    const double weight = 1.0 / (static_cast<double>(area) * static_cast<double>(one));
    const double crossing = static_cast<double>(depth[0]) / static_cast<double>(one) +
                            (static_cast<double>(e2) * static_cast<double>(depth[1] - depth[0]) +
                             static_cast<double>(e0) * static_cast<double>(depth[2] - depth[0])) *
                                weight;
    const double nearest = std::round(crossing);
    constexpr double kCloseToCenter = 1e-6;  // voxels; far above the rounding of the lines before
    if (std::abs(crossing - nearest) > kCloseToCenter) return static_cast<std::int64_t>(std::ceil(crossing));
    // So close to a centre only exact arithmetic tells the side.
    const auto center = static_cast<std::int64_t>(nearest);
    const Wide distance = static_cast<Wide>(depth[0] - center * one) * area +
                          static_cast<Wide>(e2) * (depth[1] - depth[0]) + static_cast<Wide>(e0) * (depth[2] - depth[0]);
    const bool in_front = distance < 0 || (distance == 0 && tie_is_in_front);
    return in_front ? center : center + 1;
  }
};

}  // namespace scan_detail

template <class Visit>
void scan_convert(const LatticeSoup& soup, const GridFrame& frame, int axis, Stage& stage, const Visit& visit) {
  using namespace scan_detail;
  const int u_axis = (axis + 1) % 3;
  const int v_axis = (axis + 2) % 3;
  const std::int64_t one = soup.one();
  constexpr std::int64_t kReportEvery = 4096;    // triangles
  constexpr std::int64_t kCheckEvery = 1 << 17;  // samples, for cancellation within large triangles
  std::int64_t visited = 0;
  std::int64_t unchecked = 0;
  for (const Triangle& triangle : soup.triangles()) {
    if (++visited % kReportEvery == 0) stage.advance(kReportEvery);
    const auto& points = soup.points();
    const ScanTriangle scan(points[triangle[0]], points[triangle[1]], points[triangle[2]], axis);
    if (scan.area == 0) continue;
    const auto& p = scan.p;
    const auto [u_low, u_high] = std::minmax({p[0].u, p[1].u, p[2].u});
    const auto [v_low, v_high] = std::minmax({p[0].v, p[1].v, p[2].v});
    const std::int64_t u_first = std::max<std::int64_t>(ceil_div(u_low, one), 0);
    const std::int64_t u_last = std::min(floor_div(u_high, one), frame.dims[u_axis] - 1);
    const std::int64_t v_first = std::max<std::int64_t>(ceil_div(v_low, one), 0);
    const std::int64_t v_last = std::min(floor_div(v_high, one), frame.dims[v_axis] - 1);
    std::array<std::int64_t, 3> bias{};
    for (std::size_t side = 0; side < 3; ++side)
      bias[side] = tie_is_inside(p[side], p[(side + 1) % 3], axis == 1) ? 0 : 1;
    for (std::int64_t v = v_first; v <= v_last; ++v) {
      unchecked += u_last - u_first + 1;
      if (unchecked > kCheckEvery) {
        stage.advance(0);
        unchecked = 0;
      }
      Point2 sample{u_first * one, v * one};
      for (std::int64_t u = u_first; u <= u_last; ++u, sample.u += one) {
        const std::int64_t e0 = edge_function(p[0], p[1], sample);  // weight of corner 2
        const std::int64_t e1 = edge_function(p[1], p[2], sample);  // of corner 0
        const std::int64_t e2 = edge_function(p[2], p[0], sample);  // of corner 1
        if (e0 < bias[0] || e1 < bias[1] || e2 < bias[2]) continue;
        visit(u, v, std::clamp<std::int64_t>(scan.first_behind(e0, e2, one), 0, frame.dims[axis]));
      }
    }
  }
  stage.advance(visited % kReportEvery);
}

}  // namespace voxcarve
