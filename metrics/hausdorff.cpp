// Branch and bound over pieces of triangles. The distance to a convex set is a convex function, so the distance from a
// piece to one triangle t of the other surface is greatest at a corner of the piece; the least of these over some
// candidates t bounds the piece from above, and distances at corners bound the whole from below [TLK09]. Pieces are cut
// at the middle of their longest side, the one with the greatest bound first.
#include "metrics/hausdorff.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <queue>

#include "common/mesh/aabb_tree.h"

namespace voxcarve {

namespace {

constexpr std::int64_t kGrain = 256;  // queries a chunk
constexpr std::size_t kBatch = 1024;  // pieces that are cut at once; part of the result, so fixed

/// Distance from the surface `from` to the surface behind `tree`.
class OneSidedSearch {
 public:
  OneSidedSearch(const TriangleSoup& from, const TriangleSoup& to, const AabbTree& tree, const RunContext& context)
      : from_(from), to_(to), tree_(tree), context_(context) {}

  /// The interval, at most `error` wide, over the triangles of `from` that have no twin; without allowance for
  /// rounding.
  DistanceInterval run(const std::vector<std::uint8_t>& twin, double error) {
    std::vector<std::uint32_t> triangles;
    for (std::uint32_t t = 0; t < twin.size(); ++t) {
      if (twin[t] == 0) triangles.push_back(t);
    }
    visit_vertices(triangles);
    visit_triangles(triangles);
    while (!heap_.empty() && heap_.top().upper > lower_ + error) cut_batch(error);
    return {lower_, heap_.empty() ? lower_ : std::max(lower_, heap_.top().upper)};
  }

 private:
  struct Foot {
    double distance = 0;
    std::uint32_t nearest = AabbTree::kNone;
  };
  struct Piece {
    std::array<Point, 3> corner;
    std::array<Foot, 3> foot;
    double upper = 0;
    std::uint64_t number = 0;  ///< order of creation, to break ties
    bool operator<(const Piece& other) const {
      return upper != other.upper ? upper < other.upper : number > other.number;
    }
  };

  double squared_distance_to(const Point& point, std::uint32_t triangle) const {
    const Triangle& t = to_.triangles[triangle];
    return squared_distance(point, to_.positions[t[0]], to_.positions[t[1]], to_.positions[t[2]]);
  }

  /// The nearest triangle; `guess` is one that is likely near, or kNone.
  Foot find_foot(const Point& point, std::uint32_t guess) const {
    double squared = std::numeric_limits<double>::infinity();
    if (guess != AabbTree::kNone) squared = squared_distance_to(point, guess);
    const AabbTree::Nearest nearest = tree_.nearest(point, squared);
    if (nearest.triangle == AabbTree::kNone) return {std::sqrt(squared), guess};
    return {std::sqrt(nearest.squared_distance), nearest.triangle};
  }

  void visit_vertices(const std::vector<std::uint32_t>& triangles) {
    std::vector<std::uint32_t> used;
    std::vector<std::uint8_t> seen(from_.positions.size(), 0);
    for (const std::uint32_t t : triangles) {
      for (const std::uint32_t v : from_.triangles[t]) {
        if (seen[v] == 0) used.push_back(v);
        seen[v] = 1;
      }
    }
    feet_.resize(from_.positions.size());
    parallel_for(context_, 0, static_cast<std::int64_t>(used.size()), kGrain,
                 [&](std::int64_t first, std::int64_t last) {
                   std::uint32_t guess = AabbTree::kNone;  // neighbours in the list are mostly neighbours in space
                   for (auto i = static_cast<std::size_t>(first); i < static_cast<std::size_t>(last); ++i) {
                     feet_[used[i]] = find_foot(from_.positions[used[i]], guess);
                     guess = feet_[used[i]].nearest;
                   }
                 });
    for (const std::uint32_t v : used) lower_ = std::max(lower_, feet_[v].distance);
  }

  void visit_triangles(const std::vector<std::uint32_t>& triangles) {
    std::vector<Piece> pieces(triangles.size());
    parallel_for(context_, 0, static_cast<std::int64_t>(triangles.size()), kGrain,
                 [&](std::int64_t first, std::int64_t last) {
                   for (auto i = static_cast<std::size_t>(first); i < static_cast<std::size_t>(last); ++i) {
                     const Triangle& t = from_.triangles[triangles[i]];
                     for (std::size_t c = 0; c < 3; ++c) {
                       pieces[i].corner[c] = from_.positions[t[c]];
                       pieces[i].foot[c] = feet_[t[c]];
                     }
                     pieces[i].upper = upper_bound(pieces[i]);
                   }
                 });
    for (Piece& piece : pieces) push(piece);
  }

  /// Pieces that cannot exceed the lower bound have no say in the result.
  void push(Piece& piece) {
    piece.number = created_++;
    if (piece.upper > lower_) heap_.push(piece);
  }

  /// A bound on the distance of all points of the piece.
  double upper_bound(const Piece& piece) const {
    const auto& c = piece.corner;
    const auto& foot = piece.foot;
    const std::array<double, 3> side = {(c[1] - c[0]).norm(), (c[2] - c[1]).norm(), (c[0] - c[2]).norm()};
    const double longest = std::max({side[0], side[1], side[2]});
    // Distances change no faster than position, and no point of a triangle is further than longest / sqrt(3) from all
    // corners (equality in the equilateral one).
    double best = std::max({foot[0].distance, foot[1].distance, foot[2].distance}) + longest * 0.57735026918962585;
    for (std::size_t i = 0; i < 3; ++i) {
      best = std::min(best, foot[i].distance + std::max(side[i], side[(i + 2) % 3]));
      if (i > 0 && (foot[i].nearest == foot[0].nearest || (i == 2 && foot[2].nearest == foot[1].nearest))) continue;
      double squared = 0;
      for (std::size_t j = 0; j < 3; ++j) squared = std::max(squared, squared_distance_to(c[j], foot[i].nearest));
      best = std::min(best, std::sqrt(squared));
    }
    return best;
  }

  std::array<Piece, 2> cut(const Piece& piece) const {
    const auto& c = piece.corner;
    std::size_t i = 0;  // the longest side runs from corner i to corner j
    for (std::size_t k = 1; k < 3; ++k) {
      if ((c[(k + 1) % 3] - c[k]).squaredNorm() > (c[(i + 1) % 3] - c[i]).squaredNorm()) i = k;
    }
    const std::size_t j = (i + 1) % 3;
    const Point middle = 0.5 * (c[i] + c[j]);
    const Foot foot = find_foot(middle, piece.foot[i].nearest);
    std::array<Piece, 2> halves = {piece, piece};
    halves[0].corner[j] = halves[1].corner[i] = middle;
    halves[0].foot[j] = halves[1].foot[i] = foot;
    for (Piece& half : halves) half.upper = std::min(piece.upper, upper_bound(half));
    return halves;
  }

  void cut_batch(double error) {
    std::vector<Piece> batch;
    while (!heap_.empty() && batch.size() < kBatch && heap_.top().upper > lower_ + error) {
      batch.push_back(heap_.top());
      heap_.pop();
    }
    std::vector<std::array<Piece, 2>> halves(batch.size());
    parallel_for(context_, 0, static_cast<std::int64_t>(batch.size()), kGrain,
                 [&](std::int64_t first, std::int64_t last) {
                   for (auto i = static_cast<std::size_t>(first); i < static_cast<std::size_t>(last); ++i) {
                     halves[i] = cut(batch[i]);
                   }
                 });
    for (const auto& pair : halves) {
      for (const Foot& foot : pair[0].foot) lower_ = std::max(lower_, foot.distance);
    }
    for (auto& pair : halves) {
      for (Piece& half : pair) push(half);
    }
  }

  const TriangleSoup& from_;
  const TriangleSoup& to_;
  const AabbTree& tree_;
  const RunContext& context_;
  std::vector<Foot> feet_;  ///< of the vertices of `from`
  std::priority_queue<Piece> heap_;
  double lower_ = 0;
  std::uint64_t created_ = 0;
};

struct Moments {
  double mean = 0;
  double mean_square = 0;
};

/// Mean distance over area-uniform samples.
std::optional<Moments> sampled_moments(const MeasuredSurface& from, const AabbTree& to, std::int64_t samples,
                                       std::uint64_t stream, RunContext& context) {
  const std::vector<SampleFoot> feet = sample_feet(from, to, samples, stream, context);
  if (feet.empty()) return std::nullopt;
  Moments sum;
  for (const SampleFoot& foot : feet) {
    sum.mean += std::sqrt(foot.squared_distance);
    sum.mean_square += foot.squared_distance;
  }
  const auto count = static_cast<double>(feet.size());
  return Moments{sum.mean / count, sum.mean_square / count};
}

/// Widens an interval of normalised units by the rounding allowance and turns it into model units.
DistanceInterval certified(const DistanceInterval& interval, const SurfacePair& pair) {
  return {std::max(0.0, interval.lower - pair.rounding) / pair.scale, (interval.upper + pair.rounding) / pair.scale};
}

}  // namespace

std::variant<HausdorffDistances, Undefined> hausdorff_distances(const SurfacePair& pair, const MeasuredSurface& from_a,
                                                                const MeasuredSurface& from_b,
                                                                const HausdorffOptions& options, RunContext& context) {
  if (from_a.soup.empty()) return Undefined{"no part of the first shape to measure from"};
  if (from_b.soup.empty()) return Undefined{"no part of the second shape to measure from"};
  HausdorffDistances result;
  result.diagonal = pair.diagonal;
  // The allowance on both sides is part of the promised width.
  const double error = std::max(options.error * pair.diagonal * pair.scale - 2 * pair.rounding, 2 * pair.rounding);
  const auto one_sided = [&](const MeasuredSurface& from, const MeasuredSurface& to,
                             const AabbTree& tree) -> DistanceInterval {
    context.check_cancelled();
    if (std::find(from.twin.begin(), from.twin.end(), 0) == from.twin.end()) return {0, 0};
    return certified(OneSidedSearch(from.soup, to.soup, tree, context).run(from.twin, error), pair);
  };
  result.a_to_b = one_sided(from_a, pair.b, pair.tree_b);
  result.b_to_a = one_sided(from_b, pair.a, pair.tree_a);
  result.symmetric = {std::max(result.a_to_b.lower, result.b_to_a.lower),
                      std::max(result.a_to_b.upper, result.b_to_a.upper)};

  const auto moments_a = sampled_moments(from_a, pair.tree_b, options.samples, 1, context);
  const auto moments_b = sampled_moments(from_b, pair.tree_a, options.samples, 2, context);
  if (moments_a && moments_b) {
    result.mean = (moments_a->mean + moments_b->mean) / 2 / pair.scale;
    result.rms = std::sqrt((moments_a->mean_square + moments_b->mean_square) / 2) / pair.scale;
  }
  return result;
}

std::variant<HausdorffDistances, Undefined> hausdorff_distances(const TriangleSoup& a, const TriangleSoup& b,
                                                                const HausdorffOptions& options, RunContext& context) {
  const auto pair = prepare_pair(a, b, context);
  if (const auto* reason = std::get_if<Undefined>(&pair)) return *reason;
  const auto& surfaces = std::get<SurfacePair>(pair);
  return hausdorff_distances(surfaces, surfaces.a, surfaces.b, options, context);
}

}  // namespace voxcarve
