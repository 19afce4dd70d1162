// A complex of triangles without what TetGen stumbles over or renumbers: unused and repeated points, repeated
// triangles.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/mesh/triangle_soup.h"
#include "common/run/context.h"

namespace voxcarve {

/// Every position that counts, once, and every triangle once.
struct CompactComplex {
  std::vector<std::uint32_t> vertices;  ///< compact index -> the complex's, ascending
  std::vector<Triangle> triangles;      ///< in compact indices
  std::vector<std::uint32_t> sources;   ///< compact triangle -> the complex's, ascending
  int exponent = 0;                     ///< coordinates times 2^-exponent are at most 1
};

/// Drops points that no triangle uses, but for the last `kept` ones, points equal to an earlier one that counts, and
/// triangles with the corners of an earlier one.
CompactComplex compact(const TriangleSoup& complex, std::size_t kept = 0);

/// Throws TetgenFailure, kRefused when a triangle has no area, kFlat when all points lie in a plane, by exact
/// predicates.
void require_solid(const TriangleSoup& complex, const CompactComplex& shape, Stage& stage);

/// Sign of (b - a).cross(c - a).dot(d - a), exactly: -1, 0 or 1.
int orientation(const Point& a, const Point& b, const Point& c, const Point& d);

/// Does `part`, which lies in the plane of `whole` up to rounding, face the other way? Exact where rounding does not
/// matter: on the coordinate plane that `whole` is least inclined to.
bool faces_the_other_way(const std::array<Point, 3>& part, const std::array<Point, 3>& whole);

}  // namespace voxcarve
