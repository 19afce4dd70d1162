// Based on [GH97]; differs in weighting planes by area on request, in quadrics that are kept about their own vertices,
// in taking the optimum nearest to the middle where it is not unique, in taking the best of ends and middle where it
// lies far off, and in breaking ties of the cost by the pairs' lengths. Pairs that
// would invert a triangle come last.
#include "common/mesh/pair_collapse.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "common/mesh/distinct_triangles.h"
#include "common/mesh/pair_queue.h"
#include "common/mesh/quadric.h"
#include "common/mesh/topology.h"
#include "common/mesh/unit_frame.h"
#include "common/mesh/vertex_pairs.h"
#include "common/run/errors.h"

namespace voxcarve {

namespace {

constexpr std::uint32_t kNone = 0xffffffffU;

/// What rounding hides of a distance, in lengths of the pair.
constexpr double kRounding = 1e-7;

/// Where a pair goes.
struct Merger {
  Quadric<3> sum;  ///< about the middle of the pair
  Point half;      ///< from the middle to the high end
  Point step;      ///< from the middle to the merged vertex
  double cost = 0;
  int end = 0;  ///< -1 on the low end, 1 on the high end, 0 elsewhere
};

Merger merge(const Point& low, const Quadric<3>& low_quadric, const Point& high, const Quadric<3>& high_quadric) {
  // An optimum so many lengths of the pair away comes from planes that are nearly parallel.
  constexpr double kReach = 2;
  Merger result;
  result.half = 0.5 * (high - low);
  result.sum = Quadric<3>::sum_about_middle(low_quadric, high_quadric, result.half);
  const double at_low = result.sum(-result.half);
  const double at_high = result.sum(result.half);
  const auto [step, value] = result.sum.minimum();
  result.step = step;
  result.cost = value;
  if (step.squaredNorm() > 4 * kReach * kReach * result.half.squaredNorm()) {
    result.step.setZero();
    result.cost = result.sum(result.step);
    if (at_low < result.cost || at_high < result.cost) {
      result.end = at_low <= at_high ? -1 : 1;
      result.cost = std::min(at_low, at_high);
    }
  }
  // Where exactly one end is as good as the optimum it is taken, so that corners stay to the last bit.
  const double slack = kRounding * kRounding * result.sum.trace() * 4 * result.half.squaredNorm();
  const bool low_fits = at_low <= result.cost + slack;
  const bool high_fits = at_high <= result.cost + slack;
  if (low_fits != high_fits) result.end = low_fits ? -1 : 1;
  if (result.end != 0) result.step = result.end * result.half;
  // Costs that rounding makes of nothing go by what it may hide: by the pair's length and the weight of its planes.
  result.cost = std::max(result.cost, 0.0) + slack;
  return result;
}

/// True when moving a corner turns a triangle by a right angle or more, or takes its area.
bool inverts(const Point& before, const Point& after, const Point& b, const Point& c) {
  constexpr double kSmallestArea = 1e-8;  // twice the area against the longest side squared: what rounding leaves
  const auto has_area = [&](const Point& a, const Point& area) {
    const double longest = std::max({(b - a).squaredNorm(), (c - a).squaredNorm(), (c - b).squaredNorm()});
    return area.norm() > kSmallestArea * longest;
  };
  const Point old_area = (b - before).cross(c - before);
  const Point new_area = (b - after).cross(c - after);
  return has_area(before, old_area) && !(old_area.dot(new_area) > 0 && has_area(after, new_area));
}

std::vector<Quadric<3>> make_quadrics(const TriangleSoup& soup, const std::vector<Point>& points,
                                      const PairCollapseOptions& options, const RunContext& context) {
  const bool by_area = options.plane_weight == PlaneWeight::kArea;
  std::vector<Quadric<3>> quadrics(points.size());
  std::vector<Point> areas(soup.triangles.size());
  for (std::size_t t = 0; t < areas.size(); ++t) {
    const auto& [a, b, c] = soup.triangles[t];
    areas[t] = (points[b] - points[a]).cross(points[c] - points[a]);
    const double twice_area = areas[t].norm();
    if (!(twice_area > 0)) continue;
    const auto quadric = Quadric<3>::of_plane(areas[t] / twice_area, by_area ? 0.5 * twice_area : 1);
    for (const std::uint32_t vertex : soup.triangles[t]) quadrics[vertex] += quadric;
  }
  const EdgeTable edges(soup, &context);
  for (std::size_t edge = 0; edge < edges.size(); ++edge) {
    if (edges.uses(edge).size() != 1) continue;
    const Point along = points[edges.high(edge)] - points[edges.low(edge)];
    const Point across = along.cross(areas[edges.uses(edge).front().triangle]);
    const double length = across.norm();
    if (!(length > 0)) continue;
    const double weight = options.boundary_weight * (by_area ? along.squaredNorm() : 1);
    const auto quadric = Quadric<3>::of_plane(across / length, weight);
    quadrics[edges.low(edge)] += quadric;
    quadrics[edges.high(edge)] += quadric;
  }
  return quadrics;
}

/// The soup while it loses vertices. Vertices keep their numbers.
class PairCollapse {
 public:
  PairCollapse(TriangleSoup soup, const UnitFrame& frame, std::vector<Point> points, std::vector<Quadric<3>> quadrics,
               const std::vector<VertexPair>& pairs)
      : soup_(std::move(soup)),
        frame_(frame),
        points_(std::move(points)),
        quadrics_(std::move(quadrics)),
        pairs_of_(points_.size()),
        triangles_of_(points_.size()),
        mark_(points_.size(), kNone),
        left_(static_cast<std::int64_t>(soup_.triangles.size())),
        queue_(evaluate_all(pairs)) {
    for (std::uint32_t id = 0; id < pairs.size(); ++id) {
      pairs_of_[pairs[id].low].push_back(id);
      pairs_of_[pairs[id].high].push_back(id);
    }
    for (std::uint32_t t = 0; t < soup_.triangles.size(); ++t) {
      for (const std::uint32_t vertex : soup_.triangles[t]) triangles_of_[vertex].push_back(t);
    }
  }

  void run(std::int64_t goal, Stage& stage, const std::function<void(const PairContraction&)>& watcher) {
    while (left_ > goal && !queue_.empty()) {
      const std::uint32_t id = queue_.first();
      PairQueue::Entry entry = queue_[id];
      const auto [low, high] = entry.pair;
      const Merger merger = merge(points_[low], quadrics_[low], points_[high], quadrics_[high]);
      const Point point = place(entry.pair, merger);
      if (!entry.postponed && (inverts_around(low, high, point) || inverts_around(high, low, point))) {
        entry.postponed = true;
        queue_.change(id, entry);
        stage.advance(0);
        continue;
      }
      if (watcher) watcher({low, high, model_position(merger, entry.pair, point), entry.postponed});
      const std::int64_t before = left_;
      contract(id, merger, point);
      stage.advance(before - left_);
    }
  }

  /// What is left.
  TriangleSoup take() {
    std::size_t kept = 0;
    for (std::size_t t = 0; t < soup_.triangles.size(); ++t) {
      if (!has_distinct_corners(soup_.triangles[t])) continue;
      soup_.triangles[kept] = soup_.triangles[t];
      if (!soup_.triangle_colors.empty()) soup_.triangle_colors[kept] = soup_.triangle_colors[t];
      ++kept;
    }
    soup_.triangles.resize(kept);
    if (!soup_.triangle_colors.empty()) soup_.triangle_colors.resize(kept);
    remove_unused_vertices(soup_);
    return std::move(soup_);
  }

 private:
  std::vector<PairQueue::Entry> evaluate_all(const std::vector<VertexPair>& pairs) const {
    std::vector<PairQueue::Entry> entries;
    entries.reserve(pairs.size());
    for (const VertexPair& pair : pairs) entries.push_back({pair, cost_of(pair), false});
    return entries;
  }

  double cost_of(const VertexPair& pair) const {
    return merge(points_[pair.low], quadrics_[pair.low], points_[pair.high], quadrics_[pair.high]).cost;
  }

  Point place(const VertexPair& pair, const Merger& merger) const {
    if (merger.end != 0) return points_[merger.end < 0 ? pair.low : pair.high];
    return points_[pair.low] + merger.half + merger.step;
  }

  Point model_position(const Merger& merger, const VertexPair& pair, const Point& point) const {
    if (merger.end != 0) return soup_.positions[merger.end < 0 ? pair.low : pair.high];
    return frame_.from_unit(point);
  }

  /// Whether a triangle at `vertex`, but not at `other`, is inverted when the vertex moves to `point`.
  bool inverts_around(std::uint32_t vertex, std::uint32_t other, const Point& point) const {
    return std::ranges::any_of(triangles_of_[vertex], [&](std::uint32_t t) {
      const Triangle& corners = soup_.triangles[t];
      if (std::ranges::find(corners, other) != corners.end()) return false;
      const auto corner = static_cast<std::size_t>(std::ranges::find(corners, vertex) - corners.begin());
      return inverts(points_[vertex], point, points_[corners.at((corner + 1) % 3)],
                     points_[corners.at((corner + 2) % 3)]);
    });
  }

  void contract(std::uint32_t id, const Merger& merger, const Point& point) {
    const VertexPair pair = queue_[id].pair;
    const auto [low, high] = pair;
    if (!soup_.vertex_colors.empty() && merger.step.dot(merger.half) > 0)
      soup_.vertex_colors[low] = soup_.vertex_colors[high];
    soup_.positions[low] = model_position(merger, pair, point);
    points_[low] = point;
    quadrics_[low] = merger.sum.moved(merger.step);
    remove_pair(id);
    merge_pairs(low, high);
    merge_triangles(low, high);
    for (const std::uint32_t around : pairs_of_[low])
      queue_.change(around, {queue_[around].pair, cost_of(queue_[around].pair), false});
  }

  /// Pairs of `high` become pairs of `low`; those that `low` has already go.
  void merge_pairs(std::uint32_t low, std::uint32_t high) {
    const auto partner = [&](std::uint32_t id, std::uint32_t of) {
      const VertexPair& pair = queue_[id].pair;
      return pair.low == of ? pair.high : pair.low;
    };
    for (const std::uint32_t id : pairs_of_[low]) mark_[partner(id, low)] = low;
    for (const std::uint32_t id : pairs_of_[high]) {
      const std::uint32_t other = partner(id, high);
      if (mark_[other] == low) {
        std::erase(pairs_of_[other], id);
        queue_.remove(id);
        continue;
      }
      queue_.change(id, {{std::min(low, other), std::max(low, other)}, queue_[id].cost, false});
      pairs_of_[low].push_back(id);
    }
    for (const std::uint32_t id : pairs_of_[low]) mark_[partner(id, low)] = kNone;
    release(pairs_of_[high]);
  }

  void merge_triangles(std::uint32_t low, std::uint32_t high) {
    const std::vector<std::uint32_t> moved = std::move(triangles_of_[high]);
    triangles_of_[high] = {};
    for (const std::uint32_t t : moved) {
      std::ranges::replace(soup_.triangles[t], high, low);
      if (has_distinct_corners(soup_.triangles[t])) triangles_of_[low].push_back(t);
    }
    for (const std::uint32_t t :
         moved) {  // after all the others have come, so that the vertex is not given up too soon
      if (!has_distinct_corners(soup_.triangles[t])) drop_triangle(t);
    }
    drop_duplicates_at(low);
    if (triangles_of_[low].empty()) drop_pairs_of(low);
  }

  /// Of the triangles at `vertex` that have the same other two corners the first is kept.
  void drop_duplicates_at(std::uint32_t vertex) {
    fan_.clear();
    for (const std::uint32_t t : triangles_of_[vertex]) {
      Triangle corners = soup_.triangles[t];
      std::ranges::sort(corners);
      fan_.emplace_back(corners, t);
    }
    std::ranges::sort(fan_);
    for (std::size_t i = 1; i < fan_.size(); ++i) {
      if (fan_[i].first == fan_[i - 1].first) drop_triangle(fan_[i].second);
    }
  }

  void drop_triangle(std::uint32_t t) {
    for (const std::uint32_t vertex : soup_.triangles[t]) {
      std::erase(triangles_of_[vertex], t);
      if (triangles_of_[vertex].empty()) drop_pairs_of(vertex);
    }
    soup_.triangles[t].fill(soup_.triangles[t][0]);
    --left_;
  }

  /// A vertex without triangles is no longer there.
  void drop_pairs_of(std::uint32_t vertex) {
    while (!pairs_of_[vertex].empty()) remove_pair(pairs_of_[vertex].back());
  }

  void remove_pair(std::uint32_t id) {
    const VertexPair pair = queue_[id].pair;
    std::erase(pairs_of_[pair.low], id);
    std::erase(pairs_of_[pair.high], id);
    queue_.remove(id);
  }

  static void release(std::vector<std::uint32_t>& list) { std::vector<std::uint32_t>().swap(list); }

  TriangleSoup soup_;  ///< of a triangle that is gone all corners are the same
  UnitFrame frame_;
  std::vector<Point> points_;  ///< in the unit frame
  std::vector<Quadric<3>> quadrics_;
  std::vector<std::vector<std::uint32_t>> pairs_of_;      ///< of each vertex
  std::vector<std::vector<std::uint32_t>> triangles_of_;  ///< likewise
  std::vector<std::uint32_t> mark_;
  std::vector<std::pair<Triangle, std::uint32_t>> fan_;
  std::int64_t left_;
  PairQueue queue_;
};

void check(const PairCollapseOptions& options) {
  const auto refuse_unless = [](double value, const char* what) {
    if (!(value >= 0) || !std::isfinite(value))
      throw ParameterError(std::string(what) + " of the pair collapse is not a number from 0 up");
  };
  refuse_unless(options.threshold, "the threshold");
  refuse_unless(options.boundary_weight, "the boundary weight");
}

/// Of a collapse, but for what grows with the pairs: the soup, what is known of vertices and triangles, and the edges.
std::uint64_t memory_without_pairs(const TriangleSoup& soup) {
  constexpr std::uint64_t kVertex =
      2 * sizeof(Point) + sizeof(Quadric<3>) + 2 * sizeof(std::vector<int>) + 2 * sizeof(std::uint32_t) + sizeof(Color);
  // In the lists of three vertices, which grow by doubling; the area and the edge table come before them.
  constexpr std::uint64_t kTriangle = sizeof(Triangle) + sizeof(Color) + 100;
  return soup.positions.size() * kVertex + soup.triangles.size() * kTriangle;
}

}  // namespace

TriangleSoup collapse_pairs(const TriangleSoup& soup, const PairCollapseOptions& options, RunContext& context) {
  check(options);
  const std::int64_t wanted = std::max<std::int64_t>(options.triangles, 0);
  if (static_cast<std::int64_t>(soup.triangles.size()) <= wanted) return soup;
  if (soup.triangles.size() >= (std::size_t{1} << 30))
    throw ResourceError("a surface of 2^30 triangles or more cannot be collapsed");
  // A closed surface has as many edges as three triangles have in two; an open one up to three for each.
  const std::uint64_t fixed = memory_without_pairs(soup);
  context.require_memory(fixed + 3 * soup.triangles.size() / 2 * kPairCollapseBytesPerPair, "the pair collapse");
  TriangleSoup clean = soup;
  keep_distinct_triangles(clean);
  const UnitFrame frame(clean);
  std::vector<Point> points(clean.positions.size());
  std::ranges::transform(clean.positions, points.begin(), [&](const Point& p) { return frame.to_unit(p); });
  const std::uint64_t most =
      std::min<std::uint64_t>((context.memory_budget - fixed) / kPairCollapseBytesPerPair, kNone - 1);
  std::vector<VertexPair> pairs = find_vertex_pairs(points, clean.triangles, options.threshold, most, context);
  Stage stage(context, "pair collapse", static_cast<std::int64_t>(clean.triangles.size()) - wanted);
  context.require_memory(fixed + pairs.size() * kPairCollapseBytesPerPair, "the pair collapse");
  std::vector<Quadric<3>> quadrics = make_quadrics(clean, points, options, context);
  PairCollapse collapse(std::move(clean), frame, std::move(points), std::move(quadrics), pairs);
  std::vector<VertexPair>().swap(pairs);
  collapse.run(wanted, stage, options.watcher);
  return collapse.take();
}

}  // namespace voxcarve
