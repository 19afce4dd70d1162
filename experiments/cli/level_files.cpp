#include "experiments/cli/level_files.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "common/mesh/io/mesh_io.h"
#include "common/mesh/topology.h"
#include "common/run/atomic_file.h"
#include "common/run/errors.h"
#include "common/run/text.h"
#include "experiments/cli/json_text.h"
#include "experiments/cli/session.h"

namespace voxcarve {

namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kIndex = "index.json";
constexpr std::uint64_t kMaxIndexBytes = std::uint64_t{256} << 20;

std::string level_file(std::int64_t level, const std::string& format) {
  return "level_" + std::to_string(level) + "." + format;
}

std::string layer_file(std::int64_t level, std::int64_t layer, const std::string& format) {
  return "level_" + std::to_string(level) + "_layer_" + std::to_string(layer) + "." + format;
}

/// A name that an export could have given: no path, and of its form.
bool is_export_name(const Json& name) {
  if (!name.is_string()) return false;
  const std::filesystem::path path = name.get<std::string>();
  return path.filename() == path && path.string().starts_with("level_") &&
         (mesh_format(path) || path.extension() == ".mtl");
}

/// The names of the files that an earlier export says it left in the folder; what else lies there is not ours.
std::vector<std::string> earlier_files(const std::filesystem::path& folder) {
  Json earlier;
  try {
    earlier = Json::parse(read_file(folder / kIndex, kMaxIndexBytes), nullptr, false);
  } catch (const Error&) {
    return {};  // there is none
  }
  if (!earlier.is_object() || !earlier.contains("levels") || !earlier["levels"].is_array()) return {};
  std::vector<std::string> names = {kIndex};
  const auto add = [&names](const Json& entry) {
    for (const char* key : {"file", "materials"}) {
      if (entry.is_object() && entry.contains(key) && is_export_name(entry[key]))
        names.push_back(entry[key].get<std::string>());
    }
  };
  for (const Json& level : earlier["levels"]) {
    add(level);
    if (!level.is_object() || !level.contains("layers") || !level["layers"].is_array()) continue;
    for (const Json& layer : level["layers"]) add(layer);
  }
  return names;
}

void prepare_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw ResourceError("cannot make the folder " + folder.string() + ": " + error.message());
  for (const std::string& name : earlier_files(folder)) std::filesystem::remove(folder / name, error);
}

/// Writes a surface and says so in its entry. Returns whether there was anything to write.
bool write_surface(const TriangleSoup& surface, const std::filesystem::path& folder, const std::string& name,
                   Json& entry) {
  entry["file"] = nullptr;
  if (surface.empty()) return false;
  write_mesh(surface, folder / name);
  entry["file"] = name;
  // An OBJ has its triangles' colours in a companion.
  if (mesh_format(name) == MeshFormat::kObj && !surface.triangle_colors.empty())
    entry["materials"] = std::filesystem::path(name).replace_extension(".mtl").string();
  return true;
}

Json describe(const TriangleSoup& surface, Json entry) {
  const SurfaceTopology topology = analyze_topology(surface);
  entry["vertices"] = surface.positions.size();
  entry["triangles"] = surface.triangles.size();
  entry["components"] = topology.components;
  entry["genus"] = nullptr;
  if (surface.empty()) {
    entry["undefined"] = {{"genus", "the level is empty"}};
  } else if (topology.genus) {
    entry["genus"] = *topology.genus;
  } else {
    entry["undefined"] = {{"genus", topology.genus_reason}};
  }
  return entry;
}

}  // namespace

void protect_input_of_levels(const std::string& input, const std::filesystem::path& folder, const std::string& format) {
  std::vector<std::string> names = earlier_files(folder);
  names.emplace_back(kIndex);
  std::error_code error;  // of files that are not there
  bool hit = std::ranges::any_of(
      names, [&](const std::string& name) { return std::filesystem::equivalent(input, folder / name, error); });
  // How many levels and layers there will be is not known yet: any name of their form counts.
  const std::filesystem::path path = input;
  hit = hit || (path.filename().string().starts_with("level_") && to_lower(path.extension().string()) == "." + format &&
                std::filesystem::equivalent(std::filesystem::absolute(path).parent_path(), folder, error));
  if (hit) throw ParameterError("the levels would write over the input " + input + "; give another folder to --levels");
}

std::int64_t write_levels(const MethodResult& result, const LevelsHeader& header, const std::filesystem::path& folder,
                          const std::string& format, RunContext& context) {
  const std::int64_t count = result.levels->size();
  if (count > kMostLevelFiles) {
    throw ParameterError("--levels writes at most " + std::to_string(kMostLevelFiles) + " levels, and there are " +
                         with_thousands(count) +
                         (header.method->info().gives_stream
                              ? ": write the stream, -o FILE.vcs, and take levels with voxcarve extract"
                              : ""));
  }
  prepare_folder(folder);
  std::int64_t files = 0;
  Json levels = Json::array();
  Stage stage(context, "level files", count);
  for (std::int64_t level = 0; level < count; ++level) {
    const TriangleSoup surface = result.levels->extract(level);
    Json entry = {{"level", level}};
    files += write_surface(surface, folder, level_file(level, format), entry);
    entry["properties"] = Json::object();
    if (!result.level_properties.empty()) {
      for (const LevelProperty& property : result.level_properties.at(static_cast<std::size_t>(level)))
        entry["properties"][property.name] = property.value;
    }
    entry = describe(surface, std::move(entry));
    entry["layers"] = Json::array();
    for (const TranslucentLayer& layer : result.layers) {
      if (layer.level != level) continue;
      context.check_cancelled();
      Json description = Json::object();
      files +=
          write_surface(layer.surface, folder, layer_file(level, std::ssize(entry["layers"]), format), description);
      description["iso_density"] = layer.iso_density;
      description["opacity"] = layer.opacity;
      description["triangles"] = layer.surface.triangles.size();
      entry["layers"].push_back(std::move(description));
    }
    levels.push_back(std::move(entry));
    stage.advance(1);
  }
  const Json index = {{"program", "voxcarve " + version()},
                      {"method", header.method->info().name},
                      {"model", header.model->name},
                      {"parameters", to_json(*header.parameters)},
                      {"seed", context.seed},
                      {"levels", levels}};
  write_file_atomically(folder / kIndex, json_text(index) + "\n");
  return files;
}

bool is_levels_index(const std::filesystem::path& path) {
  return to_lower(path.extension().string()) == ".json";
}

LevelsIndex read_levels_index(const std::filesystem::path& path) {
  const auto check = [&path](bool condition, const std::string& what) {
    if (!condition) throw InputError(path.string() + " is no index of levels: " + what);
  };
  const Json json = Json::parse(read_file(path, kMaxIndexBytes), nullptr, false);
  check(json.is_object() && json.contains("levels") && json["levels"].is_array() && !json["levels"].empty(),
        "it has no list \"levels\"");
  const auto text = [&json](const char* key) {
    return json.contains(key) && json[key].is_string() ? json[key].get<std::string>() : "";
  };
  const auto file_of = [&](const Json& entry) -> std::filesystem::path {
    check(entry.is_object() && entry.contains("file") && (entry["file"].is_null() || is_export_name(entry["file"])),
          "an entry's \"file\" is neither null nor a mesh file level_* beside it");
    return entry["file"].is_null() ? "" : path.parent_path() / entry["file"].get<std::string>();
  };
  LevelsIndex index;
  index.model = text("model");
  index.method = text("method");
  for (const Json& entry : json["levels"]) {
    IndexedLevel level;
    level.file = file_of(entry);
    if (entry.contains("properties") && entry["properties"].is_object()) {
      for (const auto& [name, value] : entry["properties"].items()) {
        check(value.is_number() && std::isfinite(value.get<double>()), "the property " + name + " is no number");
        level.properties.push_back({name, value.get<double>()});
      }
    }
    if (entry.contains("layers") && entry["layers"].is_array()) {
      for (const Json& layer : entry["layers"]) {
        IndexedLayer read{file_of(layer), 1};
        check(layer.contains("opacity") && layer["opacity"].is_number(), "a layer has no opacity");
        read.opacity = layer["opacity"].get<double>();
        check(read.opacity >= 0 && read.opacity <= 1, "the opacity of a layer is not from 0 to 1");
        level.layers.push_back(std::move(read));
      }
    }
    index.levels.push_back(std::move(level));
  }
  return index;
}

}  // namespace voxcarve
