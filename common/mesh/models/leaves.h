// Leaves: what the models of foliage are put together from.
#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "common/mesh/triangle_soup.h"
#include "common/run/parameters.h"

namespace voxcarve {

inline constexpr double kGoldenAngle = std::numbers::pi * (3 - 2.23606797749978969);  // 3 - sqrt 5
inline constexpr int kLeafAttempts = 60;  ///< to place a piece that crosses nothing

inline double radians(double degrees) {
  return degrees * std::numbers::pi / 180;
}

/// `direction` turned by `angle` towards the unit vector `side`, which is perpendicular to it.
inline Point turned(const Point& direction, const Point& side, double angle) {
  return std::cos(angle) * direction + std::sin(angle) * side;
}

/// An open strip of rows of equally many points, which starts and ends in a row or in a single point.
TriangleSoup strip(const std::vector<std::vector<Point>>& rows);

/// Of where things grow.
ParameterSpec seed_parameter();

}  // namespace voxcarve
