// How a cost grows with the size of its input.
#pragma once

#include <span>

namespace voxcarve::bench {

/// What one run was given, and what it took.
struct VoxelizationSample {
  double triangles = 0;
  double columns = 0;  ///< voxel columns over all directions
  double voxels = 0;
  double seconds = 0;
};

/// The cost of a voxelization as a sum: so much a triangle, a voxel column and a voxel. Lengths are of a model that
/// fills the grid in the same way throughout, so that what a triangle costs for the columns it covers is in the second.
struct VoxelizationCosts {
  double per_triangle = 0;  ///< nanoseconds, like the others
  double per_column = 0;
  double per_voxel = 0;
  double worst = 0;  ///< largest deviation of a sample from the sum, share of the sample
};

/// Least squares of relative deviations with costs that are not negative: of the subsets of the three costs, the best
/// whose fit is positive. Three samples or more, of positive seconds.
VoxelizationCosts fit_costs(std::span<const VoxelizationSample> samples);

/// The exponent p of seconds ~ size^p between two sizes: 1 where the growth is linear.
double growth_exponent(double size, double seconds, double larger_size, double its_seconds);

}  // namespace voxcarve::bench
