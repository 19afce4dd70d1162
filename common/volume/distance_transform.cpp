// Based on [MRH00]; differs in taking columns side by side, first by looking at the nearest voxels of all of them at
// once, which is enough where features lie dense, and by lower envelopes, each gap between features apart, where not.
#include "common/volume/distance_transform.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <string>
#include <vector>

#include "common/run/errors.h"
#include "common/volume/lower_envelope.h"
#include "common/volume/vectorized.h"

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

constexpr std::int64_t kColumns = 16;    ///< that are taken together: a cache line of values
constexpr std::int64_t kMostSteps = 40;  ///< along the axis, before envelopes are the faster way
constexpr std::int64_t kApron = kMostSteps + 4;
/// Farther than what kMostSteps steps decide, and no overflow when their square is added.
constexpr std::int32_t kFarAway = 1 << 30;
using Lanes [[gnu::vector_size(32)]] = std::int32_t;
constexpr std::int64_t kLanes = kColumns / 2;

/// Replaces the values of kColumns columns, row by row in `rows`, by the minimum over all rows y of value + (distance
/// along the column)^2, into `result`. `rows` may be read kApron rows beyond either end, which hold kFarAway. False
/// when some minimum lies more than kMostSteps rows off: then there is no result.
VOXCARVE_VECTORIZED bool look_nearby(const std::int32_t* rows, std::int64_t length, std::int32_t* result) {
  for (std::int64_t y = 0; y < length; ++y) {
    const std::int32_t* row = rows + y * kColumns;
    Lanes first;
    Lanes second;
    std::memcpy(&first, row, sizeof(first));
    std::memcpy(&second, row + kLanes, sizeof(second));
    for (std::int64_t d = 1;; ++d) {
      const Lanes step = Lanes{} + static_cast<std::int32_t>(d * d);
      if (d % 4 == 1) {
        const auto more = (first > step) | (second > step);
        std::array<std::uint64_t, 4> words;
        std::memcpy(words.data(), &more, sizeof(words));
        if ((words[0] | words[1] | words[2] | words[3]) == 0) break;  // everything else is farther
        if (d > kMostSteps) return false;
      }
      Lanes above;
      Lanes below;
      std::memcpy(&above, row - d * kColumns, sizeof(above));
      std::memcpy(&below, row + d * kColumns, sizeof(below));
      Lanes least = (above < below ? above : below) + step;
      first = least < first ? least : first;
      std::memcpy(&above, row - d * kColumns + kLanes, sizeof(above));
      std::memcpy(&below, row + d * kColumns + kLanes, sizeof(below));
      least = (above < below ? above : below) + step;
      second = least < second ? least : second;
    }
    std::memcpy(result + y * kColumns, &first, sizeof(first));
    std::memcpy(result + y * kColumns + kLanes, &second, sizeof(second));
  }
  return true;
}

/// The same of columns up to kLongestExactSide long and minima at any distance.
class ColumnTransform {
 public:
  explicit ColumnTransform(std::int64_t length)
      : length_(length),
        rows_(static_cast<std::size_t>((length + 2 * kApron) * kColumns), kFarAway),
        result_(static_cast<std::size_t>(length * kColumns)),
        line_(static_cast<std::size_t>(length)),
        envelope_(length) {}

  /// Of `columns` <= kColumns columns side by side, from `corner` on, whose rows lie `step` values apart.
  void operator()(std::int32_t* corner, std::int64_t step, std::int64_t columns) {
    std::int32_t* rows = rows_.data() + kApron * kColumns;
    for (std::int64_t y = 0; y < length_; ++y) {
      for (std::int64_t c = 0; c < columns; ++c) rows[y * kColumns + c] = std::min(corner[y * step + c], kFarAway);
      std::fill(rows + y * kColumns + columns, rows + (y + 1) * kColumns, 0);  // no column: nothing to look for
    }
    if (!look_nearby(rows, length_, result_.data())) {
      for (std::int64_t c = 0; c < columns; ++c) {
        for (std::int64_t y = 0; y < length_; ++y) {
          const std::int32_t value = rows[y * kColumns + c];
          line_[static_cast<std::size_t>(y)] = value == kFarAway ? corner[y * step + c] : value;
        }
        transform_line();
        for (std::int64_t y = 0; y < length_; ++y)
          result_[static_cast<std::size_t>(y * kColumns + c)] = line_[static_cast<std::size_t>(y)];
      }
    }
    for (std::int64_t y = 0; y < length_; ++y) std::copy_n(result_.data() + y * kColumns, columns, corner + y * step);
  }

 private:
  void transform_line() {
    std::int32_t* line = line_.data();
    for_each_gap(line, static_cast<std::int32_t>(length_), [&](std::int32_t begin, std::int32_t end) {
      if (!envelope_.build(line, begin, end)) return;
      envelope_.for_each_stretch([line](std::int32_t first, std::int32_t last, std::int32_t apex, std::int32_t height) {
        for (std::int32_t x = first; x < last; ++x) line[x] = height + x * (x - 2 * apex);
      });
    });
  }

  std::int64_t length_;
  std::vector<std::int32_t> rows_;
  std::vector<std::int32_t> result_;
  std::vector<std::int32_t> line_;
  LowerEnvelope envelope_;
};

/// Transforms all columns along `axis`, 1 or 2.
void transform_axis(Grid<std::int32_t>& grid, int axis, const RunContext& context) {
  const Index3 dims = grid.frame.dims;
  const std::int64_t length = dims[axis];
  if (length == 1) return;
  const std::int64_t across = axis == 1 ? dims[2] : dims[1];
  const std::int64_t step = axis == 1 ? dims[0] : dims[0] * dims[1];
  const std::int64_t across_step = axis == 1 ? dims[0] * dims[1] : dims[0];
  const std::int64_t blocks = (dims[0] + kColumns - 1) / kColumns;
  constexpr std::int64_t kVoxelsPerChunk = 1 << 17;
  const std::int64_t grain = std::max<std::int64_t>(1, kVoxelsPerChunk / (kColumns * length));
  parallel_for(context, 0, blocks * across, grain, [&](std::int64_t begin, std::int64_t end) {
    ColumnTransform transform(length);
    for (std::int64_t block = begin; block < end; ++block) {
      const std::int64_t i = block % blocks * kColumns;
      transform(grid.values.data() + block / blocks * across_step + i, step, std::min(kColumns, dims[0] - i));
    }
  });
}

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
  for (const int axis : {1, 2}) transform_axis(distance, axis, context);
  return distance;
}

}  // namespace voxcarve
