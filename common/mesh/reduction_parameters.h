// Parameters that every method with a triangle budget shares.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/mesh/triangle_soup.h"
#include "common/run/context.h"
#include "common/run/parameters.h"

namespace voxcarve {

/// Schema lines of a reduction: `triangles` (of `minimum` or more; `help` says what 0 means where it is allowed),
/// `reducer` and `color_weight`.
std::vector<ParameterSpec> reduction_parameters(std::int64_t minimum, std::int64_t default_triangles, std::string help);

/// Reduces `surface` as `parameters`, of a schema with the lines above, ask for; 0 triangles leave it as it is.
TriangleSoup reduce(TriangleSoup surface, const Parameters& parameters, RunContext& context);

}  // namespace voxcarve
