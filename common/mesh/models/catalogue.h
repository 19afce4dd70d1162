// The external models: real meshes and volumes that are not part of the program and lie in a folder of their own.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace voxcarve {

enum class ExternalKind { kMesh, kVolume };

/// "mesh", "volume".
std::string_view to_string(ExternalKind kind);

/// One file. `licence` is what its source states, with its doubts.
struct ExternalModel {
  std::string name;
  std::string file;        ///< inside the data folder
  std::string stands_for;  ///< the papers' model or figure, such as "NT turbine blade"
  std::string source;      ///< public repository, the file in it, and how ours was derived where it was
  std::string licence;
  std::string sha256;  ///< of `file`, 64 hexadecimal digits
  ExternalKind kind = ExternalKind::kMesh;
};

/// All of them: meshes, then volumes, each in alphabetical order.
const std::vector<ExternalModel>& external_models();

/// Where the file of an external model lies. `data_folder` is what VOXCARVE_DATA or --data names, empty when unset.
/// Throws ParameterError for an unknown name (with the nearest known one), and InputError, with the place to get the
/// model from, when the folder is unset or not a folder or the file is missing. The contents are not looked at.
std::filesystem::path find_external(std::string_view name, const std::filesystem::path& data_folder);

}  // namespace voxcarve
