// Based on [GH97] and [GH98]; differs in quadrics about their own vertices, in the order (see the header) and in fixing
// inner vertices to the boundary vertex they collapse onto.
#include "common/mesh/quadric_collapse.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/mesh/topology.h"

namespace voxcarve {

namespace {

constexpr std::uint32_t kNone = CornerTable::kNone;
constexpr std::uint32_t kCheckInterval = 1U << 12;  // edges between two reports of progress

/// Least ratio of a triangle's twice area to its longest side squared that counts as an area: what rounding leaves of a
/// triangle whose corners lie on a line is below.
constexpr double kSmallestArea = 1e-8;

/// Twice the area vector of a triangle, and its longest side squared.
struct Extent {
  Eigen::Vector3d area;
  double longest = 0;

  Extent(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c)
      : area((b - a).cross(c - a)),
        longest(std::max({(b - a).squaredNorm(), (c - a).squaredNorm(), (c - b).squaredNorm()})) {}
  bool has_area() const { return area.squaredNorm() > kSmallestArea * kSmallestArea * longest * longest; }
};

}  // namespace

template <int N>
QuadricCollapse<N>::QuadricCollapse(CornerTable table, std::vector<Vector> points, std::vector<Quadric<N>> quadrics)
    : table_(std::move(table)),
      points_(std::move(points)),
      quadrics_(std::move(quadrics)),
      vertex_source_(table_.vertices()),
      triangle_source_(table_.slots()) {
  std::iota(vertex_source_.begin(), vertex_source_.end(), 0U);
  std::iota(triangle_source_.begin(), triangle_source_.end(), 0U);
  for (std::uint32_t v = 0; v < table_.vertices(); ++v) {
    has_boundary_ = has_boundary_ || (table_.leaving(v) != kNone && table_.on_boundary(v));
  }
}

template <int N>
void QuadricCollapse<N>::run(std::uint32_t triangles, Stage& stage) {
  const std::uint32_t target = std::max(triangles, least_triangles());
  const auto coarseness = [target](std::uint32_t goal) {  // 16 buckets are an octave
    return goal / 16 > target ? 6 : goal / 4 > target ? 3 : 0;
  };
  fill_queue(stage);
  bool ran_out = false;  // of edges, before the goal: hardly any more will go, so these are the last rounds
  while (table_.triangles() > triangles) {
    const std::uint32_t before = table_.triangles();
    const std::uint32_t goal = std::max(triangles, before / 2);
    const int coarse = ran_out ? 0 : coarseness(goal);
    last_rounds_ = coarse == 0;
    run_round(goal, coarse, stage);
    ran_out = ran_out || table_.triangles() > goal;
    compact();
    if (table_.triangles() == before) break;  // each edge that is left was refused, and nothing has changed since
    requeue_refused();
  }
}

/// What no order of collapses gets below: a component keeps a triangle, a closed one a tetrahedron.
template <int N>
std::uint32_t QuadricCollapse<N>::least_triangles() const {
  DisjointSets components(table_.vertices());
  for (std::uint32_t t = 0; t < table_.slots(); ++t) {
    if (table_.removed(t)) continue;
    const Triangle corner = table_.corners(t);
    components.join(corner[0], corner[1]);
    components.join(corner[0], corner[2]);
  }
  std::vector<std::uint8_t> least(table_.vertices(), 0);  // by a component's representative
  for (std::uint32_t v = 0; v < table_.vertices(); ++v) {
    if (table_.leaving(v) == kNone) continue;
    std::uint8_t& of_component = least[components.find(v)];
    if (of_component != 1) of_component = table_.on_boundary(v) ? 1 : 4;
  }
  return std::accumulate(least.begin(), least.end(), 0U);
}

template <int N>
void QuadricCollapse<N>::run_round(std::uint32_t goal, int coarseness, Stage& stage) {
  std::vector<std::uint32_t> sweep;
  std::uint32_t visited = 0;
  std::uint32_t reported = table_.triangles();
  const auto report = [&] {
    stage.advance(reported - table_.triangles());
    reported = table_.triangles();
  };
  while (table_.triangles() > goal && queue_.take(sweep, coarseness)) {
    std::size_t next = 0;
    for (; next < sweep.size() && table_.triangles() > goal; ++next) {
      if (++visited % kCheckInterval == 0) report();
      visit(sweep[next]);
    }
    for (; next < sweep.size(); ++next) queue_.push_now(sweep[next]);
  }
  report();
}

template <int N>
void QuadricCollapse<N>::fill_queue(Stage& stage) {
  for (std::uint32_t t = 0; t < table_.slots(); ++t) {
    if (t % kCheckInterval == 0) stage.advance(0);
    for (std::uint32_t half_edge = 4 * t; half_edge < 4 * t + 3; ++half_edge) {
      if (table_.edge_of(half_edge) != half_edge) continue;
      queue_.push(half_edge, priority(half_edge));
      table_.mark(half_edge) = kQueued;
    }
  }
}

/// Collapses the edge, puts it back into the queue with its new cost, or drops it.
template <int N>
void QuadricCollapse<N>::visit(std::uint32_t half_edge) {
  if (table_.removed(CornerTable::triangle_of(half_edge))) return;
  std::uint8_t& mark = table_.mark(half_edge);
  const bool stale = (mark & kStale) != 0;
  mark = 0;
  if (table_.edge_of(half_edge) != half_edge) return;  // its twin stands for it since a collapse joined the two
  if (stale) {
    // Even if it stays in this bucket: a vertex that had just one collapse lets its neighbours go first, so that flat
    // regions thin out evenly.
    queue_.push(half_edge, priority(half_edge));
    mark = kQueued;
    return;
  }
  Merger merged = merger(half_edge);
  put_on_end(half_edge, merged);
  if (!is_allowed(half_edge, merged.point)) {
    mark = kRefused;
    return;
  }
  const std::uint32_t vertex = table_.start(half_edge);
  collapse(half_edge, merged);
  requeue_around(vertex);
  if (last_rounds_) requeue_refused_near(vertex);
}

template <int N>
typename QuadricCollapse<N>::Merger QuadricCollapse<N>::merger(std::uint32_t half_edge) const {
  // An optimum so many edge lengths away comes from planes that are nearly parallel, and would spoil the triangles.
  constexpr double kReach = 2;
  const std::uint32_t start = table_.start(half_edge);
  const std::uint32_t end = table_.end(half_edge);
  Merger result;
  result.half = 0.5 * (points_[end] - points_[start]);
  result.sum = Quadric<N>::sum_about_middle(quadrics_[start], quadrics_[end], result.half);
  // An inner vertex goes to the boundary vertex, which stays.
  const bool start_fixed = has_boundary_ && table_.on_boundary(start) && !table_.on_boundary(end);
  const bool end_fixed = has_boundary_ && table_.on_boundary(end) && !table_.on_boundary(start);
  if (start_fixed || end_fixed) {
    result.step = start_fixed ? Vector(-result.half) : result.half;
    result.cost = result.sum(result.step);
    result.point = points_[start_fixed ? start : end];
    return result;
  }
  const auto [step, value] = result.sum.minimum();
  constexpr double kFarthest = 2 * kReach;  // in half edges
  const bool near = step.squaredNorm() <= kFarthest * kFarthest * result.half.squaredNorm();
  result.step = near ? step : best_of_ends_and_middle(result);
  result.cost = near ? value : result.sum(result.step);
  result.point = points_[start] + result.half + result.step;
  return result;
}

template <int N>
double QuadricCollapse<N>::priority(std::uint32_t half_edge) const {
  const Merger merged = merger(half_edge);
  const double weight = merged.sum.trace();
  return weight > 0 ? merged.cost / std::sqrt(weight) : 0;
}

template <int N>
typename QuadricCollapse<N>::Vector QuadricCollapse<N>::best_of_ends_and_middle(const Merger& merger) const {
  Vector best = Vector::Zero();
  double least = merger.sum(best);
  for (const Vector& step : {Vector(-merger.half), merger.half}) {
    const double value = merger.sum(step);
    if (value < least) {
      least = value;
      best = step;
    }
  }
  return best;
}

/// Where exactly one end is as good a place as the optimum, to rounding, it is taken: corners and creases stay as they
/// are to the last bit. Where both are, the region is flat, and the middle keeps its triangles in better shape.
template <int N>
void QuadricCollapse<N>::put_on_end(std::uint32_t half_edge, Merger& merger) const {
  constexpr double kRounding = 1e-7;  // of the edge's length
  const double slack = kRounding * kRounding * merger.sum.trace() * 4 * merger.half.squaredNorm();
  const bool start_fits = merger.sum(-merger.half) <= merger.cost + slack;
  const bool end_fits = merger.sum(merger.half) <= merger.cost + slack;
  if (start_fits == end_fits) return;
  merger.step = start_fits ? Vector(-merger.half) : merger.half;
  merger.point = points_[start_fits ? table_.start(half_edge) : table_.end(half_edge)];
}

template <int N>
bool QuadricCollapse<N>::is_allowed(std::uint32_t half_edge, const Vector& point) {
  const std::uint32_t start = table_.start(half_edge);
  const std::uint32_t end = table_.end(half_edge);
  table_.gather(start, start_ring_);
  table_.gather(end, end_ring_);
  return table_.may_collapse(half_edge, start_ring_, end_ring_) && !turns_triangle(start_ring_, end, point) &&
         !turns_triangle(end_ring_, start, point);
}

/// True when a triangle at one end of an edge, except those at the edge, would turn by a right angle or more or lose
/// its area by moving its corner to `point`.
template <int N>
bool QuadricCollapse<N>::turns_triangle(const CornerTable::Ring& ring, std::uint32_t other_end,
                                        const Vector& point) const {
  return std::any_of(ring.half_edges.begin(), ring.half_edges.end(), [&](std::uint32_t half_edge) {
    const std::uint32_t second = table_.end(half_edge);
    const std::uint32_t third = table_.apex(half_edge);
    if (second == other_end || third == other_end) return false;
    const Eigen::Vector3d b = points_[second].template head<3>();
    const Eigen::Vector3d c = points_[third].template head<3>();
    const Extent before(points_[table_.start(half_edge)].template head<3>(), b, c);
    const Extent after(point.template head<3>(), b, c);
    if (before.area.dot(after.area) > 0 && after.has_area()) return false;
    return before.has_area();  // or there is nothing to lose
  });
}

template <int N>
void QuadricCollapse<N>::collapse(std::uint32_t half_edge, const Merger& merger) {
  const std::uint32_t start = table_.start(half_edge);
  const std::uint32_t end = table_.end(half_edge);
  if (watcher) watcher(table_, {start, end, merger.point, merger.cost});
  if (!carried_colors.empty()) carry_color(start, end, merger.point);
  if (merger.point == points_[end]) {
    vertex_source_[start] = vertex_source_[end];
  } else if (merger.point != points_[start]) {
    vertex_source_[start] = kNone;
  }
  quadrics_[start] = merger.sum.moved(merger.step);
  points_[start] = merger.point;
  table_.collapse(half_edge);
}

template <int N>
void QuadricCollapse<N>::carry_color(std::uint32_t start, std::uint32_t end, const Vector& point) {
  const Eigen::Vector3d edge = (points_[end] - points_[start]).template head<3>();
  const double length = edge.squaredNorm();
  const double share = length > 0 ? edge.dot((point - points_[start]).template head<3>()) / length : 0.5;
  const auto weight = static_cast<float>(std::clamp(share, 0.0, 1.0));
  carried_colors[start] += weight * (carried_colors[end] - carried_colors[start]);
}

template <int N>
void QuadricCollapse<N>::requeue(std::uint32_t edge) {
  std::uint8_t& mark = table_.mark(edge);
  if ((mark & kQueued) == 0) queue_.push_now(edge);
  mark = kQueued | kStale;
}

/// The priorities around a vertex that a collapse made are out of date. Of two edges that became one, the one may come
/// back here that had no place in the queue.
template <int N>
void QuadricCollapse<N>::requeue_around(std::uint32_t vertex) {
  table_.for_each_edge(vertex, [&](std::uint32_t edge) { requeue(edge); });
}

template <int N>
void QuadricCollapse<N>::requeue_refused() {
  for (std::uint32_t t = 0; t < table_.slots(); ++t) {
    for (std::uint32_t half_edge = 4 * t; half_edge < 4 * t + 3; ++half_edge) {
      if ((table_.mark(half_edge) & kRefused) != 0 && table_.edge_of(half_edge) == half_edge) requeue(half_edge);
    }
  }
}

/// Whether the triangles at a neighbour turn depends on this vertex.
template <int N>
void QuadricCollapse<N>::requeue_refused_near(std::uint32_t vertex) {
  table_.gather(vertex, start_ring_);
  for (const std::uint32_t neighbor : start_ring_.neighbors) {
    table_.for_each_edge(neighbor, [&](std::uint32_t edge) {
      if ((table_.mark(edge) & kRefused) != 0) requeue(edge);
    });
  }
}

template <int N>
void QuadricCollapse<N>::compact() {
  const CornerTable::Moves moves = table_.compact();
  for (std::size_t t = 0; t < moves.old_triangle.size(); ++t) {
    triangle_source_[t] = triangle_source_[moves.old_triangle[t]];
  }
  triangle_source_.resize(moves.old_triangle.size());
  const auto close_gaps = [&](auto& values) {
    for (std::size_t v = 0; v < moves.old_vertex.size(); ++v) values[v] = values[moves.old_vertex[v]];
    values.resize(moves.old_vertex.size());
  };
  close_gaps(points_);
  close_gaps(quadrics_);
  close_gaps(vertex_source_);
  if (!carried_colors.empty()) close_gaps(carried_colors);
  // Renaming keeps the order of half-edges, so what stood for its edge still does.
  queue_.rename([&](std::uint32_t half_edge) { return moves.renamed(half_edge); });
}

template class QuadricCollapse<3>;
template class QuadricCollapse<6>;

}  // namespace voxcarve
