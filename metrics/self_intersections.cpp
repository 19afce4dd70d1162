// Candidate pairs from the box intersection of Zomorodian and Edelsbrunner (CGAL); the test of a pair is that of Guigue
// and Devillers, "Fast and robust triangle-triangle overlap test using orientation predicates", 2003, with strict
// comparisons.
#include "metrics/self_intersections.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/box_intersection_d.h>

#include <array>
#include <vector>

namespace voxcarve {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Corners = std::array<const Kernel::Point_3*, 3>;
using CandidateBox = CGAL::Box_intersection_d::Box_with_handle_d<double, 3, const Triangle*>;

struct TooManyCandidates {};

/// Turns the corners of `one` so that its first lies alone strictly on the positive side of the plane of `other`, whose
/// orientation is reversed for that if need be. False when `one` is not strictly on both sides.
bool set_apart(Corners& one, Corners& other) {
  std::array<int, 3> side{};
  for (std::size_t i = 0; i < 3; ++i) side[i] = CGAL::orientation(*other[0], *other[1], *other[2], *one[i]);
  const auto count = [&side](int sign) { return (side[0] == sign) + (side[1] == sign) + (side[2] == sign); };
  if (count(1) == 0 || count(-1) == 0) return false;
  const int lone = count(1) == 1 ? 1 : -1;
  while (side[0] != lone) {
    one = {one[1], one[2], one[0]};
    side = {side[1], side[2], side[0]};
  }
  if (lone < 0) std::swap(other[1], other[2]);
  return true;
}

/// Both triangles straddle the other's plane, so each meets the common line in an interval of positive length; the
/// intervals overlap in positive length iff each begins strictly before the other ends.
bool intersect_properly(Corners one, Corners other) {
  if (!set_apart(one, other) || !set_apart(other, one)) return false;
  // Turning `other` may have been followed by reversing `one`; the first corners stay apart on the positive sides.
  return CGAL::orientation(*one[0], *one[1], *other[0], *other[1]) == CGAL::NEGATIVE &&
         CGAL::orientation(*one[0], *one[2], *other[2], *other[0]) == CGAL::NEGATIVE;
}

}  // namespace

MetricValue count_self_intersections(const TriangleSoup& soup, const RunContext& context,
                                     std::int64_t candidate_limit) {
  context.check_cancelled();
  std::vector<Kernel::Point_3> points;
  points.reserve(soup.positions.size());
  for (const Point& p : soup.positions) points.emplace_back(p[0], p[1], p[2]);
  const auto corners_of = [&](const Triangle& t) { return Corners{&points[t[0]], &points[t[1]], &points[t[2]]}; };

  std::vector<CandidateBox> boxes;
  boxes.reserve(soup.triangles.size());
  for (const Triangle& triangle : soup.triangles) {
    const Corners c = corners_of(triangle);
    if (CGAL::collinear(*c[0], *c[1], *c[2])) continue;
    boxes.emplace_back(c[0]->bbox() + c[1]->bbox() + c[2]->bbox(), &triangle);
  }

  const auto same_position = [&](std::uint32_t i, std::uint32_t j) { return i == j || points[i] == points[j]; };
  std::int64_t candidates = 0;
  std::int64_t found = 0;
  const auto examine = [&](const CandidateBox& first, const CandidateBox& second) {
    if (++candidates > candidate_limit) throw TooManyCandidates();
    if (candidates % 65536 == 0) context.check_cancelled();
    const Triangle& s = *first.handle();
    const Triangle& t = *second.handle();
    int shared = 0;
    for (const std::uint32_t i : s) {
      shared += (same_position(i, t[0]) || same_position(i, t[1]) || same_position(i, t[2])) ? 1 : 0;
    }
    // With a common side, the third corner is the only one off the other's plane: never proper.
    if (shared < 2 && intersect_properly(corners_of(s), corners_of(t))) ++found;
  };
  try {
    CGAL::box_self_intersection_d(boxes.begin(), boxes.end(), examine);
  } catch (const TooManyCandidates&) {
    return Undefined{"more than " + std::to_string(candidate_limit) + " pairs of triangles have overlapping boxes"};
  }
  return found;
}

}  // namespace voxcarve
