// A picture put together from the panels' scenes, their captions and the lines between them. Knows no graphics library.
#pragma once

#include <vector>

#include "experiments/render/captions.h"
#include "experiments/render/layout.h"
#include "experiments/render/render.h"

namespace voxcarve {

class Canvas {
 public:
  Canvas(const RenderOptions& options, const PanelGrid& grid);

  /// `rgb`: rows from top to bottom, panel_width pixels each, at most panel_height; goes to the top of the panel.
  void place_scene(int panel, const std::vector<unsigned char>& rgb);

  /// Centres the panel's text in the band below the scene. `band` may have no masks at all.
  void place_caption(int panel, const CaptionBand& band);

  /// Draws the separators and gives the picture away.
  RenderedImage finish();

 private:
  int left(int panel) const { return panel % grid_.columns * panel_width_; }
  int top(int panel) const { return panel / grid_.columns * panel_height_; }
  std::vector<unsigned char>::iterator pixel(int x, int y);
  void draw_separator(int x, int y, int width, int height);

  int panel_width_, panel_height_;
  PanelGrid grid_;
  RenderedImage image_;
};

}  // namespace voxcarve
