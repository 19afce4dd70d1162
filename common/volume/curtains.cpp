// Crossings of rows with curtains are decided on the lattice of the axes' rays, with its moved centres, so that surface
// and curtains together are closed for every row: a parity once right stays right along it.
#include "common/volume/curtains.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <span>

namespace voxcarve {

namespace {

constexpr int kLatticeBits = 16;                ///< of LatticeSoup, where it has all its digits
constexpr std::int64_t kLargestGrid = 1 << 13;  ///< voxels a side
constexpr double kBeyond = 0x1p15;              ///< voxels; leaves such a grid from wherever such a soup is
/// Voxels. Rays along the axes see vertices rounded to 2^-16 voxel, others see them rounded to 2^-14, voxel centres
/// moved by 2^-10, and directions that differ from the lattice's by 2^-12.6 at the far end: together less than 3/4 of
/// this.
constexpr double kNear = 0x1p-9;
constexpr std::int64_t kGrain = 1024;  // triangles or edges

Point in_voxels(const LatticePoint& point) {
  return Point(point[0], point[1], point[2]) * std::ldexp(1.0, -kLatticeBits);
}

/// A vector at right angles to `direction`.
Point perpendicular(const Point& direction) {
  Eigen::Index smallest = 0;
  direction.cwiseAbs().minCoeff(&smallest);
  const Point result = direction.cross(Point::Unit(smallest));
  return result.isZero(0) ? Point(Point::UnitZ()) : result;
}

/// Sets marks from any thread.
class Marker {
 public:
  Marker(const Index3& dims, IndexRange slices, BitVolume& marks) : slices_(slices), marks_(marks) {
    low_ = Index3(0, 0, slices.first);
    high_ = Index3(dims[0] - 1, dims[1] - 1, slices.last);
  }

  /// Marks, among others, the voxels within kNear of a convex flat polygon. Any normal at right angles to all its sides
  /// will do when it has no area.
  void mark(std::span<const Point> polygon, const Point& normal) const {
    Eigen::Index along = 0;
    normal.cwiseAbs().maxCoeff(&along);
    const Eigen::Index u = (along + 1) % 3;
    const Eigen::Index v = (along + 2) % 3;
    double u_low = polygon[0][u];
    double u_high = u_low;
    for (const Point& corner : polygon) {
      u_low = std::min(u_low, corner[u]);
      u_high = std::max(u_high, corner[u]);
    }
    const Point& a = polygon[0];
    const double slope_u = normal[u] / normal[along];  // at most 1, as slope_v
    const double slope_v = normal[v] / normal[along];
    const double reach = 1.75 * kNear;  // along the axis: sqrt(3) for the steepest plane
    const IndexRange us = within(u_low - kNear, u_high + kNear, u);
    for (std::int64_t at_u = us.first; at_u <= us.last; ++at_u) {
      const auto [v_low, v_high] = range_across(polygon, u, v, static_cast<double>(at_u));
      const IndexRange vs = within(v_low - kNear, v_high + kNear, v);
      for (std::int64_t at_v = vs.first; at_v <= vs.last; ++at_v) {
        const double depth =
            a[along] - slope_u * (static_cast<double>(at_u) - a[u]) - slope_v * (static_cast<double>(at_v) - a[v]);
        const IndexRange depths = within(depth - reach, depth + reach, along);
        for (std::int64_t at = depths.first; at <= depths.last; ++at) {
          Index3 voxel;
          voxel[along] = at;
          voxel[u] = at_u;
          voxel[v] = at_v;
          BitWord& word = marks_.row(voxel[1], voxel[2] - slices_.first)[voxel[0] / kWordBits];
          std::atomic_ref(word).fetch_or(bit_of(voxel[0]), std::memory_order_relaxed);
        }
      }
    }
  }

 private:
  /// Indices of the grid between two coordinates, which may lie far beyond it.
  IndexRange within(double low, double high, Eigen::Index axis) const {
    const auto first = static_cast<double>(low_[axis]);
    const auto last = static_cast<double>(high_[axis]);
    if (!(low <= last && high >= first)) return {};
    return {static_cast<std::int64_t>(std::ceil(std::max(low, first))),
            static_cast<std::int64_t>(std::floor(std::min(high, last)))};
  }

  /// Range of v within the part of the polygon whose u is within kNear of `at`.
  static std::pair<double, double> range_across(std::span<const Point> polygon, Eigen::Index u, Eigen::Index v,
                                                double at) {
    std::pair<double, double> range(HUGE_VAL, -HUGE_VAL);
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      Point from = polygon[i];
      Point to = polygon[i + 1 < polygon.size() ? i + 1 : 0];
      if (from[u] > to[u]) std::swap(from, to);
      if (to[u] < at - kNear || from[u] > at + kNear) continue;
      const double length = to[u] - from[u];
      const double enters = length > 0 ? std::max((at - kNear - from[u]) / length, 0.0) : 0.0;
      const double leaves = length > 0 ? std::min((at + kNear - from[u]) / length, 1.0) : 1.0;
      for (const double share : {enters, leaves}) {
        const double crossing = from[v] + share * (to[v] - from[v]);
        range.first = std::min(range.first, crossing);
        range.second = std::max(range.second, crossing);
      }
    }
    return range;
  }

  IndexRange slices_;
  BitVolume& marks_;
  Index3 low_, high_;
};

/// A vector across x, in lattice steps.
struct Across {
  std::int64_t y = 0, z = 0;

  std::int64_t cross(Across other) const { return y * other.z - z * other.y; }
  /// Does `offset`, from a point on a line of this direction to a moved voxel centre, lie to the left? Centres are
  /// moved further along y than along z.
  bool has_left(Across offset) const {
    const std::int64_t side = cross(offset);
    return side != 0 ? side > 0 : z != 0 ? z < 0 : y > 0;
  }
};

Across across_x(const LatticePoint& from, const LatticePoint& to) {
  return {std::int64_t{to[1]} - from[1], std::int64_t{to[2]} - from[2]};
}

/// `direction` in 2^26ths.
std::array<std::int64_t, 3> on_lattice(const Point& direction) {
  constexpr double kOne = 0x1p26;
  return {std::llround(direction[0] * kOne), std::llround(direction[1] * kOne), std::llround(direction[2] * kOne)};
}

}  // namespace

Curtains::Curtains(const TriangleSoup& soup, const LatticeSoup& lattice) : lattice_(lattice) {
  const TriangleSoup merged = merge_equal_positions(soup);
  std::vector<std::uint32_t> vertex_of(merged.positions.size());  // an index in `soup`
  std::vector<std::uint64_t> sides;
  sides.reserve(3 * soup.triangles.size());
  for (std::size_t t = 0; t < soup.triangles.size(); ++t) {
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const std::uint32_t a = merged.triangles[t][corner];
      const std::uint32_t b = merged.triangles[t][(corner + 1) % 3];
      vertex_of[a] = soup.triangles[t][corner];
      if (a != b) sides.push_back(std::uint64_t{std::min(a, b)} << 32 | std::max(a, b));
    }
  }
  std::ranges::sort(sides);
  for (std::size_t begin = 0; begin < sides.size();) {
    std::size_t end = begin;
    while (end < sides.size() && sides[end] == sides[begin]) ++end;
    if ((end - begin) % 2 != 0) {
      const auto& points = lattice.points();
      edges_.push_back({points[vertex_of[sides[begin] >> 32]], points[vertex_of[sides[begin] & 0xffffffff]]});
    }
    begin = end;
  }
}

bool Curtains::pay_off(const Index3& dims) const {
  // A curtain passes through about as many rows as the grid has voxels a side, and its marks take as long again.
  return lattice_.bits() == kLatticeBits && dims.maxCoeff() <= kLargestGrid &&
         std::ssize(edges_) * dims.sum() < dims.prod();
}

std::uint64_t Curtains::memory(const TriangleSoup& soup) {
  const std::uint64_t sides = 3 * soup.triangles.size();
  return sides * (sizeof(std::uint64_t) + 2 * sizeof(LatticePoint)) + soup.triangles.size() * sizeof(Triangle) +
         soup.positions.size() * (2 * sizeof(Point) + sizeof(std::uint32_t));
}

void Curtains::mark_surface(const Index3& dims, IndexRange slices, BitVolume& marks, const RunContext& context) const {
  const Marker marker(dims, slices, marks);
  const auto triangles = static_cast<std::int64_t>(lattice_.triangles().size());
  parallel_for(context, 0, triangles, kGrain, [&](std::int64_t begin, std::int64_t end) {
    for (auto t = static_cast<std::size_t>(begin); t < static_cast<std::size_t>(end); ++t) {
      const Triangle& triangle = lattice_.triangles()[t];
      std::array<Index3, 3> steps;
      std::array<Point, 3> corners;
      for (std::size_t i = 0; i < 3; ++i) {
        const LatticePoint& point = lattice_.points()[triangle[i]];
        steps[i] = Index3(point[0], point[1], point[2]);
        corners[i] = in_voxels(point);
      }
      const Index3 ab = steps[1] - steps[0];
      const Index3 ac = steps[2] - steps[0];
      const Index3 normal = ab.cross(ac);  // exact: slivers have one as good as any
      const Index3& longer = ab.cast<double>().squaredNorm() > ac.cast<double>().squaredNorm() ? ab : ac;
      marker.mark(corners, normal.isZero() ? perpendicular(longer.cast<double>()) : normal.cast<double>());
    }
  });
}

void Curtains::mark_curtains(const Point& direction, const Index3& dims, IndexRange slices, BitVolume& marks,
                             const RunContext& context) const {
  const Marker marker(dims, slices, marks);
  const Point far_away = direction * kBeyond;
  parallel_for(context, 0, std::ssize(edges_), kGrain, [&](std::int64_t begin, std::int64_t end) {
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
      const Point a = in_voxels(edges_[i][0]);
      const Point b = in_voxels(edges_[i][1]);
      // Exactly at right angles to the direction, along which curtains are long.
      Point normal = (b - a).cross(direction);
      normal -= normal.dot(direction) * direction;
      constexpr double kThin = 1e-5;  // voxels
      if (normal.norm() < kThin) normal = perpendicular(direction);
      const std::array<Point, 4> corners = {a - far_away, b - far_away, b + far_away, a + far_away};
      marker.mark(corners, normal);
    }
  });
}

void Curtains::toggle_slice(const Point& direction, const Index3& dims, std::int64_t k, std::vector<BitWord>& in_front,
                            std::vector<BitWord>& total) const {
  const std::array<std::int64_t, 3> w = on_lattice(direction);
  const Across ray{w[1], w[2]};
  const std::int64_t row_words = words_for(dims[0]);
  const std::int64_t z = k << kLatticeBits;
  const double one = std::ldexp(1.0, kLatticeBits);
  for (const auto& [a, b] : edges_) {
    const Across side = across_x(a, b);
    const std::int64_t area = side.cross(ray);
    if (area == 0) continue;  // seen edge-on
    // Candidates: the rows between the curtain's ends in this slice.
    IndexRange rows{0, dims[1] - 1};
    if (ray.z != 0) {
      const double slope = static_cast<double>(ray.y) / static_cast<double>(ray.z);
      const double end_a = (static_cast<double>(a[1]) + static_cast<double>(z - a[2]) * slope) / one;
      const double end_b = (static_cast<double>(b[1]) + static_cast<double>(z - b[2]) * slope) / one;
      constexpr double kSlack = 1e-3;
      const auto last = static_cast<double>(rows.last);
      rows.first = static_cast<std::int64_t>(std::ceil(std::clamp(std::min(end_a, end_b) - kSlack, 0.0, last + 1)));
      rows.last = static_cast<std::int64_t>(std::floor(std::clamp(std::max(end_a, end_b) + kSlack, -1.0, last)));
    } else if (z < std::min(a[2], b[2]) || z > std::max(a[2], b[2])) {
      continue;
    }
    for (std::int64_t j = rows.first; j <= rows.last; ++j) {
      const Across from_a{(j << kLatticeBits) - a[1], z - a[2]};
      const Across from_b{(j << kLatticeBits) - b[1], z - b[2]};
      if (ray.has_left(from_a) == ray.has_left(from_b)) continue;
      const double along_side = static_cast<double>(from_a.cross(ray)) / static_cast<double>(area);
      const double along_ray = static_cast<double>(side.cross(from_a)) / static_cast<double>(area);
      const double crossing = static_cast<double>(a[0]) + along_side * static_cast<double>(b[0] - a[0]) +
                              along_ray * static_cast<double>(w[0]);
      const double first = std::max(std::ceil(crossing / one), 0.0);
      if (first >= static_cast<double>(dims[0])) continue;
      const auto i = static_cast<std::int64_t>(first);
      const auto word = static_cast<std::size_t>(j * row_words + i / kWordBits);
      total[word] ^= bit_of(i);
      if (side.has_left(from_a) == (area > 0)) in_front[word] ^= bit_of(i);
    }
  }
}

}  // namespace voxcarve
