// The complement of a solid within its convex hull: which tetrahedra can be carved, and what walls them off.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/run/context.h"
#include "methods/hagbi_elsana/tetgen_child.h"

namespace voxcarve {

/// Tetrahedra between a model M and its convex hull, then one ghost for every face of the hull, which stands for the
/// space beyond it. Face i of a tetrahedron is the one opposite its corner i; corners are in positive order (see
/// `face_of`). M's triangles are walls: nothing is ever carved through them.
struct Complement {
  static constexpr std::uint32_t kSolid = 0xffffffffU;  ///< neighbour: the inside of M
  static constexpr std::uint32_t kFar = 0xffffffffU;    ///< last corner of a ghost: the point at infinity
  static constexpr std::uint32_t kNone = 0xffffffffU;

  std::vector<Point> points;       ///< M's vertices, then Steiner points
  std::uint32_t model_points = 0;  ///< how many are M's
  std::vector<std::array<std::uint32_t, 4>> corners;
  std::vector<std::array<std::uint32_t, 4>> neighbors;  ///< across each face
  std::vector<std::uint8_t> walls;                      ///< bit i: face i lies in M
  std::uint32_t first_ghost = 0;                        ///< all from here on are ghosts
  std::vector<std::uint32_t> solid_of_point;            ///< component of the closed set M that it lies on, or kNone

  std::uint32_t size() const { return static_cast<std::uint32_t>(corners.size()); }
  bool is_ghost(std::uint32_t t) const { return t >= first_ghost; }
  bool is_wall(std::uint32_t t, int face) const { return (walls[t] >> face & 1) != 0; }
  /// Does nothing ever cross this face?
  bool is_barrier(std::uint32_t t, int face) const {
    return is_wall(t, face) || neighbors[t][static_cast<std::size_t>(face)] == kSolid;
  }

  /// The corners of face i, counterclockwise seen from within the tetrahedron: from outside of what lies beyond it.
  static constexpr std::array<std::array<int, 3>, 4> kFace = {{{1, 3, 2}, {0, 2, 3}, {0, 3, 1}, {0, 1, 2}}};
  Triangle face(std::uint32_t t, int i) const {
    const auto& order = kFace[static_cast<std::size_t>(i)];
    const auto& corner = corners[t];
    return {corner[static_cast<std::size_t>(order[0])], corner[static_cast<std::size_t>(order[1])],
            corner[static_cast<std::size_t>(order[2])]};
  }
};

/// Part of the complement that no way leads to from beyond the hull. Opened by carving its `seed` [HE10, 3].
struct Void {
  std::uint32_t seed = 0;  ///< the tetrahedron with the longest edge, of equal ones the first
  double volume = 0;       ///< cubed model units
};

enum class InsideRule {
  /// Where the winding number is not 0; where orientations contradict each other, behind an odd number of walls or
  /// where the generalised winding number is mostly beyond 1/2.
  kWinding,
  kWindingNumber,  ///< where the generalised winding number of the tetrahedron's centroid is beyond 1/2 [JKS13]
};

struct Classification {
  Complement complement;
  std::vector<Void> voids;       ///< in the order of their seeds
  std::uint32_t tetrahedra = 0;  ///< of the whole hull
  std::uint32_t hull_faces = 0;
  std::uint32_t hull_points = 0;
  std::int64_t folds = 0;                  ///< walls with the outside on both sides
  std::int64_t nested_regions = 0;         ///< inside, with a winding number other than 1 and -1
  std::int64_t contradictory_regions = 0;  ///< where orientations say different things
};

/// Tells inside from outside by counting walls on the way from the hull, without arithmetic on coordinates [HE10, 3.2].
/// `model` is the complex that was tetrahedralized; `multiplicity` says of each of its triangles how often it stands
/// there (Arrangement). Throws MethodFailure when a facet of the model is no face of the tetrahedralization, and
/// Cancelled.
Classification classify(const Tetrahedralization& tetrahedralization, const TriangleSoup& model,
                        const std::vector<std::int32_t>& multiplicity, InsideRule rule, RunContext& context);

}  // namespace voxcarve
