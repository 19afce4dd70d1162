#include "metrics/volume.h"

#include <array>
#include <cmath>
#include <numeric>
#include <optional>

#include "common/volume/betti.h"
#include "common/volume/bit_morphology.h"
#include "common/volume/labelling.h"

namespace voxcarve {

namespace {

/// S - R(S) and F(S) - S.
struct IrregularCounts {
  std::int64_t inner = 0;
  std::int64_t outer = 0;
};

IrregularCounts count_irregular(const BinaryVolume& volume, double radius, RunContext& context) {
  const std::int64_t reach = squared_reach(radius);
  const Index3 margin = ball_margin(volume.frame.dims, radius);
  context.require_memory(volume.values.size() + BitVolume::memory(volume.frame.dims + 2 * margin), "regularity");
  const BitVolume shape = packed(volume, margin, false, context);
  const std::int64_t interior = count_set(shape, context);
  // R(S) lies within S, and S within F(S).
  return {interior - count_set(open(shape, reach, false, context), context),
          count_set(close(shape, reach, false, context), context) - interior};
}

/// By how many voxels b's grid lies beyond a's along each axis, or nothing where the lattices differ.
std::optional<Index3> lattice_offset(const GridFrame& a, const GridFrame& b) {
  constexpr double kTolerance = 1e-6;  // voxels
  if (std::abs(a.voxel_size - b.voxel_size) * static_cast<double>(b.dims.maxCoeff()) > kTolerance * a.voxel_size)
    return std::nullopt;
  const Point offset = (b.origin - a.origin) / a.voxel_size;
  const Point whole = offset.array().round();
  if ((offset - whole).cwiseAbs().maxCoeff() > kTolerance) return std::nullopt;
  return whole.cast<std::int64_t>();
}

/// Voxels interior to both.
std::int64_t count_common(const BinaryVolume& a, const BinaryVolume& b, const Index3& offset, RunContext& context) {
  const Index3 low = offset.cwiseMax(0);
  const Index3 high = a.frame.dims.cwiseMin(offset + b.frame.dims);
  if ((low.array() >= high.array()).any()) return 0;
  std::vector<std::int64_t> counts(static_cast<std::size_t>(high[2] - low[2]));
  parallel_for(context, low[2], high[2], 1, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t k = begin; k < end; ++k) {
      std::int64_t count = 0;
      for (std::int64_t j = low[1]; j < high[1]; ++j) {
        const std::uint8_t* left = a.values.data() + a.index(low[0], j, k);
        const std::uint8_t* right = b.values.data() + b.index(low[0] - offset[0], j - offset[1], k - offset[2]);
        for (std::int64_t i = 0; i < high[0] - low[0]; ++i) count += left[i] & right[i];
      }
      counts[static_cast<std::size_t>(k - low[2])] = count;
    }
  });
  return std::accumulate(counts.begin(), counts.end(), std::int64_t{0});
}

}  // namespace

const std::vector<MetricColumn>& volume_columns() {
  static const std::vector<MetricColumn> kColumns = {
      {"voxels.interior", "voxels", Direction::kNone, "voxels of the interior"},
      {"voxels.foreground_components", "", Direction::kNone, "components of the interior, 6-connected (4 in an image)"},
      {"voxels.background_components", "", Direction::kNone,
       "components of the exterior, 18-connected (8 in an image), the unbounded one included"},
      {"voxels.b0", "", Direction::kNone, "components"},
      {"voxels.b1", "", Direction::kNone, "tunnels (holes, in an image)"},
      {"voxels.b2", "", Direction::kNone, "voids"},
      {"voxels.inner_irregular", "voxels", Direction::kLowerIsBetter,
       "voxels that a ball of the regularity radius within the interior does not reach"},
      {"voxels.outer_irregular", "voxels", Direction::kLowerIsBetter,
       "voxels that a ball of the regularity radius within the exterior does not reach"},
  };
  return kColumns;
}

const std::vector<MetricColumn>& volume_pair_columns() {
  static const std::vector<MetricColumn> kColumns = {
      {"voxels.changed", "voxels", Direction::kLowerIsBetter, "voxels interior to one of the two: A - B and B - A"},
      {"voxels.a_minus_b", "voxels", Direction::kLowerIsBetter, "voxels of A that B has not"},
      {"voxels.b_minus_a", "voxels", Direction::kLowerIsBetter, "voxels of B that A has not"},
  };
  return kColumns;
}

std::vector<Measurement> measure_volume(const BinaryVolume& volume, const MetricOptions& options, RunContext& context) {
  const BettiNumbers betti = betti_numbers(volume, context);
  MetricValue inner = Undefined{"no regularity radius was given"};
  MetricValue outer = inner;
  if (options.regularity_radius) {
    const IrregularCounts irregular = count_irregular(volume, *options.regularity_radius, context);
    inner = irregular.inner;
    outer = irregular.outer;
  }
  return {{"voxels.interior", count_interior(volume)},
          {"voxels.foreground_components", betti.b0},
          {"voxels.background_components", count_exterior_components(volume, Connectivity::kEdge, context)},
          {"voxels.b0", betti.b0},
          {"voxels.b1", betti.b1},
          {"voxels.b2", betti.b2},
          {"voxels.inner_irregular", inner},
          {"voxels.outer_irregular", outer}};
}

std::vector<Measurement> measure_volume_pair(const BinaryVolume& reference, const BinaryVolume& shape,
                                             RunContext& context) {
  const auto offset = lattice_offset(reference.frame, shape.frame);
  if (!offset) {
    const Undefined reason{"the two grids do not share a lattice of voxels"};
    return {{"voxels.changed", reason}, {"voxels.a_minus_b", reason}, {"voxels.b_minus_a", reason}};
  }
  const std::int64_t common = count_common(reference, shape, *offset, context);
  const std::int64_t a_minus_b = count_interior(reference) - common;
  const std::int64_t b_minus_a = count_interior(shape) - common;
  return {{"voxels.changed", a_minus_b + b_minus_a}, {"voxels.a_minus_b", a_minus_b}, {"voxels.b_minus_a", b_minus_a}};
}

}  // namespace voxcarve
