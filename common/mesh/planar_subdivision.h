// One step of `arrange`: the triangles of a plane, cut along what meets them.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/mesh/triangle_crossings.h"
#include "common/mesh/triangle_soup.h"
#include "common/run/context.h"

namespace voxcarve {

/// A segment, or where both ends are the same a point, that has to be made of edges and vertices.
using PlanarConstraint = std::array<ContactPoint, 2>;

/// A part of a triangle of a soup, or of several that overlap.
struct PlanarPart {
  Triangle corners;        ///< a vertex of the soup, or its number of vertices plus an index into `new_positions`
  std::size_t covers_end;  ///< its covers end here in `covers`; they begin where those of the part before end
};

/// A triangle of the soup that a part belongs to.
struct PlanarCover {
  std::uint32_t triangle = 0;
  bool aligned = true;  ///< oriented like the part
};

struct PlanarSubdivision {
  std::vector<Point> new_positions;  ///< exact points, each coordinate rounded to the nearest number
  std::vector<PlanarPart> parts;
  std::vector<PlanarCover> covers;
};

/// The constrained Delaunay triangulation of `triangles`, which lie in one plane exactly and are not collinear, with
/// their edges and with `constraints`, which lie in that plane. Where constraints cross, there is a vertex; this is
/// exact until the coordinates of new vertices are rounded. No two parts overlap. Points that are the same exactly have
/// the same rounded coordinates, in whatever plane they were found. Throws Cancelled.
PlanarSubdivision subdivide(const TriangleSoup& soup, std::span<const std::uint32_t> triangles,
                            std::span<const PlanarConstraint> constraints, const RunContext& context);

}  // namespace voxcarve
