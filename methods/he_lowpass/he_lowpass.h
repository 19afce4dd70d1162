// He, Hong, Kaufman, Varshney and Wang: voxel based object simplification.
#pragma once

#include <memory>

#include "methods/method.h"

namespace voxcarve {

/// Low-pass filtered hierarchies and multi-layered surfaces [He95].
std::unique_ptr<Method> make_he_lowpass();

}  // namespace voxcarve
