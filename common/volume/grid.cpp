#include "common/volume/grid.h"

#include <algorithm>
#include <numeric>

namespace voxcarve {

GridFrame padded(const GridFrame& frame, std::int64_t margin) {
  GridFrame larger = frame;
  for (int axis = 0; axis < 3; ++axis) {
    if (axis == 2 && frame.is_image()) continue;
    larger.dims[axis] += 2 * margin;
    larger.origin[axis] -= static_cast<double>(margin) * frame.voxel_size;
  }
  return larger;
}

BinaryVolume thresholded(const Grid<float>& field, float threshold) {
  auto volume = BinaryVolume::uninitialized(field.frame);
  std::ranges::transform(field.values, volume.values.begin(),
                         [threshold](float value) { return static_cast<std::uint8_t>(value >= threshold); });
  return volume;
}

std::int64_t count_interior(const BinaryVolume& volume) {
  return std::accumulate(volume.values.begin(), volume.values.end(), std::int64_t{0});
}

}  // namespace voxcarve
