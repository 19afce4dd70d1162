// Slices of volumes as pictures: a plane of voxels, its colours, and its enlargement to a panel. Knows no graphics
// library, so that builds without rendering have it too.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <stop_token>
#include <string_view>
#include <vector>

#include "common/run/context.h"
#include "common/volume/grid.h"
#include "experiments/render/color.h"

namespace voxcarve {

/// Which slice of a volume: perpendicular to an axis, at an index or at a share of the volume's extent.
struct SlicePosition {
  int axis = 2;                       ///< 0 x, 1 y, 2 z
  std::optional<std::int64_t> index;  ///< of the voxels along the axis, from 0; may lie outside a given volume
  double share = 0.5;                 ///< 0 to 1, where there is no index
};

/// Reads "z", "z=12" or "z=50%" (of x, y, z). Throws ParameterError for anything else.
SlicePosition parse_slice(std::string_view text);

/// The index of that slice in a volume of `frame`: of n slices, a share s asks for floor(s n), at most n - 1. Throws
/// ParameterError, with the volume's `name`, when there is no such slice.
std::int64_t slice_index(const SlicePosition& position, const GridFrame& frame, std::string_view name);

/// The slice of a volume that holds the plane at `coordinate`, in model units, across `axis`. Throws ParameterError,
/// with the volume's `name`, when the plane misses the volume.
std::int64_t slice_at(int axis, double coordinate, const GridFrame& frame, std::string_view name);

/// The samples of one slice. To the right runs x, or y in a slice perpendicular to x; upwards z, or y in a slice
/// perpendicular to z. So slices across x, y and z are seen from +x, -y and +z.
struct SliceField {
  std::int64_t width = 0;       ///< voxels
  std::int64_t height = 0;      ///< voxels
  std::vector<float> values;    ///< rows from the lowest to the highest
  Eigen::Vector2d lower{0, 0};  ///< corner of the slice in its plane, model units
  double voxel_size = 1;        ///< model units
  float operator()(std::int64_t column, std::int64_t row) const {
    return values[static_cast<std::size_t>(row * width + column)];
  }
};

/// Takes a slice out of a volume. `index` must be one of its slices. For T of uint8, int32 and float.
template <class T>
SliceField extract_slice(const Grid<T>& grid, int axis, std::int64_t index);

/// A slice of the exterior distance map that dilation thresholds [NT03, 4]: exact Euclidean distances, in voxels, to
/// the nearest interior voxel of the volume (not of the slice alone), 0 in the interior. Throws InputError when the
/// volume has no interior voxel.
SliceField distance_slice(const BinaryVolume& volume, int axis, std::int64_t index, std::string_view name,
                          RunContext& context);

enum class ColorMap {
  kGrey,   ///< black at the lower end of a window, white at its upper end, constant beyond
  kCyclic  ///< blue for 0 through green to red, then blue again, once a period [NT03, Fig. 5b]
};

struct SliceColors {
  ColorMap map = ColorMap::kGrey;
  double low = 0;          ///< the window of kGrey, in the values' units
  double high = 1;         ///< above `low`, or equal to it: then all that exceeds it is white
  double period = 16;      ///< of kCyclic, in the values' units; positive
  bool mark_zero = false;  ///< values of exactly 0 are dark grey: the interior in a distance map
};

/// Colours of single values. `value` must be finite.
Rgb8 grey_color(double value, double low, double high);
Rgb8 cyclic_color(double value, double period);

/// A slice as coloured voxels.
struct SlicePicture {
  std::int64_t width = 0;
  std::int64_t height = 0;
  std::vector<Rgb8> colors;  ///< as SliceField::values
  Eigen::Vector2d lower{0, 0};
  double voxel_size = 1;
  /// How far the values lie above an iso-value whose line is to be drawn; empty: no line.
  std::vector<float> above_iso;
  Rgb8 contour_color = {0, 0, 0};
};

SlicePicture color_slice(const SliceField& field, const SliceColors& colors);

/// Asks for the line where `field`, which must be of the same slice, crosses `iso_value`.
void add_contour(SlicePicture& picture, const SliceField& field, double iso_value);

/// Enlarges slices into scenes of one size, nearest neighbour, over white, with a thin grey line around the grid: a
/// solid may reach the grid's border, and is white itself.
class SlicePainter {
 public:
  /// A scene of `width` x `height` pixels for these slices. `common`: all at one scale and at their own places, such
  /// that the box of all fits; the smallest voxels are squares of a whole number of pixels. Otherwise each slice fills
  /// its scene with such squares and is centred. Voxels that would be smaller than a pixel are averaged over whole
  /// numbers of them; where they are more than 64 a side, over 64 x 64 points of the pixel. Throws ParameterError when
  /// the slices lie so far apart that no pixel is large enough.
  SlicePainter(const std::vector<const SlicePicture*>& slices, bool common, int width, int height);

  /// RGB, rows from top to bottom, of a slice that was given to the constructor. Throws Cancelled when a stop was
  /// requested, and as the constructor does when every slice has its own scale.
  std::vector<unsigned char> paint(const SlicePicture& slice, const std::stop_token& cancellation = {}) const;

 private:
  /// How voxels become pixels.
  struct Fit {
    Eigen::Vector2d lower{0, 0};  ///< model position of the scene's lower left corner
    double pixel = 1;             ///< model units a pixel
    int samples = 1;              ///< a side, averaged in every pixel
  };
  struct Lane;
  Fit fit(const std::vector<const SlicePicture*>& slices) const;
  Lane lane(const SlicePicture& slice, const Fit& fit, int axis) const;
  /// Of a scene's pixel, counted from its lower left corner.
  std::size_t pixel_index(int x, int y) const {
    return static_cast<std::size_t>(height_ - 1 - y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  }
  void draw_frame(const SlicePicture& slice, const Fit& fit, std::vector<unsigned char>& rgb) const;
  void draw_contour(const SlicePicture& slice, const Fit& fit, std::vector<unsigned char>& rgb,
                    const std::stop_token& cancellation) const;

  bool common_;
  int width_, height_;
  Fit common_fit_;
};

}  // namespace voxcarve
