#include "common/mesh/models/procedural.h"

#include <algorithm>
#include <cstdint>

#include "common/mesh/models/builders.h"
#include "common/mesh/models/catalogue.h"
#include "common/mesh/models/model_spec.h"
#include "common/run/errors.h"
#include "common/run/text.h"

namespace voxcarve {

namespace {

constexpr double kMaximumTriangles = 20e6;
constexpr const char* kImplicit = "implicit";

std::vector<ProceduralModel> all_models() {
  std::vector<ProceduralModel> models = cracked_models();
  for (const auto& model :
       {blade_model, bolt_model, chair_model, elm_model, engine_model, foot_bones_model, genus_n_model,
        geospheres_model, interpenetrating_figure_model, mechanical_part_model, mushrooms_model, perforated_box_model,
        pine_model, sconce_model, sphereflake_model, torso_ribs_model, torus_model, two_spheres_model, yucca_model}) {
    models.push_back(model());
  }
  std::ranges::sort(models, {}, [](const ProceduralModel& model) { return model.info.name; });
  return models;
}

bool is_external(std::string_view name) {
  return std::ranges::any_of(external_models(), [&](const ExternalModel& model) { return model.name == name; });
}

}  // namespace

void require_triangles_within_limit(std::string_view model, double triangles) {
  if (triangles <= kMaximumTriangles) return;
  throw ParameterError(std::string(model) + ": these parameters make " +
                       std::to_string(static_cast<std::int64_t>(triangles)) +
                       " triangles, more than the limit of 20 million");
}

ParameterSpec form_parameter() {
  return ParameterSpec::choice("form", {"mesh", kImplicit}, "mesh",
                               "a triangle mesh, or the exact solid by its formulas, for methods that sample it");
}

const std::vector<ProceduralModel>& procedural_models() {
  static const std::vector<ProceduralModel> models = all_models();
  return models;
}

const ProceduralModel& find_procedural_model(std::string_view name) {
  std::vector<std::string> names;
  for (const ProceduralModel& model : procedural_models()) {
    if (model.info.name == name) return model;
    names.push_back(model.info.name);
  }
  const std::string quoted = "'" + std::string(name) + "'";
  if (is_external(name)) {
    throw ParameterError(quoted + " is an external model (a file), not a procedural one and has no parameters");
  }
  for (const ExternalModel& model : external_models()) names.push_back(model.name);
  throw ParameterError("no model is called " + quoted + suggestion(name, names));
}

namespace {

/// A model and a complete set of its parameters.
struct ParsedSpec {
  const ProceduralModel& model;
  Parameters parameters;
  bool is_implicit;
};

ParsedSpec parse(std::string_view spec) {
  const auto [name, assignments] = parse_model_spec(spec);
  const ProceduralModel& model = find_procedural_model(name);
  Parameters parameters = Parameters::parse(model.info.parameters, assignments, model.info.name);
  const bool is_implicit = model.solid && parameters.choice("form") == kImplicit;
  return {model, std::move(parameters), is_implicit};
}

}  // namespace

TriangleSoup make_procedural(std::string_view spec) {
  const ParsedSpec parsed = parse(spec);
  if (parsed.is_implicit) throw ParameterError(parsed.model.info.name + ": form=implicit has no triangles");
  return parsed.model.build(parsed.parameters);
}

std::optional<ImplicitSolid> make_implicit(std::string_view spec) {
  const ParsedSpec parsed = parse(spec);
  if (!parsed.is_implicit) return std::nullopt;
  return parsed.model.solid(parsed.parameters);
}

}  // namespace voxcarve
