// The low-pass filters of He et al. as functions of the distance from their centre, and what they make of a plane.
#pragma once

#include <cstdint>
#include <string_view>

namespace voxcarve {

/// How the weight falls from the centre to the support's radius R, beyond which it is 0.
enum class RadialShape {
  kGaussian,   ///< exp(-r^2 / 2 sigma^2), cut off at R
  kHyperCone,  ///< linear, 0 at R [He95, eq. 3]
  kBox         ///< constant
};

/// "gaussian", "hyper-cone" or "box"; throws ParameterError for another name.
RadialShape radial_shape_from(std::string_view name);

/// A radially symmetric filter; all distances are in units of its support's radius.
struct RadialFilter {
  RadialShape shape = RadialShape::kGaussian;
  double sigma_ratio = 0.4;  ///< standard deviation of the Gaussian; others do not look at it

  /// The weight at distance r >= 0, 1 at the centre, not normalised.
  double weight(double r) const;

  /// d(x) of [He95, eq. 5]: the density where the nearest point of a half-space is at distance x in [-1, 1] (negative:
  /// inside it), for a filter of integral 1. Falls from 1 to 0, convex from 0 on; d(0) = 1/2 and d(x) + d(-x) = 1.
  double plane_profile(double x) const;

  /// The distance in [0, 1] with plane_profile(x) = density, for a density in [0, 1/2].
  double plane_distance(double density) const;
};

}  // namespace voxcarve
