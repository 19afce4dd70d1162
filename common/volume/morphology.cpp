// Based on [NT03, 4]: dilation thresholds a distance map, erosion is the dilation of the complement. Differs in using
// an exact Euclidean map unless asked for the paper's own.
#include "common/volume/morphology.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "common/run/errors.h"

namespace voxcarve {

namespace {

/// Largest squared integer distance within `distance`: the test d^2 <= r^2 in exact integers. A hair is added to r^2 so
/// that distances such as sqrt(2), typed as decimals, reach what they name.
std::int64_t squared_reach(double distance) {
  if (!(distance >= 0) || distance > 20000)
    throw ParameterError("a morphological distance must lie between 0 and 20000 voxels");
  constexpr double kHair = 1e-9;
  return static_cast<std::int64_t>(std::floor(distance * distance * (1 + kHair)));
}

/// What a step on `voxels` padded voxels holds at its peak: the distance map, the padded volume, and the volumes that
/// the caller and its caller still hold.
void require_step(std::int64_t voxels, std::string_view what, RunContext& context) {
  constexpr std::uint64_t kBytesPerVoxel = sizeof(std::int32_t) + 3;
  context.require_memory(static_cast<std::uint64_t>(voxels) * kBytesPerVoxel, what);
}

/// Makes a volume 1 where the squared distance to the nearest `feature` is at most `reach`, else 0.
BinaryVolume within(BinaryVolume volume, std::uint8_t feature, std::int64_t reach, DistanceMap map,
                    RunContext& context) {
  const auto transform = map == DistanceMap::kExact ? squared_distance : squared_distance_4sed;
  const Grid<std::int32_t> distance = transform(volume, feature, context);
  std::ranges::transform(distance.values, volume.values.begin(), [reach](std::int32_t squared) {
    return static_cast<std::uint8_t>(squared != kInfiniteDistance && squared <= reach);
  });
  return volume;
}

}  // namespace

BinaryVolume dilate(const BinaryVolume& volume, double distance, RunContext& context, DistanceMap map) {
  const std::int64_t reach = squared_reach(distance);
  const GridFrame frame = padded(volume.frame, static_cast<std::int64_t>(std::ceil(distance)));
  require_step(frame.voxels(), "the dilation", context);
  return within(resized(volume, frame), 1, reach, map, context);
}

BinaryVolume erode(const BinaryVolume& volume, double distance, RunContext& context, DistanceMap map) {
  const std::int64_t reach = squared_reach(distance);
  // One layer of exterior is enough: the nearest exterior voxel beyond the grid is always next to it.
  const GridFrame frame = padded(volume.frame, 1);
  require_step(frame.voxels(), "the erosion", context);
  BinaryVolume near_exterior = within(resized(volume, frame), 0, reach, map, context);
  for (std::uint8_t& value : near_exterior.values) value = static_cast<std::uint8_t>(1 - value);
  return resized(near_exterior, volume.frame);
}

BinaryVolume open(const BinaryVolume& volume, double distance, RunContext& context, DistanceMap map) {
  return resized(dilate(erode(volume, distance, context, map), distance, context, map), volume.frame);
}

BinaryVolume close(const BinaryVolume& volume, double distance, RunContext& context, DistanceMap map) {
  return resized(erode(dilate(volume, distance, context, map), distance, context, map), volume.frame);
}

}  // namespace voxcarve
