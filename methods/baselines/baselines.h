// What every method is compared with.
#pragma once

#include <memory>

#include "methods/method.h"

namespace voxcarve {

/// The input itself; of a volume its isosurface.
std::unique_ptr<Method> make_identity();

/// Quadric edge collapse alone, which keeps the topology [GH97].
std::unique_ptr<Method> make_qslim();

/// Contraction of vertex pairs within a threshold, which changes the topology [GH97].
std::unique_ptr<Method> make_pair_collapse();

/// Vertices merged in the cells of a grid [RB93].
std::unique_ptr<Method> make_vertex_clustering();

/// CGAL's Alpha_wrap_3 [AW22]: an offset surface shrink-wrapped by Delaunay refinement, then reduced.
std::unique_ptr<Method> make_alpha_wrap();

}  // namespace voxcarve
