// Based on [NT03, 4] and [WR05, 4.1], which threshold a distance map; differs in asking only what lies within reach.
#include "common/volume/bit_morphology.h"

#include <cmath>

#include "common/run/errors.h"
#include "common/volume/ball_sweep.h"
#include "common/volume/distance_transform.h"

namespace voxcarve {

namespace {

/// `within_reach` for every reach: by a whole distance transform, which is what far reaches take.
BitVolume within_far_reach(const BitVolume& volume, const Features& features, std::int64_t reach, bool inverted,
                           RunContext& context) {
  GridFrame frame;
  frame.dims = volume.dims();
  // The nearest feature outside the grid is always next to it, so a layer of them stands for all.
  const GridFrame wider = padded(frame, features.outside ? 1 : 0);
  const Index3 margin = (wider.dims - frame.dims) / 2;
  const BinaryVolume bytes =
      resized(expanded(volume, frame, context), wider, static_cast<std::uint8_t>(features.value));
  const Grid<std::int32_t> distance = squared_distance(bytes, static_cast<std::uint8_t>(features.value), context);
  BitVolume result(volume.dims());
  for_each_row(result, context, [&](BitWord* row, std::int64_t row_words, std::int64_t j, std::int64_t k) {
    const std::int32_t* squared = distance.values.data() + distance.index(margin[0], j + margin[1], k + margin[2]);
    std::fill_n(row, row_words, BitWord{0});
    for (std::int64_t i = 0; i < frame.dims[0]; ++i) {
      const bool near = squared[i] != kInfiniteDistance && squared[i] <= reach;
      if (near != inverted) row[i / kWordBits] |= bit_of(i);
    }
  });
  return result;
}

BitVolume reached(const BitVolume& volume, const Features& features, std::int64_t reach, bool inverted,
                  RunContext& context) {
  const auto swept = reach <= kLargestSweptReach;
  constexpr std::uint64_t kBytesPerVoxel = sizeof(std::int32_t) + 3;
  context.require_memory(
      BitVolume::memory(volume.dims()) + (swept ? within_reach_memory(volume.dims(), reach)
                                                : static_cast<std::uint64_t>(volume.dims().prod()) * kBytesPerVoxel),
      "morphology");
  return (swept ? within_reach : within_far_reach)(volume, features, reach, inverted, context);
}

}  // namespace

std::int64_t squared_reach(double distance) {
  if (!(distance >= 0) || distance > 20000)
    throw ParameterError("a morphological distance must lie between 0 and 20000 voxels");
  constexpr double kHair = 1e-9;
  return static_cast<std::int64_t>(std::floor(distance * distance * (1 + kHair)));
}

Index3 ball_margin(const Index3& dims, double distance) {
  const auto margin = static_cast<std::int64_t>(std::ceil(distance));
  return {margin, margin, dims[2] == 1 ? 0 : margin};
}

BitVolume dilate(const BitVolume& volume, std::int64_t reach, bool outside, RunContext& context) {
  return reached(volume, {true, outside}, reach, false, context);
}

BitVolume erode(const BitVolume& volume, std::int64_t reach, bool outside, RunContext& context) {
  return reached(volume, {false, !outside}, reach, true, context);
}

BitVolume open(const BitVolume& volume, std::int64_t reach, bool outside, RunContext& context) {
  return dilate(erode(volume, reach, outside, context), reach, outside, context);
}

BitVolume close(const BitVolume& volume, std::int64_t reach, bool outside, RunContext& context) {
  return erode(dilate(volume, reach, outside, context), reach, outside, context);
}

}  // namespace voxcarve
