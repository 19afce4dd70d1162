// A solid given by a function.
#pragma once

#include <functional>

#include "common/mesh/triangle_soup.h"

namespace voxcarve {

/// A point-membership function with a box that holds the whole solid. Both functions are callable from several threads
/// at once and depend on nothing but the point.
struct ImplicitSolid {
  std::function<bool(const Point&)> inside;
  Box box;
  /// A lower bound of the distance, in model units, from a point to the solid's boundary, 0 or more on either side:
  /// all points closer to `p` than clearance(p) are inside iff `p` is. So a block of samples has one class when the
  /// clearance of its centre exceeds half its diagonal. May be empty: nothing is known.
  std::function<double(const Point&)> clearance = {};
};

}  // namespace voxcarve
