// What the tests of TetGen's child run it on, and how.
#pragma once

#include "common/mesh/triangle_soup.h"
#include "common/run/context.h"
#include "methods/hagbi_elsana/tetgen_child.h"

namespace voxcarve::test {

/// `tetrahedralize` in a context of its own.
inline Tetrahedralization tetrahedralized(const TriangleSoup& complex, FacetSplitting splitting = FacetSplitting::kNone,
                                          const TetgenLimits& limits = {}) {
  RunContext context;
  return tetrahedralize(complex, splitting, limits, context);
}

/// The corner of the unit cube at the origin, outward.
inline TriangleSoup unit_tetrahedron() {
  TriangleSoup soup;
  soup.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  soup.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  return soup;
}

}  // namespace voxcarve::test
