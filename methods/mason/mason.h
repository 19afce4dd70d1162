// Mason and the operators it is made of.
#pragma once

#include <memory>

#include "methods/method.h"

namespace voxcarve {

/// Mason: Morphological Simplification [WR05].
std::unique_ptr<Method> make_mason();

// The operators alone, as baselines: a step, two, or four. `round` and `fillet` are what the rest of the literature
// calls opening and closing; both names stand in tables.
std::unique_ptr<Method> make_dilate();
std::unique_ptr<Method> make_erode();
std::unique_ptr<Method> make_round();
std::unique_ptr<Method> make_fillet();
std::unique_ptr<Method> make_open();
std::unique_ptr<Method> make_close();
std::unique_ptr<Method> make_rf();
std::unique_ptr<Method> make_fr();

}  // namespace voxcarve
