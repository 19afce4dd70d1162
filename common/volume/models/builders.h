// What the files of this folder share: each model's entry of the registry.
#pragma once

#include "common/volume/models/volume_models.h"

namespace voxcarve {

VolumeModel ball_cube_model();
VolumeModel cells_model();
VolumeModel galaxy_model();
VolumeModel landscape_model();

}  // namespace voxcarve
