// Building blocks of implicit solids: signed clearances, and how they are combined.
//
// A signed clearance s of a set A is a function with this property: membership in A is the same at all points closer to
// p than |s(p)|, and where s(p) is not 0, p is in A iff s(p) < 0. The signed distance is the largest one. The property
// passes on to the operations of CSG:
//   complement     -s     trivially;
//   intersection   max    where it is negative, p is in every set and stays in all of them within the least |s|; where
//                         it is positive, it belongs to a set that p is not in, and stays out of, so that p stays out
//                         of the intersection;
//   union          min    by complements.
// So |s| is a lower bound of the distance to the boundary of whatever was combined, though beside the edges of an
// intersection, and where parts of a union overlap, it may be less than that distance.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <memory>

#include "common/mesh/implicit_solid.h"

namespace voxcarve {

/// An interval [low, high]. Exact.
inline double slab_clearance(double coordinate, double low, double high) {
  return std::max(low - coordinate, coordinate - high);
}

/// The intersection of two sets of which one is a matter of some coordinates and the other of the others, from their
/// signed distances: the exact distance also where the nearest point is on the edge.
inline double extruded_clearance(double across, double along) {
  if (across > 0 && along > 0) return std::sqrt(across * across + along * along);
  return std::max(across, along);
}

/// A closed box. Exact.
double box_clearance(const Point& p, const Box& box);

/// A prism between the planes `low` and `high` of `axis`. Its section, in the plane of the axes u = axis + 1 and
/// v = axis + 2 (mod 3), is what lies within `radius` of a segment that reaches `half_length` to either side of
/// `center` along v: a disk for 0, else the shape of a slot.
struct RoundPrism {
  int axis = 2;
  Eigen::Vector2d center = Eigen::Vector2d::Zero();
  double half_length = 0;
  double radius = 0;
  double low = 0;
  double high = 0;

  /// Squared distance of the section's segment from p.
  double squared_offset(const Point& p) const {
    const double u = p[(axis + 1) % 3] - center[0];
    const double v = std::max(0.0, std::abs(p[(axis + 2) % 3] - center[1]) - half_length);
    return u * u + v * v;
  }
  /// With its boundary, or without.
  bool holds(const Point& p) const { return p[axis] >= low && p[axis] <= high && squared_offset(p) <= radius * radius; }
  bool holds_within(const Point& p) const {
    return p[axis] > low && p[axis] < high && squared_offset(p) < radius * radius;
  }
  /// Exact, of both.
  double clearance(const Point& p) const {
    return extruded_clearance(std::sqrt(squared_offset(p)) - radius, slab_clearance(p[axis], low, high));
  }
  Box bounds() const;
};

/// The angle of (x, y) from the x axis, counterclockwise, in turns: 0 <= turns <= 1. To about 1e-16, and the same bits
/// on every machine, since it uses no function of the mathematics library. (x, y) is not (0, 0).
double turns_of(double x, double y);

/// The bound that ImplicitSolid::clearance gives, from a signed clearance that was computed with a relative error of up
/// to 1e-12 of itself and of the solid's diagonal.
inline double guarded_clearance(double signed_clearance, double diagonal) {
  constexpr double kRounding = 1e-12;
  return std::max(0.0, std::abs(signed_clearance) * (1 - kRounding) - kRounding * diagonal);
}

/// The model of a shape that has `bool inside(const Point&) const`, `double signed_clearance(const Point&) const` and
/// `Box bounds() const`.
template <class Shape>
ImplicitSolid implicit_solid(Shape shape) {
  const auto shared = std::make_shared<const Shape>(std::move(shape));
  const Box box = shared->bounds();
  return {[shared](const Point& p) { return shared->inside(p); }, box,
          [shared, diagonal = box.diagonal()](const Point& p) {
            return guarded_clearance(shared->signed_clearance(p), diagonal);
          }};
}

}  // namespace voxcarve
