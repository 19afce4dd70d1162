// The triple integral of [He95, eq. 5] over the part of the support beyond a plane at distance x is, by shells of
// radius r, 2 pi times the integral of h(r) r (r - x) from x to 1: a shell has the share (1 - x / r) / 2 of its area
// there. Integrated by hand for the three shapes.
#include "methods/he_lowpass/radial_filter.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "common/run/errors.h"

namespace voxcarve {

namespace {

/// The integral of exp(-a r^2) r (r - x) from x to 1, times 2 a.
double gaussian_beyond(double a, double x) {
  const double root = std::sqrt(a);
  const double bell = std::sqrt(std::numbers::pi) / 2 / root * (std::erf(root) - std::erf(root * x));
  return (x - 1) * std::exp(-a) + bell;
}

}  // namespace

RadialShape radial_shape_from(std::string_view name) {
  if (name == "gaussian") return RadialShape::kGaussian;
  if (name == "hyper-cone") return RadialShape::kHyperCone;
  if (name == "box") return RadialShape::kBox;
  throw ParameterError("there is no filter '" + std::string(name) + "': use gaussian, hyper-cone or box");
}

double RadialFilter::weight(double r) const {
  if (r > 1) return 0;
  switch (shape) {
    case RadialShape::kGaussian:
      return std::exp(-0.5 * (r / sigma_ratio) * (r / sigma_ratio));
    case RadialShape::kHyperCone:
      return 1 - r;
    case RadialShape::kBox:
      break;
  }
  return 1;
}

double RadialFilter::plane_profile(double x) const {
  if (x < 0) return 1 - plane_profile(-x);
  if (x >= 1) return 0;
  switch (shape) {
    case RadialShape::kGaussian: {
      const double a = 0.5 / (sigma_ratio * sigma_ratio);
      return 0.5 * gaussian_beyond(a, x) / gaussian_beyond(a, 0);
    }
    case RadialShape::kHyperCone:
      return 0.5 * (1 - x) * (1 - x) * (1 - x) * (1 + x);
    case RadialShape::kBox:
      break;
  }
  return 0.25 * (1 - x) * (1 - x) * (2 + x);
}

double RadialFilter::plane_distance(double density) const {
  double low = 0;
  double high = 1;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (plane_profile(middle) > density ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace voxcarve
