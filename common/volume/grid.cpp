#include "common/volume/grid.h"

#include <algorithm>
#include <numeric>
#include <vector>

#include "common/volume/grid_passes.h"

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

BinaryVolume thresholded(const Grid<float>& field, float threshold, const RunContext& context) {
  auto volume = BinaryVolume::uninitialized(field.frame);
  parallel_for(context, 0, field.frame.voxels(), kVoxelsPerPass, [&](std::int64_t begin, std::int64_t end) {
    std::transform(field.values.begin() + begin, field.values.begin() + end, volume.values.begin() + begin,
                   [threshold](float value) { return static_cast<std::uint8_t>(value >= threshold); });
  });
  return volume;
}

std::int64_t count_interior(const BinaryVolume& volume, const RunContext& context) {
  const std::int64_t voxels = volume.frame.voxels();
  std::vector<std::int64_t> counts(static_cast<std::size_t>(voxels / kVoxelsPerPass + 1), 0);
  parallel_for(context, 0, voxels, kVoxelsPerPass, [&](std::int64_t begin, std::int64_t end) {
    counts[static_cast<std::size_t>(begin / kVoxelsPerPass)] =
        std::accumulate(volume.values.begin() + begin, volume.values.begin() + end, std::int64_t{0});
  });
  return std::accumulate(counts.begin(), counts.end(), std::int64_t{0});
}

}  // namespace voxcarve
