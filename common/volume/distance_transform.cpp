// Based on [MRH00]; differs in taking columns side by side, and each gap between features apart.
#include "common/volume/distance_transform.h"

#include <algorithm>
#include <string>

#include "common/run/errors.h"
#include "common/volume/lower_envelope.h"

namespace voxcarve {

namespace {

/// Squared distance within a row: the distance to the last feature on one side, then the smaller one of both.
void transform_row(const std::uint8_t* row, std::uint8_t feature, std::int64_t length, std::int32_t* squared) {
  constexpr std::int32_t kFar = 1 << 30;  // grows by less than kLongestExactSide
  std::int32_t since = kFar;
  for (std::int64_t i = 0; i < length; ++i) {
    since = row[i] == feature ? 0 : since + 1;
    squared[i] = since;
  }
  since = kFar;
  for (std::int64_t i = length - 1; i >= 0; --i) {
    since = std::min(since + 1, squared[i]);
    squared[i] = since >= kFar ? kInfiniteDistance : since * since;
  }
}

/// Replaces every value of a line by the minimum over all of its positions of value + (distance along the line)^2.
class EnvelopeWorker {
 public:
  explicit EnvelopeWorker(std::int64_t length) : length_(static_cast<std::int32_t>(length)), envelope_(length) {}

  void operator()(std::int32_t* line, const Index3&) {
    for_each_gap(line, length_, [&](std::int32_t begin, std::int32_t end) {
      if (!envelope_.build(line, begin, end)) return;
      envelope_.for_each_stretch([line](std::int32_t first, std::int32_t last, std::int32_t apex, std::int32_t height) {
        for (std::int32_t x = first; x < last; ++x) line[x] = height + x * (x - 2 * apex);
      });
    });
  }

 private:
  std::int32_t length_;
  LowerEnvelope envelope_;
};

}  // namespace

void require_exact_sides(const GridFrame& frame) {
  if (frame.dims.maxCoeff() <= kLongestExactSide) return;
  throw ResourceError("a distance transform takes at most " + std::to_string(kLongestExactSide) + " voxels a side");
}

Grid<std::int32_t> squared_distance(const BinaryVolume& volume, std::uint8_t feature, RunContext& context) {
  require_exact_sides(volume.frame);
  context.require_memory(volume.values.size() * (sizeof(std::int32_t) + 1), "the distance transform");
  auto distance = Grid<std::int32_t>::uninitialized(volume.frame);
  if (volume.values.empty()) return distance;
  const std::int64_t nx = volume.nx();
  constexpr std::int64_t kVoxelsPerChunk = 1 << 17;
  parallel_for(context, 0, volume.ny() * volume.nz(), kVoxelsPerChunk / nx, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t row = begin; row < end; ++row) {
      transform_row(volume.values.data() + row * nx, feature, nx, distance.values.data() + row * nx);
    }
  });
  for (const int axis : {1, 2}) {
    transform_columns(distance, axis, context, [&] { return EnvelopeWorker(volume.frame.dims[axis]); });
  }
  return distance;
}

}  // namespace voxcarve
