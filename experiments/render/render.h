// Pictures of meshes and volumes side by side under one camera, and of slices, made without a window system.
#pragma once

#include <cstdint>
#include <filesystem>
#include <stop_token>
#include <string>
#include <variant>
#include <vector>

#include "common/mesh/triangle_soup.h"
#include "common/model.h"
#include "common/volume/grid.h"
#include "experiments/render/slice.h"

namespace voxcarve {

/// What a panel shows: a mesh (without triangles: nothing), a volume drawn as a solid by casting rays into its voxels,
/// or a slice.
using RenderContent = std::variant<TriangleSoup, BinaryVolume, ScalarVolume, SlicePicture>;

/// One panel of a picture.
struct RenderItem {
  RenderContent content;
  std::string caption;  ///< UTF-8, may hold several lines; long lines are wrapped, "" leaves the band empty
};

/// How a picture looks. Panels are laid out row by row; the background is white.
struct RenderOptions {
  int panel_width = 800;      ///< pixels of one panel, caption included; kMinPanelSize to kMaxPanelSize
  int panel_height = 800;     ///< likewise
  int columns = 0;            ///< panels in a row; 0 chooses: up to four in one row, more in about a square
  bool wireframe = false;     ///< edges over the shaded surface, fainter the denser they lie
  double crease_angle = 40;   ///< degrees, 0 to 180: a dihedral angle above it is shown as a sharp edge
  double azimuth = 30;        ///< degrees: 0 looks at the front (+z with y up, -y with z up), 90 at the +x side
  double elevation = 20;      ///< degrees, -90 (from below) to 90 (from above)
  std::string up_axis = "y";  ///< "y" or "z"
  /// True: all items under one camera that holds all of them, at their own places and sizes (for results of one input);
  /// slices likewise among themselves. False: every item fills its own panel.
  bool common_camera = true;
  std::stop_token cancellation;  ///< asked between panels, rows of a slice and rays of a volume, and around a mesh
};

inline constexpr int kMinPanelSize = 16;                    ///< pixels
inline constexpr int kMaxPanelSize = 4096;                  ///< pixels; one panel is drawn at twice that size
inline constexpr std::int64_t kMaxPicturePixels = 1 << 28;  ///< of the whole picture
inline constexpr std::int64_t kRayCastBytes = 6;            ///< a voxel, that drawing a volume takes beside the volume

/// Eight-bit RGB pixels, rows from top to bottom.
struct RenderedImage {
  int width = 0;
  int height = 0;
  std::vector<unsigned char> rgb;  ///< 3 * width * height

  bool operator==(const RenderedImage&) const = default;
};

/// True when this build can render and this machine gives it an OpenGL context. Asked once, then remembered.
bool rendering_available();

/// True when this build can set captions. Without, pictures of slices alone are still drawn, with no caption band.
bool captions_available();

/// The picture of all items: columns * panel_width by rows * panel_height pixels, thin lines between the panels.
/// Surfaces are lit from both sides; a side that is seen from behind (through a hole, or of an inside-out shape) is
/// dull red. Colours of the shape are shown where it has them (a triangle's over a vertex's), else it is warm grey.
/// Coordinates are centred and scaled in double before anything is rounded, so their magnitude does not matter. The
/// same items and options give the same pixels on one machine. Calls from several threads take turns.
///
/// Volumes are drawn in the colour and light of meshes: transparent below the iso-value (0.5 of a binary volume),
/// opaque from a hundredth of the range of values above it on (at the greatest value, and transparent a hundredth below
/// that, where no value lies so far above), and closed where they meet the border of their grid.
/// Slices look as SlicePainter states, and ignore the camera.
///
/// Throws ParameterError for an empty list or options out of range, InputError for a shape that `validate` refuses or a
/// volume without voxels, ResourceError when this build or this machine cannot render meshes and volumes (or not that
/// many triangles: 2^29 a shape), and Cancelled when a stop was requested.
RenderedImage render_image(const std::vector<RenderItem>& items, const RenderOptions& options = {});

/// Writes `render_image` as a PNG file: complete, or not at all. Throws what `render_image` throws, and ResourceError
/// when the file cannot be written.
void render_meshes(const std::vector<RenderItem>& items, const RenderOptions& options,
                   const std::filesystem::path& png);

}  // namespace voxcarve
