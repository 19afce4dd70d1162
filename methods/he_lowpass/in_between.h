// Levels between two levels of a hierarchy.
#pragma once

#include <cstdint>
#include <vector>

#include "common/run/context.h"
#include "common/volume/grid.h"

namespace voxcarve {

/// Interpolation between two adjacent volumes of a hierarchy [He95, 5]. The coarse one is resampled on the grid of the
/// fine one, trilinearly; what lies in between is there a weighted mean of both. Only samples of cells that can hold
/// the surface are touched: those where one of the volumes has it, or exactly one is inside.
class InBetween {
 public:
  /// Both may be of densities or other values; what lies beyond the grid of `coarse` continues its border. Holds a copy
  /// of `fine` and 16 bytes a touched sample.
  InBetween(const DensityVolume& coarse, const DensityVolume& fine, float iso_value, RunContext& context);

  /// The densities at `share` in [0, 1] of the way from the coarse volume to the fine one. Elsewhere than in the
  /// touched cells those of the fine one, which lie on the same side of the iso-value, so that the surface is that of
  /// the whole mean.
  DensityVolume at(double share, RunContext& context) const;

  std::int64_t cells() const { return cells_; }                  ///< between samples of the fine grid
  std::int64_t touched_cells() const { return touched_cells_; }  ///< those that can hold the surface
  /// The largest difference of the two volumes: no density changes faster, per unit of `share`.
  double largest_difference() const { return largest_difference_; }

 private:
  struct Sample {
    std::int64_t index;
    float coarse;
    float fine;
  };
  DensityVolume elsewhere_;
  std::vector<Sample> samples_;
  std::int64_t cells_ = 0;
  std::int64_t touched_cells_ = 0;
  double largest_difference_ = 0;
};

}  // namespace voxcarve
