// What an arrangement must be, by slow and obvious means: every pair of triangles by exact integers, and winding
// numbers by adding up solid angles.
#pragma once

#include <gmpxx.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <numbers>
#include <numeric>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "common/mesh/arrangement.h"
#include "common/mesh/triangle_soup.h"

namespace voxcarve::test {

/// The numbers times one power of two that makes all of them integers.
inline std::vector<mpz_class> as_integers(std::initializer_list<double> values) {
  constexpr int kDigits = 53;
  int least = 0;
  for (const double value : values) {
    int exponent = 0;
    if (std::frexp(value, &exponent) != 0) least = std::min(least, exponent - kDigits);
  }
  std::vector<mpz_class> integers;
  for (const double value : values) {
    int exponent = 0;
    const double mantissa = std::ldexp(std::frexp(value, &exponent), kDigits);
    integers.emplace_back(mantissa);
    if (mantissa != 0) integers.back() <<= static_cast<mp_bitcnt_t>(exponent - kDigits - least);
  }
  return integers;
}

/// Sign of det(b - a, c - a, d - a).
inline int exact_orientation(const Point& a, const Point& b, const Point& c, const Point& d) {
  if (a == b || a == c || a == d || b == c || b == d || c == d) return 0;
  const Point u = b - a;
  const Point v = c - a;
  const Point w = d - a;
  // The determinant has a relative error far below 1e-13 of the sum of its terms' sizes.
  const double value = u.dot(v.cross(w));
  double size = 0;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    const int k = (i + 2) % 3;
    size += std::abs(u[i]) * (std::abs(v[j] * w[k]) + std::abs(v[k] * w[j]));
  }
  // Differences of coordinates are rounded too: relative to the differences themselves, within one unit each.
  if (size > 1e-200 && std::abs(value) > 1e-13 * size) return value > 0 ? 1 : -1;
  const auto z = as_integers({a[0], a[1], a[2], b[0], b[1], b[2], c[0], c[1], c[2], d[0], d[1], d[2]});
  std::array<mpz_class, 9> m;
  for (std::size_t i = 0; i < 9; ++i) m[i] = z[i + 3] - z[i % 3];
  const mpz_class det =
      m[0] * (m[4] * m[8] - m[5] * m[7]) - m[1] * (m[3] * m[8] - m[5] * m[6]) + m[2] * (m[3] * m[7] - m[4] * m[6]);
  return sgn(det);
}

/// Sign of the area of a triangle in the projection along an axis.
inline int exact_turn(const Point& a, const Point& b, const Point& c, int axis) {
  const int u = (axis + 1) % 3;
  const int v = (axis + 2) % 3;
  const double left = (b[u] - a[u]) * (c[v] - a[v]);
  const double right = (b[v] - a[v]) * (c[u] - a[u]);
  const double size = std::abs(left) + std::abs(right);
  if (size > 1e-200 && std::abs(left - right) > 1e-13 * size) return left > right ? 1 : -1;
  const auto z = as_integers({a[u], a[v], b[u], b[v], c[u], c[v]});
  const mpz_class det = (z[2] - z[0]) * (z[5] - z[1]) - (z[3] - z[1]) * (z[4] - z[0]);
  return sgn(det);
}

using Corners = std::array<Point, 3>;

inline Corners corners_of(const TriangleSoup& soup, std::size_t t) {
  return {soup.positions[soup.triangles[t][0]], soup.positions[soup.triangles[t][1]],
          soup.positions[soup.triangles[t][2]]};
}

inline bool exactly_collinear(const Corners& t) {
  return exact_turn(t[0], t[1], t[2], 0) == 0 && exact_turn(t[0], t[1], t[2], 1) == 0 &&
         exact_turn(t[0], t[1], t[2], 2) == 0;
}

inline bool one_sided(int a, int b, int c) {
  return std::min({a, b, c}) >= 0 || std::max({a, b, c}) <= 0;
}

/// Whether closed segments of one plane have a point in common.
inline bool segments_meet(const Point& p, const Point& q, const Point& a, const Point& b, int axis) {
  const int pa = exact_turn(p, q, a, axis);
  const int pb = exact_turn(p, q, b, axis);
  const int ap = exact_turn(a, b, p, axis);
  const int aq = exact_turn(a, b, q, axis);
  if (pa == 0 && pb == 0) {  // on a line: the ranges overlap in every coordinate
    return (p.cwiseMin(q).array() <= a.cwiseMax(b).array()).all() &&
           (a.cwiseMin(b).array() <= p.cwiseMax(q).array()).all();
  }
  return pa * pb <= 0 && ap * aq <= 0;
}

/// Whether a closed segment and a closed triangle that is not collinear have a point in common.
inline bool segment_meets_triangle(const Point& p, const Point& q, const Corners& t) {
  const int sp = exact_orientation(t[0], t[1], t[2], p);
  const int sq = exact_orientation(t[0], t[1], t[2], q);
  if (sp * sq > 0) return false;
  if (sp != 0 || sq != 0) {
    return one_sided(exact_orientation(p, q, t[0], t[1]), exact_orientation(p, q, t[1], t[2]),
                     exact_orientation(p, q, t[2], t[0]));
  }
  int axis = 0;
  while (exact_turn(t[0], t[1], t[2], axis) == 0) ++axis;
  for (std::size_t i = 0; i < 3; ++i)
    if (segments_meet(p, q, t[i], t[(i + 1) % 3], axis)) return true;
  return one_sided(exact_turn(t[0], t[1], p, axis), exact_turn(t[1], t[2], p, axis), exact_turn(t[2], t[0], p, axis));
}

/// Whether two triangles meet elsewhere than in common vertices and whole common edges. By cases of what they share:
/// without a common vertex, an edge of one meets the other; with one, the edge opposite to it of one meets the other;
/// with two, they lie in one plane on one side of the common edge; and never may all three be common.
inline bool forbidden_pair(const TriangleSoup& soup, std::size_t first, std::size_t second) {
  const Corners s = corners_of(soup, first);
  const Corners t = corners_of(soup, second);
  const auto in = [](std::uint32_t v, const Triangle& u) { return v == u[0] || v == u[1] || v == u[2]; };
  std::vector<std::size_t> own_s;
  std::vector<std::size_t> own_t;
  for (std::size_t i = 0; i < 3; ++i) {
    if (!in(soup.triangles[first][i], soup.triangles[second])) own_s.push_back(i);
    if (!in(soup.triangles[second][i], soup.triangles[first])) own_t.push_back(i);
  }
  if (own_s.empty()) return true;
  if (own_s.size() == 1) {
    const Point& p = s[(own_s[0] + 1) % 3];
    const Point& q = s[(own_s[0] + 2) % 3];
    if (exact_orientation(s[0], s[1], s[2], t[own_t[0]]) != 0) return false;
    int axis = 0;
    while (exact_turn(s[0], s[1], s[2], axis) == 0) ++axis;
    return exact_turn(p, q, s[own_s[0]], axis) == exact_turn(p, q, t[own_t[0]], axis);
  }
  if (own_s.size() == 2) {
    return segment_meets_triangle(s[own_s[0]], s[own_s[1]], t) || segment_meets_triangle(t[own_t[0]], t[own_t[1]], s);
  }
  for (std::size_t i = 0; i < 3; ++i) {
    if (segment_meets_triangle(s[i], s[(i + 1) % 3], t) || segment_meets_triangle(t[i], t[(i + 1) % 3], s)) return true;
  }
  return false;
}

/// Every pair whose boxes overlap, in order.
inline std::vector<std::array<std::uint32_t, 2>> slow_crossings(const TriangleSoup& soup) {
  std::vector<std::array<Point, 2>> boxes;
  for (std::size_t t = 0; t < soup.triangles.size(); ++t) {
    const Corners c = corners_of(soup, t);
    boxes.push_back({c[0].cwiseMin(c[1]).cwiseMin(c[2]), c[0].cwiseMax(c[1]).cwiseMax(c[2])});
  }
  std::vector<std::array<std::uint32_t, 2>> found;
  std::vector<std::uint32_t> order(boxes.size());
  std::iota(order.begin(), order.end(), 0U);
  std::sort(order.begin(), order.end(),
            [&](std::uint32_t s, std::uint32_t t) { return boxes[s][0][0] < boxes[t][0][0]; });
  for (std::size_t i = 0; i < order.size(); ++i) {
    for (std::size_t j = i + 1; j < order.size() && boxes[order[j]][0][0] <= boxes[order[i]][1][0]; ++j) {
      const auto [s, t] = std::minmax(order[i], order[j]);
      if ((boxes[s][0].array() > boxes[t][1].array()).any() || (boxes[t][0].array() > boxes[s][1].array()).any())
        continue;
      if (forbidden_pair(soup, s, t)) found.push_back({s, t});
    }
  }
  std::sort(found.begin(), found.end());
  return found;
}

/// What is wrong with a complex, or nothing.
inline std::optional<std::string> flaw(const Arrangement& a) {
  const TriangleSoup& soup = a.complex;
  if (a.multiplicity.size() != soup.triangles.size() || a.source.size() != soup.triangles.size()) return "array sizes";
  if (!std::is_sorted(a.source.begin(), a.source.end())) return "sources are not in order";
  std::vector<bool> used(soup.positions.size(), false);
  for (std::size_t t = 0; t < soup.triangles.size(); ++t) {
    for (const std::uint32_t v : soup.triangles[t]) used.at(v) = true;
    if (exactly_collinear(corners_of(soup, t))) return "triangle " + std::to_string(t) + " is collinear";
  }
  if (std::find(used.begin(), used.end(), false) != used.end()) return "an unused vertex";
  std::vector<std::array<double, 3>> positions;
  for (const Point& p : soup.positions) positions.push_back({p[0] + 0.0, p[1] + 0.0, p[2] + 0.0});
  std::sort(positions.begin(), positions.end());
  if (std::adjacent_find(positions.begin(), positions.end()) != positions.end()) return "two vertices in one place";
  const auto pairs = slow_crossings(soup);
  if (!pairs.empty()) {
    return std::to_string(pairs.size()) + " crossings, first " + std::to_string(pairs[0][0]) + " and " +
           std::to_string(pairs[0][1]);
  }
  return {};
}

/// Solid angle of a triangle over 4 pi, by van Oosterom and Strackee's formula.
inline double solid_angle(const Corners& t, const Point& p) {
  const Point a = t[0] - p;
  const Point b = t[1] - p;
  const Point c = t[2] - p;
  const double top = a.dot(b.cross(c));
  const double bottom =
      a.norm() * b.norm() * c.norm() + a.dot(b) * c.norm() + b.dot(c) * a.norm() + c.dot(a) * b.norm();
  return std::atan2(top, bottom) / (2 * std::numbers::pi);
}

inline double winding_number(const TriangleSoup& soup, const Point& p) {
  double sum = 0;
  for (std::size_t t = 0; t < soup.triangles.size(); ++t) sum += solid_angle(corners_of(soup, t), p);
  return sum;
}

inline double winding_number(const Arrangement& a, const Point& p) {
  double sum = 0;
  for (std::size_t t = 0; t < a.complex.triangles.size(); ++t) {
    if (a.multiplicity[t] != 0) sum += a.multiplicity[t] * solid_angle(corners_of(a.complex, t), p);
  }
  return sum;
}

/// Triangles with corners on a lattice of `side` points a direction, in a cube.
inline TriangleSoup lattice_soup(int count, int side, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  TriangleSoup soup;
  const auto draw = [&] { return static_cast<double>(random() % static_cast<std::uint64_t>(side)); };
  for (int i = 0; i < 3 * count; ++i) soup.positions.emplace_back(draw(), draw(), draw());
  for (std::uint32_t i = 0; i < soup.positions.size(); i += 3) soup.triangles.push_back({i, i + 1, i + 2});
  return soup;
}

}  // namespace voxcarve::test
