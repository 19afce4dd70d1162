// Smoothing of surfaces.
#pragma once

#include "common/mesh/triangle_soup.h"
#include "common/run/context.h"

namespace voxcarve {

/// The low-pass filter of [Tau95]: a step towards the mean of the neighbours by `lambda`, then one away by `mu`.
struct TaubinOptions {
  int iterations = 10;   ///< each one a step by lambda and a step by mu; 0 changes nothing
  double lambda = 0.5;   ///< in (0, 1)
  double mu = -0.52632;  ///< less than -lambda; this one gives a pass band of 1 / lambda + 1 / mu = 0.1
};

/// Moves the vertices of `surface` [NT03, 5.1]: weights are equal over the vertices joined by an edge, vertices on a
/// boundary edge average over boundary neighbours only, unused ones stay. Triangles and colours stay as they are. The
/// same bytes on any number of threads. Throws ParameterError for options out of range, and Cancelled.
void taubin_smooth(TriangleSoup& surface, const TaubinOptions& options, RunContext& context);

}  // namespace voxcarve
