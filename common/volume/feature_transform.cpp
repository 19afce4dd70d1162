// Based on [MRH00], with the apex of the lowest parabola kept in place of its value. Instead of a distance beside every
// index, the index alone is stored, of which each pass knows one more coordinate: after the rows the feature's x, after
// the second pass y nx + x within the slice, in the end its index.
#include <algorithm>

#include "common/run/errors.h"
#include "common/volume/distance_transform.h"
#include "common/volume/lower_envelope.h"

namespace voxcarve {

namespace {

/// The x of the nearest feature in the row, the smaller one of two.
void transform_row(const std::uint8_t* row, std::uint8_t feature, std::int64_t length, std::uint32_t* nearest) {
  std::uint32_t last = kNoFeature;
  for (std::int64_t i = 0; i < length; ++i) {
    if (row[i] == feature) last = static_cast<std::uint32_t>(i);
    nearest[i] = last;
  }
  std::uint32_t next = kNoFeature;
  for (std::int64_t i = length - 1; i >= 0; --i) {
    const auto here = static_cast<std::uint32_t>(i);
    if (row[i] == feature) next = here;
    if (next != kNoFeature && (nearest[i] == kNoFeature || next - here < here - nearest[i])) nearest[i] = next;
  }
}

std::int32_t squared(std::int64_t difference) {
  return static_cast<std::int32_t>(difference * difference);
}

/// Replaces the index at every position of a line by that of the nearest of all the line's features.
class NearestWorker {
 public:
  NearestWorker(const Index3& dims, int axis)
      : nx_(static_cast<std::uint32_t>(dims[0])),
        axis_(axis),
        stride_(static_cast<std::uint32_t>(axis == 1 ? dims[0] : dims[0] * dims[1])),
        length_(static_cast<std::int32_t>(dims[axis])),
        envelope_(dims[axis]),
        squared_(static_cast<std::size_t>(length_)),
        line_(squared_.size()) {}

  void operator()(std::uint32_t* line, const Index3& position) {
    for (std::size_t x = 0; x < line_.size(); ++x) {
      squared_[x] = squared_offset(line[x], position);
      line_[x] = line[x] == kNoFeature ? kNoFeature : line[x] + static_cast<std::uint32_t>(x) * stride_;
    }
    std::ranges::copy(line_, line);
    for_each_gap(squared_.data(), length_, [&](std::int32_t begin, std::int32_t end) {
      if (!envelope_.build(squared_.data(), begin, end)) return;
      envelope_.for_each_stretch([&](std::int32_t first, std::int32_t last, std::int32_t apex, std::int32_t) {
        std::fill(line + first, line + last, line_[static_cast<std::size_t>(apex)]);
      });
    });
  }

 private:
  /// Squared distance of a feature from the line at `position`.
  std::int32_t squared_offset(std::uint32_t feature, const Index3& position) const {
    if (feature == kNoFeature) return kInfiniteDistance;
    if (axis_ == 1) return squared(feature - position[0]);
    return squared(feature % nx_ - position[0]) + squared(feature / nx_ - position[1]);
  }

  std::uint32_t nx_;
  int axis_;
  std::uint32_t stride_;
  std::int32_t length_;
  LowerEnvelope envelope_;
  std::vector<std::int32_t> squared_;
  std::vector<std::uint32_t> line_;
};

}  // namespace

Grid<std::uint32_t> nearest_feature(const BinaryVolume& volume, std::uint8_t feature, RunContext& context) {
  require_exact_sides(volume.frame);
  if (volume.frame.voxels() > std::int64_t{kNoFeature})
    throw ResourceError("the grid has more voxels than 32-bit indices reach; lower the resolution");
  context.require_memory(volume.values.size() * (sizeof(std::uint32_t) + 1), "the feature transform");
  auto nearest = Grid<std::uint32_t>::uninitialized(volume.frame);
  if (volume.values.empty()) return nearest;
  const std::int64_t nx = volume.nx();
  constexpr std::int64_t kVoxelsPerChunk = 1 << 17;
  parallel_for(context, 0, volume.ny() * volume.nz(), kVoxelsPerChunk / nx, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t row = begin; row < end; ++row) {
      transform_row(volume.values.data() + row * nx, feature, nx, nearest.values.data() + row * nx);
    }
  });
  for (const int axis : {1, 2}) {
    transform_columns(nearest, axis, context, [&] { return NearestWorker(volume.frame.dims, axis); });
  }
  return nearest;
}

}  // namespace voxcarve
