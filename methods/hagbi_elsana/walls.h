// Where a model's triangles lie in the tetrahedralization of its hull, and what they separate.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/run/context.h"
#include "methods/hagbi_elsana/tetgen_child.h"

namespace voxcarve {

/// A facet seen from a tetrahedron beside it.
struct Wall {
  std::uint32_t tetrahedron = 0;
  std::uint32_t facet = 0;
  std::uint8_t face = 0;  ///< of the tetrahedron: the one opposite this corner
  bool in_front = false;  ///< the tetrahedron lies where the facet's corners are seen counterclockwise
};

struct Walls {
  std::vector<std::uint8_t> faces;  ///< a tetrahedron's: bit i says that face i is a wall
  /// In pieces: by tetrahedron, then by face; a facet once for every tetrahedron beside it.
  std::vector<std::vector<Wall>> pieces;

  template <class Visit>
  void for_each(const Visit& visit) const {
    for (const std::vector<Wall>& piece : pieces) {
      for (const Wall& wall : piece) visit(wall);
    }
  }
};

/// Throws MethodFailure when a facet is no face of a tetrahedron, or is there twice; and Cancelled.
Walls find_walls(const Tetrahedralization& input, const RunContext& context);

/// A face of a tetrahedron beyond which lies nothing.
struct HullFace {
  std::uint32_t tetrahedron = 0;
  int face = 0;
};

/// By tetrahedron, then by face.
std::vector<HullFace> find_hull(const Tetrahedralization& input);

/// Tetrahedra that hang together by faces that are no barriers (bit i of barriers[t]: face i of t, seen from both its
/// sides). Region 0, which may be empty, is what reaches beyond the hull; others are in the order of their first
/// tetrahedra.
struct Regions {
  std::vector<std::uint32_t> of;  ///< a tetrahedron's
  std::uint32_t count = 0;
};

/// Throws Cancelled.
Regions find_regions(const Tetrahedralization& input, std::span<const HullFace> hull,
                     std::vector<std::uint8_t> barriers, const RunContext& context);

}  // namespace voxcarve
