#include "methods/hagbi_elsana/compact_complex.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>

#include "methods/hagbi_elsana/tetgen_child.h"

namespace voxcarve {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

Kernel::Point_3 exact(const Point& p) {
  return {p[0], p[1], p[2]};
}

Triangle sorted(Triangle t) {
  std::ranges::sort(t);
  return t;
}

}  // namespace

CompactComplex compact(const TriangleSoup& complex, std::size_t kept) {
  std::vector<char> used(complex.positions.size(), 0);
  std::fill(used.end() - static_cast<std::ptrdiff_t>(kept), used.end(), char{1});
  for (const Triangle& t : complex.triangles) {
    for (const std::uint32_t v : t) used[v] = 1;
  }
  std::vector<std::uint32_t> by_position;
  for (std::uint32_t v = 0; v < used.size(); ++v) {
    if (used[v] != 0) by_position.push_back(v);
  }
  const auto key = [&](std::uint32_t v) {
    const Point& p = complex.positions[v];
    return std::tuple(p[0], p[1], p[2]);
  };
  std::ranges::sort(by_position,
                    [&](std::uint32_t a, std::uint32_t b) { return std::tuple(key(a), a) < std::tuple(key(b), b); });
  std::vector<std::uint32_t> first_copy(used.size(), 0);
  CompactComplex result;
  for (std::size_t i = 0; i < by_position.size(); ++i) {
    const std::uint32_t v = by_position[i];
    const bool repeated = i > 0 && key(by_position[i - 1]) == key(v);
    first_copy[v] = repeated ? first_copy[by_position[i - 1]] : v;
    if (!repeated) result.vertices.push_back(v);
  }
  std::ranges::sort(result.vertices);
  std::vector<std::uint32_t> compact_index(used.size(), 0);
  for (std::uint32_t i = 0; i < result.vertices.size(); ++i) compact_index[result.vertices[i]] = i;

  std::vector<std::tuple<Triangle, std::uint32_t>> by_corners;
  for (std::uint32_t f = 0; f < complex.triangles.size(); ++f) {
    Triangle t = complex.triangles[f];
    for (std::uint32_t& v : t) v = compact_index[first_copy[v]];
    by_corners.emplace_back(sorted(t), f);
  }
  std::ranges::sort(by_corners);
  for (std::size_t i = 0; i < by_corners.size(); ++i) {
    const auto& [corners, f] = by_corners[i];
    if (i == 0 || std::get<Triangle>(by_corners[i - 1]) != corners) result.sources.push_back(f);
  }
  std::ranges::sort(result.sources);
  for (const std::uint32_t f : result.sources) {
    Triangle t = complex.triangles[f];
    for (std::uint32_t& v : t) v = compact_index[first_copy[v]];
    result.triangles.push_back(t);
  }
  double largest = 0;
  for (const std::uint32_t v : result.vertices) {
    largest = std::max(largest, complex.positions[v].lpNorm<Eigen::Infinity>());
  }
  std::frexp(largest, &result.exponent);
  return result;
}

void require_solid(const TriangleSoup& complex, const CompactComplex& shape, Stage& stage) {
  const auto point = [&](std::uint32_t v) { return exact(complex.positions[shape.vertices[v]]); };
  constexpr std::size_t kInterval = 4096;
  for (std::size_t f = 0; f < shape.triangles.size(); ++f) {
    if (f % kInterval == 0) stage.advance(0);
    const auto [a, b, c] = shape.triangles[f];
    if (a != b && b != c && c != a && !CGAL::collinear(point(a), point(b), point(c))) continue;
    throw TetgenFailure(TetgenFailure::Kind::kRefused,
                        "triangle " + std::to_string(shape.sources[f]) +
                            " has no area; drop such triangles before the tetrahedralization");
  }
  const auto [a, b, c] = shape.triangles.front();
  for (std::uint32_t v = 0; v < shape.vertices.size(); ++v) {
    if (v % kInterval == 0) stage.advance(0);
    if (CGAL::orientation(point(a), point(b), point(c), point(v)) != CGAL::COPLANAR) return;
  }
  throw TetgenFailure(TetgenFailure::Kind::kFlat,
                      "the model's vertices lie in a plane, so its convex hull has no volume");
}

int orientation(const Point& a, const Point& b, const Point& c, const Point& d) {
  return static_cast<int>(CGAL::orientation(exact(a), exact(b), exact(c), exact(d)));
}

bool faces_the_other_way(const std::array<Point, 3>& part, const std::array<Point, 3>& whole) {
  // Of the directions alone, so that no product over- or underflows.
  const Point normal = (whole[1] - whole[0]).stableNormalized().cross((whole[2] - whole[0]).stableNormalized());
  int axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  const auto turn = [axis](const std::array<Point, 3>& t) {
    const auto flat = [axis](const Point& p) { return Kernel::Point_2(p[(axis + 1) % 3], p[(axis + 2) % 3]); };
    return static_cast<int>(CGAL::orientation(flat(t[0]), flat(t[1]), flat(t[2])));
  };
  return turn(part) * turn(whole) < 0;
}

}  // namespace voxcarve
