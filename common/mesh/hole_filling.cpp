// The triangulation of least area is that of [BS95], by dynamic programming. Differs in leaving out edges that the
// surface has already, and in cutting large holes in two at narrow places first.
#include "common/mesh/hole_filling.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "common/mesh/topology.h"

namespace voxcarve {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::size_t kLargestExactHole = 400;   ///< edges; the time grows with the cube
constexpr std::size_t kLargestSearched = 20000;  ///< edges; from here on chords are tried at a few places only

/// A vertex of a hole and the triangle beside the edge that leads to the next one.
struct Corner {
  std::uint32_t vertex = 0;
  std::uint32_t triangle = 0;
};
using Loop = std::vector<Corner>;

/// The holes in the direction of the triangles that will fill them, by their smallest vertices.
std::vector<Loop> find_holes(const TriangleSoup& soup, const EdgeTable& edges) {
  constexpr std::uint32_t kNone = 0xffffffffU;
  std::vector<Corner> next(soup.positions.size(), {kNone, kNone});  // vertex after, triangle beside
  for (std::size_t e = 0; e < edges.size(); ++e) {
    if (edges.uses(e).size() != 1) continue;
    const EdgeUse& use = edges.uses(e)[0];
    const std::uint32_t from = use.forward ? edges.low(e) : edges.high(e);
    const std::uint32_t to = use.forward ? edges.high(e) : edges.low(e);
    next[to] = {from, use.triangle};
  }
  std::vector<Loop> holes;
  for (std::uint32_t start = 0; start < next.size(); ++start) {
    if (next[start].vertex == kNone) continue;
    Loop loop;
    for (std::uint32_t v = start; next[v].vertex != kNone;) {
      const Corner step = next[v];
      loop.push_back({v, step.triangle});
      next[v].vertex = kNone;
      v = step.vertex;
    }
    if (loop.size() >= 3) holes.push_back(std::move(loop));
  }
  return holes;
}

class HoleFiller {
 public:
  HoleFiller(TriangleSoup& soup, const EdgeTable& edges, const RunContext& context)
      : soup_(soup), edges_(edges), context_(context) {}

  void fill(const Loop& loop) {
    context_.check_cancelled();
    if (loop.size() > kLargestExactHole) {
      if (cut_in_two(loop)) return;
    } else if (fill_with_least_area(loop)) {
      return;
    }
    fill_with_fan(loop);
  }

 private:
  const Point& position(const Corner& corner) const { return soup_.positions[corner.vertex]; }

  double area(const Corner& a, const Corner& b, const Corner& c) const {
    return (position(b) - position(a)).cross(position(c) - position(a)).norm();
  }

  /// Whether the surface has an edge between two vertices.
  bool has_edge(std::uint32_t u, std::uint32_t v) const {
    const auto [low, high] = std::minmax(u, v);
    std::size_t begin = 0;
    std::size_t end = edges_.size();
    while (begin < end) {
      const std::size_t middle = begin + (end - begin) / 2;
      const bool before = edges_.low(middle) != low ? edges_.low(middle) < low : edges_.high(middle) < high;
      if (before) {
        begin = middle + 1;
      } else {
        end = middle;
      }
    }
    return begin < edges_.size() && edges_.low(begin) == low && edges_.high(begin) == high;
  }

  void add(std::uint32_t a, std::uint32_t b, std::uint32_t c, const Corner& beside) {
    soup_.triangles.push_back({a, b, c});
    if (!soup_.triangle_colors.empty()) soup_.triangle_colors.push_back(soup_.triangle_colors[beside.triangle]);
  }

  /// least[i, k]: the least area that fills the part of the hole from corner i to corner k.
  bool fill_with_least_area(const Loop& loop) {
    const std::size_t n = loop.size();
    std::vector<double> least(n * n, 0.0);
    std::vector<std::uint32_t> middle(n * n, 0);
    for (std::size_t span = 2; span < n; ++span) {
      if (span % 16 == 0) context_.check_cancelled();
      for (std::size_t i = 0; i + span < n; ++i) {
        const std::size_t k = i + span;
        double best = kInfinity;
        if (span == n - 1 || !has_edge(loop[i].vertex, loop[k].vertex)) {
          for (std::size_t m = i + 1; m < k; ++m) {
            const double sides = least[i * n + m] + least[m * n + k];
            if (!(sides < best)) continue;
            const double total = sides + area(loop[i], loop[m], loop[k]);
            if (!(total < best)) continue;
            best = total;
            middle[i * n + k] = static_cast<std::uint32_t>(m);
          }
        }
        least[i * n + k] = best;
      }
    }
    if (!(least[n - 1] < kInfinity)) return false;
    std::vector<std::pair<std::size_t, std::size_t>> open = {{0, n - 1}};
    while (!open.empty()) {
      const auto [i, k] = open.back();
      open.pop_back();
      if (k - i < 2) continue;
      const std::size_t m = middle[i * n + k];
      add(loop[i].vertex, loop[m].vertex, loop[k].vertex, loop[i]);
      open.emplace_back(m, k);
      open.emplace_back(i, m);
    }
    return true;
  }

  /// Along the chord that is the shortest against the border that it cuts off. The two parts are of like size.
  bool cut_in_two(const Loop& loop) {
    const std::size_t n = loop.size();
    const std::size_t stride = n / kLargestSearched + 1;
    std::vector<double> way(n + 1, 0.0);
    for (std::size_t i = 0; i < n; ++i) way[i + 1] = way[i] + (position(loop[(i + 1) % n]) - position(loop[i])).norm();
    double best = kInfinity;
    std::size_t from = 0;
    std::size_t to = 0;
    for (std::size_t i = 0; i < n; i += stride) {
      if (i % 64 == 0) context_.check_cancelled();
      for (std::size_t k = i + n / 3; k < std::min(n, i + n - n / 3); k += stride) {
        const double along = std::min(way[k] - way[i], way[n] - (way[k] - way[i]));
        const double ratio = (position(loop[k]) - position(loop[i])).norm() / along;
        if (!(ratio < best) || has_edge(loop[i].vertex, loop[k].vertex)) continue;
        best = ratio;
        from = i;
        to = k;
      }
    }
    if (!(best < kInfinity)) return false;
    Loop inner(loop.begin() + static_cast<std::ptrdiff_t>(from), loop.begin() + static_cast<std::ptrdiff_t>(to) + 1);
    Loop outer(loop.begin() + static_cast<std::ptrdiff_t>(to), loop.end());
    outer.insert(outer.end(), loop.begin(), loop.begin() + static_cast<std::ptrdiff_t>(from) + 1);
    // The last edge of each part is the chord; what lies beside it is as good a neighbour as any.
    inner.back().triangle = inner.front().triangle;
    outer.back().triangle = outer.front().triangle;
    fill(inner);
    fill(outer);
    return true;
  }

  void fill_with_fan(const Loop& loop) {
    const auto center = static_cast<std::uint32_t>(soup_.positions.size());
    const auto count = static_cast<double>(loop.size());
    Point sum = Point::Zero();
    Color color = Color::Zero();
    for (const Corner& corner : loop) {
      sum += position(corner) / count;
      if (!soup_.vertex_colors.empty()) color += soup_.vertex_colors[corner.vertex] / static_cast<float>(count);
    }
    soup_.positions.push_back(sum);
    if (!soup_.vertex_colors.empty()) soup_.vertex_colors.push_back(color);
    for (std::size_t i = 0; i < loop.size(); ++i)
      add(loop[i].vertex, loop[(i + 1) % loop.size()].vertex, center, loop[i]);
  }

  TriangleSoup& soup_;
  const EdgeTable& edges_;
  const RunContext& context_;
};

}  // namespace

FillReport fill_holes(TriangleSoup& soup, RunContext& context) {
  const EdgeTable edges(soup);
  const std::vector<Loop> holes = find_holes(soup, edges);
  const std::size_t before = soup.triangles.size();
  HoleFiller filler(soup, edges, context);
  for (const Loop& loop : holes) filler.fill(loop);
  return {static_cast<std::int64_t>(holes.size()), static_cast<std::int64_t>(soup.triangles.size() - before)};
}

}  // namespace voxcarve
