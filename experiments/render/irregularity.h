// Slices in the colours of Williams and Rossignac's figures. Knows no graphics library.
#pragma once

#include "common/run/context.h"
#include "common/volume/grid.h"
#include "experiments/render/slice.h"

namespace voxcarve {

/// A slice as [WR05, Figs. 4 to 6] draw it for a ball of `radius` voxels: the core R(S) black, the anticore white,
/// inner-irregular voxels S - R(S) red and outer-irregular ones F(S) - S green. (The paper's text and captions swap red
/// and green; these are the captions'.) The whole volume is filtered, not the slice alone. `index` must be one of the
/// volume's slices.
SlicePicture irregularity_slice(const BinaryVolume& volume, int axis, std::int64_t index, double radius,
                                RunContext& context);

}  // namespace voxcarve
