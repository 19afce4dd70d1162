// What a carving stream holds, by looking at every tetrahedron for every step.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <set>
#include <utility>
#include <vector>

#include "common/mesh/triangle_soup.h"
#include "methods/hagbi_elsana/carving.h"
#include "methods/hagbi_elsana/complement.h"

namespace voxcarve::test {

using PositionTriple = std::array<std::array<double, 3>, 3>;

inline std::array<double, 3> coordinates(const Point& point) {
  return {point[0], point[1], point[2]};
}

/// The corners' positions from the least one on: the same for a triangle and its rotations, not for its mirror image.
inline PositionTriple position_triple(const Point& a, const Point& b, const Point& c) {
  PositionTriple triple = {coordinates(a), coordinates(b), coordinates(c)};
  std::ranges::rotate(triple, std::ranges::min_element(triple));
  return triple;
}

/// Of all triangles, sorted.
inline std::vector<PositionTriple> position_triples(const TriangleSoup& soup) {
  std::vector<PositionTriple> triples;
  for (const Triangle& t : soup.triangles) {
    triples.push_back(position_triple(soup.positions[t[0]], soup.positions[t[1]], soup.positions[t[2]]));
  }
  std::ranges::sort(triples);
  return triples;
}

/// A complement and the steps that carve it.
struct SlowStream {
  const Complement& mesh;
  const std::vector<std::uint32_t>& steps;

  bool outside(std::uint32_t t, std::uint32_t step) const { return steps[t] <= step; }

  /// The faces between the outside and the solid or the model, seen from the outside.
  std::vector<PositionTriple> faces(std::uint32_t step) const {
    std::vector<PositionTriple> result;
    for (std::uint32_t t = 0; t < mesh.size(); ++t) {
      for (std::size_t i = 0; outside(t, step) && i < 4; ++i) {
        const std::uint32_t beyond = mesh.neighbors[t][i];
        const bool in_model = (mesh.walls[t] >> i & 1) != 0;
        if (!in_model && beyond != Complement::kSolid && outside(beyond, step)) continue;
        const Triangle face = mesh.face(t, static_cast<int>(i));
        result.push_back(position_triple(mesh.points[face[0]], mesh.points[face[1]], mesh.points[face[2]]));
      }
    }
    std::ranges::sort(result);
    return result;
  }

  std::uint32_t last_step() const {
    std::uint32_t last = 0;
    for (const std::uint32_t step : steps) last = step == kNeverCarved ? last : std::max(last, step);
    return last;
  }
};

inline std::uint32_t distinct_positions(const std::vector<PositionTriple>& faces) {
  std::set<std::array<double, 3>> positions;
  for (const PositionTriple& face : faces) positions.insert(face.begin(), face.end());
  return static_cast<std::uint32_t>(positions.size());
}

}  // namespace voxcarve::test
