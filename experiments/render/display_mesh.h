// A soup made ready for a rasteriser: unit size, crease-aware normals, colours, edges. Knows no graphics library.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "common/mesh/triangle_soup.h"
#include "experiments/render/color.h"

namespace voxcarve {

/// Maps model coordinates to about [-1, 1] in double, whatever their magnitude and offset.
struct UnitFrame {
  Point center = Point::Zero();
  double half_extent = 1;  ///< half the longest side of the box that is mapped to [-1, 1]

  /// The frame of a box. An empty box or one point gives half_extent 1.
  static UnitFrame of(const Box& box);

  Point to_unit(const Point& point) const { return (point - center) / half_extent; }
};

/// Vertices are split where normals or colours differ.
struct DisplayMesh {
  std::vector<Eigen::Vector3f> positions;  ///< in the unit frame
  std::vector<Eigen::Vector3f> normals;    ///< unit length, one a position
  std::vector<Rgb8> colors;                ///< one a position
  std::vector<Triangle> triangles;         ///< the soup's, in its order
  std::vector<bool> two_sided;  ///< one a triangle: the other side of the same three positions is a triangle too
  std::vector<std::array<std::uint32_t, 2>> edges;  ///< each edge once; filled only on request
};

/// Splits the vertices of `soup` along creases and gives each copy the angle-weighted mean normal of its smoothing
/// group [TW98]. A group is a set of corners at one position that are linked across edges whose
/// faces differ by at most `crease_angle` degrees; positions that are equal to the last bit count as one, so unwelded
/// triangles are shaded as one surface. Neighbours of opposite orientation never share a group unless the angle allows
/// it. Degenerate triangles join no group, and their normals are finite.
///
/// `soup` must pass `validate`. Colours are clamped to [0, 1].
DisplayMesh make_display_mesh(const TriangleSoup& soup, const UnitFrame& frame, double crease_angle, bool with_edges);

}  // namespace voxcarve
