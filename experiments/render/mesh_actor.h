// Meshes as VTK draws them.
#pragma once

#include <cstdint>
#include <vector>

#include "experiments/render/display_mesh.h"

class vtkRenderer;

namespace voxcarve {

/// Adds the triangles, opaque, lit from both sides; dull red where they are seen from behind, unless they are
/// two-sided.
void add_surface(vtkRenderer& renderer, const DisplayMesh& mesh);

/// Adds the mesh's edges as lines of so many pixels.
void add_edges(vtkRenderer& renderer, const DisplayMesh& mesh, double opacity, float width);

/// Adds the fronts of the triangles, each blended over what was drawn before it: in the order of the mesh, after and
/// not behind what is opaque. `opacities`: one a position, of 255. The renderer then draws with passes of its own,
/// since VTK's blend in no order (a weighted mean) unless told otherwise.
void add_translucent(vtkRenderer& renderer, const DisplayMesh& mesh, const std::vector<std::uint8_t>& opacities);

}  // namespace voxcarve
