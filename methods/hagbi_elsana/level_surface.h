// From the faces on the boundary of a carved solid to a closed manifold.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/run/context.h"
#include "methods/hagbi_elsana/complement.h"

namespace voxcarve {

/// The solid that is left of a complement after a step: whatever has a step of its own that is later.
struct CarvedSolid {
  const Complement& complement;
  const std::vector<std::uint32_t>& steps;
  std::uint32_t step = 0;

  /// Does face i of a tetrahedron on the outside lie on the solid's boundary?
  bool ends_at(std::uint32_t t, int i) const {
    return complement.is_barrier(t, i) || steps[complement.neighbors[t][static_cast<std::size_t>(i)]] > step;
  }
};

/// What making a surface needs, kept from level to level: so a manifold one takes no time for what is not on it, and no
/// new memory after the largest one. Where surfaces have to be cut, the cutting has memory of its own, and the first
/// such one clears `place`. Between two surfaces only `vertex_of` has to be as it was left.
struct LevelWorkspace {
  static constexpr std::uint32_t kNone = 0xffffffffU;

  explicit LevelWorkspace(std::size_t points) : vertex_of(points, kNone) {}

  /// Bytes, where surfaces have to be cut; what else there is grows with the surface.
  static constexpr std::size_t kBytesATetrahedron = 4 * sizeof(std::uint32_t);

  std::vector<std::uint32_t> faces;      ///< for the caller
  std::vector<std::uint32_t> vertex_of;  ///< by point; kNone of all between two surfaces
  std::vector<std::uint32_t> point_of;   ///< by vertex
  std::vector<std::uint32_t> first;      ///< in links, by vertex
  std::vector<std::uint64_t> links;      ///< the other two corners of every face around a vertex
  std::vector<std::uint8_t> singular;    ///< by vertex: not one fan of triangles
  std::vector<std::uint32_t> place;      ///< by face of a tetrahedron: which of the surface's it is
};

/// The closed surface of these faces (4 t + i, of tetrahedra on the outside), which must be all of the solid's: see
/// CarvingStream::extract. Triangles are in the order of the faces, vertices in that of their first corners, but for
/// copies made where doubled edges were cut, which come last.
TriangleSoup level_surface(const CarvedSolid& solid, const std::vector<std::uint32_t>& faces, LevelWorkspace& workspace,
                           const RunContext& context);

}  // namespace voxcarve
