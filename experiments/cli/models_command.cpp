#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "common/mesh/io/mesh_io.h"
#include "common/mesh/models/catalogue.h"
#include "common/mesh/models/procedural.h"
#include "common/run/errors.h"
#include "common/run/text.h"
#include "common/volume/io/volume_io.h"
#include "common/volume/models/volume_models.h"
#include "experiments/cli/commands.h"
#include "experiments/cli/json_text.h"
#include "experiments/cli/session.h"
#include "experiments/runner/table.h"

namespace voxcarve {

namespace {

using Json = nlohmann::ordered_json;

bool is_present(const ExternalModel& model, const std::string& folder) {
  std::error_code ignored;
  return !folder.empty() && std::filesystem::exists(std::filesystem::path(folder) / model.file, ignored);
}

/// A computed model of any kind.
struct ComputedModel {
  const ModelInfo* info;
  std::string_view kind;
};

ComputedModel computed(const VolumeModel& model) {
  return {&model.info, model.is_image ? "image" : "volume"};
}

/// Meshes, volumes and images in alphabetical order.
std::vector<ComputedModel> computed_models() {
  std::vector<ComputedModel> models;
  for (const ProceduralModel& model : procedural_models()) models.push_back({&model.info, "mesh"});
  for (const VolumeModel& model : volume_models()) models.push_back(computed(model));
  std::ranges::sort(models, {}, [](const ComputedModel& model) { return model.info->name; });
  return models;
}

/// Throws ParameterError, with the nearest name of all models, when there is none of that name.
ComputedModel find_computed(const std::string& name) {
  for (const ComputedModel& model : computed_models()) {
    if (model.info->name == name) return model;
  }
  return computed(find_volume_model(name));
}

Json to_json(const ComputedModel& model) {
  return {{"name", model.info->name},
          {"kind", model.kind},
          {"summary", model.info->summary},
          {"stands_for", model.info->stands_for},
          {"parameters", voxcarve::to_json(model.info->parameters)}};
}

void list_models(const std::string& folder, bool json) {
  if (json) {
    Json procedural = Json::array();
    for (const ComputedModel& model : computed_models()) procedural.push_back(to_json(model));
    Json external = Json::array();
    for (const ExternalModel& model : external_models()) {
      external.push_back({{"name", model.name},
                          {"kind", to_string(model.kind)},
                          {"file", model.file},
                          {"stands_for", model.stands_for},
                          {"source", model.source},
                          {"licence", model.licence},
                          {"sha256", model.sha256},
                          {"present", is_present(model, folder)}});
    }
    print_json({{"procedural", procedural}, {"external", external}});
    return;
  }
  Table procedural{{"procedural model", "kind", "stands for", "what it is"}, {}};
  for (const auto& [info, kind] : computed_models()) {
    procedural.rows.push_back(
        {info->name, std::string(kind), info->stands_for.empty() ? "-" : info->stands_for, info->summary});
  }
  Table external{{"external model", "kind", "here", "stands for"}, {}};
  for (const ExternalModel& model : external_models()) {
    external.rows.push_back(
        {model.name, std::string(to_string(model.kind)), is_present(model, folder) ? "yes" : "no", model.stands_for});
  }
  fmt::print("{}\n{}", to_text(procedural), to_text(external));
  if (folder.empty()) fmt::print("\nExternal models lie in the folder that VOXCARVE_DATA or --data names.\n");
}

void show_model(const std::string& name, bool json) {
  for (const ExternalModel& model : external_models()) {
    if (model.name != name) continue;
    if (json) {
      print_json({{"name", model.name},
                  {"file", model.file},
                  {"source", model.source},
                  {"licence", model.licence},
                  {"sha256", model.sha256}});
    } else {
      fmt::print("{} (external {})\n  file:    {}\n  source:  {}\n  licence: {}\n  sha256:  {}\n", model.name,
                 to_string(model.kind), model.file, model.source, model.licence, model.sha256);
    }
    return;
  }
  const ComputedModel model = find_computed(name);
  if (json) {
    print_json(to_json(model));
  } else {
    const ModelInfo& info = *model.info;
    fmt::print("{} ({}): {}\n  stands for: {}\nparameters\n{}", info.name, model.kind, info.summary,
               info.stands_for.empty() ? "-" : info.stands_for, schema_text(info.parameters));
  }
}

std::string grouped(std::int64_t count) {
  return with_thousands(static_cast<long long>(count));
}

void write_surface(const std::string& name, const TriangleSoup& soup, const std::string& output, bool json) {
  write_mesh(soup, output);
  if (json) {
    print_json({{"model", name},
                {"vertices", soup.positions.size()},
                {"triangles", soup.triangles.size()},
                {"output", output}});
  } else {
    fmt::print("{}: {} vertices, {} triangles -> {}\n", name, grouped(std::ssize(soup.positions)),
               grouped(std::ssize(soup.triangles)), output);
  }
}

void write_binary_volume(const std::string& name, const BinaryVolume& volume, const std::string& output, bool json) {
  write_volume(volume, output);
  const std::int64_t interior = count_interior(volume);
  if (json) {
    print_json({{"model", name},
                {"dims", {volume.nx(), volume.ny(), volume.nz()}},
                {"interior", interior},
                {"output", output}});
  } else {
    const bool image = volume.frame.is_image();
    const std::string dims = image ? fmt::format("{} x {} pixels", volume.nx(), volume.ny())
                                   : fmt::format("{} x {} x {} voxels", volume.nx(), volume.ny(), volume.nz());
    fmt::print("{}: {}, {} interior -> {}\n", name, dims, grouped(interior), output);
  }
}

void write_model(Session& session, const std::string& name, const std::string& output) {
  const Model model = session.open(name.starts_with("model:") ? name : "model:" + name);
  const bool json = session.options().json;
  if (const TriangleSoup* soup = model.soup()) {
    write_surface(model.name, *soup, output, json);
  } else if (const auto* volume = std::get_if<BinaryVolume>(&model.shape)) {
    write_binary_volume(model.name, *volume, output, json);
  } else {
    throw InputError(name + " is " + with_article(to_string(model.kind())) +
                     "; only meshes, binary volumes and images are written here");
  }
}

}  // namespace

void add_models_command(CLI::App& app) {
  struct Options {
    CommonOptions common;
    std::string name;
    std::string output;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command =
      app.add_subcommand("models", "list procedural and external models, show one, or write one to a file");
  CLI::Option* name =
      command->add_option("NAME", options->name, "a model, with parameters as NAME?key=value&key=value");
  command
      ->add_option("-o,--output", options->output,
                   "file to write it to: a mesh (PLY, OBJ, OFF, STL), volume (NRRD, MHD, MHA) or image (PNG, PBM, PGM)")
      ->needs(name);
  add_common_options(*command, options->common);
  command->callback([options] {
    Session session(options->common);
    if (options->name.empty()) {
      list_models(session.data_folder(), options->common.json);
    } else if (options->output.empty()) {
      show_model(options->name, options->common.json);
    } else {
      write_model(session, options->name, options->output);
    }
  });
}

}  // namespace voxcarve
