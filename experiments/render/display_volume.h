// A volume made ready for a ray caster: cropped to its interior, with a closed border. Knows no graphics library.
#pragma once

#include <cstdint>
#include <vector>

#include "common/model.h"
#include "experiments/render/display_mesh.h"

namespace voxcarve {

/// Points, in model units, whose convex hull is that of the interior voxels as cubes: two faces of every row along x.
/// Interior are the ones of a binary volume and the values from the iso-value on of a scalar one.
std::vector<Point> interior_hull(const BinaryVolume& volume);
std::vector<Point> interior_hull(const ScalarVolume& volume);

/// Samples on a scale of 15 bits, which a ray caster in fixed-point arithmetic takes as they are.
struct DisplayVolume {
  static constexpr std::uint16_t kLargest = 32767;

  Index3 dims = Index3::Zero();           ///< zero when nothing is interior
  Eigen::Vector3d first_sample{0, 0, 0};  ///< its centre, in the unit frame
  double spacing = 1;                     ///< in the unit frame
  std::vector<std::uint16_t> samples;     ///< x fastest, in proportion to the values
  double iso_value = 0;                   ///< on the samples' scale
  /// On that scale, positive: opacity rises from nothing at `opaque - band` to full at `opaque`. The rise begins at the
  /// iso-value, or ends at the greatest value where that lies within a band of the iso-value.
  double band = 1;
  double opaque = 1;
};

/// Takes the box of the interior voxels, two voxels wider on every side; gradients at the surface need no more. Beyond
/// the grid samples mirror the outermost ones about the iso-value, so that the surface closes half a voxel outside, as
/// `scalar_isosurface` closes it.
DisplayVolume make_display_volume(const BinaryVolume& volume, const UnitFrame& frame);
DisplayVolume make_display_volume(const ScalarVolume& volume, const UnitFrame& frame);

}  // namespace voxcarve
