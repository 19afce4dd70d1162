// The filtered density of a solid at the points of a grid.
#pragma once

#include <cstdint>

#include "methods/he_lowpass/lattice_kernel.h"
#include "methods/he_lowpass/radial_filter.h"
#include "methods/he_lowpass/solid_sampler.h"

namespace voxcarve {

/// How a filter is sampled where it lies on a grid point. Lattice points coincide with grid points, so that no two of
/// these need samples of their own.
struct TapLattice {
  std::int64_t per_voxel = 1;  ///< lattice points along a voxel's edge
  std::int64_t stride = 1;     ///< lattice points from tap to tap
  double radius = 1;           ///< taps from the centre to the end of the support

  /// Lattice points from a grid point to the farthest one that its density may depend on.
  std::int64_t reach(const LatticeKernel& kernel) const { return kernel.reach() * stride; }
};

/// The coarsest lattice with at least `taps` taps across a support of radius `support`, in voxels: taps lie closer than
/// voxels where the support is narrow, and skip some where it is wide, so that a density costs about the same for any
/// support. Throws ParameterError for supports below a hundredth of a voxel.
TapLattice tap_lattice(double support, double taps);

struct LowPassOptions {
  RadialFilter filter;
  double support = 1;  ///< R, in voxels of the grid
  double taps = 24;    ///< at least so many across the support
  TapRule rule = TapRule::kCell;
};

/// What the filtering cost.
struct LowPassReport {
  std::int64_t evaluated = 0;  ///< grid points whose support may hold both inside and outside, so that it was summed
  std::int64_t taps = 0;       ///< weights of the filter
};

/// f of [He95, eq. 1] at the centre of every voxel of `frame`: the share of the filter's weight that lies in the solid,
/// in [0, 1], exactly 0 or 1 where all samples within the support agree. The same bytes on any number of threads.
/// Time goes with the lattice, a bit a point, and with the grid points near the surface times the number of taps;
/// memory beside the result is a slab of the lattice, at least as high as the support.
DensityVolume low_pass(const SolidSampler& solid, const GridFrame& frame, const LowPassOptions& options,
                       RunContext& context, LowPassReport* report = nullptr);

}  // namespace voxcarve
