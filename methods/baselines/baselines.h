// What every method is compared with.
#pragma once

#include <memory>

#include "methods/method.h"

namespace voxcarve {

/// The input itself; of a volume its isosurface.
std::unique_ptr<Method> make_identity();

/// Quadric edge collapse alone, which keeps the topology [GH97].
std::unique_ptr<Method> make_qslim();

/// CGAL's Alpha_wrap_3 [AW22]: an offset surface shrink-wrapped by Delaunay refinement, then reduced.
std::unique_ptr<Method> make_alpha_wrap();

}  // namespace voxcarve
