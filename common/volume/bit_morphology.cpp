// Based on [NT03, 4] and [WR05, 4.1], which threshold a distance map; differs in asking only what lies within reach.
#include "common/volume/bit_morphology.h"

#include <cmath>

#include "common/run/errors.h"
#include "common/volume/ball_sweep.h"
#include "common/volume/distance_transform.h"
#include "common/volume/grid_passes.h"

namespace voxcarve {

namespace {

/// The grid that `within_far_reach` works on: the nearest feature outside a grid is always next to it, so that a layer
/// of them stands for all.
GridFrame far_frame(const Index3& dims, bool features_outside) {
  GridFrame frame;
  frame.dims = dims;
  return padded(frame, features_outside ? 1 : 0);
}

/// `within_reach` for every reach: by a whole distance transform, which is what far reaches take.
BitVolume within_far_reach(const BitVolume& volume, const Features& features, std::int64_t reach, bool inverted,
                           RunContext& context) {
  const GridFrame frame = far_frame(volume.dims(), false);
  const GridFrame wider = far_frame(volume.dims(), features.outside);
  const Index3 margin = (wider.dims - frame.dims) / 2;
  const auto value = static_cast<std::uint8_t>(features.value);
  Grid<std::int32_t> distance;
  {
    const BinaryVolume bytes = resized(expanded(volume, frame, context), wider, value, context);
    distance = squared_distance(bytes, value, context);
  }
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
  context.require_memory(BitVolume::memory(volume.dims()) + morphology_memory(volume.dims(), reach), "morphology");
  return (reach <= kLargestSweptReach ? within_reach : within_far_reach)(volume, features, reach, inverted, context);
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

std::uint64_t morphology_memory(const Index3& dims, std::int64_t reach) {
  if (reach <= kLargestSweptReach) return within_reach_memory(dims, reach);
  // A distance transform and the bytes that it is made of, which go before the result comes.
  const auto voxels = static_cast<std::uint64_t>(far_frame(dims, true).voxels());
  return voxels * (sizeof(std::int32_t) + 1);
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
