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
#include "metrics/counter_random.h"

namespace voxcarve {

namespace {

constexpr std::int64_t kGrain = 256;    // queries a chunk
constexpr std::size_t kBatch = 1024;    // pieces that are cut at once; part of the result, so fixed
constexpr double kRoundingSteps = 256;  // roundings of a coordinate between input and distance, generously

/// Both surfaces about the centre of a's box, scaled by a power of two so that its diagonal is in [1, 2).
struct Normalised {
  TriangleSoup a, b;
  double scale = 1;     ///< model units times scale are normalised units
  double rounding = 0;  ///< largest rounding error of a distance, in normalised units
};

TriangleSoup transformed(const TriangleSoup& soup, const Point& center, double scale) {
  TriangleSoup result;
  result.triangles = soup.triangles;
  result.positions.assign(soup.positions.size(), Point::Zero());
  for (const Triangle& triangle : soup.triangles) {
    for (const std::uint32_t v : triangle) result.positions[v] = scale * (soup.positions[v] - center);
  }
  return result;
}

/// The corners of every triangle in lexicographic order: equal keys are equal triangles as sets of points.
using TriangleKey = std::array<double, 9>;

std::vector<TriangleKey> keys_of(const TriangleSoup& soup) {
  std::vector<TriangleKey> keys;
  keys.reserve(soup.triangles.size());
  for (const Triangle& t : soup.triangles) {
    std::array<std::array<double, 3>, 3> corner;
    for (std::size_t c = 0; c < 3; ++c) {
      const Point& p = soup.positions[t[c]];
      corner[c] = {p[0] + 0.0, p[1] + 0.0, p[2] + 0.0};  // + 0.0 turns -0 into 0
    }
    std::sort(corner.begin(), corner.end());
    TriangleKey key;
    for (std::size_t i = 0; i < 9; ++i) key[i] = corner[i / 3][i % 3];
    keys.push_back(key);
  }
  return keys;
}

/// By triangle of `from`: 1 when it is a triangle of `to` too, so that its points are at distance 0 exactly.
std::vector<std::uint8_t> find_twins(const TriangleSoup& from, const TriangleSoup& to) {
  std::vector<TriangleKey> others = keys_of(to);
  std::sort(others.begin(), others.end());
  const std::vector<TriangleKey> keys = keys_of(from);
  std::vector<std::uint8_t> twin(keys.size());
  for (std::size_t t = 0; t < keys.size(); ++t) {
    twin[t] = std::binary_search(others.begin(), others.end(), keys[t]) ? 1 : 0;
  }
  return twin;
}

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

/// Mean distance over area-uniform samples, one in each of `samples` equal shares of the area.
std::optional<Moments> sampled_moments(const TriangleSoup& from, const std::vector<std::uint8_t>& twin,
                                       const AabbTree& tree, std::int64_t samples, std::uint64_t stream,
                                       const RunContext& context) {
  std::vector<double> area_up_to;
  double area = 0;
  for (const Triangle& t : from.triangles) area_up_to.push_back(area += area_vector(from, t).norm());
  if (!(area > 0) || samples < 1) return std::nullopt;
  const CounterRandom random(context.seed, stream);
  std::vector<double> squared(static_cast<std::size_t>(samples));
  parallel_for(context, 0, samples, kGrain, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t i = first; i < last; ++i) {
      const auto counter = 3 * static_cast<std::uint64_t>(i);
      const double share = (static_cast<double>(i) + random(counter)) / static_cast<double>(samples);
      const auto found = std::upper_bound(area_up_to.begin(), area_up_to.end() - 1, share * area);
      const auto triangle = static_cast<std::size_t>(found - area_up_to.begin());
      if (twin[triangle] != 0) continue;
      const Triangle& t = from.triangles[triangle];
      const double root = std::sqrt(random(counter + 1));
      const double along = random(counter + 2);
      const Point point = (1 - root) * from.positions[t[0]] + root * (1 - along) * from.positions[t[1]] +
                          root * along * from.positions[t[2]];
      squared[static_cast<std::size_t>(i)] = tree.nearest(point).squared_distance;
    }
  });
  Moments sum;
  for (const double s : squared) {
    sum.mean += std::sqrt(s);
    sum.mean_square += s;
  }
  return Moments{sum.mean / static_cast<double>(samples), sum.mean_square / static_cast<double>(samples)};
}

std::variant<Normalised, Undefined> normalise(const TriangleSoup& a, const TriangleSoup& b, double& diagonal) {
  Box box = bounds(a);
  diagonal = box.diagonal();
  if (!(diagonal > 0)) {
    box.extend(bounds(b));
    diagonal = box.diagonal();
  }
  Normalised result;
  if (diagonal > 0 && std::isfinite(diagonal)) {
    // Scaling in the range of normal numbers; beyond it the check below or the rounding allowance takes over.
    result.scale = std::ldexp(1.0, -std::clamp(std::ilogb(diagonal), -1000, 1000));
  }
  result.a = transformed(a, box.center(), result.scale);
  result.b = transformed(b, box.center(), result.scale);
  Box both = bounds(result.a);
  both.extend(bounds(result.b));
  const double reach = std::max(both.lower.cwiseAbs().maxCoeff(), both.upper.cwiseAbs().maxCoeff());
  if (!std::isfinite(diagonal) || !(reach < 1e70)) {  // fourth powers must not overflow
    return Undefined{"the shapes' coordinates are too far apart for double precision"};
  }
  result.rounding = kRoundingSteps * std::numeric_limits<double>::epsilon() * reach;
  return result;
}

/// Widens an interval of normalised units by the rounding allowance and turns it into model units.
DistanceInterval certified(const DistanceInterval& interval, const Normalised& shapes) {
  return {std::max(0.0, interval.lower - shapes.rounding) / shapes.scale,
          (interval.upper + shapes.rounding) / shapes.scale};
}

}  // namespace

std::variant<HausdorffDistances, Undefined> hausdorff_distances(const TriangleSoup& a, const TriangleSoup& b,
                                                                const HausdorffOptions& options,
                                                                const RunContext& context) {
  if (a.empty()) return Undefined{"the first shape has no triangles"};
  if (b.empty()) return Undefined{"the second shape has no triangles"};
  HausdorffDistances result;
  auto normalised = normalise(a, b, result.diagonal);
  if (const auto* reason = std::get_if<Undefined>(&normalised)) return *reason;
  const auto& shapes = std::get<Normalised>(normalised);
  const AabbTree tree_a(shapes.a);
  context.check_cancelled();
  const AabbTree tree_b(shapes.b);

  // The allowance on both sides is part of the promised width.
  const double error =
      std::max(options.error * result.diagonal * shapes.scale - 2 * shapes.rounding, 2 * shapes.rounding);
  const std::vector<std::uint8_t> twin_a = find_twins(a, b);
  const std::vector<std::uint8_t> twin_b = find_twins(b, a);
  const auto one_sided = [&](const TriangleSoup& from, const std::vector<std::uint8_t>& twin, const TriangleSoup& to,
                             const AabbTree& tree) -> DistanceInterval {
    context.check_cancelled();
    if (std::find(twin.begin(), twin.end(), 0) == twin.end()) return {0, 0};
    return certified(OneSidedSearch(from, to, tree, context).run(twin, error), shapes);
  };
  result.a_to_b = one_sided(shapes.a, twin_a, shapes.b, tree_b);
  result.b_to_a = one_sided(shapes.b, twin_b, shapes.a, tree_a);
  result.symmetric = {std::max(result.a_to_b.lower, result.b_to_a.lower),
                      std::max(result.a_to_b.upper, result.b_to_a.upper)};

  const auto from_a = sampled_moments(shapes.a, twin_a, tree_b, options.samples, 1, context);
  const auto from_b = sampled_moments(shapes.b, twin_b, tree_a, options.samples, 2, context);
  if (from_a && from_b) {
    result.mean = (from_a->mean + from_b->mean) / 2 / shapes.scale;
    result.rms = std::sqrt((from_a->mean_square + from_b->mean_square) / 2) / shapes.scale;
  }
  return result;
}

}  // namespace voxcarve
