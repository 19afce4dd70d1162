// The text that names a model and sets its parameters.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace voxcarve {

/// "name" or "name?key=value&key=value" in its parts.
struct ModelSpec {
  std::string_view name;                 ///< a view of the text
  std::vector<std::string> assignments;  ///< "key=value", as Parameters::parse takes them
};

/// Only takes the text apart: whether there is such a model with such parameters is not looked at.
ModelSpec parse_model_spec(std::string_view spec);

}  // namespace voxcarve
