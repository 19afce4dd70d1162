// Topology simplification and repair by voxels and morphology [NT03].
#pragma once

#include <memory>

#include "methods/method.h"

namespace voxcarve {

/// soup -> voxelize -> open, close, dilate or erode -> manifold marching cubes -> quadric edge collapse [NT03, Fig. 1].
/// Without morphology it is the paper's repair. Volumes enter after the voxelization. The README beside this file lists
/// parameters and deviations.
std::unique_ptr<Method> make_nooruddin_turk();

}  // namespace voxcarve
