// The construction follows the description of Haines, "A Proposal for Standard Graphics Environments", IEEE CG&A 7(11),
// 1987.
#include "common/mesh/models/sphereflake.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace voxcarve {

namespace {

constexpr std::size_t kChildren = 9;

/// Six directions around the equator and three above, 60 degrees from their neighbours: the nine of a face-centred
/// cubic packing's twelve contacts that do not point back to the parent.
std::array<Point, kChildren> child_directions(const Point& axis) {
  Eigen::Index least = 0;
  axis.cwiseAbs().minCoeff(&least);
  const Point helper = Point::Unit(least);
  const Point u = (helper - helper.dot(axis) * axis).normalized();
  const Point v = axis.cross(u);
  std::array<Point, kChildren> directions;
  for (int i = 0; i < 6; ++i) {
    const double angle = std::numbers::pi * i / 3;
    directions[static_cast<std::size_t>(i)] = std::cos(angle) * u + std::sin(angle) * v;
  }
  for (int i = 0; i < 3; ++i) {
    const double angle = std::numbers::pi * (1 + 4 * i) / 6;  // between two of the equator's
    const Point flat = std::cos(angle) * u + std::sin(angle) * v;
    directions[static_cast<std::size_t>(6 + i)] = std::sqrt(1.0 / 3) * flat + std::sqrt(2.0 / 3) * axis;
  }
  return directions;
}

/// The ball around `members` whose centre is the best of 17 on the line from the first's centre to the mean of all:
/// descendants stand to one side. Grown by more than rounding, so that no member leaves it.
Sphereflake::Ball ball_around(std::span<const Sphereflake::Ball> members) {
  Point mean = Point::Zero();
  for (const Sphereflake::Ball& member : members) mean += member.center;
  mean /= static_cast<double>(members.size());
  constexpr int kSteps = 16;
  Sphereflake::Ball best{Point::Zero(), std::numeric_limits<double>::infinity()};
  for (int step = 0; step <= kSteps; ++step) {
    const Point center = members[0].center + 2.0 * step / kSteps * (mean - members[0].center);
    double radius = 0;
    for (const Sphereflake::Ball& member : members) {
      radius = std::max(radius, (member.center - center).norm() + member.radius);
    }
    if (radius < best.radius) best = {center, radius};
  }
  best.radius *= 1 + 1e-12;
  return best;
}

}  // namespace

Sphereflake::Sphereflake(int depth, double radius) : balls_{{Point::Zero(), radius}} {
  std::vector<Point> axes = {Point::UnitZ()};  // away from the parent
  for (std::size_t generation = 0, next = 0; generation < static_cast<std::size_t>(depth); ++generation) {
    first_leaf_ = balls_.size();
    for (; next < first_leaf_; ++next) {
      const Ball parent = balls_[next];  // a copy: the vector grows below
      const double child_radius = parent.radius / 3;
      for (const Point& direction : child_directions(axes[next])) {
        balls_.push_back({parent.center + (parent.radius + child_radius) * direction, child_radius});
        axes.push_back(direction);
      }
    }
  }
  families_ = balls_;
  for (std::size_t i = first_leaf_; i-- > 0;) {
    std::array<Ball, kChildren + 1> members;
    members[0] = balls_[i];
    for (std::size_t child = 1; child <= kChildren; ++child) members[child] = families_[kChildren * i + child];
    families_[i] = ball_around(members);
  }
}

bool Sphereflake::inside(const Point& p) const {
  return balls_[0].holds(p) || (families_[0].holds(p) && family_holds(0, p));
}

/// Whether a descendant of `ball` holds p.
bool Sphereflake::family_holds(std::size_t ball, const Point& p) const {
  if (ball >= first_leaf_) return false;
  const std::size_t first = kChildren * ball + 1;
  for (std::size_t child = first; child < first + kChildren; ++child) {
    if (!families_[child].holds(p)) continue;
    if (balls_[child].holds(p) || family_holds(child, p)) return true;
  }
  return false;
}

double Sphereflake::signed_clearance(const Point& p) const {
  double least = balls_[0].signed_distance(p);
  improve(0, p, least);
  return least;
}

/// Lowers `least` to the least signed distance of the descendants of `ball` where that is less. A family whose ball is
/// no nearer has no member that is.
void Sphereflake::improve(std::size_t ball, const Point& p, double& least) const {
  if (ball >= first_leaf_) return;
  const std::size_t first = kChildren * ball + 1;
  std::array<double, kChildren> at_least;
  for (std::size_t i = 0; i < kChildren; ++i) {
    at_least[i] = families_[first + i].signed_distance(p);
    if (at_least[i] < least) least = std::min(least, balls_[first + i].signed_distance(p));
  }
  for (std::size_t i = 0; i < kChildren; ++i) {
    if (at_least[i] < least) improve(first + i, p, least);
  }
}

Box Sphereflake::bounds() const {
  Box box;
  for (const Ball& ball : balls_) {
    box.extend(Box{ball.center - Point::Constant(ball.radius), ball.center + Point::Constant(ball.radius)});
  }
  return box;
}

}  // namespace voxcarve
