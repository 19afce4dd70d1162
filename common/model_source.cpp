#include "common/model_source.h"

#include <algorithm>
#include <cstdlib>
#include <optional>
#include <string_view>

#include "common/mesh/io/mesh_io.h"
#include "common/mesh/models/catalogue.h"
#include "common/mesh/models/model_spec.h"
#include "common/mesh/models/procedural.h"
#include "common/run/errors.h"
#include "common/run/text.h"
#include "common/volume/io/volume_io.h"
#include "common/volume/isosurface.h"
#include "common/volume/models/volume_models.h"

namespace voxcarve {

namespace {

constexpr std::string_view kModelPrefix = "model:";

std::string file_stem(const std::filesystem::path& path) {
  return path.stem().string();
}

Model volume_model(const std::filesystem::path& path, const ModelSourceOptions& options,
                   std::vector<std::string>& notices) {
  VolumeFile file = read_volume(path);
  notices.insert(notices.end(), file.notices.begin(), file.notices.end());
  const auto [low, high] = std::ranges::minmax(file.values.values);
  const bool is_image = file.values.frame.is_image();
  const double middle = 0.5 * (static_cast<double>(low) + static_cast<double>(high));
  // Binary values are 0 and 1 here, whatever the file called them: an iso-value in the file's own units says nothing.
  const double iso_value = file.is_binary ? 0.5 : options.iso_value.value_or(middle);
  if (!options.iso_value && !file.is_binary) {
    notices.push_back(path.filename().string() + ": no --iso was given; took " + format_real(iso_value) +
                      ", the middle of the values from " + format_real(static_cast<double>(low)) + " to " +
                      format_real(static_cast<double>(high)));
  }
  Model model;
  model.name = file_stem(path);
  if (!file.is_binary && !is_image) {
    model.shape = ScalarVolume{std::move(file.values), static_cast<float>(iso_value)};
    return model;
  }
  BinaryVolume binary(file.values.frame);
  std::ranges::transform(file.values.values, binary.values.begin(), [iso_value](float value) {
    return static_cast<std::uint8_t>(static_cast<double>(value) >= iso_value);
  });
  // One value only: all of it is what the file calls it, foreground for anything but 0.
  if (low == high) std::ranges::fill(binary.values, static_cast<std::uint8_t>(low != 0));
  model.shape = std::move(binary);
  return model;
}

Model file_model(const std::filesystem::path& path, const ModelSourceOptions& options,
                 std::vector<std::string>& notices) {
  if (is_volume_file(path)) return volume_model(path, options, notices);
  if (!mesh_format(path)) {
    throw InputError(path.string() +
                     ": its extension names no format that can be read; use PLY, OBJ, OFF, STL, NRRD, MHD, MHA, PNG, "
                     "PBM, PGM or model:NAME");
  }
  return Model{file_stem(path), read_mesh(path)};
}

/// A model of "NAME?key=value&key=value". What is none of the program's surfaces or files goes to the volume models,
/// which know the names of all when it is nothing.
Model named_model(const std::string& spec, const ModelSourceOptions& options, std::vector<std::string>& notices) {
  const ModelSpec parts = parse_model_spec(spec);
  const std::string name(parts.name);
  const bool external = std::ranges::any_of(external_models(), [&](const ExternalModel& m) { return m.name == name; });
  if (external && parts.assignments.empty()) {
    Model model = file_model(find_external(name, data_folder(options)), options, notices);
    model.name = name;
    return model;
  }
  const bool surface =
      std::ranges::any_of(procedural_models(), [&](const ProceduralModel& m) { return m.info.name == name; });
  // An external model with parameters is refused there.
  if (surface || external) {
    if (std::optional<ImplicitSolid> solid = make_implicit(spec)) return Model{name, *std::move(solid)};
    return Model{name, make_procedural(spec)};
  }
  return Model{name, make_volume(spec)};
}

}  // namespace

std::filesystem::path data_folder(const ModelSourceOptions& options) {
  if (!options.data_folder.empty()) return options.data_folder;
  const char* folder = std::getenv("VOXCARVE_DATA");
  return folder == nullptr ? "" : folder;
}

Model open_model(const std::string& input, const ModelSourceOptions& options, std::vector<std::string>& notices) {
  Model model = input.starts_with(kModelPrefix) ? named_model(input.substr(kModelPrefix.size()), options, notices)
                                                : file_model(input, options, notices);
  validate(model);
  return model;
}

TriangleSoup reference_surface(const Model& model, RunContext& context) {
  if (const auto* soup = model.soup()) return *soup;
  if (const auto* scalar = std::get_if<ScalarVolume>(&model.shape))
    return scalar_isosurface(scalar->grid, scalar->iso_value, context);
  if (model.kind() == ModelKind::kBinaryVolume) return isosurface(std::get<BinaryVolume>(model.shape), context);
  if (model.kind() == ModelKind::kImplicitSolid) {
    throw InputError(model.name + " is an implicit solid, which has no triangles: take its surface, form=mesh, here");
  }
  throw InputError(model.name + " is an " + std::string(to_string(model.kind())) + ", which has no surface");
}

}  // namespace voxcarve
