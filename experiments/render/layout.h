// Where the panels of a picture go, and which options are refused. Shared by the build with rendering and the one
// without. Knows no graphics library.
#pragma once

#include <cstddef>
#include <vector>

#include "experiments/render/render.h"

namespace voxcarve {

/// Throws what `render_image` throws for its arguments.
void check_render_arguments(const std::vector<RenderItem>& items, const RenderOptions& options);

/// The grid of panels. Panels are numbered row by row.
struct PanelGrid {
  int columns = 1;
  int rows = 1;

  static PanelGrid of(std::size_t items, int columns);
};

}  // namespace voxcarve
