// From any soup to a tetrahedralization of its hull.
#pragma once

#include <vector>

#include "common/mesh/triangle_soup.h"
#include "common/run/context.h"
#include "methods/hagbi_elsana/tetgen_child.h"

namespace voxcarve {

struct ComplexOptions {
  TetgenLimits limits;
  bool box = false;  ///< around the corners of the model's box, too [HE10, 3.1]
};

/// A piecewise linear complex, and the tetrahedra of its hull.
struct ValidComplex {
  TriangleSoup complex;
  std::vector<std::int32_t> multiplicity;  ///< of its triangles, see Arrangement
  Tetrahedralization tetrahedralization;
  bool wrapped = false;  ///< the complex is a wrap of the model, with vertices of its own
};

/// Tries, in this order, with a notice of what was done and what it took: the soup as it is, its equal vertices and
/// coincident triangles merged and its flat ones dropped; crossing triangles split (`arrange`); points told apart that
/// are closer than usual; Steiner points on the triangles; a shrink-wrap around it. What failed attempts took stands
/// among the context's timings as stages "tetrahedralization (failed)" and the like, in this order.
/// Throws MethodFailure, with the reason of each, when none can be tetrahedralized, or when the vertices lie in a
/// plane, and as `tetrahedralize` does.
ValidComplex make_valid_complex(const TriangleSoup& soup, const ComplexOptions& options, RunContext& context);

}  // namespace voxcarve
