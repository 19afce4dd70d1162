// Where lines run inside of a shape.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "common/mesh/line_stabber.h"
#include "common/mesh/triangle_soup.h"

namespace voxcarve {

/// A piece of a line, by coordinates along it, in model units.
struct Interval {
  double begin = 0;
  double end = 0;
};

/// The solid {winding number != 0} of a soup, {|generalised winding number| > 1/2} of an open one; see
/// symmetric_difference.h. Queries are const and may run on several threads at once.
class InsideIntervals {
 public:
  explicit InsideIntervals(const TriangleSoup& soup);

  /// Edges of the boundary chain, with multiplicity; 0 for a closed shape.
  std::int64_t boundary_edges() const { return static_cast<std::int64_t>(boundary_.size()); }

  /// Prepares lines along coordinate axis 0, 1 or 2.
  void prepare(int axis);

  /// The parts, in order, of a line along `axis` that lie inside; u and v are the coordinates on the next two axes in
  /// cyclic order. `crossings` is scratch space.
  void along_line(int axis, double u, double v, std::vector<Crossing>& crossings, std::vector<Interval>& out) const;

  /// Evaluations of the cone's solid angle that a line may cost.
  static constexpr std::int64_t kEvaluationsALine = 120;

 private:
  struct Edge {
    Point from, to;
  };
  double cone_winding(const Point& point) const;
  void split_smooth_part(const StabFrame& frame, double u, double v, int crossed, const Interval& part,
                         std::vector<Interval>& out) const;

  TriangleSoup closed_;         ///< the soup and the cone over its boundary, vertices of equal position merged
  Box box_;                     ///< of the soup alone
  std::vector<Edge> boundary_;  ///< of the soup as a chain
  Point apex_ = Point::Zero();
  std::array<std::unique_ptr<LineStabber>, 3> stabbers_;
};

}  // namespace voxcarve
