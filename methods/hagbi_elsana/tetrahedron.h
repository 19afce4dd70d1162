// Measures of a tetrahedron.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "common/mesh/triangle_soup.h"

namespace voxcarve {

using TetrahedronCorners = std::array<std::uint32_t, 4>;  ///< indices of points

inline Point centroid(const std::vector<Point>& points, const TetrahedronCorners& t) {
  return 0.25 * (points[t[0]] + points[t[1]] + (points[t[2]] + points[t[3]]));
}

/// Positive for corners in positive order; rounding may say otherwise of flat ones, so nothing branches on its sign.
inline double volume(const std::vector<Point>& points, const TetrahedronCorners& t) {
  const Point& a = points[t[0]];
  return (points[t[1]] - a).cross(points[t[2]] - a).dot(points[t[3]] - a) / 6;
}

/// Squared lengths of the six edges.
inline std::array<double, 6> squared_edges(const std::vector<Point>& points, const TetrahedronCorners& t) {
  const auto squared = [&](std::size_t i, std::size_t j) { return (points[t[i]] - points[t[j]]).squaredNorm(); };
  return {squared(0, 1), squared(0, 2), squared(0, 3), squared(1, 2), squared(1, 3), squared(2, 3)};
}

inline double longest_edge_squared(const std::vector<Point>& points, const TetrahedronCorners& t) {
  const std::array<double, 6> squared = squared_edges(points, t);
  return *std::max_element(squared.begin(), squared.end());
}

/// Circumradius by the edges [Crelle's formula]; infinite for a flat one.
inline double circumradius(const std::vector<Point>& points, const TetrahedronCorners& t) {
  const std::array<double, 6> squared = squared_edges(points, t);
  // Products of opposite edges are the sides of a triangle whose area is 6 V R.
  const double p = std::sqrt(squared[0] * squared[5]);
  const double q = std::sqrt(squared[1] * squared[4]);
  const double r = std::sqrt(squared[2] * squared[3]);
  const double s = (p + q + r) / 2;
  const double area = std::sqrt(std::max(s * (s - p) * (s - q) * (s - r), 0.0));
  return area / (6 * std::abs(volume(points, t)));
}

}  // namespace voxcarve
