// A volume as VTK draws it.
#pragma once

#include "experiments/render/display_volume.h"

class vtkRenderer;

namespace voxcarve {

/// Adds `volume` to the scene, cast by rays in fixed-point arithmetic on the CPU: the same pixels on any number of
/// threads. `volume` must not be empty and must outlive the scene.
void add_volume(vtkRenderer& renderer, const DisplayVolume& volume);

}  // namespace voxcarve
