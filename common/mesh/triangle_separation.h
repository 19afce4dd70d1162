// A quick proof that two triangles do not cross.
#pragma once

#include <array>

#include "common/mesh/triangle_soup.h"

namespace voxcarve {

/// A triangle with its corners at hand.
struct CorneredTriangle {
  CorneredTriangle() = default;
  CorneredTriangle(const TriangleSoup& soup, const Triangle& triangle);

  std::array<Point, 3> corners;
  double size = 0;  ///< the largest difference of two corners' coordinates along an axis, as computed
  Triangle vertices{};
};

/// True only if two triangles meet in nothing but common vertices and whole common edges, where vertices are common by
/// their names, at equal positions; then that is certain, whatever the rounding mode. No triangle may name a vertex
/// twice. False says nothing, and is what triangles larger than 2^240 get. Most pairs of neighbours on a surface are
/// settled so, at a fraction of the cost of exact signs.
bool certainly_apart(const CorneredTriangle& first, const CorneredTriangle& second);

}  // namespace voxcarve
