// Captions under the panels of a picture, set with VTK's built-in font: no font file of the machine matters.
#pragma once

#include <string>
#include <vector>

namespace voxcarve {

/// Text as ink: 0 paper, 255 ink; rows from top to bottom.
struct TextMask {
  int width = 0;
  int height = 0;
  std::vector<unsigned char> ink;
};

/// The captions of all panels, in one size.
struct CaptionBand {
  int height = 0;               ///< pixels at the bottom of every panel, 0 when no panel has a caption
  int padding = 0;              ///< of these, above the first line, which is at one height in all panels
  std::vector<TextMask> masks;  ///< one a panel, each within the panel's width and height - padding
};

/// Sets captions (UTF-8; what is not becomes '?') centred, wrapped at spaces. The size follows from the panel's and
/// shrinks until every line fits the width and the tallest caption a third of the height; what does not even fit then
/// is cut off. A build without VTK gives an empty band without masks.
CaptionBand set_captions(const std::vector<std::string>& captions, int panel_width, int panel_height);

}  // namespace voxcarve
