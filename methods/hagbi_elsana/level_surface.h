// From the faces on the boundary of a carved solid to a closed manifold.
#pragma once

#include <cstdint>
#include <vector>

#include "common/run/context.h"
#include "methods/hagbi_elsana/complement.h"

namespace voxcarve {

/// Gives every face of a carved solid's boundary its place in a list, and every point a counter. Reused from level to
/// level, so that making a surface takes no time for what is not on it.
class FacePlaces {
 public:
  FacePlaces(std::size_t tetrahedra, std::size_t points) : place_(4 * tetrahedra, 0), counts_(points, 0) {}
  std::uint32_t& operator[](std::uint32_t face) { return place_[face]; }
  std::uint32_t operator[](std::uint32_t face) const { return place_[face]; }
  /// All zero, to be left so.
  std::vector<std::uint32_t>& counts() { return counts_; }

 private:
  std::vector<std::uint32_t> place_;
  std::vector<std::uint32_t> counts_;
};

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

/// The closed surface of these faces (4 t + i, of tetrahedra on the outside), which must be all of the solid's: see
/// CarvingStream::extract. Triangles are in the order of the faces.
TriangleSoup level_surface(const CarvedSolid& solid, const std::vector<std::uint32_t>& faces, FacePlaces& places,
                           const RunContext& context);

}  // namespace voxcarve
