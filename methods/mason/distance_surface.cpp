#include "methods/mason/distance_surface.h"

#include <algorithm>
#include <cmath>

#include "common/volume/bit_morphology.h"
#include "common/volume/distance_transform.h"

namespace voxcarve {

namespace {

/// Distance of a voxel from nothing: farther than any grid is long.
constexpr float kNowhere = 1e6F;

/// The distance to the nearest bit of value `feature`, minus the radius, times `sign`. A result's last step never
/// reaches the border of its grid, but the exterior beyond it counts: `bits` is padded with a layer of it by the
/// caller.
Grid<float> signed_reach(const BitVolume& bits, const GridFrame& frame, std::uint8_t feature, std::int64_t reach,
                         float sign, RunContext& context) {
  const Grid<std::int32_t> squared = squared_distance(expanded(bits, frame, context), feature, context);
  auto field = Grid<float>::uninitialized(frame);
  // Squared distances are integers: half of one keeps the sign away from 0.
  const double radius = std::sqrt(static_cast<double>(reach) + 0.5);
  constexpr std::int64_t kChunk = 1 << 18;
  parallel_for(context, 0, frame.voxels(), kChunk, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t at = begin; at < end; ++at) {
      const std::int32_t value = squared.values[static_cast<std::size_t>(at)];
      const float distance =
          value == kInfiniteDistance ? kNowhere : static_cast<float>(std::sqrt(static_cast<double>(value)) - radius);
      field.values[static_cast<std::size_t>(at)] = sign * distance;
    }
  });
  return field;
}

}  // namespace

Grid<float> distance_field(const BitVolume& shape, const GridFrame& frame, std::int64_t reach,
                           MorphologicalFilter filter, TieRule tie, std::uint64_t held, RunContext& context) {
  const bool is_mason = filter == MorphologicalFilter::kMason;
  const auto bytes_of_field = static_cast<std::uint64_t>(frame.voxels()) * sizeof(float);
  const std::uint64_t bytes_of_bits = BitVolume::memory(frame.dims);
  // Rounded, filleted, RF and FR, Mason's two maps, the mortar, and what the last step is made from.
  constexpr std::uint64_t kVolumesOfBits = 8;
  // Squared distances become the field; Mason has made one before. Or bits are in the making.
  context.require_memory(held + (is_mason ? kVolumesOfBits : 3) * bytes_of_bits + (is_mason ? bytes_of_field : 0) +
                             std::max(2 * bytes_of_field, morphology_memory(frame.dims, reach)),
                         "the distance field");
  RegularFilters filters(shape, reach, false, context);
  const auto grown = [&](const BitVolume& from) { return signed_reach(from, frame, 1, reach, -1, context); };
  const auto shrunk = [&](const BitVolume& from) { return signed_reach(from, frame, 0, reach, 1, context); };
  const auto eroded = [&](const BitVolume& from) { return erode(from, reach, false, context); };
  const auto dilated = [&](const BitVolume& from) { return dilate(from, reach, false, context); };
  switch (filter) {
    case MorphologicalFilter::kDilate:
      return grown(shape);
    case MorphologicalFilter::kErode:
      return shrunk(shape);
    case MorphologicalFilter::kRound:
      return grown(eroded(shape));
    case MorphologicalFilter::kFillet:
      return shrunk(dilated(shape));
    case MorphologicalFilter::kRf:
      return grown(eroded(filters.filleted()));
    case MorphologicalFilter::kFr:
      return shrunk(dilated(filters.rounded()));
    case MorphologicalFilter::kMason:
      break;
  }
  MasonMaps maps;
  filters.mason(tie, nullptr, &maps, held + 4 * bytes_of_bits);
  const BitVolume mortar = filters.mortar();
  Grid<float> field = grown(eroded(filters.filleted()));
  const Grid<float> by_fr = shrunk(dilated(filters.rounded()));
  parallel_for(context, 0, frame.dims[2], 1, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t k = begin; k < end; ++k) {
      for (std::int64_t j = 0; j < frame.dims[1]; ++j) {
        for (std::int64_t i = 0; i < frame.dims[0]; ++i) {
          const float other = by_fr(i, j, k);
          float& value = field(i, j, k);
          const bool nearer = std::abs(other) < std::abs(value);
          if (maps.took_fr.get(i, j, k) || (nearer && !mortar.get(i, j, k))) value = other;
        }
      }
    }
  });
  return field;
}

}  // namespace voxcarve
