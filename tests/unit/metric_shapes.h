// Small shapes whose measures are known by hand, for the tests of topology and metrics.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

#include "common/mesh/triangle_soup.h"

namespace voxcarve::test {

/// An axis-aligned box, outward, 8 vertices and 12 triangles.
inline TriangleSoup make_box(const Point& low, const Point& high) {
  TriangleSoup soup;
  for (int i = 0; i < 8; ++i) {
    soup.positions.emplace_back((i & 1) != 0 ? high[0] : low[0], (i & 2) != 0 ? high[1] : low[1],
                                (i & 4) != 0 ? high[2] : low[2]);
  }
  soup.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return soup;
}

inline TriangleSoup unit_cube() {
  return make_box(Point::Zero(), Point::Ones());
}

inline TriangleSoup translated(TriangleSoup soup, const Point& shift) {
  for (Point& p : soup.positions) p += shift;
  return soup;
}

inline TriangleSoup flipped(TriangleSoup soup) {
  for (Triangle& t : soup.triangles) std::swap(t[1], t[2]);
  return soup;
}

inline TriangleSoup joined(TriangleSoup first, const TriangleSoup& second) {
  append(first, second);
  return first;
}

inline TriangleSoup tetrahedron() {
  TriangleSoup soup;
  soup.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  soup.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  return soup;
}

/// A torus about the z axis, n x m quads cut into triangles.
inline TriangleSoup torus(double big, double small, std::uint32_t n, std::uint32_t m) {
  TriangleSoup soup;
  for (std::uint32_t i = 0; i < n; ++i) {
    for (std::uint32_t j = 0; j < m; ++j) {
      const double a = 2 * std::numbers::pi * i / n;
      const double b = 2 * std::numbers::pi * j / m;
      const double r = big + small * std::cos(b);
      soup.positions.emplace_back(r * std::cos(a), r * std::sin(a), small * std::sin(b));
    }
  }
  const auto at = [n, m](std::uint32_t i, std::uint32_t j) { return (i % n) * m + j % m; };
  for (std::uint32_t i = 0; i < n; ++i) {
    for (std::uint32_t j = 0; j < m; ++j) {
      soup.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      soup.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return soup;
}

/// A strip of n quads closed with a half twist: vertex i of the lower rim continues as the upper rim.
inline TriangleSoup moebius_strip(std::uint32_t n) {
  TriangleSoup soup;
  for (std::uint32_t i = 0; i < n; ++i) {
    const double a = 2 * std::numbers::pi * i / n;
    for (const double s : {-0.5, 0.5}) {
      const double r = 2 + s * std::cos(a / 2);
      soup.positions.emplace_back(r * std::cos(a), r * std::sin(a), s * std::sin(a / 2));
    }
  }
  for (std::uint32_t i = 0; i < n; ++i) {
    const bool last = i + 1 == n;
    const std::uint32_t low = last ? 1 : 2 * i + 2;
    const std::uint32_t high = last ? 0 : 2 * i + 3;
    soup.triangles.push_back({2 * i, low, high});
    soup.triangles.push_back({2 * i, high, 2 * i + 1});
  }
  return soup;
}

/// The octahedron, every triangle cut in four `levels` times, vertices moved to the sphere of this radius.
inline TriangleSoup sphere(double radius, int levels) {
  TriangleSoup soup;
  soup.positions = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  soup.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int level = 0; level < levels; ++level) {
    TriangleSoup finer;
    for (const Triangle& t : soup.triangles) {
      const auto base = static_cast<std::uint32_t>(finer.positions.size());
      for (int c = 0; c < 3; ++c) finer.positions.push_back(soup.positions[t[static_cast<std::size_t>(c)]]);
      for (std::size_t c = 0; c < 3; ++c) {
        // The sum of two corners is the same in either order, so neighbours agree on the middle of their edge.
        finer.positions.push_back((soup.positions[t[c]] + soup.positions[t[(c + 1) % 3]]).normalized());
      }
      finer.triangles.push_back({base, base + 3, base + 5});
      finer.triangles.push_back({base + 3, base + 1, base + 4});
      finer.triangles.push_back({base + 5, base + 4, base + 2});
      finer.triangles.push_back({base + 3, base + 4, base + 5});
    }
    soup = merge_equal_positions(finer);
  }
  for (Point& p : soup.positions) p *= radius;
  return soup;
}

/// Numbers in [0, 1) that are the same on every machine.
class Sequence {
 public:
  explicit Sequence(std::uint64_t seed) : state_(seed) {}
  double next() {
    state_ = state_ * 6364136223846793005ULL + 1442695040888963407ULL;
    return static_cast<double>(state_ >> 11) * 0x1p-53;
  }
  std::uint32_t below(std::uint32_t bound) { return static_cast<std::uint32_t>(next() * bound); }
  Point point() {
    const double x = next();
    const double y = next();
    return {x, y, next()};
  }

 private:
  std::uint64_t state_;
};

}  // namespace voxcarve::test
