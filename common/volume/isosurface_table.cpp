// Based on marching cubes [LC87] with the face rule of a table that leaves no holes [NT03, 5.1];
// differs in deriving the table from its rule, which forbids diagonals in cube faces.
#include "common/volume/isosurface_table.h"

#include <stdexcept>
#include <vector>

namespace voxcarve {

namespace {

using Loop = std::vector<std::uint8_t>;

/// Corners of the six faces, counterclockwise seen from outside the cube.
constexpr std::array<std::array<std::uint8_t, 4>, 6> kFaceCorners = {{{0, 4, 6, 2},    // x = 0
                                                                      {1, 3, 7, 5},    // x = 1
                                                                      {0, 1, 5, 4},    // y = 0
                                                                      {2, 6, 7, 3},    // y = 1
                                                                      {0, 2, 3, 1},    // z = 0
                                                                      {4, 5, 7, 6}}};  // z = 1

std::uint8_t edge_between(std::uint8_t a, std::uint8_t b) {
  for (std::uint8_t e = 0; e < 12; ++e) {
    if ((kEdgeCorners[e][0] == a && kEdgeCorners[e][1] == b) || (kEdgeCorners[e][0] == b && kEdgeCorners[e][1] == a))
      return e;
  }
  throw std::logic_error("no such cube edge");
}

bool face_has_edge(const std::array<std::uint8_t, 4>& corners, std::uint8_t edge) {
  int found = 0;
  for (const std::uint8_t corner : corners) found += corner == kEdgeCorners[edge][0] || corner == kEdgeCorners[edge][1];
  return found == 2;
}

bool share_a_face(std::uint8_t edge_a, std::uint8_t edge_b) {
  for (const auto& face : kFaceCorners) {
    if (face_has_edge(face, edge_a) && face_has_edge(face, edge_b)) return true;
  }
  return false;
}

/// The contour loops of a configuration, as edges in the order that makes normals point to the exterior.
std::vector<Loop> contour_loops(unsigned mask) {
  constexpr std::uint8_t kNone = 255;
  std::array<std::uint8_t, 12> next{};
  next.fill(kNone);
  const auto inside = [mask](std::uint8_t corner) { return (mask >> corner & 1U) != 0; };
  for (const auto& corners : kFaceCorners) {
    for (std::size_t start = 0; start < 4; ++start) {
      if (inside(corners[start]) || !inside(corners[(start + 1) % 4])) continue;  // no run of interior corners begins
      std::size_t last = (start + 1) % 4;
      while (inside(corners[(last + 1) % 4])) last = (last + 1) % 4;
      const std::uint8_t entry = edge_between(corners[start], corners[(start + 1) % 4]);
      const std::uint8_t exit = edge_between(corners[last], corners[(last + 1) % 4]);
      next[entry] = exit;
    }
  }
  std::vector<Loop> loops;
  for (std::uint8_t first = 0; first < 12; ++first) {
    if (next[first] == kNone) continue;
    Loop loop;
    for (std::uint8_t edge = first; next[edge] != kNone;) {
      loop.push_back(edge);
      const std::uint8_t following = next[edge];
      next[edge] = kNone;
      edge = following;
    }
    loops.push_back(loop);
  }
  return loops;
}

/// Triangulates loop[first..last] (a polygon closed by the chord last-first) without chords in cube faces.
bool triangulate(const Loop& loop, std::size_t first, std::size_t last, CubeCase& result) {
  if (last - first < 2) return true;
  const auto chord_is_allowed = [&](std::size_t a, std::size_t b) {
    return b - a == 1 || (a == 0 && b + 1 == loop.size()) || !share_a_face(loop[a], loop[b]);
  };
  for (std::size_t apex = first + 1; apex < last; ++apex) {
    if (!chord_is_allowed(first, apex) || !chord_is_allowed(apex, last)) continue;
    const std::uint8_t count_before = result.triangle_count;
    if (triangulate(loop, first, apex, result) && triangulate(loop, apex, last, result)) {
      result.triangles.at(result.triangle_count++) = {loop[first], loop[apex], loop[last]};
      return true;
    }
    result.triangle_count = count_before;
  }
  return false;
}

std::array<CubeCase, 256> derive_cases() {
  std::array<CubeCase, 256> cases{};
  for (unsigned mask = 0; mask < 256; ++mask) {
    for (unsigned e = 0; e < 12; ++e) {
      const unsigned crossed = (mask >> kEdgeCorners[e][0] ^ mask >> kEdgeCorners[e][1]) & 1U;
      cases[mask].crossed_edges = static_cast<std::uint16_t>(cases[mask].crossed_edges | crossed << e);
    }
    for (const Loop& loop : contour_loops(mask)) {
      if (!triangulate(loop, 0, loop.size() - 1, cases[mask])) {
        throw std::logic_error("a contour loop has no triangulation without diagonals in faces");
      }
    }
  }
  return cases;
}

}  // namespace

const std::array<CubeCase, 256>& cube_cases() {
  static const std::array<CubeCase, 256> kCases = derive_cases();
  return kCases;
}

}  // namespace voxcarve
