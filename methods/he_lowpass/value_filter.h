// Scalar volumes filtered directly, without an inside test.
#pragma once

#include "common/run/context.h"
#include "common/volume/grid.h"
#include "methods/he_lowpass/radial_filter.h"

namespace voxcarve {

/// The values of `field` seen through the filter at the voxel centres of `frame` [He95, 4: reconstruction filters on
/// the original volume]; beyond the grid the border values go on. `support` is R in model units. A Gaussian is
/// separable: it is applied to the field, cut off at R along each axis, and interpolated trilinearly at the centres.
/// The others are weighted means of the samples within R of a centre, or the trilinear interpolation where there are
/// fewer than eight. The same bytes on any number of threads.
Grid<float> filter_values(const Grid<float>& field, const GridFrame& frame, const RadialFilter& filter, double support,
                          RunContext& context);

/// Trilinear interpolation of `field` at the voxel centres of `frame`, constant beyond the outermost samples.
Grid<float> interpolated(const Grid<float>& field, const GridFrame& frame, RunContext& context);

}  // namespace voxcarve
