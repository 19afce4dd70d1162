// From the INPUT of a command line to a model.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/model.h"
#include "common/run/context.h"

namespace voxcarve {

struct ModelSourceOptions {
  /// Where external models lie; empty: the environment variable VOXCARVE_DATA, or nowhere.
  std::filesystem::path data_folder;
  /// Iso-value of scalar volumes and threshold of grey images; default: the middle of the value range, with a notice.
  std::optional<double> iso_value;
};

/// The folder that `options` or VOXCARVE_DATA names, or an empty path.
std::filesystem::path data_folder(const ModelSourceOptions& options);

/// Opens a mesh file (PLY, OBJ, OFF, STL), a volume (NRRD, MetaImage), an image (PNG, PBM, PGM), a procedural model
/// "model:NAME?key=value&key=value" or an external one "model:NAME" of the catalogue. Notices go to `notices`.
/// Throws InputError for what cannot be opened or makes no sense, ParameterError for unknown models and keys.
Model open_model(const std::string& input, const ModelSourceOptions& options, std::vector<std::string>& notices);

/// The surface that a model's results are measured against: the soup itself, or the isosurface of a volume. Throws
/// InputError for images and implicit solids, which have none.
TriangleSoup reference_surface(const Model& model, RunContext& context);

}  // namespace voxcarve
