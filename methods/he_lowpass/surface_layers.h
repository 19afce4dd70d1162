// How many layers of a surface stand for a gradual transition, and which.
#pragma once

#include <cstdint>
#include <vector>

#include "methods/he_lowpass/radial_filter.h"

namespace voxcarve {

/// One surface of a multi-layered mesh [He95, 3].
struct SurfaceLayer {
  double iso_density = 0.5;
  double opacity = 1;  ///< of the surface, 1 - translucency of [He95, eq. 4]
  /// Distances from the solid's surface, in units of the filter's support, for which it stands, were the surface flat.
  double from = 0;
  double to = 1;
};

/// Layers and how far their step function is from the density profile of a plane, the left side of [He95, eq. 6] with
/// lengths in units of the support: a density.
struct LayerChoice {
  std::vector<SurfaceLayer> layers;  ///< from the innermost one, which is opaque, outward
  double error = 0;
};

/// The `count` >= 1 layers of least error.
LayerChoice best_layers(const RadialFilter& filter, std::int64_t count);

/// The fewest layers with an error of at most `bound` > 0. Throws ParameterError when 1000 are not enough.
LayerChoice fewest_layers(const RadialFilter& filter, double bound);

}  // namespace voxcarve
