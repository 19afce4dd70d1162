#include "common/mesh/io/polygon.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace voxcarve::mesh_io {

namespace {

using Point2 = Eigen::Vector2d;

/// Twice the signed area of a triangle, 0 where rounding could have made up its sign.
double turn(const Point2& a, const Point2& b, const Point2& c) {
  const double left = (b[0] - a[0]) * (c[1] - a[1]);
  const double right = (b[1] - a[1]) * (c[0] - a[0]);
  // [She97]: the rounding error of this expression stays below (3 + 16 eps) eps (|left| + |right|), eps = 2^-53.
  constexpr double kBound = 3.4e-16;
  const double area = left - right;
  return std::abs(area) <= kBound * (std::abs(left) + std::abs(right)) ? 0.0 : area;
}

/// The corners in the plane that shows the polygon's area best, counterclockwise, moved and scaled into [-1, 1]^2 so
/// that products neither overflow nor vanish. Empty when the polygon has no area.
std::vector<Point2> project(const std::vector<Point>& positions, std::span<const std::uint32_t> corners) {
  const Point origin = positions[corners[0]];
  double size = 0;
  for (const std::uint32_t corner : corners) size = std::max(size, (positions[corner] - origin).cwiseAbs().maxCoeff());
  if (!(size > 0) || !std::isfinite(size)) return {};
  Point normal = Point::Zero();
  Point previous = (positions[corners.back()] - origin) / size;
  for (const std::uint32_t corner : corners) {
    const Point current = (positions[corner] - origin) / size;
    normal += previous.cross(current);
    previous = current;
  }
  int axis = 0;
  const double area = normal.cwiseAbs().maxCoeff(&axis);
  if (!(area > 0)) return {};
  int first = (axis + 1) % 3;
  int second = (axis + 2) % 3;
  if (normal[axis] < 0) std::swap(first, second);
  std::vector<Point2> points;
  points.reserve(corners.size());
  for (const std::uint32_t corner : corners) {
    const Point local = (positions[corner] - origin) / size;
    points.emplace_back(local[first], local[second]);
  }
  return points;
}

/// True when no corner turns right and every triangle of the fan about the first corner has area. The second condition
/// also excludes stars that turn more than once.
bool is_fan_valid(const std::vector<Point2>& points) {
  const std::size_t n = points.size();
  for (std::size_t i = 0; i < n; ++i) {
    if (turn(points[i], points[(i + 1) % n], points[(i + 2) % n]) < 0) return false;
  }
  for (std::size_t i = 1; i + 1 < n; ++i) {
    if (turn(points[0], points[i], points[i + 1]) <= 0) return false;
  }
  return true;
}

/// Clips ears from a ring of corners.
class EarClipper {
 public:
  explicit EarClipper(const std::vector<Point2>& points) : points_(points) {
    const auto n = static_cast<std::uint32_t>(points.size());
    for (std::uint32_t i = 0; i < n; ++i) {
      next_.push_back(i + 1 == n ? 0 : i + 1);
      previous_.push_back(i == 0 ? n - 1 : i - 1);
    }
    turns_.resize(n);
    for (std::uint32_t i = 0; i < n; ++i) update_turn(i);
  }

  /// Triangles of corner numbers, or nothing when the ring ran out of ears.
  std::vector<Triangle> run() {
    std::vector<Triangle> triangles;
    auto left = static_cast<std::uint32_t>(points_.size());
    std::uint32_t corner = 0;
    std::uint32_t rejected = 0;
    bool flat_allowed = false;  // corners of no area go last: they would leave triangles of no area
    while (left > 3) {
      const bool take = is_ear(corner) || (flat_allowed && turns_[corner] == 0);
      const std::uint32_t after = next_[corner];
      if (take) {
        const std::uint32_t before = previous_[corner];
        triangles.push_back({before, corner, after});
        clip(corner);
        --left;
        rejected = 0;
        flat_allowed = false;
        corner = before;
      } else {
        corner = after;
        if (++rejected < left) continue;
        if (flat_allowed) return {};
        flat_allowed = true;
        rejected = 0;
      }
    }
    triangles.push_back({previous_[corner], corner, next_[corner]});
    return triangles;
  }

 private:
  void update_turn(std::uint32_t corner) {
    turns_[corner] = turn(points_[previous_[corner]], points_[corner], points_[next_[corner]]);
  }

  void clip(std::uint32_t corner) {
    next_[previous_[corner]] = next_[corner];
    previous_[next_[corner]] = previous_[corner];
    update_turn(previous_[corner]);
    update_turn(next_[corner]);
  }

  /// An ear turns left, and no other corner that does not lies in its closed triangle. Copies of its own corners, as
  /// holes on doubled edges leave them, do not count.
  bool is_ear(std::uint32_t corner) const {
    if (!(turns_[corner] > 0)) return false;
    const Point2& a = points_[previous_[corner]];
    const Point2& b = points_[corner];
    const Point2& c = points_[next_[corner]];
    for (std::uint32_t other = next_[next_[corner]]; other != previous_[corner]; other = next_[other]) {
      if (turns_[other] > 0) continue;
      const Point2& p = points_[other];
      if (p == a || p == b || p == c) continue;
      if (turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0) return false;
    }
    return true;
  }

  const std::vector<Point2>& points_;
  std::vector<std::uint32_t> next_;
  std::vector<std::uint32_t> previous_;
  std::vector<double> turns_;
};

}  // namespace

bool triangulate_polygon(const std::vector<Point>& positions, std::span<const std::uint32_t> corners,
                         std::vector<Triangle>& triangles) {
  if (corners.size() == 3) {
    triangles.push_back({corners[0], corners[1], corners[2]});
    return true;
  }
  const std::vector<Point2> points = project(positions, corners);
  if (!points.empty() && !is_fan_valid(points)) {
    if (corners.size() > kMaxNonConvexCorners) return false;
    const std::vector<Triangle> clipped = EarClipper(points).run();
    for (const Triangle& t : clipped) triangles.push_back({corners[t[0]], corners[t[1]], corners[t[2]]});
    if (!clipped.empty()) return true;
  }
  for (std::size_t i = 1; i + 1 < corners.size(); ++i) triangles.push_back({corners[0], corners[i], corners[i + 1]});
  return true;
}

}  // namespace voxcarve::mesh_io
