#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/mesh/io/mesh_io.h"
#include "common/run/atomic_file.h"
#include "common/run/errors.h"
#include "common/run/text.h"
#include "common/volume/io/volume_io.h"
#include "experiments/cli/checks.h"
#include "experiments/cli/commands.h"
#include "experiments/cli/json_text.h"
#include "experiments/cli/level_files.h"
#include "experiments/cli/session.h"
#include "experiments/runner/comparison.h"
#include "methods/hagbi_elsana/hagbi_elsana.h"
#include "methods/hagbi_elsana/stream_file.h"
#include "methods/registry.h"

namespace voxcarve {

namespace {

using Json = nlohmann::ordered_json;

struct RunOptions {
  CommonOptions common;
  std::string method;
  std::string input;
  std::string output;
  std::string report;
  std::string volume;
  std::string levels;
  std::string levels_format = "ply";
  std::vector<std::string> settings;
  std::int64_t triangles = 0;
  std::int64_t vertices = 0;
  std::int64_t level = -1;
  bool check_invariants = false;
};

/// The level that --level, --vertices or --triangles asks for; the finest without them.
ChosenLevel choose_level(const MethodResult& result, const RunOptions& options) {
  const std::int64_t levels = result.levels->size();
  if (options.level >= levels) {
    throw ParameterError("there is no level " + std::to_string(options.level) + ": this result has " +
                         std::to_string(levels) + ", numbered from 0, the coarsest");
  }
  if (options.level >= 0) return {options.level, result.levels->extract(options.level)};
  if (options.vertices == 0) return level_for_budget(result, options.triangles);
  std::int64_t index = levels - 1;
  while (index > 0 && result.levels->counts(index).vertices > options.vertices) --index;
  return {index, result.levels->extract(index)};
}

/// The volume that --volume names, of the level chosen or of all levels; the result of that level without it.
const NamedVolume& choose_volume(const MethodResult& result, std::int64_t level, const RunOptions& options) {
  if (result.volumes.empty())
    throw ParameterError("this run has no volume to write to " + options.output + "; name a PLY, OBJ, OFF or STL file");
  const NamedVolume* chosen = nullptr;
  std::vector<std::string> names;
  for (const NamedVolume& volume : result.volumes) {
    if (std::ranges::find(names, volume.name) == names.end()) names.push_back(volume.name);
    const bool named = options.volume.empty() || volume.name == options.volume;
    if (named && (volume.level == level || chosen == nullptr)) chosen = &volume;
  }
  if (chosen == nullptr) {
    throw ParameterError("this run has no volume '" + options.volume + "'" + suggestion(options.volume, names) +
                         "; it has " + join(names));
  }
  return *chosen;
}

/// A volume file takes a volume of the result, on the input's grid where the input is a volume and the result fits it.
void write_result_volume(const NamedVolume& chosen, const Model& model, const std::string& output) {
  std::visit(
      [&](const auto& volume) {
        const auto* binary = std::get_if<BinaryVolume>(&model.shape);
        const auto* scalar = std::get_if<ScalarVolume>(&model.shape);
        const GridFrame& frame = binary != nullptr   ? binary->frame
                                 : scalar != nullptr ? scalar->grid.frame
                                                     : volume.frame;
        if (frame == volume.frame || frame.voxel_size != volume.frame.voxel_size) {
          write_volume(volume, output);
          return;
        }
        const auto on_input = resized(volume, frame);
        const bool fits = resized(on_input, volume.frame) == volume;
        write_volume(fits ? on_input : volume, output);
      },
      chosen.volume);
}

/// Interior voxels of the level's result, of a method that makes binary volumes.
std::optional<std::int64_t> interior_of(const MethodResult& result, std::int64_t level) {
  std::optional<std::int64_t> interior;
  for (const NamedVolume& volume : result.volumes) {
    const auto* binary = std::get_if<BinaryVolume>(&volume.volume);
    if (binary != nullptr && volume.level == level) interior = count_interior(*binary);
  }
  return interior;
}

/// What a level holds, for the terminal.
std::string summary_of(const MethodResult& result, const ChosenLevel& level) {
  const auto voxels = interior_of(result, level.index);
  if (level.surface.empty() && voxels) return with_thousands(*voxels) + " interior voxels";
  const auto densities = std::ranges::find_if(result.volumes, [&](const NamedVolume& volume) {
    return volume.level == level.index && std::holds_alternative<DensityVolume>(volume.volume);
  });
  if (level.surface.empty() && densities != result.volumes.end())
    return with_thousands(std::get<DensityVolume>(densities->volume).frame.voxels()) + " voxels";
  return with_thousands(static_cast<long long>(level.surface.positions.size())) + " vertices, " +
         with_thousands(static_cast<long long>(level.surface.triangles.size())) + " triangles";
}

Json run_report(const Model& model, const Method& method, const Parameters& parameters, const MethodResult& result,
                std::int64_t level, const TriangleSoup& surface, const std::vector<InvariantCheck>& checks,
                const RunOptions& options) {
  Json json = {{"program", "voxcarve " + version()},
               {"method", method.info().name},
               {"model", model.name},
               {"parameters", to_json(parameters)},
               {"seed", options.common.seed},
               {"levels", result.levels->size()},
               {"level", level}};
  if (!surface.empty()) {
    json["vertices"] = surface.positions.size();
    json["triangles"] = surface.triangles.size();
  }
  if (const auto voxels = interior_of(result, level)) json["interior"] = *voxels;
  json["notices"] = result.notices;
  json["timings"] = to_json(result.timings);
  if (options.check_invariants) {
    Json list = Json::array();
    for (const InvariantCheck& check : checks)
      list.push_back({{"invariant", check.name}, {"holds", check.holds}, {"detail", check.detail}});
    json["invariants"] = list;
  }
  if (!options.output.empty()) json["output"] = options.output;
  if (!options.levels.empty()) json["levels_folder"] = options.levels;
  return json;
}

void run(const RunOptions& options) {
  const Method& method = find_method(options.method);
  const Parameters parameters = parameters_for_budget(method, options.triangles, options.settings);
  if (!options.volume.empty() && (options.output.empty() || !is_volume_file(options.output)))
    throw ParameterError("--volume needs an output file that holds a volume: NRRD, MHD, PNG, PGM or PBM");
  const bool wants_volume = !options.output.empty() && is_volume_file(options.output);
  const bool wants_stream = is_stream_file(options.output);
  if (!options.output.empty() && !wants_volume && !wants_stream && !mesh_format(options.output)) {
    throw ParameterError(
        options.output +
        ": its extension names no format that can be written; use PLY, OBJ, OFF, STL, NRRD, MHD, PNG or VCS");
  }
  if (wants_volume && !method.info().gives_volume) {
    throw ParameterError(method.info().name + " makes no volume to write to " + options.output +
                         "; name a PLY, OBJ, OFF or STL file");
  }
  if (wants_stream && !method.info().gives_stream) {
    throw ParameterError(method.info().name + " makes no carving stream to write to " + options.output +
                         "; hagbi-elsana does");
  }
  if (wants_stream && (options.level >= 0 || options.vertices > 0 || options.triangles > 0)) {
    throw ParameterError(options.output + " takes the whole stream; voxcarve extract takes levels out of it");
  }
  require_folder(options.output);
  require_folder(options.report);
  if (!options.levels.empty()) {
    require_folder(options.levels);
    protect_input_of_levels(options.input, options.levels, options.levels_format);
  }
  Session session(options.common);
  const Model model = session.open(options.input);
  session.announce(method.info().name);
  // Surfaces cost more than volumes, and nobody looks at them where these are all that is wanted.
  session.context().surfaces = !wants_volume || options.check_invariants || options.triangles > 0 ||
                               options.vertices > 0 || !options.levels.empty();
  MethodResult result = method.run(model, parameters, session.context());
  const ChosenLevel level = choose_level(result, options);
  const TriangleSoup& surface = level.surface;
  const std::string missed = missed_budget(surface, options.triangles, options.vertices);
  if (!missed.empty()) result.notices.push_back(missed);
  std::vector<InvariantCheck> checks;
  if (options.check_invariants) checks = method.check_invariants(model, parameters, result, session.context());
  if (wants_stream) {
    write_stream(*stream_of(*result.levels), options.output);
  } else if (wants_volume) {
    write_result_volume(choose_volume(result, level.index, options), model, options.output);
  } else if (!options.output.empty()) {
    if (surface.empty())
      throw MethodFailure("nothing of " + model.name + " is left, so there is no mesh to write to " + options.output);
    write_mesh(surface, options.output);
  }
  std::int64_t level_files = 0;
  if (!options.levels.empty()) {
    level_files =
        write_levels(result, {&method, &model, &parameters}, options.levels, options.levels_format, session.context());
  }
  const Json report = run_report(model, method, parameters, result, level.index, surface, checks, options);
  if (!options.report.empty()) write_file_atomically(options.report, json_text(report) + "\n");
  session.print_notices(result.notices);
  session.print_timings(result.timings);
  if (options.common.json) {
    print_json(report);
  } else {
    double seconds = 0;
    for (const StageTiming& timing : result.timings) seconds += timing.seconds;
    fmt::print("{} of {}: {} in {:.2f} s{}\n", method.info().name, model.name, summary_of(result, level), seconds,
               options.output.empty() ? "" : " -> " + options.output);
    if (!options.levels.empty())
      fmt::print("  {} level{}, {} mesh file{} -> {}\n", result.levels->size(), result.levels->size() == 1 ? "" : "s",
                 level_files, level_files == 1 ? "" : "s",
                 (std::filesystem::path(options.levels) / "index.json").string());
    for (const InvariantCheck& check : checks)
      fmt::print("  {}: {}{}\n", check.name, check.holds ? "holds" : "VIOLATED",
                 check.detail.empty() ? "" : " (" + check.detail + ")");
  }
  for (const InvariantCheck& check : checks) {
    if (!check.holds)
      throw MethodFailure("the result violates an invariant: " + check.name +
                          (check.detail.empty() ? "" : " (" + check.detail + ")"));
  }
}

}  // namespace

void add_run_command(CLI::App& app) {
  auto options = std::make_shared<RunOptions>();
  CLI::App* command = app.add_subcommand("run", "run one method on one input and write the result");
  command->add_option("METHOD", options->method, "a method (voxcarve methods)")->required();
  command
      ->add_option("INPUT", options->input,
                   "a mesh, volume or image file, or model:NAME?key=value&... (voxcarve models)")
      ->required();
  command->add_option(
      "-o,--output", options->output,
      "file for the result: PLY, OBJ, OFF, STL for the mesh; NRRD, MHD for the volume; PNG, PGM, PBM for the "
      "image; VCS for the whole stream of hagbi-elsana (voxcarve extract)");
  command->add_option("--volume", options->volume,
                      "which volume of the result a volume file takes, such as mortar (default: the result itself)");
  command->add_option("--set", options->settings, "parameters as name=value (voxcarve methods NAME lists them)")
      ->allow_extra_args();
  command->add_option("--triangles", options->triangles, "triangle budget of the result (0: as it comes)")
      ->check(in_range(0, kLargestCount));
  CLI::Option* level =
      command
          ->add_option("--level", options->level,
                       "level of the result, 0 is the coarsest (default: the finest that meets the budget)")
          ->check(in_range(0, kLargestCount));
  command->add_option("--vertices", options->vertices, "take the finest level with at most this many distinct vertices")
      ->check(in_range(1, kLargestCount))
      ->excludes(level);
  CLI::Option* levels = command->add_option(
      "--levels", options->levels,
      "folder for all levels, at most 1,000: level_0.ply, the coarsest, and so on, layers as level_0_layer_0.ply, and "
      "index.json, which lists them with their properties and counts (results/README.md). Levels without triangles "
      "have no file. Of an earlier export its files are removed, others stay");
  command->add_option("--levels-format", options->levels_format, "format of these meshes (default ply)")
      ->check(CLI::IsMember({"ply", "obj", "off", "stl"}))
      ->needs(levels);
  command->add_flag("--check-invariants", options->check_invariants,
                    "verify what the method promises of its result; exit code 5 when it does not hold");
  command->add_option("--report", options->report, "write a JSON report of the run to this file");
  add_common_options(*command, options->common);
  command->callback([options] { run(*options); });
}

}  // namespace voxcarve
