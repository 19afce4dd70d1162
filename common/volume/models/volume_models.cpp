#include "common/volume/models/volume_models.h"

#include <algorithm>

#include "common/mesh/models/catalogue.h"
#include "common/mesh/models/model_spec.h"
#include "common/run/errors.h"
#include "common/run/text.h"
#include "common/volume/models/builders.h"

namespace voxcarve {

namespace {

std::vector<VolumeModel> all_models() {
  std::vector<VolumeModel> models = {ball_cube_model(), cells_model(), galaxy_model(), landscape_model()};
  std::ranges::sort(models, {}, [](const VolumeModel& model) { return model.info.name; });
  return models;
}

std::vector<std::string> names_of_all_kinds() {
  std::vector<std::string> names;
  for (const VolumeModel& model : volume_models()) names.push_back(model.info.name);
  for (const ProceduralModel& model : procedural_models()) names.push_back(model.info.name);
  for (const ExternalModel& model : external_models()) names.push_back(model.name);
  return names;
}

}  // namespace

const std::vector<VolumeModel>& volume_models() {
  static const std::vector<VolumeModel> models = all_models();
  return models;
}

bool is_volume_model(std::string_view name) {
  return std::ranges::any_of(volume_models(), [&](const VolumeModel& model) { return model.info.name == name; });
}

const VolumeModel& find_volume_model(std::string_view name) {
  for (const VolumeModel& model : volume_models()) {
    if (model.info.name == name) return model;
  }
  const std::vector<std::string> names = names_of_all_kinds();
  const std::string quoted = "'" + std::string(name) + "'";
  if (std::ranges::find(names, name) != names.end()) throw ParameterError(quoted + " is no volume or image model");
  throw ParameterError("no model is called " + quoted + suggestion(name, names));
}

BinaryVolume make_volume(std::string_view spec) {
  const auto [name, assignments] = parse_model_spec(spec);
  const VolumeModel& model = find_volume_model(name);
  return model.build(Parameters::parse(model.info.parameters, assignments, model.info.name));
}

}  // namespace voxcarve
