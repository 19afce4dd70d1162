// A hierarchy as files: one mesh a level and a layer, and index.json, which says what they are. results/README.md lists
// its keys.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "common/run/context.h"
#include "methods/method.h"

namespace voxcarve {

/// The most levels that are written as files.
inline constexpr std::int64_t kMostLevelFiles = 1000;

/// What stands in the index beside the levels.
struct LevelsHeader {
  const Method* method = nullptr;
  const Model* model = nullptr;
  const Parameters* parameters = nullptr;
};

/// Refuses with a ParameterError, before a run, an input that the files could write over or remove.
void protect_input_of_levels(const std::string& input, const std::filesystem::path& folder, const std::string& format);

/// Writes FOLDER/level_K.EXT for every level that has triangles, from 0, the coarsest, FOLDER/level_K_layer_L.EXT for
/// its layers, and at last FOLDER/index.json. The folder is made where there is none; files that the index of an
/// earlier export names are removed first, others are not touched. `format` is an extension: ply, obj, off or stl.
/// Returns the number of mesh files. Throws ParameterError for more than kMostLevelFiles levels, ResourceError when
/// something cannot be written, and Cancelled.
std::int64_t write_levels(const MethodResult& result, const LevelsHeader& header, const std::filesystem::path& folder,
                          const std::string& format, RunContext& context);

/// A layer or a level as an index lists it.
struct IndexedLayer {
  std::filesystem::path file;  ///< empty: it has no triangles
  double opacity = 1;
};
struct IndexedLevel {
  std::filesystem::path file;  ///< empty: it has no triangles
  std::vector<LevelProperty> properties;
  std::vector<IndexedLayer> layers;  ///< from the innermost outward
};
struct LevelsIndex {
  std::string model;
  std::string method;
  std::vector<IndexedLevel> levels;  ///< from coarse to fine, at least one
};

/// True for a name that ends in ".json", in either case.
bool is_levels_index(const std::filesystem::path& path);

/// Reads an index. Files are taken to lie beside it, whatever folder they name. Throws InputError where it is no index
/// of levels.
LevelsIndex read_levels_index(const std::filesystem::path& path);

}  // namespace voxcarve
