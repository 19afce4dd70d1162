// Models that are computed: small, exact stand-ins for the papers' own inputs, which are mostly not public.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/mesh/implicit_solid.h"
#include "common/mesh/triangle_soup.h"
#include "common/run/parameters.h"

namespace voxcarve {

/// What a model is called, what it is, and which figure of the papers it stands in for.
struct ModelInfo {
  std::string name;
  std::string summary;     ///< one line
  std::string stands_for;  ///< "NT Fig. 9", or "" for a plain test shape
  ParameterSchema parameters;
};

/// A model and how it is made. `build` takes a complete set of parameters of the schema, is deterministic, and gives
/// closed, outward-oriented parts with shared vertices, in model units. Exceptions: `yucca`, and the leaves of `elm`
/// and needles of `pine`, are open sheets; others are made to have defects: `engine` has cavities (closed,
/// inward-oriented), T-joints, zero-area faces and non-manifold vertices, and each `cracked-...` what its name says.
struct ProceduralModel {
  ModelInfo info;
  std::function<TriangleSoup(const Parameters&)> build;
  /// The exact solid that the surface of `build` approximates, by formulas. Where there is one, the schema has a choice
  /// "form", mesh or implicit; elsewhere it is empty.
  std::function<ImplicitSolid(const Parameters&)> solid = {};
};

/// All of them, in alphabetical order.
const std::vector<ProceduralModel>& procedural_models();

/// The model of that name. Throws ParameterError, with the nearest name of a procedural or external model.
const ProceduralModel& find_procedural_model(std::string_view name);

/// Builds from "name" or "name?key=value&key=value", for instance "torus?major=2&minor=0.5". Throws ParameterError for
/// an unknown name or key (with the nearest known one), a value out of range, more than 20 million triangles, or
/// form=implicit, which has none.
TriangleSoup make_procedural(std::string_view spec);

/// The solid of a spec that says form=implicit, for instance "sphereflake?form=implicit", or nothing for other specs.
/// Throws ParameterError for an unknown name or key, or a value out of range.
std::optional<ImplicitSolid> make_implicit(std::string_view spec);

}  // namespace voxcarve
