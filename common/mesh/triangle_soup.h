// The triangle soup: what methods take and give.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <limits>
#include <string_view>
#include <vector>

namespace voxcarve {

using Point = Eigen::Vector3d;                  ///< position in model units
using Color = Eigen::Vector3f;                  ///< RGB, each in [0, 1]
using Triangle = std::array<std::uint32_t, 3>;  ///< vertex indices, counterclockwise seen from outside

/// An axis-aligned box. Empty (lower > upper) until it was extended.
struct Box {
  Point lower = Point::Constant(std::numeric_limits<double>::infinity());
  Point upper = Point::Constant(-std::numeric_limits<double>::infinity());

  bool empty() const { return (lower.array() > upper.array()).any(); }
  void extend(const Point& point) {
    lower = lower.cwiseMin(point);
    upper = upper.cwiseMax(point);
  }
  void extend(const Box& box) {
    lower = lower.cwiseMin(box.lower);
    upper = upper.cwiseMax(box.upper);
  }
  Point extent() const { return empty() ? Point(Point::Zero()) : Point(upper - lower); }
  Point center() const { return lower + 0.5 * (upper - lower); }
  double diagonal() const { return extent().stableNorm(); }
};

/// Positions and triangles without any assumption of manifoldness, orientation or closedness. Polygons were
/// triangulated on reading. Colours are optional: per vertex, per triangle, or both (then the triangle's wins).
struct TriangleSoup {
  std::vector<Point> positions;
  std::vector<Triangle> triangles;
  std::vector<Color> vertex_colors;    ///< empty, or one a position
  std::vector<Color> triangle_colors;  ///< empty, or one a triangle

  bool empty() const { return triangles.empty(); }
  bool operator==(const TriangleSoup&) const = default;
};

/// The box of all positions that a triangle uses.
Box bounds(const TriangleSoup& soup);

/// Twice-area vector of a triangle: its length is twice the area, its direction the normal.
Point area_vector(const TriangleSoup& soup, const Triangle& triangle);

/// Sum of the triangles' areas, in squared model units.
double surface_area(const TriangleSoup& soup);

/// Signed volume by the divergence theorem about the centre of the bounding box, in cubed model units. Meaningful for
/// closed, consistently oriented surfaces; positive when normals point outward.
double signed_volume(const TriangleSoup& soup);

/// True when two corners are the same vertex, or all three positions lie on a line to the last bit.
bool is_degenerate(const TriangleSoup& soup, const Triangle& triangle);

/// Merges vertices whose positions are equal (-0 and 0 are), keeps the order of first use and drops unused vertices.
/// Triangles keep their number and order; a merged vertex keeps the colour of its first copy.
TriangleSoup merge_equal_positions(const TriangleSoup& soup);

/// Drops positions that no triangle uses; the others keep their order.
void remove_unused_vertices(TriangleSoup& soup);

/// Appends `other` to `soup`. Where only one of them has colours, the other's part becomes mid-grey.
void append(TriangleSoup& soup, const TriangleSoup& other);

/// Throws InputError when an index is out of range, a coordinate is not finite, a colour array has the wrong length, or
/// there is no triangle. `name` says whose soup it is.
void validate(const TriangleSoup& soup, std::string_view name);

}  // namespace voxcarve
