#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "common/mesh/io/mesh_io.h"
#include "common/mesh/models/catalogue.h"
#include "common/mesh/models/procedural.h"
#include "common/run/errors.h"
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

void list_models(const std::string& folder, bool json) {
  if (json) {
    Json procedural = Json::array();
    for (const ProceduralModel& model : procedural_models()) {
      procedural.push_back({{"name", model.info.name},
                            {"summary", model.info.summary},
                            {"stands_for", model.info.stands_for},
                            {"parameters", to_json(model.info.parameters)}});
    }
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
  Table procedural{{"procedural model", "stands for", "what it is"}, {}};
  for (const ProceduralModel& model : procedural_models()) {
    procedural.rows.push_back(
        {model.info.name, model.info.stands_for.empty() ? "-" : model.info.stands_for, model.info.summary});
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
  const ModelInfo& info = find_procedural_model(name).info;
  if (json) {
    print_json({{"name", info.name},
                {"summary", info.summary},
                {"stands_for", info.stands_for},
                {"parameters", to_json(info.parameters)}});
  } else {
    fmt::print("{}: {}\n  stands for: {}\nparameters\n{}", info.name, info.summary,
               info.stands_for.empty() ? "-" : info.stands_for, schema_text(info.parameters));
  }
}

void write_model(Session& session, const std::string& name, const std::string& output) {
  const Model model = session.open(name.starts_with("model:") ? name : "model:" + name);
  if (model.soup() == nullptr) throw InputError(name + " is a volume; only meshes are written here");
  write_mesh(*model.soup(), output);
  if (session.options().json) {
    print_json({{"model", model.name},
                {"vertices", model.soup()->positions.size()},
                {"triangles", model.soup()->triangles.size()},
                {"output", output}});
  } else {
    fmt::print("{}: {} vertices, {} triangles -> {}\n", model.name,
               with_thousands(static_cast<long long>(model.soup()->positions.size())),
               with_thousands(static_cast<long long>(model.soup()->triangles.size())), output);
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
  command->add_option("-o,--output", options->output, "mesh file to write it to")->needs(name);
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
