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

/// Throws ParameterError for options out of range, and for steps that make waves instead of smoothing them. An
/// iteration multiplies a wave by f(k) = (1 - lambda k) (1 - mu k), for its k in [0, 2] [Tau95]: the longest waves have
/// the least k. The shortest, of k = 2, must not grow: |f(2)| <= 1. Others grow at most by f's greatest value,
/// 1 + (lambda + mu)^2 / (4 lambda |mu|), and no wave may more than double over all iterations. That leaves the
/// defaults legal at 1000 iterations, where it is 1.93 (1.007 at 10).
void check_options(const TaubinOptions& options);

/// Moves the vertices of `surface` [NT03, 5.1]: weights are equal over the vertices joined by an edge, vertices on a
/// boundary edge average over boundary neighbours only, unused ones stay. Triangles and colours stay as they are. The
/// same bytes on any number of threads. Throws what `check_options` throws, ResourceError, and Cancelled; `surface` is
/// as it was then, for the steps are made on a copy of the positions.
void taubin_smooth(TriangleSoup& surface, const TaubinOptions& options, RunContext& context);

}  // namespace voxcarve
