// Triangles that meet where a piecewise linear complex forbids it, decided exactly.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/mesh/triangle_soup.h"
#include "common/run/context.h"

namespace voxcarve {

/// An end of what two triangles have in common: a vertex (then `from` == `to`), or the point where the edge between two
/// vertices goes through the plane of a triangle.
struct ContactPoint {
  std::uint32_t from = 0;
  std::uint32_t to = 0;
  std::uint32_t triangle = 0;  ///< of the plane; 0 for a vertex

  bool is_vertex() const { return from == to; }
  auto operator<=>(const ContactPoint&) const = default;
};

/// Two triangles that meet elsewhere than in a common vertex or a whole common edge.
struct Crossing {
  std::uint32_t first = 0;
  std::uint32_t second = 0;  ///< greater than `first`
  bool coplanar = false;
  /// Of triangles in different planes: the ends of the segment, or twice the point, in which they meet.
  std::array<ContactPoint, 2> ends;
};

/// All such pairs, ordered by (first, second). Common vertices are known by their index: vertices that triangles use
/// must have different positions, and no triangle may be collinear. Two triangles with the same three vertices are no
/// crossing. Exact at every scale, coplanar overlaps and touching included; the same on any number of threads. Takes
/// O(n log n) and the time of the pairs with overlapping boxes. Throws ResourceError when the pairs exceed the memory
/// budget, and Cancelled.
std::vector<Crossing> find_crossings(const TriangleSoup& soup, RunContext& context);

/// Only the pairs of which at least one is a suspect, one flag a triangle. Where no two others cross, these are all.
/// Takes the time of the suspects and of those near them, and a descent of a tree for each of the others.
std::vector<Crossing> find_crossings(const TriangleSoup& soup, const std::vector<bool>& suspects, RunContext& context);

/// True when three points lie on a line, exactly.
bool are_collinear(const Point& a, const Point& b, const Point& c);

}  // namespace voxcarve
