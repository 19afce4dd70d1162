// Every method that the program knows.
#pragma once

#include <string_view>
#include <vector>

#include "methods/method.h"

namespace voxcarve {

/// All methods, in the order of the registry: the papers' first, then the baselines.
const std::vector<const Method*>& all_methods();

/// The method called `name`; throws ParameterError with the nearest known name when there is none.
const Method& find_method(std::string_view name);

}  // namespace voxcarve
