// Cutting follows [GTLH98, 4]; differs in pairing the triangles at an edge of many by the order around it instead of
// cutting all of them apart.
#include "common/mesh/gluing.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "common/mesh/topology.h"

namespace voxcarve {

namespace {

constexpr std::uint32_t kNone = 0xffffffffU;

/// Triangles next to each other across edges of two.
struct Neighbour {
  std::uint32_t triangle = kNone;
  bool agrees = true;
};

void turn(Triangle& triangle) {
  std::swap(triangle[1], triangle[2]);
}

/// Six times the volume between a patch and its middle.
double enclosed_volume(const TriangleSoup& soup, std::span<const std::uint32_t> patch, double& size) {
  Box box;
  for (const std::uint32_t t : patch)
    for (const std::uint32_t v : soup.triangles[t]) box.extend(soup.positions[v]);
  const Point middle = box.center();
  double sum = 0;
  for (const std::uint32_t t : patch) {
    const Triangle& triangle = soup.triangles[t];
    sum += (soup.positions[triangle[0]] - middle).dot(area_vector(soup, triangle));
  }
  size = std::pow(box.diagonal(), 3);
  return sum;
}

/// Pairs of the uses of one edge that are to be glued: walking around the edge, a triangle whose inside lies ahead
/// belongs to the next one whose inside lies behind, as brackets do.
std::vector<std::pair<std::size_t, std::size_t>> pairs_around(const TriangleSoup& soup, const EdgeTable& edges,
                                                              std::size_t edge) {
  const auto uses = edges.uses(edge);
  if (uses.size() == 2) {
    if (uses[0].forward == uses[1].forward) return {};
    return {{0, 1}};
  }
  struct Place {
    std::int64_t angle;  ///< in steps so coarse that triangles of one plane have the same
    bool forward;        ///< its normal points ahead, so its inside lies behind
    std::size_t use;
  };
  const Point& low = soup.positions[edges.low(edge)];
  const Point axis = (soup.positions[edges.high(edge)] - low).stableNormalized();
  const auto offset = [&](const EdgeUse& use) -> Point {
    const Point apex = soup.positions[soup.triangles[use.triangle][(use.corner + 2U) % 3]] - low;
    return (apex - apex.dot(axis) * axis).stableNormalized();
  };
  const Point x_axis = offset(uses[0]);
  const Point y_axis = axis.cross(x_axis);
  std::vector<Place> places;
  for (std::size_t i = 0; i < uses.size(); ++i) {
    const Point direction = offset(uses[i]);
    const double x = direction.dot(x_axis);
    const double y = direction.dot(y_axis);
    // Grows with the angle from 0 to 4, without a function that differs between machines.
    const double share = 1 - x / std::max(std::abs(x) + std::abs(y), 1e-300);
    constexpr double kSteps = 1e7;
    constexpr std::int64_t kTurn = 40000000;
    const auto angle = static_cast<std::int64_t>(std::floor((y >= 0 ? share : 4 - share) * kSteps + 0.5));
    places.push_back({angle % kTurn, uses[i].forward, i});
  }
  // In one plane, what closes comes before what opens: two solids that touch in a face are not joined through it.
  std::ranges::sort(places, [](const Place& a, const Place& b) {
    if (a.angle != b.angle) return a.angle < b.angle;
    return a.forward != b.forward ? a.forward : a.use < b.use;
  });
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  std::vector<std::size_t> open;
  std::vector<std::size_t> unmatched;
  const auto close = [&](std::size_t use) {
    if (open.empty()) return false;
    pairs.emplace_back(open.back(), use);
    open.pop_back();
    return true;
  };
  for (const Place& place : places) {
    if (!place.forward) {
      open.push_back(place.use);
    } else if (!close(place.use)) {
      unmatched.push_back(place.use);
    }
  }
  for (const std::size_t use : unmatched) close(use);  // around the turn's beginning
  return pairs;
}

std::uint32_t corner_at(const TriangleSoup& soup, std::uint32_t triangle, std::uint32_t vertex) {
  const Triangle& t = soup.triangles[triangle];
  return 3 * triangle + (t[0] == vertex ? 0U : t[1] == vertex ? 1U : 2U);
}

/// A copy of a vertex for every fan of triangles that are glued around it.
std::int64_t separate_fans(TriangleSoup& soup, const EdgeTable& edges) {
  DisjointSets corners(3 * soup.triangles.size());
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const auto uses = edges.uses(e);
    if (uses.size() < 2) continue;
    for (const auto& [first, second] : pairs_around(soup, edges, e)) {
      for (const std::uint32_t vertex : {edges.low(e), edges.high(e)}) {
        corners.join(corner_at(soup, uses[first].triangle, vertex), corner_at(soup, uses[second].triangle, vertex));
      }
    }
  }
  std::vector<std::uint8_t> taken(soup.positions.size(), 0);  // the first fan keeps the vertex
  std::vector<std::uint32_t> vertex_of(3 * soup.triangles.size());
  std::int64_t copies = 0;
  for (std::uint32_t corner = 0; corner < vertex_of.size(); ++corner) {
    std::uint32_t& vertex = soup.triangles[corner / 3][corner % 3];
    const std::uint32_t first = corners.find(corner);
    if (first == corner) {
      vertex_of[corner] = vertex;
      if (taken[vertex] != 0) {
        vertex_of[corner] = static_cast<std::uint32_t>(soup.positions.size());
        soup.positions.push_back(Point(soup.positions[vertex]));
        if (!soup.vertex_colors.empty()) soup.vertex_colors.push_back(Color(soup.vertex_colors[vertex]));
        ++copies;
      } else {
        taken[vertex] = 1;
      }
    }
    vertex = vertex_of[first];
  }
  return copies;
}

/// Splits the triangle at the middle of one of its edges.
void split_at(TriangleSoup& soup, const EdgeUse& use, std::uint32_t middle) {
  const Triangle whole = soup.triangles[use.triangle];
  Triangle& first = soup.triangles[use.triangle];
  Triangle second = whole;
  first[(use.corner + 1U) % 3] = middle;
  second[use.corner] = middle;
  soup.triangles.push_back(second);
  if (!soup.triangle_colors.empty()) soup.triangle_colors.push_back(Color(soup.triangle_colors[use.triangle]));
}

/// Gives every pair of triangles at an edge of more than two its own vertex in the middle. False when there is no such
/// edge; a triangle is split once a call.
bool divide_crowded_edges(TriangleSoup& soup) {
  const EdgeTable edges(soup);
  std::vector<std::uint8_t> touched(soup.triangles.size(), 0);
  bool found = false;
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const auto uses = edges.uses(e);
    if (uses.size() < 3) continue;
    found = true;
    if (std::ranges::any_of(uses, [&](const EdgeUse& use) { return touched[use.triangle] != 0; })) continue;
    const Point middle = 0.5 * (soup.positions[edges.low(e)] + soup.positions[edges.high(e)]);
    std::vector<std::uint32_t> vertex(uses.size(), kNone);
    const auto make_vertex = [&] {
      soup.positions.push_back(middle);
      if (!soup.vertex_colors.empty()) {
        const Color color = 0.5F * (soup.vertex_colors[edges.low(e)] + soup.vertex_colors[edges.high(e)]);
        soup.vertex_colors.push_back(color);
      }
      return static_cast<std::uint32_t>(soup.positions.size() - 1);
    };
    for (const auto& [first, second] : pairs_around(soup, edges, e)) vertex[first] = vertex[second] = make_vertex();
    for (std::size_t i = 0; i < uses.size(); ++i) {
      if (vertex[i] == kNone) vertex[i] = make_vertex();
      touched[uses[i].triangle] = 1;
      split_at(soup, uses[i], vertex[i]);
    }
  }
  return found;
}

}  // namespace

OrientReport orient(TriangleSoup& soup, RunContext& context) {
  OrientReport report;
  std::vector<std::array<Neighbour, 3>> neighbours(soup.triangles.size());
  {
    const EdgeTable edges(soup);
    for (std::size_t e = 0; e < edges.size(); ++e) {
      const auto uses = edges.uses(e);
      if (uses.size() != 2) continue;
      const bool agrees = uses[0].forward != uses[1].forward;
      neighbours[uses[0].triangle][uses[0].corner] = {uses[1].triangle, agrees};
      neighbours[uses[1].triangle][uses[1].corner] = {uses[0].triangle, agrees};
    }
  }
  constexpr std::uint8_t kUnseen = 2;
  std::vector<std::uint8_t> turned(soup.triangles.size(), kUnseen);
  std::int64_t one_sided = 0;
  for (std::uint32_t start = 0; start < turned.size(); ++start) {
    if (turned[start] != kUnseen) continue;
    if (start % 4096 == 0) context.check_cancelled();
    turned[start] = 0;
    std::vector<std::uint32_t> patch = {start};
    std::size_t count = 0;
    for (std::size_t i = 0; i < patch.size(); ++i) {
      for (const Neighbour& next : neighbours[patch[i]]) {
        if (next.triangle == kNone) continue;
        const std::uint8_t side = next.agrees ? turned[patch[i]] : 1 - turned[patch[i]];
        if (turned[next.triangle] == kUnseen) {
          turned[next.triangle] = side;
          count += side;
          patch.push_back(next.triangle);
        } else if (turned[next.triangle] != side) {
          ++one_sided;
        }
      }
    }
    if (count == 0) continue;
    for (const std::uint32_t t : patch)
      if (turned[t] != 0) turn(soup.triangles[t]);
    constexpr double kFlat = 1e-6;
    double size = 0;
    const double volume = enclosed_volume(soup, patch, size);
    const bool other_side = std::abs(volume) > kFlat * size ? volume < 0 : 2 * count > patch.size();
    if (other_side) {
      for (const std::uint32_t t : patch) turn(soup.triangles[t]);
      count = patch.size() - count;
    }
    report.turned += static_cast<std::int64_t>(count);
  }
  report.one_sided = one_sided / 2;  // met from both sides
  return report;
}

GlueReport glue_to_manifold(TriangleSoup& soup, RunContext& context) {
  GlueReport report;
  {
    const EdgeTable edges(soup);
    for (std::size_t e = 0; e < edges.size(); ++e) report.crowded_edges += edges.uses(e).size() > 2 ? 1 : 0;
    context.check_cancelled();
    report.copied_vertices = separate_fans(soup, edges);
  }
  // Every call takes at least the first such edge away, and the new edges have two triangles each.
  while (divide_crowded_edges(soup)) context.check_cancelled();
  remove_unused_vertices(soup);  // the cut leaves them out, and they would hide copies in the count
  const auto before = static_cast<std::int64_t>(soup.positions.size());
  soup = cut_to_manifold(soup);  // copies the vertices of neighbours that no orientation makes agree
  report.copied_vertices += std::max<std::int64_t>(0, static_cast<std::int64_t>(soup.positions.size()) - before);
  return report;
}

}  // namespace voxcarve
