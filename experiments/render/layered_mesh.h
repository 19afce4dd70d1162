// Layers of a surface made ready for a rasteriser that blends triangles in the order in which they come [He95, 3].
// Knows no graphics library.
#pragma once

#include <cstdint>
#include <vector>

#include "experiments/render/display_mesh.h"
#include "experiments/render/view.h"

namespace voxcarve {

struct LayeredMesh {
  DisplayMesh opaque;                   ///< layers of opacity 1, all sides
  DisplayMesh translucent;              ///< the others, their triangles from the farthest to the nearest
  std::vector<std::uint8_t> opacities;  ///< of 255, one a position of `translucent`
};

/// The triangles of all translucent layers, merged and sorted by the distance of their centroids from the camera; of
/// equal distances the inner layer comes first. Where triangles are longer than layers lie apart the order of two
/// layers of one place may be wrong. That shows little: their opacities commute, and so close together their shades
/// hardly differ. Layers without triangles count for nothing.
LayeredMesh make_layered_mesh(const LayeredSurface& surface, const View& view, double crease_angle);

}  // namespace voxcarve
