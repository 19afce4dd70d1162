// Generalised winding numbers [JKS13] summed over a tree after [BDS18], with the solid angle of Van Oosterom and
// Strackee, "The Solid Angle of a Plane Triangle", 1983. Differs from [BDS18] in three ways: the moments are exact
// integrals over the triangles, of which only the harmonic part is kept (the rest of a moment has no effect); a node is
// opened by a bound on its own truncation error, not by a constant ratio of distance to radius, which takes account of
// area, shape and multiplicity; and the tree is binary, halved by count, and walked without a stack.
//
// The expansion. With u = c - p for the centre c of a cluster, a point x = c + y of a triangle with normal n adds
// n . g(u + y), g(r) = r / |r|^3 = -grad(1 / |r|). The Taylor terms in y of order k = 0, 1, 2 are, in the direction
// q = u / |u|,  (n . q) / |u|^2,  -3 H[(n . q)(y . q)] / |u|^3,  15/2 H[(n . q)(y . q)^2] / |u|^4,  H the harmonic part
// of a polynomial in q, which is the polynomial less |q|^2 times its Laplacian over 6 (order 2) or 10 (order 3).
//
// The bound. The term of order k is the derivative along n of the solid harmonic |y|^(k+1) P_(k+1) / |u|^(k+2), P the
// Legendre polynomial. Its gradient is at most (k + 1) |y|^k / |u|^(k+2): with m = k + 1, it squares to
// m^2 P_m(cos t)^2 + (d/dt P_m(cos t))^2 <= m^2 by the inequality of Bernstein and Szego. For a cluster of radius R
// with S = sum of the integrals of |y|^3, s = R / |u| < 1, cutting after k = 2 is wrong by at most
// S / |u|^5 * sum over k >= 3 of (k + 1) s^(k - 3) = S / |u|^5 * (4 - 3 s) / (1 - s)^2.
#include "common/mesh/winding_number.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "common/run/errors.h"

namespace voxcarve {

namespace {

constexpr std::uint32_t kLeafSize = 8;
constexpr double kRounding = 8 * std::numeric_limits<double>::epsilon();  // relative, of a triple product
constexpr double kTurn = 4 * std::numbers::pi;                            // solid angle of one turn
// Beyond this distance, in sizes of the soup, its winding number is 0 within the least positive accuracy that makes
// sense, and powers of the distance would overflow. Clusters of less than the inverse are summed one by one.
constexpr double kFarthest = 1e60;

/// Leaves hold at least kLeafSize / 2 triangles each, but for a lone one.
std::size_t most_nodes(std::size_t triangles) {
  return 2 * (triangles / (kLeafSize / 2)) + 1;
}

/// The power of two that brings a finite `size` into [1, 2); 1 for 0.
double normalizing_scale(double size) {
  if (!(size > 0)) return 1;
  return std::ldexp(1.0, std::min(-std::ilogb(size), std::numeric_limits<double>::max_exponent - 1));
}

/// The greatest s = R / |u| for which `strength` * s^5 (4 - 3 s) / (1 - s)^2 is at most `bound`.
double opening_ratio(double strength, double bound) {
  double low = 0;
  double high = 1;
  for (int i = 0; i < 30; ++i) {
    const double s = 0.5 * (low + high);
    const double error = strength * s * s * s * s * s * (4 - 3 * s) / ((1 - s) * (1 - s));
    (error <= bound ? low : high) = s;  // not a number counts as too much
  }
  return low;
}

}  // namespace

struct WindingNumber::Builder {
  WindingNumber& result;
  double bound;  ///< on the error of a cluster
  std::vector<Corners> corners;
  std::vector<Point> centers;
  std::vector<std::uint32_t> order;

  void add_triangles(const TriangleSoup& soup, std::span<const std::int32_t> multiplicity) {
    corners.reserve(soup.triangles.size());
    centers.reserve(soup.triangles.size());
    order.reserve(soup.triangles.size());
    for (std::size_t t = 0; t < soup.triangles.size(); ++t) {
      const Triangle& triangle = soup.triangles[t];
      const double count = multiplicity.empty() ? 1 : multiplicity[t];
      if (count == 0) continue;
      const Point a = result.normalized(soup.positions[triangle[0]]);
      const Point b = result.normalized(soup.positions[triangle[1]]);
      const Point c = result.normalized(soup.positions[triangle[2]]);
      if ((b - a).cross(c - a).isZero(0)) continue;
      order.push_back(static_cast<std::uint32_t>(corners.size()));
      corners.push_back({a, b, c, count});
      centers.push_back((a + b + c) / 3);
    }
  }

  void split(std::uint32_t begin, std::uint32_t end) {
    const std::size_t node = result.nodes_.size();
    result.nodes_.push_back({.center = Point::Zero(), .first = begin, .count = end - begin});
    if (end - begin > kLeafSize) {
      Box box;
      for (std::uint32_t i = begin; i < end; ++i) box.extend(centers[order[i]]);
      Eigen::Index axis = 0;
      box.extent().maxCoeff(&axis);
      const std::uint32_t middle = begin + (end - begin) / 2;
      std::nth_element(order.begin() + begin, order.begin() + middle, order.begin() + end,
                       [&](std::uint32_t i, std::uint32_t j) {
                         return centers[i][axis] != centers[j][axis] ? centers[i][axis] < centers[j][axis] : i < j;
                       });
      split(begin, middle);
      split(middle, end);
    }
    result.nodes_[node].skip = static_cast<std::uint32_t>(result.nodes_.size());
  }

  /// Centre, radius, error bound and expansion of a node, straight from its triangles.
  void measure(Node& node, Expansion& expansion) const {
    const std::span<const Corners> triangles(result.corners_.data() + node.first, node.count);
    double mass = 0;
    Point moment = Point::Zero();
    for (const Corners& t : triangles) {
      const double weight = std::abs(t.multiplicity) * (t.b - t.a).cross(t.c - t.a).norm();
      mass += weight;
      moment += weight * (t.a + t.b + t.c) / 3;
    }
    if (mass > 0) moment /= mass;
    node.center = mass > 0 ? moment : triangles.front().a;
    double radius = 0;
    for (const Corners& t : triangles) {
      for (const Point& corner : {t.a, t.b, t.c}) radius = std::max(radius, (corner - node.center).squaredNorm());
    }
    radius = std::sqrt(radius);
    node.near_squared = std::numeric_limits<double>::infinity();
    if (!(radius > 1 / kFarthest)) return;
    double strength = 0;  // S / R^5; of a convex function the mean of the corners is at least the mean of the triangle
    for (const Corners& t : triangles) {
      const Point area = 0.5 * t.multiplicity * (t.b - t.a).cross(t.c - t.a);
      double cubes = 0;
      for (const Point& corner : {t.a, t.b, t.c}) {
        const double share = (corner - node.center).norm() / radius;
        cubes += share * share * share / 3;
      }
      strength += area.norm() * cubes / (radius * radius);
      add_moments(t, node.center, area, expansion);
    }
    keep_harmonic_part(expansion);
    const double distance = radius / opening_ratio(strength / kTurn, bound);
    node.near_squared = distance * distance;
  }

  static void add_moments(const Corners& t, const Point& center, const Point& area, Expansion& expansion) {
    const Point a = t.a - center;
    const Point b = t.b - center;
    const Point c = t.c - center;
    const Point m = (a + b + c) / 3;
    // The mean of y y^T over a triangle.
    const Eigen::Matrix3d s = (a * a.transpose() + b * b.transpose() + c * c.transpose() + 9 * m * m.transpose()) / 12;
    const Point& n = area;
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3;
      const int k = (i + 2) % 3;
      const auto at = static_cast<std::size_t>(i);
      expansion.first[at] += n[i];
      expansion.second[at] += n[i] * m[i];
      expansion.second[at + 3] += n[i] * m[j] + n[j] * m[i];
      expansion.third[at] += n[i] * s(i, i);
      expansion.third[at + 3] += n[j] * s(i, i) + 2 * n[i] * s(i, j);
      expansion.third[at + 6] += n[i] * s(j, j) + 2 * n[j] * s(i, j);
      expansion.third[9] += 2 * n[i] * s(j, k);
    }
  }

  static void keep_harmonic_part(Expansion& expansion) {
    auto& [first, second, third] = expansion;
    const double trace = (second[0] + second[1] + second[2]) / 3;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t k = (i + 2) % 3;
      // The Laplacian's coefficient of x_i comes from iii, ijj (the entry i + 6) and ikk (the entry k + 3).
      const double laplacian = (6 * third[i] + 2 * third[i + 6] + 2 * third[k + 3]) / 10;
      first[i] /= kTurn;
      second[i] = -3 / kTurn * (second[i] - trace);
      second[i + 3] *= -3 / kTurn;
      third[i] = 7.5 / kTurn * (third[i] - laplacian);
      third[i + 6] = 7.5 / kTurn * (third[i + 6] - laplacian);
      third[k + 3] = 7.5 / kTurn * (third[k + 3] - laplacian);
    }
    third[9] *= 7.5 / kTurn;
  }
};

WindingNumber::WindingNumber(const TriangleSoup& soup, std::span<const std::int32_t> multiplicity, double accuracy) {
  if (!multiplicity.empty() && multiplicity.size() != soup.triangles.size()) {
    throw InputError("winding number: " + std::to_string(multiplicity.size()) + " multiplicities for " +
                     std::to_string(soup.triangles.size()) + " triangles");
  }
  if (!(accuracy > 0)) throw ParameterError("winding number: the accuracy must be positive");
  if (soup.empty()) return;
  const Box box = bounds(soup);
  center_ = box.center();
  scale_ = normalizing_scale(box.extent().maxCoeff());
  Builder builder{*this, kClusterShare * accuracy, {}, {}, {}};
  builder.add_triangles(soup, multiplicity);
  if (builder.corners.empty()) return;
  nodes_.reserve(most_nodes(builder.order.size()));
  builder.split(0, static_cast<std::uint32_t>(builder.order.size()));
  builder.centers = {};
  corners_.reserve(builder.order.size());
  for (const std::uint32_t triangle : builder.order) corners_.push_back(builder.corners[triangle]);
  builder.corners = {};
  expansions_.resize(nodes_.size());
  for (std::size_t i = 0; i < nodes_.size(); ++i) builder.measure(nodes_[i], expansions_[i]);
}

double WindingNumber::turns(const Corners& triangle, const Point& point) {
  const Point a = triangle.a - point;
  const Point b = triangle.b - point;
  const Point c = triangle.c - point;
  const Point ab = triangle.b - triangle.a;  // differences of the corners keep the digits of small triangles
  const Point ac = triangle.c - triangle.a;
  const double numerator = a.dot(ab.cross(ac));
  const double la = a.norm();
  const double lb = b.norm();
  const double lc = c.norm();
  const double product = la * lb * lc;
  const double denominator = product + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
  // On the triangle, its sides or its corners, where the quotient is rounding: the mean of the two sides.
  if (denominator <= kRounding * product && std::abs(numerator) <= kRounding * la * ab.norm() * ac.norm()) return 0;
  return triangle.multiplicity * std::atan2(numerator, denominator) / (kTurn / 2);
}

double WindingNumber::at(const Point& point) const {
  const Point p = normalized(point);
  if (!(p.cwiseAbs().maxCoeff() < kFarthest)) return 0;
  double sum = 0;
  for (std::size_t i = 0; i < nodes_.size();) {
    const Node& node = nodes_[i];
    const Point u = node.center - p;
    const double squared = u.squaredNorm();
    if (squared > node.near_squared) {
      const auto& [first, second, third] = expansions_[i];
      const double inverse = 1 / std::sqrt(squared);
      const double x = inverse * u[0];
      const double y = inverse * u[1];
      const double z = inverse * u[2];
      const double xx = x * x;
      const double yy = y * y;
      const double zz = z * z;
      const double one = first[0] * x + first[1] * y + first[2] * z;
      const double two =
          second[0] * xx + second[1] * yy + second[2] * zz + second[3] * x * y + second[4] * y * z + second[5] * z * x;
      const double three = xx * (third[0] * x + third[3] * y + third[8] * z) +
                           yy * (third[1] * y + third[4] * z + third[6] * x) +
                           zz * (third[2] * z + third[5] * x + third[7] * y) + third[9] * x * y * z;
      sum += inverse * inverse * (one + inverse * (two + inverse * three));
      i = node.skip;
    } else if (node.skip == i + 1) {
      for (std::uint32_t t = node.first; t < node.first + node.count; ++t) sum += turns(corners_[t], p);
      ++i;
    } else {
      ++i;
    }
  }
  return sum;
}

std::uint64_t WindingNumber::memory_estimate(std::size_t triangles) {
  return (2 * sizeof(Corners) + sizeof(Point) + sizeof(std::uint32_t)) * triangles +
         (sizeof(Node) + sizeof(Expansion)) * most_nodes(triangles);
}

}  // namespace voxcarve
