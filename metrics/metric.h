// The interface of metrics: computed from stored shapes, apart from the runs that made them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "common/mesh/triangle_soup.h"
#include "common/run/context.h"

namespace voxcarve {

/// A metric that does not apply says why, never a number.
struct Undefined {
  std::string reason;
  bool operator==(const Undefined&) const = default;
};

using MetricValue = std::variant<bool, std::int64_t, double, Undefined>;

/// One figure. `key` is the JSON path of DESIGN section 6, dots between objects: "hausdorff.a_to_b.upper", "genus".
struct Measurement {
  std::string key;
  MetricValue value;
  bool operator==(const Measurement&) const = default;
};

enum class Direction { kNone, kLowerIsBetter, kHigherIsBetter };

/// What one key means.
struct MetricColumn {
  std::string key;
  std::string unit;  ///< "", "model", "model^2", "model^3", "share", "degrees"
  Direction direction = Direction::kNone;
  std::string help;  ///< one line
};

/// Settings of all metrics.
struct MetricOptions {
  double hausdorff_error = 1e-3;            ///< width of the certified interval, share of the reference diagonal
  std::int64_t distance_samples = 20000;    ///< area-uniform samples a side for mean and RMS
  std::int64_t rays = 1 << 14;              ///< rays over all replicates of the symmetric difference
  std::int64_t replicates = 8;              ///< at least 8
  bool visible = true;                      ///< the pair metrics of the parts that are visible from outside
  std::int64_t view_directions = 128;       ///< to look from, for these
  std::optional<double> regularity_radius;  ///< voxels: also count what of a volume is irregular at this radius
};

/// Columns of `measure_shape`, in its order.
const std::vector<MetricColumn>& shape_columns();
/// Columns of `measure_pair`, in its order.
const std::vector<MetricColumn>& pair_columns();

/// The single-shape metrics of one surface. Never throws for a finite soup, an empty one included: what does not apply
/// is Undefined. Throws Cancelled.
std::vector<Measurement> measure_shape(const TriangleSoup& shape, const MetricOptions& options, RunContext& context);

/// The pair metrics: `reference` is the input, `shape` the output; lengths are shares of the reference's diagonal where
/// the key says relative. Same promises as `measure_shape`, but for ResourceError when finding the visible parts needs
/// more than the memory budget.
std::vector<Measurement> measure_pair(const TriangleSoup& reference, const TriangleSoup& shape,
                                      const MetricOptions& options, RunContext& context);

/// The value of `key`, or an Undefined that says it was not measured.
const MetricValue& value_of(const std::vector<Measurement>& measurements, std::string_view key);

}  // namespace voxcarve
