// Certified floating point in the manner of [She97]: a value is believed where it exceeds a bound of its error. Differs
// in what is evaluated: mostly the projection onto a direction that need not be exact, as any that separates will do.
//
// In what follows u = 2^-52, the most that one operation is off by in any rounding mode, relative to its result where
// that is not subnormal; where it is, the operation is off by less than 2^-1074 if it is a product, and exact if it is
// a sum or a difference. Nothing may overflow, which rounds to a finite number in some modes: so nothing is said of
// larger triangles than kLimit.
#include "common/mesh/triangle_separation.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace voxcarve {

namespace {

/// Terms of a projection m . (x - a) go through a difference, a product and two sums: together they are off by at most
/// 4u (1 + 4u) times the sum of |m| |x - a| over the axes, which itself is computed as well as that, and by three
/// underflows. 2^-49 = 8u.
constexpr double kProjectionError = 0x1p-49;
constexpr double kProjectionUnderflow = 0x1p-1070;

/// Terms of degree four go through four differences, three products and five sums at the most, so they are off by
/// 12u (1 + 12u) times the sum of their sizes, which is computed as well as that. 2^-48 = 16u. While differences are
/// below 2^240, a product that underflows adds less than 2^-1074 times 2^482, and there are less than forty.
constexpr double kQuarticError = 0x1p-48;
constexpr double kQuarticUnderflow = 0x1p-550;
constexpr double kLimit = 0x1p240;

double largest(const Point& p) {
  return p.cwiseAbs().maxCoeff();
}

double sum_of_sizes(const Point& p) {
  return p.cwiseAbs().sum();
}

/// Of triangles with one common vertex, given the others seen from it: whether the first triangle's are on one side of
/// a plane through the vertex and the second's on the other, strictly.
bool separated_at_vertex(const Point& p0, const Point& p1, const Point& q0, const Point& q1, double size,
                         const Point& direction) {
  if (!(size < kLimit)) return false;
  const double bound = kProjectionError * (sum_of_sizes(direction) * size) + kProjectionUnderflow;
  return std::max(direction.dot(p0), direction.dot(p1)) < -bound &&
         std::min(direction.dot(q0), direction.dot(q1)) > bound;
}

bool apart_at_vertex(const CorneredTriangle& first, std::size_t i, const CorneredTriangle& second, std::size_t j) {
  const Point& vertex = first.corners[i];
  const Point p0 = first.corners[(i + 1) % 3] - vertex;
  const Point p1 = first.corners[(i + 2) % 3] - vertex;
  const Point q0 = second.corners[(j + 1) % 3] - vertex;
  const Point q1 = second.corners[(j + 2) % 3] - vertex;
  const double size = std::max(first.size, second.size);
  // From the middle of the one to the middle of the other, as seen from the vertex; then so that each corner counts
  // alike, be it far or near, for slivers.
  const Point p = p0 + p1;
  const Point q = q0 + q1;
  if (separated_at_vertex(p0, p1, q0, q1, size, largest(p) * q - largest(q) * p)) return true;
  const Point p_middle = p0 / p0.norm() + p1 / p1.norm();
  const Point q_middle = q0 / q0.norm() + q1 / q1.norm();
  return separated_at_vertex(p0, p1, q0, q1, size, p_middle.norm() * q_middle - q_middle.norm() * p_middle);
}

/// Triangles with a common edge meet in more iff they lie in one plane on one side of it.
bool apart_at_edge(const Point& start, const Point& end, const Point& first, const Point& second) {
  const Point e = end - start;
  const Point p = first - start;
  const Point q = second - start;
  if (!(std::max(std::max(largest(e), largest(p)), largest(q)) < kLimit)) return false;
  // The product of what p and q have across the edge, times the square of the edge.
  const double square = e.dot(e);
  const double across = square * p.dot(q) - e.dot(p) * e.dot(q);
  const Point e_size = e.cwiseAbs();
  const Point p_size = p.cwiseAbs();
  const Point q_size = q.cwiseAbs();
  const double across_size = square * p_size.dot(q_size) + e_size.dot(p_size) * e_size.dot(q_size);
  if (across < -(kQuarticError * across_size + kQuarticUnderflow)) return true;
  const double volume = e.dot(p.cross(q));
  const double volume_size = e_size[0] * (p_size[1] * q_size[2] + p_size[2] * q_size[1]) +
                             e_size[1] * (p_size[2] * q_size[0] + p_size[0] * q_size[2]) +
                             e_size[2] * (p_size[0] * q_size[1] + p_size[1] * q_size[0]);
  return std::abs(volume) > kQuarticError * volume_size + kQuarticUnderflow;
}

/// Of triangles without a common vertex, all seen from the same point: whether their projections onto a direction are
/// apart.
bool separated(const std::array<Point, 3>& p, const std::array<Point, 3>& q, double size, const Point& direction) {
  if (!(size < kLimit)) return false;
  const double bound = kProjectionError * (sum_of_sizes(direction) * size) + kProjectionUnderflow;
  const double p0 = direction.dot(p[0]);
  const double p1 = direction.dot(p[1]);
  const double p2 = direction.dot(p[2]);
  const double q0 = direction.dot(q[0]);
  const double q1 = direction.dot(q[1]);
  const double q2 = direction.dot(q[2]);
  const double gap = 4 * bound;  // the difference, too, is rounded
  return std::min(std::min(q0, q1), q2) - std::max(std::max(p0, p1), p2) > gap ||
         std::min(std::min(p0, p1), p2) - std::max(std::max(q0, q1), q2) > gap;
}

bool apart_in_space(const CorneredTriangle& first, const CorneredTriangle& second) {
  const Point& origin = first.corners[0];
  const std::array<Point, 3> p{Point::Zero(), first.corners[1] - origin, first.corners[2] - origin};
  const std::array<Point, 3> q{second.corners[0] - origin, second.corners[1] - origin, second.corners[2] - origin};
  const double size =
      std::max(std::max(largest(p[1]), largest(p[2])), std::max(std::max(largest(q[0]), largest(q[1])), largest(q[2])));
  return separated(p, q, size, (q[0] + q[1] + q[2]) - (p[1] + p[2])) || separated(p, q, size, p[1].cross(p[2])) ||
         separated(p, q, size, (q[1] - q[0]).cross(q[2] - q[0]));
}

}  // namespace

CorneredTriangle::CorneredTriangle(const TriangleSoup& soup, const Triangle& triangle)
    : corners{soup.positions[triangle[0]], soup.positions[triangle[1]], soup.positions[triangle[2]]},
      size(std::max(
          {largest(corners[1] - corners[0]), largest(corners[2] - corners[1]), largest(corners[0] - corners[2])})),
      vertices(triangle) {}

bool certainly_apart(const CorneredTriangle& first, const CorneredTriangle& second) {
  std::size_t common = 0;
  std::size_t sum_first = 0;  // of the corners that are common
  std::size_t sum_second = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      const std::size_t same = first.vertices[i] == second.vertices[j] ? 1 : 0;
      common += same;
      sum_first += same * i;
      sum_second += same * j;
    }
  }
  if (common == 0) return apart_in_space(first, second);
  if (common == 1) return apart_at_vertex(first, sum_first, second, sum_second);
  if (common == 3) return false;        // the same triangle, which is no crossing; the exact test knows
  const std::size_t i = 3 - sum_first;  // the corners that are not common
  const std::size_t j = 3 - sum_second;
  return apart_at_edge(first.corners[(i + 1) % 3], first.corners[(i + 2) % 3], first.corners[i], second.corners[j]);
}

}  // namespace voxcarve
