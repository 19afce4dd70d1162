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

/// Surfaces one around the other that are drawn together [He95, 3], from the innermost, which is opaque, outward.
struct LayeredSurface {
  struct Layer {
    TriangleSoup surface;  ///< may be empty
    double opacity = 1;    ///< 0 to 1
  };
  std::vector<Layer> layers;
};

/// What a panel shows: a mesh (without triangles: nothing), a volume drawn as a solid by casting rays into its voxels,
/// a slice, or layers of a surface.
using RenderContent = std::variant<TriangleSoup, BinaryVolume, ScalarVolume, SlicePicture, LayeredSurface>;

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
  double view_angle = 24;     ///< degrees, 1 to 120, vertical: how strong perspective is
  bool aliased = false;       ///< one sample a pixel instead of the mean of four; volumes and meshes
  int magnification = 1;      ///< 1 to 16: draw meshes and volumes so many times smaller, each pixel as a square
  /// Points that the camera holds in place of the items: for pictures whose camera must be known before.
  std::vector<Point> framed = {};
  /// True: all items under one camera that holds all of them, at their own places and sizes (for results of one input);
  /// slices likewise among themselves. False: every item fills its own panel.
  bool common_camera = true;
  std::stop_token cancellation;  ///< asked between panels, rows of a slice and rays of a volume, and around a mesh
};

inline constexpr int kMinPanelSize = 16;    ///< pixels
inline constexpr int kMaxPanelSize = 4096;  ///< pixels; one panel is drawn at twice that size
inline constexpr int kMaxMagnification = 16;
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

/// Width and height in pixels of what is left of a panel above the captions, in samples that `magnification` makes.
struct SceneSize {
  int width = 0;
  int height = 0;
};
SceneSize scene_size(const std::vector<std::string>& captions, const RenderOptions& options);

/// True when this build can set captions. Without, pictures of slices alone are still drawn, with no caption band.
bool captions_available();

/// The picture of all items: columns * panel_width by rows * panel_height pixels, thin lines between the panels.
/// Surfaces are lit from both sides; a side that is seen from behind (through a hole, or of an inside-out shape) is
/// dull red, except where its other side is a triangle too, as on the doubled sheets of closed surfaces. Colours of the
/// shape are shown where it has them (a triangle's over a vertex's), else it is warm grey. Coordinates are centred and
/// scaled in double before anything is rounded, so their magnitude does not matter. The same items and options give the
/// same pixels on one machine. Calls from several threads take turns.
///
/// Volumes are drawn in the colour and light of meshes: transparent below the iso-value (0.5 of a binary volume),
/// opaque from a hundredth of the range of values above it on (at the greatest value, and transparent a hundredth below
/// that, where no value lies so far above), and closed where they meet the border of their grid.
/// Layers are drawn from the farthest triangle to the nearest, each over what lies behind it, and only their fronts:
/// what looks at a layer from outside passes it once, as its opacity takes for granted. Those of opacity 1 are drawn as
/// meshes are. The edges of layers are not drawn.
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
