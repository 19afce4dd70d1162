// Polygons into triangles.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/mesh/triangle_soup.h"

namespace voxcarve::mesh_io {

/// Non-convex polygons of more corners than this are refused: clipping ears takes quadratic time.
inline constexpr std::size_t kMaxNonConvexCorners = 20000;

/// Appends the n - 2 triangles of a polygon of n >= 3 corners, which index `positions`. A polygon that is convex where
/// its Newell normal points is a fan about its first corner; others lose ears in the projection along that normal's
/// dominant axis, each time the first one in their order [Mei75]. Holes joined by doubled edges are fine. A
/// polygon that has no area, or runs out of ears because it crosses itself, becomes the fan. Returns false, and appends
/// nothing, when it is not convex and exceeds kMaxNonConvexCorners.
bool triangulate_polygon(const std::vector<Point>& positions, std::span<const std::uint32_t> corners,
                         std::vector<Triangle>& triangles);

}  // namespace voxcarve::mesh_io
