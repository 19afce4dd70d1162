// Surfaces of pieces to be joined, and what is asked of the result, for the tests of stitching.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "common/mesh/topology.h"
#include "common/mesh/triangle_soup.h"
#include "common/run/context.h"
#include "tests/support/shapes.h"

namespace voxcarve::test {

/// A rectangle of n x m squares with corner `origin` and sides along u and v, outward along u x v.
inline TriangleSoup rectangle(const Point& origin, const Point& u, const Point& v, std::uint32_t n = 1,
                              std::uint32_t m = 1) {
  TriangleSoup soup;
  for (std::uint32_t j = 0; j <= m; ++j)
    for (std::uint32_t i = 0; i <= n; ++i)
      soup.positions.push_back(origin + static_cast<double>(i) / n * u + static_cast<double>(j) / m * v);
  for (std::uint32_t j = 0; j < m; ++j) {
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::uint32_t a = j * (n + 1) + i;
      soup.triangles.push_back({a, a + 1, a + n + 2});
      soup.triangles.push_back({a, a + n + 2, a + n + 1});
    }
  }
  return soup;
}

/// The faces of the unit cube, each drawn in by `gap` from its edges and divided into n(face) squares a side.
template <class Division>
std::vector<TriangleSoup> faces(double gap, const Division& division) {
  std::vector<TriangleSoup> parts;
  for (int axis = 0; axis < 3; ++axis) {
    const Point u = (1 - 2 * gap) * Point::Unit((axis + 1) % 3);
    const Point v = (1 - 2 * gap) * Point::Unit((axis + 2) % 3);
    const Point inset = gap * (Point::Ones() - Point::Unit(axis));
    const auto n = [&](int face) { return static_cast<std::uint32_t>(division(face)); };
    parts.push_back(rectangle(inset, v, u, n(2 * axis), n(2 * axis)));
    parts.push_back(rectangle(inset + Point::Unit(axis), u, v, n(2 * axis + 1), n(2 * axis + 1)));
  }
  return parts;
}

/// The unit cube of undivided faces.
inline TriangleSoup cracked_cube(double gap) {
  return joined(faces(gap, [](int) { return 1; }));
}

/// The topology, which is expected to be that of a closed, oriented manifold.
inline SurfaceTopology closed_topology(const TriangleSoup& soup) {
  SurfaceTopology topology = analyze_topology(soup);
  EXPECT_TRUE(topology.closed);
  EXPECT_TRUE(topology.oriented);
  EXPECT_EQ(topology.nonmanifold_vertices, 0);
  return topology;
}

/// Whether a notice of the run contains `text`.
inline bool has_notice(const RunContext& context, const std::string& text) {
  return std::ranges::any_of(context.notices(),
                             [&](const std::string& notice) { return notice.find(text) != std::string::npos; });
}

}  // namespace voxcarve::test
