// The part of a surface that can be seen from outside.
#pragma once

#include <cstdint>
#include <vector>

#include "metrics/surface_pair.h"

namespace voxcarve {

struct VisibilityOptions {
  std::int64_t directions = 128;  ///< to look from, at least 1
  double coarse = 1.0 / 32;       ///< longest side of a piece that is looked at, share of the diagonal
  double fine = 1.0 / 128;        ///< longest side of a piece that is not cut any more, share of the diagonal
  double tolerance = 1e-6;        ///< surfaces nearer than this do not hide each other, share of the diagonal
};

/// Unit vectors spread evenly over the sphere: the spiral with equal steps of z and the golden angle between
/// neighbours. No point of the sphere is further than 14.2 degrees from one of 128 of them.
std::vector<Point> view_directions(std::int64_t count);

/// The part of a surface that is visible from outside along at least one of `directions` fixed directions, seen from
/// infinitely far. All lengths are shares of the diagonal of the surface's box.
///
/// A point is visible along a direction when the ray from it in that direction meets no triangle. Both sides of a
/// triangle can be seen, whatever its orientation: the ray starts `tolerance` off the side that it leaves from, so that
/// coincident triangles do not hide each other, and triangles are grown by `tolerance`, so that no light falls through
/// cracks narrower than twice that. Directions within half a degree of the triangle's plane do not count.
///
/// Triangles are cut at the middle of their longest side until no side is longer than `coarse`. A piece is looked at in
/// its centroid and near its three corners. When these agree, so does the whole piece; when they do not, it is cut on,
/// and at the length `fine` the centroid decides alone. So the border of the visible part is known to about `fine`, and
/// a window narrower than `coarse` may be overlooked. Where there would be about two million pieces more than twice the
/// number of triangles, both lengths are doubled until there are fewer.
///
/// Triangles that are visible as a whole are kept as they are, in their order; pieces of the others follow. Triangles
/// without area are not part of the result, which is empty when nothing has area. Which points are visible does not
/// depend on the number of threads. Throws Cancelled, and ResourceError when the memory budget does not suffice.
SurfacePart visible_part(const TriangleSoup& surface, const VisibilityOptions& options, RunContext& context);

}  // namespace voxcarve
