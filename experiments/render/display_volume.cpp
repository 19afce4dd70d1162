#include "experiments/render/display_volume.h"

#include <algorithm>
#include <cmath>

namespace voxcarve {

namespace {

constexpr std::int64_t kMargin = 2;       ///< voxels: one for interpolation, one more for gradients
constexpr double kBandShare = 1.0 / 100;  ///< of the range of values

const BinaryVolume& grid_of(const BinaryVolume& volume) {
  return volume;
}
const Grid<float>& grid_of(const ScalarVolume& volume) {
  return volume.grid;
}
double iso_of(const BinaryVolume&) {
  return 0.5;
}
double iso_of(const ScalarVolume& volume) {
  return static_cast<double>(volume.iso_value);
}

/// Calls visit(j, k, first, last) with the first and the last voxel of every row along x that holds values from `least`
/// on.
template <class T, class Visit>
void for_each_row(const Grid<T>& grid, double least, const Visit& visit) {
  const auto reaches = [least](T value) { return static_cast<double>(value) >= least; };
  for (std::int64_t k = 0; k < grid.nz(); ++k) {
    for (std::int64_t j = 0; j < grid.ny(); ++j) {
      const T* const row = grid.values.data() + grid.index(0, j, k);
      const T* const end = row + grid.nx();
      const T* const first = std::find_if(row, end, reaches);
      if (first == end) continue;
      const T* last = end - 1;
      while (!reaches(*last)) --last;
      visit(j, k, first - row, last - row);
    }
  }
}

template <class Volume>
std::vector<Point> hull_points(const Volume& volume) {
  const auto& grid = grid_of(volume);
  std::vector<Point> points;
  for_each_row(grid, iso_of(volume), [&](std::int64_t j, std::int64_t k, std::int64_t first, std::int64_t last) {
    for (const std::int64_t i : {first, last + 1}) {
      for (std::int64_t corner = 0; corner < 4; ++corner) {
        const Index3 lattice(i, j + corner % 2, k + corner / 2);
        points.push_back(grid.frame.origin + grid.frame.voxel_size * lattice.cast<double>());
      }
    }
  });
  return points;
}

/// From values to samples. The range holds the mirror images about the iso-value of all interior values.
class Scale {
 public:
  template <class T>
  Scale(const Grid<T>& grid, double iso_value) : iso_value_(iso_value) {
    const auto [least, greatest] = std::ranges::minmax_element(grid.values);
    low_ = std::min(static_cast<double>(*least), 2 * iso_value - static_cast<double>(*greatest));
    double range = static_cast<double>(*greatest) - low_;
    if (!(range > 0)) {  // everything lies at the iso-value
      range = 1;
      low_ = iso_value - 0.5;
    }
    factor_ = DisplayVolume::kLargest / range;
    band_ = kBandShare * range;
    opaque_ = std::min(iso_value + band_, static_cast<double>(*greatest));
  }
  /// In samples; neither end of the rise is beyond their range.
  double band() const { return band_ * factor_; }
  double opaque() const { return (opaque_ - low_) * factor_; }
  double mirrored(double value) const { return iso_value_ - std::max(value - iso_value_, band_); }
  double operator()(double value) const {
    return std::clamp((value - low_) * factor_, 0.0, static_cast<double>(DisplayVolume::kLargest));
  }

 private:
  double iso_value_, low_, factor_, band_, opaque_;
};

template <class Volume>
DisplayVolume display(const Volume& volume, const UnitFrame& frame) {
  const auto& grid = grid_of(volume);
  const double iso_value = iso_of(volume);
  const Scale scale(grid, iso_value);
  Index3 low = grid.frame.dims;
  Index3 high = Index3::Constant(-1);
  for_each_row(grid, iso_value, [&](std::int64_t j, std::int64_t k, std::int64_t first, std::int64_t last) {
    low = low.cwiseMin(Index3(first, j, k));
    high = high.cwiseMax(Index3(last, j, k));
  });
  DisplayVolume result;
  if ((high.array() < low.array()).any()) return result;
  low.array() -= kMargin;
  result.dims = high - low + Index3::Constant(1 + kMargin);
  result.first_sample = frame.to_unit(grid.frame.center(low));
  result.spacing = grid.frame.voxel_size / frame.half_extent;
  result.iso_value = scale(iso_value);
  result.band = scale.band();
  result.opaque = scale.opaque();
  result.samples.reserve(static_cast<std::size_t>(result.dims.prod()));
  const Index3 last_voxel = grid.frame.dims - Index3::Ones();
  Index3 at;
  for (at[2] = low[2]; at[2] < low[2] + result.dims[2]; ++at[2]) {
    for (at[1] = low[1]; at[1] < low[1] + result.dims[1]; ++at[1]) {
      for (at[0] = low[0]; at[0] < low[0] + result.dims[0]; ++at[0]) {
        const Index3 voxel = at.cwiseMax(0).cwiseMin(last_voxel);
        auto value = static_cast<double>(grid(voxel[0], voxel[1], voxel[2]));
        if (voxel != at && value >= iso_value) value = scale.mirrored(value);
        result.samples.push_back(static_cast<std::uint16_t>(std::lround(scale(value))));
      }
    }
  }
  return result;
}

}  // namespace

std::vector<Point> interior_hull(const BinaryVolume& volume) {
  return hull_points(volume);
}

std::vector<Point> interior_hull(const ScalarVolume& volume) {
  return hull_points(volume);
}

DisplayVolume make_display_volume(const BinaryVolume& volume, const UnitFrame& frame) {
  return display(volume, frame);
}

DisplayVolume make_display_volume(const ScalarVolume& volume, const UnitFrame& frame) {
  return display(volume, frame);
}

}  // namespace voxcarve
