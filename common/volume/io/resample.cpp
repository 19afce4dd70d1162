// From the samples of a file to cubic voxels at their place.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "common/run/context.h"
#include "common/run/errors.h"
#include "common/run/text.h"
#include "common/volume/io/samples.h"

namespace voxcarve::volume_io {

namespace {

/// Spacings that differ by less than this share count as equal: headers round them.
constexpr double kIsotropic = 1e-6;
/// Resampling may multiply the number of samples by at most this.
constexpr double kMaxGrowth = 1000;

/// Where a new sample lies between two old ones along one axis.
struct Between {
  std::int64_t low = 0;
  std::int64_t high = 0;
  float share = 0;  ///< of the high one
};

/// Samples beyond the outermost old ones repeat them.
std::vector<Between> between(std::int64_t old_size, std::int64_t new_size, double ratio) {
  std::vector<Between> result(static_cast<std::size_t>(new_size));
  for (std::int64_t index = 0; index < new_size; ++index) {
    const double at =
        std::clamp((static_cast<double>(index) + 0.5) * ratio - 0.5, 0.0, static_cast<double>(old_size - 1));
    Between& entry = result[static_cast<std::size_t>(index)];
    entry.low = static_cast<std::int64_t>(at);
    entry.high = std::min(entry.low + 1, old_size - 1);
    entry.share = static_cast<float>(at - static_cast<double>(entry.low));
  }
  return result;
}

Grid<float> resample(const Grid<float>& grid, const Index3& dims, const Point& ratio) {
  std::array<std::vector<Between>, 3> axes;
  for (int axis = 0; axis < 3; ++axis) {
    axes[static_cast<std::size_t>(axis)] = between(grid.frame.dims[axis], dims[axis], ratio[axis]);
  }
  Grid<float> result({dims, Point::Zero(), 1.0});
  const auto mix = [](float low, float high, float share) { return low + share * (high - low); };
  std::size_t sample = 0;
  for (const Between& z : axes[2]) {
    for (const Between& y : axes[1]) {
      for (const Between& x : axes[0]) {
        const auto row = [&](std::int64_t j, std::int64_t k) {
          return mix(grid(x.low, j, k), grid(x.high, j, k), x.share);
        };
        const float low = mix(row(y.low, z.low), row(y.high, z.low), y.share);
        const float high = mix(row(y.low, z.high), row(y.high, z.high), y.share);
        result.values[sample++] = mix(low, high, z.share);
      }
    }
  }
  return result;
}

/// The dims that cover the same extent with voxels of size `voxel`.
Index3 cubic_dims(const VolumeLayout& layout, double voxel, std::string_view name) {
  const Point exact = layout.spacing.cwiseProduct(layout.dims.cast<double>()) / voxel;
  const double growth = exact.prod() / static_cast<double>(layout.dims.prod());
  if (!(growth <= kMaxGrowth)) {
    throw InputError(fmt::format("{}: absurd spacings {} x {} x {}: cubic voxels would be more than {} times as many",
                                 name, format_real(layout.spacing[0]), format_real(layout.spacing[1]),
                                 format_real(layout.spacing[2]), kMaxGrowth));
  }
  const double bytes = exact.prod() * sizeof(float);
  if (bytes > static_cast<double>(default_memory_budget())) {
    throw ResourceError(fmt::format("{}: the resampled volume needs {} of memory", name,
                                    format_bytes(static_cast<std::uint64_t>(bytes))));
  }
  return exact.array().round().cast<std::int64_t>().cwiseMax(1);
}

}  // namespace

void place(const VolumeLayout& layout, std::string_view name, VolumeFile& file) {
  VolumeLayout flat = layout;
  const bool one_slice = layout.dims[2] == 1;
  if (one_slice) flat.spacing[2] = std::min(layout.spacing[0], layout.spacing[1]);
  const double voxel = flat.spacing.minCoeff();
  if (flat.spacing.maxCoeff() > voxel * (1 + kIsotropic)) {
    Index3 dims = cubic_dims(flat, voxel, name);
    if (one_slice) dims[2] = 1;
    file.values = resample(file.values, dims, voxel * flat.spacing.cwiseInverse());
    file.is_binary = false;
    const auto text = [](const auto& v) { return fmt::format("{} x {} x {}", v[0], v[1], v[2]); };
    file.notices.push_back(fmt::format("anisotropic spacing {}: resampled trilinearly from {} to {} voxels of size {}",
                                       text(flat.spacing), text(layout.dims), text(dims), format_real(voxel)));
  }
  GridFrame& frame = file.values.frame;
  frame.voxel_size = voxel;
  // The first sample lies half of the file's own spacing behind the corner, which resampling keeps.
  frame.origin = layout.first_sample.value_or(Point::Zero()) - 0.5 * flat.spacing;
  // Our files also hold the corner itself. It counts as long as nobody moved the origin since.
  if (layout.lower_corner) {
    const double tolerance = 1e-9 * (voxel + layout.lower_corner->cwiseAbs().maxCoeff());
    if ((*layout.lower_corner - frame.origin).cwiseAbs().maxCoeff() <= tolerance) frame.origin = *layout.lower_corner;
  }
}

}  // namespace voxcarve::volume_io
