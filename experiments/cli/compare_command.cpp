#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <stop_token>

#include "common/mesh/io/mesh_io.h"
#include "common/run/atomic_file.h"
#include "common/run/errors.h"
#include "common/run/text.h"
#include "experiments/cli/checks.h"
#include "experiments/cli/commands.h"
#include "experiments/cli/json_text.h"
#include "experiments/cli/session.h"
#include "experiments/render/render.h"
#include "experiments/runner/comparison.h"
#include "methods/registry.h"

namespace voxcarve {

namespace {

using Json = nlohmann::ordered_json;

struct CompareOptions {
  CommonOptions common;
  std::string input;
  std::string methods;
  std::vector<std::string> settings;
  std::int64_t triangles = 2000;
  std::string output;
  RenderOptions render;
  MetricOptions metrics;
};

/// Splits "METHOD.name=value"; a name without a method goes to every method that has it.
std::vector<PlannedRun> make_plan(const CompareOptions& options) {
  std::vector<const Method*> methods;
  if (options.methods.empty()) methods = all_methods();
  for (const std::string& name : split(options.methods, ',')) {
    const Method* method = &find_method(name);
    if (std::ranges::find(methods, method) != methods.end()) throw ParameterError("--methods names " + name + " twice");
    methods.push_back(method);
  }

  // Settings of one method come after those for all, and so win.
  std::map<std::string, std::vector<std::string>> settings;
  for (const bool specific : {false, true}) {
    for (const std::string& setting : options.settings) {
      const std::string name = setting.substr(0, setting.find('='));
      const std::size_t dot = name.find('.');
      if ((dot != std::string::npos) != specific) continue;
      bool used = false;
      for (const Method* method : methods) {
        const MethodInfo& info = method->info();
        const bool here = specific ? name.substr(0, dot) == info.name : info.parameters.find(name) != nullptr;
        if (!here) continue;
        settings[info.name].push_back(specific ? setting.substr(dot + 1) : setting);
        used = true;
      }
      if (!used) {
        throw ParameterError(
            "--set " + setting +
            " fits none of the methods compared; write METHOD.name=value, or a name that one of them has");
      }
    }
  }
  std::vector<PlannedRun> plan;
  for (const Method* method : methods)
    plan.push_back({method, parameters_for_budget(*method, options.triangles, settings[method->info().name])});
  return plan;
}

std::string panel_caption(const ComparisonRow& row) {
  if (row.status != RunStatus::kDone) return row.method + "\n" + std::string(to_string(row.status));
  const MetricValue& distance = value_of(row.measurements, "hausdorff.relative_upper");
  const auto* share = std::get_if<double>(&distance);
  return row.method + "\n" + with_thousands(static_cast<long long>(row.surface.triangles.size())) + " triangles" +
         (share != nullptr ? ", Hausdorff " + rounded(100 * *share, 3) + " % of the diagonal" : "");
}

/// Draws the input and every result; returns why there is no picture, or "".
std::string draw(const Model& model, const TriangleSoup& reference, const std::vector<ComparisonRow>& rows,
                 const CompareOptions& options, std::stop_token cancellation, const std::filesystem::path& png) {
  std::vector<RenderItem> items;
  items.push_back({reference, model.name + "\n" + with_thousands(static_cast<long long>(reference.triangles.size())) +
                                  " triangles"});
  for (const ComparisonRow& row : rows) {
    if (row.method != "identity") items.push_back({row.surface, panel_caption(row)});
  }
  try {
    RenderOptions how = options.render;
    how.cancellation = std::move(cancellation);
    render_meshes(items, how, png);
    return "";
  } catch (const ResourceError& error) {
    return error.what();
  }
}

Json to_json(const ComparisonRow& row) {
  Json json = {{"method", row.method}, {"status", to_string(row.status)}, {"parameters", row.parameters}};
  if (!row.reason.empty()) json["reason"] = row.reason;
  json["metrics"] = voxcarve::to_json(row.measurements);
  json["notices"] = row.notices;
  json["seconds"] = row.seconds;
  json["timings"] = voxcarve::to_json(row.timings);
  return json;
}

/// Reasons of empty cells under the table, each once.
void print_reasons(const std::vector<ComparisonRow>& rows) {
  std::vector<std::string> shown;
  for (const ComparisonRow& row : rows) {
    if (row.status != RunStatus::kDone)
      shown.push_back(row.method + " " + std::string(to_string(row.status)) + ": " + row.reason);
    for (const char* key :
         {"genus", "self_intersections", "hausdorff.relative_upper", "symmetric_difference.relative"}) {
      const auto* undefined =
          row.status == RunStatus::kDone ? std::get_if<Undefined>(&value_of(row.measurements, key)) : nullptr;
      if (undefined != nullptr) shown.push_back(row.method + ", " + key + ": " + undefined->reason);
    }
    for (const std::string& notice : row.notices) shown.push_back(row.method + ": " + notice);
  }
  for (const std::string& line : shown) fmt::print("  {}\n", line);
}

constexpr const char* kCsv = "comparison.csv";
constexpr const char* kJson = "comparison.json";
constexpr const char* kPicture = "comparison.png";

std::string mesh_file(const std::string& method) {
  return method + ".ply";
}

/// The names of the files that an earlier comparison says it left in the folder; what else lies there is not ours.
std::vector<std::string> earlier_files(const std::filesystem::path& folder) {
  std::ifstream file(folder / kJson);
  const Json earlier = Json::parse(file, nullptr, false);
  if (!earlier.is_object() || !earlier.contains("rows") || !earlier["rows"].is_array()) return {};
  std::vector<std::string> names = {kCsv, kJson};
  if (!earlier.contains("no_picture")) names.emplace_back(kPicture);
  for (const Json& row : earlier["rows"]) {
    if (!row.is_object() || !row.contains("method") || !row["method"].is_string()) continue;
    const std::string name = mesh_file(row["method"].get<std::string>());
    const bool written = row.value("status", Json()) == to_string(RunStatus::kDone);
    if (written && std::filesystem::path(name).filename() == name) names.push_back(name);
  }
  return names;
}

/// Refuses an input that the comparison would write over or remove.
void protect_input(const std::string& input, const std::filesystem::path& folder, const std::vector<PlannedRun>& plan) {
  std::vector<std::string> names = earlier_files(folder);
  names.insert(names.end(), {kCsv, kJson, kPicture});
  for (const PlannedRun& run : plan) names.push_back(mesh_file(run.method->info().name));
  for (const std::string& name : names) {
    std::error_code error;  // of files that are not there
    if (std::filesystem::equivalent(input, folder / name, error)) {
      throw ParameterError("the comparison would write over its input " + input + "; give another folder with -o");
    }
  }
}

/// Makes the folder and removes what an earlier comparison left there, so that all of a comparison's files in it are of
/// one run.
void prepare_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw ResourceError("cannot make the folder " + folder.string() + ": " + error.message());
  for (const std::string& name : earlier_files(folder)) std::filesystem::remove(folder / name, error);
}

void compare(const CompareOptions& options) {
  const std::vector<PlannedRun> plan = make_plan(options);
  Session session(options.common);
  const Model model = session.open(options.input);
  const std::filesystem::path folder = options.output.empty() ? "compare-" + model.name : options.output;
  protect_input(options.input, folder, plan);
  const TriangleSoup reference = reference_surface(model, session.context());
  const auto rows = compare_methods(model, reference, plan, options.triangles, options.metrics, session.context(),
                                    [&](const std::string& method) { session.announce(method); });
  session.announce("");
  prepare_folder(folder);
  for (const ComparisonRow& row : rows) {
    if (row.status == RunStatus::kDone) write_mesh(row.surface, folder / mesh_file(row.method));
  }
  write_file_atomically(folder / kCsv, to_csv(full_table(model.name, rows)));
  const std::string no_picture =
      draw(model, reference, rows, options, session.context().cancellation, folder / kPicture);
  Json json = {{"program", "voxcarve " + version()},
               {"model", model.name},
               {"budget", options.triangles},
               {"seed", options.common.seed},
               {"folder", folder.string()}};
  if (!no_picture.empty()) json["no_picture"] = no_picture;
  json["rows"] = Json::array();
  for (const ComparisonRow& row : rows) json["rows"].push_back(to_json(row));
  write_file_atomically(folder / kJson, json_text(json) + "\n");
  if (options.common.json) {
    print_json(json);
    return;
  }
  fmt::print("{}: {} triangles, budget {}\n\n{}\n", model.name,
             with_thousands(static_cast<long long>(reference.triangles.size())), with_thousands(options.triangles),
             to_text(summary_table(rows)));
  print_reasons(rows);
  fmt::print("\n{}: comparison.csv, comparison.json, a PLY file a method{}\n", folder.string(),
             no_picture.empty() ? ", comparison.png" : "");
  if (!no_picture.empty()) fmt::print("no picture: {}\n", no_picture);
}

}  // namespace

void add_compare_command(CLI::App& app) {
  auto options = std::make_shared<CompareOptions>();
  CLI::App* command = app.add_subcommand(
      "compare", "all methods on one input at one triangle budget: table, CSV, meshes and a picture");
  command->add_option("INPUT", options->input, "a mesh or volume file, or model:NAME?key=value&...")->required();
  command->add_option("--methods", options->methods, "methods, separated by commas (default: all)");
  command
      ->add_option("--set", options->settings,
                   "parameters as METHOD.name=value, or name=value for every method that has it")
      ->allow_extra_args();
  command->add_option("--triangles", options->triangles, "triangle budget of every result (default 2000)")
      ->check(in_range(1, kLargestCount));
  command->add_option("-o,--output", options->output, "folder for the results (default: compare-NAME)");
  command
      ->add_option("--error", options->metrics.hausdorff_error,
                   "width of the certified Hausdorff interval, as a share of the input's diagonal (default 1e-3)")
      ->check(in_range(1e-9, 1.0));
  options->metrics.visible = false;
  command->add_flag("--visible", options->metrics.visible,
                    "measure the distances of the visible surface too: seconds to minutes where much is hidden");
  command->add_option("--azimuth", options->render.azimuth, "camera: degrees from the front");
  command->add_option("--elevation", options->render.elevation, "camera: degrees above the ground")
      ->check(in_range(-90, 90));
  command->add_option("--up", options->render.up_axis, "axis that points up in the picture")
      ->check(CLI::IsMember({"y", "z"}));
  command->add_flag("--wireframe", options->render.wireframe, "draw the triangles' edges");
  add_common_options(*command, options->common);
  command->callback([options] { compare(*options); });
}

}  // namespace voxcarve
