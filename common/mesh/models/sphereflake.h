// The balls of the model `sphereflake`.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "common/mesh/triangle_soup.h"

namespace voxcarve {

/// A ball about the origin that carries nine of a third of its radius, six around its equator and three above, each of
/// which carries nine in turn, turned away from their carriers. Each touches its carrier; they overlap nowhere.
class Sphereflake {
 public:
  struct Ball {
    Point center;
    double radius;
    bool holds(const Point& p) const { return (p - center).squaredNorm() <= radius * radius; }
    double signed_distance(const Point& p) const { return (p - center).norm() - radius; }
  };

  /// `depth` generations of children: (9^(depth + 1) - 1) / 8 balls.
  Sphereflake(int depth, double radius);

  /// One generation after the other.
  std::span<const Ball> balls() const { return balls_; }

  /// In one of the closed balls: as if all were asked, but only some are.
  bool inside(const Point& p) const;

  /// The least signed distance of all balls. Outside, that is the distance from the union; inside it is the depth in
  /// the ball that holds p the deepest, and as balls do not overlap, the only one.
  double signed_clearance(const Point& p) const;

  /// Tight.
  Box bounds() const;

 private:
  bool family_holds(std::size_t ball, const Point& p) const;
  void improve(std::size_t ball, const Point& p, double& least) const;

  std::vector<Ball> balls_;     ///< the children of ball i are 9 i + 1 ... 9 i + 9
  std::vector<Ball> families_;  ///< a ball around each ball and its descendants
  std::size_t first_leaf_ = 0;
};

}  // namespace voxcarve
