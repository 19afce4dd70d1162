// Gaussian low-pass filter of samples on a grid.
#pragma once

#include <vector>

#include "common/mesh/triangle_soup.h"
#include "common/run/context.h"
#include "common/volume/grid.h"

namespace voxcarve {

/// What a filter finds beyond the grid.
enum class BorderRule {
  kRepeat,   ///< the nearest value of the grid
  kConstant  ///< one value everywhere
};

/// Lengths are in voxels, one for each axis.
struct GaussianOptions {
  Point sigma = Point::Constant(1);    ///< standard deviations; 0 leaves an axis as it is
  Point support = Point::Constant(4);  ///< samples farther off than this along the axis take no part
  BorderRule border = BorderRule::kRepeat;
  float outside = 0;  ///< the value beyond the grid under kConstant
};

/// The weights of the samples 1, 2, ... voxels off, on either side, along one axis: the Gaussian's values there over
/// the sum of all, as far as they are normal floats. The middle sample has what is missing of 1. Throws ParameterError
/// for a negative sigma, and for a support that is negative or longer than 16,384 voxels.
std::vector<float> gaussian_weights(double sigma, double support);

/// The field convolved with a Gaussian that is cut off along each axis, on the same grid: the low-pass filter by which
/// scalar volumes are simplified directly [He95, 4]. An image is not filtered along z.
///
/// Values are finite and less than a quarter of the greatest float. A field that is constant as far as a voxel's
/// support reaches keeps exactly this value there; elsewhere results are off by less than 2^-24 M (2 R + 24) and terms
/// of second order, for values of at most M and R samples on one side along all axes together. Mirrored fields give
/// mirrored results, bit by bit, and the same bytes come out on any number of threads and from registers of any width.
///
/// Time is linear in voxels and in R. Holds 8 bytes a voxel with the field, and 32 KiB a thread for each slice that the
/// support along z reaches. Throws ParameterError as gaussian_weights does, ResourceError when memory exceeds the
/// budget.
Grid<float> gaussian_filtered(const Grid<float>& field, const GaussianOptions& options, RunContext& context);

}  // namespace voxcarve
