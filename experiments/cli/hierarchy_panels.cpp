#include "experiments/cli/hierarchy_panels.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <charconv>
#include <string_view>
#include <vector>

#include "common/mesh/io/mesh_io.h"
#include "common/run/errors.h"
#include "common/run/text.h"
#include "experiments/cli/checks.h"
#include "experiments/cli/level_files.h"
#include "experiments/render/assembly.h"
#include "experiments/runner/table.h"

namespace voxcarve {

namespace {

using Json = nlohmann::ordered_json;

constexpr int kMostAside = 100;

TriangleSoup read_surface(const std::filesystem::path& file) {
  return file.empty() ? TriangleSoup{} : read_mesh(file);
}

/// The level asked for, else the finest that has triangles.
std::size_t chosen_level(const LevelsIndex& index, const std::string& input, const HierarchyOptions& options) {
  const std::int64_t count = std::ssize(index.levels);
  if (options.level) {
    if (*options.level < count) return static_cast<std::size_t>(*options.level);
    throw ParameterError(input + " has no level " + std::to_string(*options.level) + ": it has " +
                         std::to_string(count) + ", numbered from 0, the coarsest");
  }
  for (std::size_t level = index.levels.size(); level-- > 0;) {
    if (!index.levels[level].file.empty()) return level;
  }
  return index.levels.size() - 1;
}

/// "6" or "4x30", columns and rows.
std::array<int, 2> parse_assembly(const std::string& text) {
  const std::size_t cross = text.find('x');
  const std::string_view whole = text;
  const std::array<std::string_view, 2> parts = {whole.substr(0, cross),
                                                 cross == std::string::npos ? whole : whole.substr(cross + 1)};
  std::array<int, 2> counts{};
  bool good = true;
  for (std::size_t i = 0; i < 2; ++i) {
    const char* last = parts[i].data() + parts[i].size();
    const auto [end, error] = std::from_chars(parts[i].data(), last, counts[i]);
    good = good && error == std::errc() && end == last && counts[i] >= 1 && counts[i] <= kMostAside;
  }
  if (good) return counts;
  throw ParameterError("--assembly '" + text + "' is none: give N, or COLUMNSxROWS, each from 1 to " +
                       std::to_string(kMostAside));
}

/// The size of what a level leaves out, in model units, by what its method says of it.
double detail_of(const IndexedLevel& level, const std::string& input) {
  double detail = 0;
  for (const LevelProperty& property : level.properties) {
    if (property.name == "voxel_size" || property.name == "support" || property.name == "radius_model")
      detail = std::max(detail, property.value);
  }
  if (detail > 0) return detail;
  throw ParameterError(input + " does not say how fine its levels are, by which an assembly takes them: none of " +
                       "voxel_size, support, radius_model; he-lowpass and mason do");
}

}  // namespace

void check_hierarchy_options(const HierarchyOptions& options, std::size_t shapes, std::size_t indices) {
  if (indices == 0) {
    for (const auto& [given, name] : {std::pair(options.level.has_value(), "--level"),
                                      {options.layered, "--layered"},
                                      {!options.assembly.empty(), "--assembly"}}) {
      if (given) throw ParameterError(std::string(name) + " needs the index.json of voxcarve run --levels");
    }
  }
  if (options.assembly.empty()) {
    if (options.assembly_pixels) throw ParameterError("--assembly-pixels has a meaning with --assembly only");
    return;
  }
  parse_assembly(options.assembly);
  if (shapes != 1) throw ParameterError("--assembly draws one index.json, by itself");
  if (options.level || options.layered)
    throw ParameterError("--assembly takes levels by their distance; leave out --level and --layered");
}

Panel level_panel(const std::string& input, const HierarchyOptions& options, RunContext& context) {
  const LevelsIndex index = read_levels_index(input);
  const std::size_t chosen = chosen_level(index, input, options);
  const IndexedLevel& level = index.levels[chosen];
  Json description = {{"input", input}, {"kind", options.layered ? "layers" : "mesh"}, {"level", chosen}};
  const std::string name = index.model + ", level " + std::to_string(chosen) + "\n";
  if (!options.layered) {
    TriangleSoup surface = read_surface(level.file);
    const std::int64_t triangles = std::ssize(surface.triangles);
    description["triangles"] = triangles;
    return {{std::move(surface), name + with_thousands(triangles) + " triangles"}, std::move(description)};
  }
  if (level.layers.empty()) {
    throw ParameterError("level " + std::to_string(chosen) + " of " + input +
                         " has no layers; voxcarve run he-lowpass --set layers=5 makes some");
  }
  LayeredSurface layered;
  std::int64_t triangles = 0;
  Json opacities = Json::array();
  for (const IndexedLayer& layer : level.layers) {
    context.check_cancelled();
    layered.layers.push_back({read_surface(layer.file), layer.opacity});
    triangles += std::ssize(layered.layers.back().surface.triangles);
    opacities.push_back(layer.opacity);
  }
  description["triangles"] = triangles;
  description["opacities"] = opacities;
  const std::string caption =
      name + std::to_string(level.layers.size()) + " layers, " + with_thousands(triangles) + " triangles";
  return {{std::move(layered), caption}, std::move(description)};
}

Panel assembly_panel(const std::string& input, const HierarchyOptions& options,
                     const std::optional<std::string>& caption, RenderOptions& render, RunContext& context) {
  const LevelsIndex index = read_levels_index(input);
  const auto [columns, rows] = parse_assembly(options.assembly);
  std::vector<AssemblyLevel> levels;
  for (const IndexedLevel& level : index.levels) {
    context.check_cancelled();
    const double detail = detail_of(level, input);
    levels.push_back({read_surface(level.file), detail});
  }
  AssemblyOptions how;
  how.columns = columns;
  how.rows = rows;
  if (options.assembly_pixels) how.pixels = *options.assembly_pixels;
  const std::string text =
      caption.value_or(index.model + "\n" + std::to_string(columns) + " x " + std::to_string(rows) +
                       ", details of at most " + format_real(how.pixels) + (how.pixels == 1 ? " pixel" : " pixels"));
  const Assembly assembly = plan_assembly(levels, how, render, scene_size({text}, render));
  render.framed = assembly.framed;
  Json used = Json::array();
  for (std::size_t level = 0; level < levels.size(); ++level) {
    const auto here = [level](const AssemblyInstance& i) { return i.level == static_cast<std::int64_t>(level); };
    used.push_back({{"level", level},
                    {"detail", levels[level].detail},
                    {"triangles", levels[level].surface.triangles.size()},
                    {"instances", std::ranges::count_if(assembly.instances, here)}});
  }
  Json instances = Json::array();
  for (const AssemblyInstance& instance : assembly.instances) {
    instances.push_back({{"column", instance.column},
                         {"row", instance.row},
                         {"depth", instance.depth},
                         {"level", instance.level},
                         {"detail_pixels", instance.detail_pixels}});
  }
  Json description = {{"input", input},
                      {"kind", "assembly"},
                      {"columns", columns},
                      {"rows", rows},
                      {"pixels", how.pixels},
                      {"triangles", assembly.triangles},
                      {"finest_triangles", assembly.finest_triangles},
                      {"levels", used},
                      {"instances", instances}};
  return {{assembly_surface(levels, assembly, context), text}, std::move(description)};
}

std::string assembly_text(const Json& description) {
  Table table{{"level", "detail", "triangles", "instances"}, {}};
  for (const Json& level : description["levels"]) {
    table.rows.push_back({std::to_string(level["level"].get<std::int64_t>()), rounded(level["detail"].get<double>(), 4),
                          with_thousands(level["triangles"].get<std::int64_t>()),
                          std::to_string(level["instances"].get<std::int64_t>())});
  }
  const auto drawn = description["triangles"].get<std::int64_t>();
  const auto finest = description["finest_triangles"].get<std::int64_t>();
  return fmt::format("{}\n{} triangles are drawn, {:.2f} % of the {} of {} instances at the finest level\n",
                     to_text(table), with_thousands(drawn),
                     100 * static_cast<double>(drawn) / static_cast<double>(finest), with_thousands(finest),
                     description["instances"].size());
}

void add_hierarchy_options(CLI::App& command, HierarchyOptions& options) {
  command
      .add_option("--level", options.level,
                  "index.json: the level to draw, 0 is the coarsest (default: the finest that has triangles)")
      ->check(in_range(0, kLargestCount));
  command.add_flag("--layered", options.layered,
                   "index.json: draw the layers of the level, sorted and blended, instead of its one surface; with "
                   "--aliased one sees what they smooth by themselves");
  command.add_option(
      "--assembly", options.assembly,
      "index.json: draw N x N instances, such as 6, or COLUMNSxROWS, in rows that go away from the camera. Each is "
      "drawn at the coarsest level whose detail takes at most --assembly-pixels pixels where the "
      "instance is nearest: detail = the largest of voxel_size, support and radius_model in the level's "
      "properties, pixels = detail / depth along the view x height of the scene / (2 tan(half the view "
      "angle)); the finest where none does. Levels without triangles are passed over");
  command
      .add_option("--assembly-pixels", options.assembly_pixels,
                  "--assembly: the most pixels that a level's detail may take (default 1)")
      ->check(in_range(1e-6, 1e6));
}

}  // namespace voxcarve
