#include "common/volume/labelling.h"

#include <cstdlib>
#include <vector>

namespace voxcarve {

namespace {

std::vector<Index3> neighbour_offsets(Connectivity connectivity, bool image) {
  std::vector<Index3> offsets;
  const std::int64_t depth = image ? 0 : 1;
  for (std::int64_t z = -depth; z <= depth; ++z) {
    for (std::int64_t y = -1; y <= 1; ++y) {
      for (std::int64_t x = -1; x <= 1; ++x) {
        const std::int64_t differing = std::abs(x) + std::abs(y) + std::abs(z);
        if (differing > 0 && differing <= static_cast<std::int64_t>(connectivity)) offsets.emplace_back(x, y, z);
      }
    }
  }
  return offsets;
}

}  // namespace

Labelling label_components(const BinaryVolume& volume, std::uint8_t value, Connectivity connectivity,
                           RunContext& context) {
  context.require_memory(volume.values.size() * (sizeof(std::int32_t) + 1), "component labelling");
  Labelling result{Grid<std::int32_t>(volume.frame), 0};
  const std::vector<Index3> offsets = neighbour_offsets(connectivity, volume.frame.is_image());
  std::vector<Index3> front;
  for (std::int64_t k = 0; k < volume.nz(); ++k) {
    context.check_cancelled();
    for (std::int64_t j = 0; j < volume.ny(); ++j) {
      for (std::int64_t i = 0; i < volume.nx(); ++i) {
        if (volume(i, j, k) != value || result.labels(i, j, k) != 0) continue;
        const std::int32_t label = ++result.count;
        result.labels(i, j, k) = label;
        front.assign(1, Index3(i, j, k));
        while (!front.empty()) {
          const Index3 voxel = front.back();
          front.pop_back();
          for (const Index3& offset : offsets) {
            const Index3 next = voxel + offset;
            if (!volume.frame.contains(next) || volume(next[0], next[1], next[2]) != value) continue;
            std::int32_t& next_label = result.labels(next[0], next[1], next[2]);
            if (next_label != 0) continue;
            next_label = label;
            front.push_back(next);
          }
        }
      }
    }
  }
  return result;
}

std::int64_t count_interior_components(const BinaryVolume& volume, Connectivity connectivity, RunContext& context) {
  return label_components(volume, 1, connectivity, context).count;
}

std::int64_t count_exterior_components(const BinaryVolume& volume, Connectivity connectivity, RunContext& context) {
  return label_components(resized(volume, padded(volume.frame, 1)), 0, connectivity, context).count;
}

}  // namespace voxcarve
