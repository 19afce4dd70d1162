// Based on [NT03, 4]: dilation thresholds a distance map, erosion is the dilation of the complement. Differs in asking
// only what lies within the exact ball, on bits, unless asked for the paper's own map.
#include "common/volume/morphology.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "common/volume/bit_morphology.h"
#include "common/volume/grid_passes.h"

namespace voxcarve {

namespace {

constexpr std::uint8_t kOutside = 0;  ///< of a grid: exterior

/// What a step by Danielsson's map on `voxels` padded voxels holds at its peak: the map, the padded volume, and the
/// volumes that the caller and its caller still hold.
void require_4sed_step(std::int64_t voxels, std::string_view what, RunContext& context) {
  constexpr std::uint64_t kBytesPerVoxel = sizeof(std::int32_t) + 3;
  context.require_memory(static_cast<std::uint64_t>(voxels) * kBytesPerVoxel, what);
}

/// Makes a volume 1 where Danielsson's squared distance to the nearest `feature` is at most `reach`, else 0.
BinaryVolume within_4sed(BinaryVolume volume, std::uint8_t feature, std::int64_t reach, RunContext& context) {
  const Grid<std::int32_t> distance = squared_distance_4sed(volume, feature, context);
  parallel_for(context, 0, volume.frame.voxels(), kVoxelsPerPass, [&](std::int64_t begin, std::int64_t end) {
    std::transform(distance.values.begin() + begin, distance.values.begin() + end, volume.values.begin() + begin,
                   [reach](std::int32_t squared) {
                     return static_cast<std::uint8_t>(squared != kInfiniteDistance && squared <= reach);
                   });
  });
  return volume;
}

BinaryVolume dilate_4sed(const BinaryVolume& volume, double distance, RunContext& context) {
  const GridFrame frame = padded(volume.frame, static_cast<std::int64_t>(std::ceil(distance)));
  require_4sed_step(frame.voxels(), "the dilation", context);
  return within_4sed(resized(volume, frame, kOutside, context), 1, squared_reach(distance), context);
}

BinaryVolume erode_4sed(const BinaryVolume& volume, double distance, RunContext& context) {
  // One layer of exterior is enough: the nearest exterior voxel beyond the grid is always next to it.
  const GridFrame frame = padded(volume.frame, 1);
  require_4sed_step(frame.voxels(), "the erosion", context);
  BinaryVolume near_exterior =
      within_4sed(resized(volume, frame, kOutside, context), 0, squared_reach(distance), context);
  parallel_for(context, 0, frame.voxels(), kVoxelsPerPass, [&](std::int64_t begin, std::int64_t end) {
    for (auto at = static_cast<std::size_t>(begin); at < static_cast<std::size_t>(end); ++at)
      near_exterior.values[at] = static_cast<std::uint8_t>(1 - near_exterior.values[at]);
  });
  return resized(near_exterior, volume.frame, kOutside, context);
}

BitVolume bits_of(const BinaryVolume& volume, const Index3& margin, RunContext& context) {
  context.require_memory(volume.values.size() + BitVolume::memory(volume.frame.dims + 2 * margin), "morphology");
  return packed(volume, margin, false, context);
}

BinaryVolume bytes_of(const BitVolume& bits, const GridFrame& frame, const Index3& margin, RunContext& context) {
  context.require_memory(2 * static_cast<std::uint64_t>(frame.voxels()) + BitVolume::memory(bits.dims()), "morphology");
  return expanded(bits, frame, margin, context);
}

}  // namespace

BinaryVolume dilate(const BinaryVolume& volume, double distance, RunContext& context, DistanceMap map) {
  const std::int64_t reach = squared_reach(distance);
  if (map == DistanceMap::kDanielsson4sed) return dilate_4sed(volume, distance, context);
  const Index3 margin = ball_margin(volume.frame.dims, distance);
  const BitVolume result = dilate(bits_of(volume, margin, context), reach, false, context);
  return bytes_of(result, padded(volume.frame, margin[0]), Index3::Zero(), context);
}

BinaryVolume erode(const BinaryVolume& volume, double distance, RunContext& context, DistanceMap map) {
  const std::int64_t reach = squared_reach(distance);
  if (map == DistanceMap::kDanielsson4sed) return erode_4sed(volume, distance, context);
  const BitVolume result = erode(bits_of(volume, Index3::Zero(), context), reach, false, context);
  return bytes_of(result, volume.frame, Index3::Zero(), context);
}

BinaryVolume open(const BinaryVolume& volume, double distance, RunContext& context, DistanceMap map) {
  const std::int64_t reach = squared_reach(distance);
  if (map == DistanceMap::kDanielsson4sed) {
    return resized(dilate_4sed(erode_4sed(volume, distance, context), distance, context), volume.frame, kOutside,
                   context);
  }
  const BitVolume result = open(bits_of(volume, Index3::Zero(), context), reach, false, context);
  return bytes_of(result, volume.frame, Index3::Zero(), context);
}

BinaryVolume close(const BinaryVolume& volume, double distance, RunContext& context, DistanceMap map) {
  const std::int64_t reach = squared_reach(distance);
  if (map == DistanceMap::kDanielsson4sed) {
    return resized(erode_4sed(dilate_4sed(volume, distance, context), distance, context), volume.frame, kOutside,
                   context);
  }
  const Index3 margin = ball_margin(volume.frame.dims, distance);
  const BitVolume result = close(bits_of(volume, margin, context), reach, false, context);
  return bytes_of(result, volume.frame, margin, context);
}

}  // namespace voxcarve
