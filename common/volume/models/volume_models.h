// Models that are computed voxel by voxel: volumes and images, stand-ins for those of the papers that are not public.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "common/mesh/models/procedural.h"
#include "common/run/parameters.h"
#include "common/volume/grid.h"

namespace voxcarve {

/// A volume or image (one slice) and how it is made. `build` takes a complete set of parameters of the schema and is
/// deterministic: made of integers and of the exactly rounded operations of doubles (+ - * / and the square root), it
/// is the same on every machine. The grid has voxels of size 1 and its corner at 0; y points up.
struct VolumeModel {
  ModelInfo info;
  bool is_image = false;
  std::function<BinaryVolume(const Parameters&)> build;
};

/// All of them, in alphabetical order.
const std::vector<VolumeModel>& volume_models();

/// True for the name of one of them.
bool is_volume_model(std::string_view name);

/// The model of that name. Throws ParameterError, with the nearest name of any model: volume, procedural or external.
const VolumeModel& find_volume_model(std::string_view name);

/// Builds from "name" or "name?key=value&key=value", for instance "galaxy?seed=3". Throws ParameterError for an unknown
/// name or key (with the nearest known one), a value out of range, or more than 2^30 voxels.
BinaryVolume make_volume(std::string_view spec);

}  // namespace voxcarve
