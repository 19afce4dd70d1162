// Coordinates in which tolerances mean the same for models of any size.
#pragma once

#include "common/mesh/triangle_soup.h"

namespace voxcarve {

/// The model's box about its centre, its diagonal as the unit.
struct UnitFrame {
  explicit UnitFrame(const TriangleSoup& soup) {
    const Box box = bounds(soup);
    if (box.empty()) return;
    center = box.center();
    if (box.diagonal() > 0) diagonal = box.diagonal();
  }
  Point to_unit(const Point& point) const { return (point - center) / diagonal; }
  Point from_unit(const Point& point) const { return center + diagonal * point; }

  Point center = Point::Zero();
  double diagonal = 1;
};

}  // namespace voxcarve
