// Closed, outward-oriented building blocks of the procedural models. Every surface shares its vertices: each directed
// edge stands in exactly one triangle and its reverse in exactly one other, so closedness and genus are exact and do
// not depend on comparing coordinates. All lengths are in model units.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "common/mesh/triangle_soup.h"

namespace voxcarve {

/// A cross-section of a loft: points counterclockwise seen against the direction of travel, or one point (a pole).
using Ring = std::vector<Point>;

/// What a loft has at its ends.
enum class LoftEnds {
  kCapped,  ///< flat triangle fans over the first and the last ring (poles need none)
  kJoined   ///< the last ring joins the first: a torus
};

/// The surface through consecutive rings. All rings have the same number of points, at least 3, but the first and the
/// last of a capped loft, which may be poles. Throws InputError otherwise. Flat caps of rings that are not star-shaped
/// about their first point overlap themselves. Triangles: per pair of rings 2 points (1 at a pole), per cap points - 2.
TriangleSoup loft(std::span<const Ring> rings, LoftEnds ends = LoftEnds::kCapped);

/// The surface of revolution of `profile` (radius, z), from bottom to top, about the z axis, as a prism of `slices`
/// sides whose corners lie on the circle. A radius of 0 at an end is a pole; elsewhere radii are positive.
TriangleSoup lathe(std::span<const Eigen::Vector2d> profile, int slices);

/// The same about the line through `origin` along `direction`; the profile's z is the distance along it.
TriangleSoup lathe(std::span<const Eigen::Vector2d> profile, int slices, const Point& origin, const Point& direction);

/// 12 triangles.
TriangleSoup box(const Point& lower, const Point& upper);

/// Vertices on the sphere; 2 slices (stacks - 1) triangles. slices >= 3, stacks >= 2.
TriangleSoup uv_sphere(const Point& center, double radius, int slices, int stacks);

/// Icosahedron, each triangle split in four `subdivision` times; vertices on the sphere; 20 * 4^subdivision triangles.
TriangleSoup icosphere(const Point& center, double radius, int subdivision);

/// A prism of `sides` from `a` to `b` with flat ends: 4 (sides - 1) triangles.
TriangleSoup cylinder(const Point& a, const Point& b, double radius, int sides);

/// The convex hull of two balls (bones, limbs), sampled with `stacks` >= 3 belts of `slices` >= 3 sides:
/// 2 slices (stacks - 1) triangles. Throws InputError when one ball holds the other.
TriangleSoup capsule(const Point& a, double radius_a, const Point& b, double radius_b, int slices, int stacks);

/// A ring torus about the z axis, centred at the origin: 2 segments tube_segments triangles. minor < major.
TriangleSoup torus(double major, double minor, int segments, int tube_segments);

/// A round tube of constant radius about a path, with flat ends; its cross-sections turn as little as possible
/// (parallel transport). Consecutive points differ, and the path bends gently against the radius, or the tube
/// intersects itself.
TriangleSoup swept_tube(std::span<const Point> path, double radius, int sides);

/// A smooth path through `controls` (a Catmull-Rom spline), `segments` pieces between each two of them.
std::vector<Point> smooth_path(std::span<const Point> controls, int segments);

/// Two round cones, tip to tip in the middle of `a` and `b`, which are the centres of their bases. They share the tip,
/// a non-manifold vertex. 4 sides - 4 triangles.
TriangleSoup hourglass(const Point& a, const Point& b, double radius, int sides);

/// The boundary of a union of cubes of edge `cell_size` on a lattice that starts at the origin; each exposed face is
/// cut into `subdivision`^2 squares of two triangles. `filled(i, j, k)` is asked for 0 <= i, j, k < dims. A 2-manifold
/// where no two cubes meet in an edge or a vertex alone.
TriangleSoup block_surface(const std::array<int, 3>& dims, const std::function<bool(int, int, int)>& filled,
                           double cell_size, int subdivision);

/// The image of `soup`, turned inside out again where the map mirrors.
TriangleSoup transformed(TriangleSoup soup, const Eigen::Affine3d& map);

/// The same surface seen from the other side: a solid becomes a cavity.
TriangleSoup as_cavity(TriangleSoup soup);

/// Gives every triangle the same colour.
TriangleSoup colored(TriangleSoup soup, const Color& color);

}  // namespace voxcarve
