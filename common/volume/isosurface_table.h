// The marching-cubes table.
#pragma once

#include <array>
#include <cstdint>

namespace voxcarve {

/// Triangles of one corner configuration, as indices of cube edges.
struct CubeCase {
  std::uint16_t crossed_edges = 0;  ///< bit e: one end of edge e is interior, the other one is not
  std::uint8_t triangle_count = 0;
  std::array<std::array<std::uint8_t, 3>, 10> triangles{};
};

/// Corner c of a cube lies at (c & 1, c >> 1 & 1, c >> 2 & 1). Edge e runs along axis e / 4 from corner
/// kEdgeCorners[e][0] to kEdgeCorners[e][1].
inline constexpr std::array<std::array<std::uint8_t, 2>, 12> kEdgeCorners = {
    {{0, 1}, {2, 3}, {4, 5}, {6, 7}, {0, 2}, {1, 3}, {4, 6}, {5, 7}, {0, 4}, {1, 5}, {2, 6}, {3, 7}}};

/// The table: entry m holds the surface in a cube whose corner c is interior iff bit c of m is set.
///
/// It is derived, not listed. On every face the contour cuts off each run of interior corners by itself, so on an
/// ambiguous face interior corners are separated: neighbouring cubes agree because the rule sees nothing but the face.
/// The contours close to loops, and every loop is triangulated without a diagonal that lies in a face of the cube,
/// because a neighbour could use the same one and three or more triangles would meet there. The surface is therefore
/// closed and everywhere 2-manifold. It realises 6-connected interiors and 18-connected exteriors.
const std::array<CubeCase, 256>& cube_cases();

}  // namespace voxcarve
