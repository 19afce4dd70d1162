// What the tests of the implicit solids check again and again.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "common/mesh/implicit_solid.h"
#include "common/mesh/winding_number.h"
#include "tests/support/shapes.h"

namespace voxcarve::test {

/// Random numbers and points that are the same with every standard library.
class RandomPoints {
 public:
  explicit RandomPoints(std::uint64_t seed) : generator_(seed) {}

  /// Of [0, 1).
  double share() { return static_cast<double>(generator_() >> 11U) * 0x1p-53; }
  Point in(const Box& box) {
    const double x = share();
    const double y = share();
    return box.lower + Point(x, y, share()).cwiseProduct(box.extent());
  }
  /// Of length 1, all directions alike.
  Point direction() {
    for (;;) {
      const Point p = in({Point::Constant(-1), Point::Constant(1)});
      const double length = p.norm();
      if (length > 0.1 && length < 1) return p / length;
    }
  }

 private:
  std::mt19937_64 generator_;
};

/// `box`, larger by a share of its diagonal on every side.
inline Box grown(const Box& box, double share) {
  const Point margin = Point::Constant(share * box.diagonal());
  return {box.lower - margin, box.upper + margin};
}

/// A point of the boundary, to the last bits, between a point inside and one outside.
inline Point crossing(const ImplicitSolid& solid, Point inside, Point outside) {
  for (int i = 0; i < 60; ++i) {
    const Point middle = 0.5 * (inside + outside);
    (solid.inside(middle) ? inside : outside) = middle;
  }
  return outside;
}

/// Points in and around the box, and points at all small distances from the boundary.
inline std::vector<Point> probes(const ImplicitSolid& solid, std::size_t count, std::uint64_t seed) {
  RandomPoints random(seed);
  std::vector<Point> points;
  Point inside = Point::Zero();
  Point outside = solid.box.upper + Point::Ones();
  for (std::size_t i = 0; i < count; ++i) {
    points.push_back(random.in(grown(solid.box, 0.1)));
    (solid.inside(points.back()) ? inside : outside) = points.back();
    if (!solid.inside(inside)) continue;
    const double distance = solid.box.diagonal() * std::pow(10.0, -1 - 8 * random.share());
    points.push_back(crossing(solid, inside, outside) + distance * random.direction());
  }
  return points;
}

/// All points closer to p than clearance(p) have p's class, and the clearance says something about most points.
inline void expect_clearance_is_valid(const ImplicitSolid& solid, std::size_t count) {
  RandomPoints random(11);
  const std::vector<Point> points = probes(solid, count, 7);
  std::size_t silent = 0;
  std::size_t wrong = 0;
  for (const Point& p : points) {
    const double clearance = solid.clearance(p);
    ASSERT_GE(clearance, 0);
    silent += clearance == 0 ? 1 : 0;
    const bool inside = solid.inside(p);
    for (int i = 0; i < 8; ++i) {
      // Mostly near the ball's surface, where it breaks first.
      const Point q = p + (1 - 1e-9) * std::cbrt(random.share()) * clearance * random.direction();
      wrong += solid.inside(q) != inside ? 1 : 0;
    }
  }
  EXPECT_EQ(wrong, 0U);
  EXPECT_LT(silent, points.size() / 100);
}

/// Nothing is inside beyond the box, on any of its sides.
inline void expect_box_holds(const ImplicitSolid& solid, std::size_t count) {
  RandomPoints random(3);
  const Box around = grown(solid.box, 0.05);
  std::size_t beyond = 0;
  for (std::size_t i = 0; i < count; ++i) {
    Point p = random.in(around);
    const auto axis = static_cast<Eigen::Index>(i % 3);
    // Just beyond, or up to the end of the margin.
    const double margin = i % 2 == 0 ? 0 : around.upper[axis] - solid.box.upper[axis];
    const double step = 1e-9 * solid.box.diagonal() + random.share() * margin;
    p[axis] = i % 12 < 6 ? solid.box.lower[axis] - step : solid.box.upper[axis] + step;
    beyond += solid.inside(p) ? 1 : 0;
  }
  EXPECT_EQ(beyond, 0U);
}

/// The share of the box that the solid fills, times its volume, is `expected` within five standard deviations of a
/// share of `count` samples.
inline void expect_volume(const ImplicitSolid& solid, double expected, std::size_t count) {
  RandomPoints random(5);
  std::size_t inside = 0;
  for (std::size_t i = 0; i < count; ++i) inside += solid.inside(random.in(solid.box)) ? 1 : 0;
  const double box = solid.box.extent().prod();
  const double share = expected / box;
  const double deviation = std::sqrt(share * (1 - share) / static_cast<double>(count));
  EXPECT_NEAR(static_cast<double>(inside) / static_cast<double>(count), share, 5 * deviation);
}

/// The surface winds once around what is inside and not around what is outside, farther than `tolerance` from the
/// boundary, which is as far as the surface may be from it.
inline void expect_surface_agrees(const ImplicitSolid& solid, const TriangleSoup& surface, double tolerance,
                                  std::size_t count) {
  const WindingNumber winding(surface);
  std::size_t compared = 0;
  std::size_t inside = 0;
  std::size_t wrong = 0;
  for (const Point& p : probes(solid, count, 13)) {
    if (solid.clearance(p) <= tolerance) continue;
    ++compared;
    inside += solid.inside(p) ? 1 : 0;
    wrong += std::lround(winding.at(p)) != (solid.inside(p) ? 1 : 0) ? 1 : 0;
  }
  EXPECT_EQ(wrong, 0U);
  EXPECT_GT(compared, count / 2);
  EXPECT_GT(inside, count / 50);
}

}  // namespace voxcarve::test
