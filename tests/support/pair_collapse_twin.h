// The slow, obvious twin of vertex pairs and of their contraction.
#pragma once

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "common/mesh/pair_collapse.h"
#include "common/mesh/triangle_soup.h"
#include "common/mesh/vertex_pairs.h"

namespace voxcarve::test {

/// The edges of a soup, and the pairs of used vertices nearer than the threshold: every pair is tried.
inline std::set<VertexPair> slow_pairs(const TriangleSoup& soup, double threshold) {
  std::set<std::uint32_t> used;
  std::set<VertexPair> pairs;
  for (const Triangle& t : soup.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      used.insert(t.at(i));
      pairs.insert({std::min(t.at(i), t.at((i + 1) % 3)), std::max(t.at(i), t.at((i + 1) % 3))});
    }
  }
  for (const std::uint32_t a : used) {
    for (const std::uint32_t b : used) {
      if (a < b && (soup.positions[a] - soup.positions[b]).squaredNorm() < threshold * threshold) pairs.insert({a, b});
    }
  }
  return pairs;
}

/// The contraction of [GH97] with nothing kept from step to step but positions, 4 x 4 quadrics about the common origin
/// [GH97, 5] and the set of pairs: every step looks at all pairs.
class SlowPairCollapse {
 public:
  SlowPairCollapse(const TriangleSoup& soup, double threshold, double boundary_weight) : soup_(soup) {
    const Box box = bounds(soup);
    center_ = box.center();
    diagonal_ = box.diagonal();
    for (Point& p : soup_.positions) p = (p - center_) / diagonal_;
    pairs_ = slow_pairs(soup_, threshold);
    quadrics_.assign(soup.positions.size(), Eigen::Matrix4d::Zero());
    std::map<VertexPair, std::vector<std::size_t>> edges;
    for (std::size_t t = 0; t < soup_.triangles.size(); ++t) {
      const Triangle& c = soup_.triangles[t];
      const Point area = area_vector(soup_, c);
      for (std::size_t i = 0; i < 3; ++i) {
        add_plane(c.at(i), area.normalized(), soup_.positions[c[0]], 0.5 * area.norm());
        const auto [low, high] = std::minmax(c.at(i), c.at((i + 1) % 3));
        edges[{low, high}].push_back(t);
      }
    }
    for (const auto& [edge, users] : edges) {
      if (users.size() != 1) continue;
      const Point along = soup_.positions[edge.high] - soup_.positions[edge.low];
      const Point normal = along.cross(area_vector(soup_, soup_.triangles[users.front()])).normalized();
      for (const std::uint32_t v : {edge.low, edge.high})
        add_plane(v, normal, soup_.positions[edge.low], boundary_weight * along.squaredNorm());
    }
  }

  bool step() {
    while (true) {
      const VertexPair* best = nullptr;
      std::pair<bool, double> best_key;
      for (const VertexPair& pair : pairs_) {
        const std::pair<bool, double> key{postponed_.contains(pair), optimum(pair).second};
        if (best == nullptr || key < best_key) {
          best = &pair;
          best_key = key;
        }
      }
      if (best == nullptr) return false;
      const VertexPair pair = *best;
      const Point point = optimum(pair).first;
      if (!best_key.first && inverts(pair, point)) {
        postponed_.insert(pair);
        ++postponements;
        continue;
      }
      contract(pair, point);
      last = {pair.low, pair.high, center_ + diagonal_ * point, best_key.first};
      return true;
    }
  }

  std::size_t triangles() const { return soup_.triangles.size(); }
  const std::vector<Triangle>& triangle_list() const { return soup_.triangles; }
  PairContraction last;
  std::int64_t postponements = 0;

 private:
  void add_plane(std::uint32_t vertex, const Point& normal, const Point& through, double weight) {
    const Eigen::Vector4d plane(normal[0], normal[1], normal[2], -normal.dot(through));
    quadrics_[vertex] += weight * plane * plane.transpose();
  }

  static double error(const Eigen::Matrix4d& quadric, const Point& p) {
    const Eigen::Vector4d h(p[0], p[1], p[2], 1);
    return h.dot(quadric * h);
  }

  /// The point and the key of a pair: the least error, with the documented pull of 1e-10 to the middle; the best of
  /// ends and middle where that is more than two lengths away; exactly one end where that is as good.
  std::pair<Point, double> optimum(const VertexPair& pair) const {
    const Point& a = soup_.positions[pair.low];
    const Point& b = soup_.positions[pair.high];
    const Point middle = 0.5 * (a + b);
    const double length = (b - a).norm();
    const Eigen::Matrix4d sum = quadrics_[pair.low] + quadrics_[pair.high];
    const double trace = sum.topLeftCorner<3, 3>().trace();
    const double pull = 1e-10 * trace;
    const Eigen::Matrix3d matrix = sum.topLeftCorner<3, 3>() + pull * Eigen::Matrix3d::Identity();
    Point best = matrix.inverse() * (pull * middle - sum.topRightCorner<3, 1>());
    if ((best - middle).norm() > 2 * length) {
      best = middle;
      for (const Point& end : {a, b}) {
        if (error(sum, end) < error(sum, best)) best = end;
      }
    }
    const double slack = 1e-14 * trace * length * length;
    const bool a_fits = error(sum, a) <= error(sum, best) + slack;
    const bool b_fits = error(sum, b) <= error(sum, best) + slack;
    const double least = error(sum, best);
    if (a_fits != b_fits) best = a_fits ? a : b;
    return {best, std::max(least, 0.0) + slack};
  }

  bool inverts(const VertexPair& pair, const Point& point) const {
    for (const Triangle& t : soup_.triangles) {
      Triangle moved = t;
      std::ranges::replace(moved, pair.high, pair.low);
      if (!has_distinct_corners(moved)) continue;
      TriangleSoup after = soup_;
      after.positions[pair.low] = after.positions[pair.high] = point;
      if (area_vector(soup_, t).dot(area_vector(after, t)) <= 0) return true;
    }
    return false;
  }

  void contract(const VertexPair& pair, const Point& point) {
    soup_.positions[pair.low] = point;
    quadrics_[pair.low] += quadrics_[pair.high];
    std::vector<Triangle> left;
    std::set<std::set<std::uint32_t>> seen;
    for (Triangle t : soup_.triangles) {
      std::ranges::replace(t, pair.high, pair.low);
      if (has_distinct_corners(t) && seen.insert({t[0], t[1], t[2]}).second) left.push_back(t);
    }
    soup_.triangles = left;
    std::set<std::uint32_t> used;
    for (const Triangle& t : left) used.insert(t.begin(), t.end());
    const auto rename = [&](const std::set<VertexPair>& pairs) {
      std::set<VertexPair> renamed;
      for (VertexPair p : pairs) {
        if (p.low == pair.high) p.low = pair.low;
        if (p.high == pair.high) p.high = pair.low;
        if (p.low > p.high) std::swap(p.low, p.high);
        if (p.low != p.high && used.contains(p.low) && used.contains(p.high)) renamed.insert(p);
      }
      return renamed;
    };
    pairs_ = rename(pairs_);
    std::erase_if(postponed_, [&](const VertexPair& p) {
      return p.low == pair.low || p.high == pair.low || p.low == pair.high || p.high == pair.high ||
             !pairs_.contains(p);
    });
  }

  TriangleSoup soup_;
  Point center_;
  double diagonal_ = 1;
  std::set<VertexPair> pairs_;
  std::set<VertexPair> postponed_;
  std::vector<Eigen::Matrix4d> quadrics_;
};

}  // namespace voxcarve::test
