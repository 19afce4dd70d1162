// A part as it comes from a machine shop: boxes, with bosses on them and bores and slots through them, as a surface and
// as an implicit solid.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/mesh/implicit_solid.h"
#include "common/mesh/models/implicit_shapes.h"
#include "common/mesh/triangle_soup.h"

namespace voxcarve {

/// A bore or slot that leads from the face at `high` along `axis` to the opposite face at `low`, straight through. Both
/// faces are flat and free within `frame` of the centre, and so is the space before them for as far as its boss and a
/// quarter of its length reach. Lengths are in model units; u and v are the axes after `axis`, cyclically.
struct Passage {
  int axis = 2;
  Eigen::Vector2d center = Eigen::Vector2d::Zero();  ///< u, v
  Eigen::Vector2d frame = Eigen::Vector2d::Zero();   ///< half sizes of the rectangle of either face that it takes
  double low = 0;
  double high = 0;
  double radius = 0;
  double half_length = 0;  ///< of a slot, along v, without its round ends; 0 is a bore
  int outer_side = 1;      ///< the boss and the counterbore, if any, are at `high` for 1, at `low` for -1

  double boss_radius = 0;  ///< more than the counterbore's, or none
  double boss_height = 0;
  double counterbore_radius = 0;  ///< more than `radius`, or none
  double counterbore_depth = 0;   ///< from the boss's end
};

/// The union of the closed boxes and of the bosses, less the bores.
struct MachinedPart {
  std::vector<Box> boxes;  ///< they touch or overlap in faces, not in edges or vertices alone
  std::vector<Passage> passages;
};

/// All lengths times `factor`.
MachinedPart scaled(MachinedPart part, double factor);

/// A 2-manifold; the genus is that of the boxes' union and one a passage. Quarters of circles are `arc_segments` chords
/// with their ends on the circle, so that bores are a little too narrow and bosses too slim. Throws InputError when a
/// passage's frame is not on free faces.
TriangleSoup surface_of(const MachinedPart& part, int arc_segments);

/// Its box is that of the boxes and bosses.
ImplicitSolid solid_of(const MachinedPart& part);

}  // namespace voxcarve
