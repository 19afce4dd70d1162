// Checks of option values that say in one short line what would do.
#pragma once

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdlib>
#include <string>

#include "common/run/text.h"

namespace voxcarve {

/// A finite number from `low` to `high`; not a number, or more digits than a double takes, is refused too.
inline CLI::Validator in_range(double low, double high) {
  const std::string range = format_real(low) + " to " + format_real(high);
  return CLI::Validator(
      [=](std::string& text) -> std::string {
        char* end = nullptr;
        const double value = std::strtod(text.c_str(), &end);
        const bool fits = end != text.c_str() && *end == '\0' && value >= low && value <= high;
        return fits ? "" : "'" + text + "' is not a number from " + range;
      },
      range, "in_range");
}

/// The largest number of triangles, vertices or levels that may be asked for.
inline constexpr double kLargestCount = 4294967296;

}  // namespace voxcarve
