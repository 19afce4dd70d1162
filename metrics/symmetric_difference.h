// Volume of the symmetric difference of two solids given by their surfaces.
#pragma once

#include <cstdint>
#include <variant>

#include "metrics/metric.h"

namespace voxcarve {

/// Boundary edges, counted with multiplicity, above which an open shape is refused: each evaluation of its generalised
/// winding number visits all of them.
inline constexpr std::int64_t kMaxBoundaryEdges = 2000;

struct SymmetricDifferenceOptions {
  std::int64_t rays = 1 << 14;  ///< over all replicates; open shapes get fewer, at least 16 a replicate
  std::int64_t replicates = 8;  ///< at least 8, else 8 are taken
};

/// Volumes in cubed model units. All of them come from the same rays.
struct SymmetricDifference {
  double volume = 0;          ///< of A xor B
  double standard_error = 0;  ///< of `volume`, from the spread of the replicates
  double a_minus_b = 0;
  double b_minus_a = 0;
  double volume_a = 0;
  double volume_b = 0;
  std::int64_t rays = 0;  ///< that were cast
};

/// Integrates along lines parallel to the coordinate axes, exactly along each line: replicates take the directions z,
/// x, y, z, ... in turn and the lines of one replicate are one jittered line in each cell of a square number of cells
/// over the box of both shapes, from the context's seed. An empty shape is the empty solid.
///
/// A point is inside of a shape when the shape's winding number there is not zero. Where the shape's triangles, with
/// vertices of equal position taken as one, have no boundary as a chain (every edge is run through as often in one
/// direction as in the other), that is the sum of signed crossings. An open shape has a generalised winding number
/// [JKS13], and inside means above 1/2 in absolute value, within the shape's own bounding box: the boundary chain is
/// coned to one apex, the crossings with surface and cone give an integer, and the solid angle of the cone is taken off
/// again; along a line, changes between crossings are found by sampling (33 samples over the box) and bisection.
///
/// Undefined, with the reason, when an open shape has more than kMaxBoundaryEdges boundary edges, or coordinates whose
/// differences overflow. Throws Cancelled.
std::variant<SymmetricDifference, Undefined> symmetric_difference(const TriangleSoup& a, const TriangleSoup& b,
                                                                  const SymmetricDifferenceOptions& options,
                                                                  const RunContext& context);

}  // namespace voxcarve
