#include "common/mesh/reduction_parameters.h"

#include <utility>

#include "common/mesh/quadric_reduction.h"
#include "common/mesh/reduction.h"

namespace voxcarve {

std::vector<ParameterSpec> reduction_parameters(std::int64_t minimum, std::int64_t default_triangles,
                                                std::string help) {
  return {
      ParameterSpec::integer("triangles", "triangles", minimum, std::int64_t{1} << 32, default_triangles,
                             std::move(help)),
      ParameterSpec::choice("reducer", {"quadric", "openmesh"}, "quadric",
                            "quadric edge collapse: our own, to the point of least error, or OpenMesh's decimater, to "
                            "one end of the edge and without colours"),
      ParameterSpec::real("color_weight", "diag", 0, 10, QuadricReductionOptions{}.color_weight,
                          "our reducer, vertex colours: the length that a difference of 1 in a channel weighs as much "
                          "as; 0 reduces by shape alone"),
  };
}

TriangleSoup reduce(TriangleSoup surface, const Parameters& parameters, RunContext& context) {
  const std::int64_t triangles = parameters.integer("triangles");
  if (triangles == 0) return surface;
  if (parameters.choice("reducer") == "openmesh") return reduce_openmesh(surface, triangles, context);
  QuadricReductionOptions options;
  options.triangles = triangles;
  options.color_weight = parameters.real("color_weight");
  return reduce_quadric(surface, options, context);
}

}  // namespace voxcarve
