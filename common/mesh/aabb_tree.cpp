// Binned surface-area heuristic after Wald, "On fast construction of SAH-based bounding volume hierarchies", 2007.
#include "common/mesh/aabb_tree.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <numeric>

namespace voxcarve {

namespace {

constexpr std::uint32_t kLeafSize = 4;
constexpr std::size_t kBins = 16;
constexpr int kHeuristicDepth = 40;  // below it nodes are halved, so a query's stack is bounded by 40 + 32
constexpr int kStackSize = 80;

double squared_distance_to_segment(const Point& p, const Point& a, const Point& b) {
  // Measured from the nearer end, so that a point at either end has distance 0 exactly.
  const Point ab = b - a;
  const Point ap = p - a;
  const Point bp = p - b;
  const double length = ab.squaredNorm();
  const double along = ab.dot(ap);
  if (!(along > 0)) return ap.squaredNorm();
  if (along >= length) return bp.squaredNorm();
  return std::min({(ap - (along / length) * ab).squaredNorm(), ap.squaredNorm(), bp.squaredNorm()});
}

/// Surface measure of a box, for the heuristic.
double half_area(const Box& box) {
  const Point e = box.extent();
  return e[0] * e[1] + e[1] * e[2] + e[2] * e[0];
}

}  // namespace

double squared_distance(const Point& p, const Point& a, const Point& b, const Point& c) {
  const Point ab = b - a;
  const Point ac = c - a;
  const Point ap = p - a;
  const Point normal = ab.cross(ac);
  const double area = normal.squaredNorm();  // of the parallelogram, squared
  const double size = std::max({ab.squaredNorm(), ac.squaredNorm(), (c - b).squaredNorm()});
  double best = std::numeric_limits<double>::infinity();
  const bool sliver = area < 1e-8 * size * size;  // height below 1e-4 of the longest side
  double v = -1;
  double w = -1;
  if (area > 1e-28 * size * size) {
    v = normal.dot(ap.cross(ac)) / area;
    w = normal.dot(ab.cross(ap)) / area;
    Point rest = ap - v * ab - w * ac;
    if (sliver) {  // the first foot may be off by eps * size^2 / height along the plane; its residual corrects it
      const double dv = normal.dot(rest.cross(ac)) / area;
      const double dw = normal.dot(ab.cross(rest)) / area;
      v += dv;
      w += dw;
      rest -= dv * ab + dw * ac;
    }
    if (v >= 0 && w >= 0 && v + w <= 1) best = rest.squaredNorm();
    if (best == 0 || (!sliver && best < std::numeric_limits<double>::infinity())) return best;
  }
  // The nearest point lies on a side that the foot is beyond; all sides of a sliver count, its foot being uncertain.
  if (sliver || v < 0) best = std::min(best, squared_distance_to_segment(p, a, c));
  if (sliver || w < 0) best = std::min(best, squared_distance_to_segment(p, a, b));
  if (sliver || v + w > 1) best = std::min(best, squared_distance_to_segment(p, b, c));
  return best;
}

struct AabbTree::Builder {
  const TriangleSoup& soup;
  std::vector<Box> boxes;
  std::vector<Point> centers;
  std::vector<std::uint32_t> order;
  std::vector<Node>& nodes;

  Builder(const TriangleSoup& s, std::vector<Node>& n) : soup(s), order(s.triangles.size()), nodes(n) {
    std::iota(order.begin(), order.end(), 0U);
    boxes.reserve(soup.triangles.size());
    centers.reserve(soup.triangles.size());
    for (const Triangle& triangle : soup.triangles) {
      Box box;
      for (const std::uint32_t vertex : triangle) box.extend(soup.positions[vertex]);
      boxes.push_back(box);
      centers.push_back(box.center());
    }
  }

  /// Splits order[begin, end) where the heuristic is least and gives the position, or `begin` when it finds no split.
  std::uint32_t split_by_area(std::uint32_t begin, std::uint32_t end, const Box& range) {
    double best_cost = std::numeric_limits<double>::infinity();
    int best_axis = -1;
    std::size_t best_bin = 0;
    for (int axis = 0; axis < 3; ++axis) {
      if (!(range.upper[axis] > range.lower[axis])) continue;
      std::array<Box, kBins> bin_box;
      std::array<std::uint32_t, kBins> bin_count{};
      for (std::uint32_t i = begin; i < end; ++i) {
        const std::size_t bin = bin_of(order[i], axis, range);
        bin_box[bin].extend(boxes[order[i]]);
        ++bin_count[bin];
      }
      std::array<double, kBins> right_cost{};  // of the bins from i on
      Box box;
      std::uint32_t count = 0;
      for (std::size_t i = kBins; i-- > 1;) {
        box.extend(bin_box[i]);
        count += bin_count[i];
        right_cost[i] = count == 0 ? 0 : half_area(box) * count;
      }
      box = Box();
      count = 0;
      for (std::size_t i = 1; i < kBins; ++i) {
        box.extend(bin_box[i - 1]);
        count += bin_count[i - 1];
        if (count == 0 || count == end - begin) continue;
        const double cost = half_area(box) * count + right_cost[i];
        if (cost < best_cost) {
          best_cost = cost;
          best_axis = axis;
          best_bin = i;
        }
      }
    }
    if (best_axis < 0) return begin;
    const auto middle = std::stable_partition(order.begin() + begin, order.begin() + end, [&](std::uint32_t triangle) {
      return bin_of(triangle, best_axis, range) < best_bin;
    });
    return static_cast<std::uint32_t>(middle - order.begin());
  }

  std::size_t bin_of(std::uint32_t triangle, int axis, const Box& range) const {
    const double share = (centers[triangle][axis] - range.lower[axis]) / (range.upper[axis] - range.lower[axis]);
    return std::min(kBins - 1, static_cast<std::size_t>(share * static_cast<double>(kBins)));
  }

  std::uint32_t split_in_halves(std::uint32_t begin, std::uint32_t end, const Box& range) {
    Eigen::Index axis = 0;
    range.extent().maxCoeff(&axis);
    const std::uint32_t middle = begin + (end - begin) / 2;
    std::nth_element(order.begin() + begin, order.begin() + middle, order.begin() + end,
                     [&](std::uint32_t i, std::uint32_t j) {
                       return centers[i][axis] != centers[j][axis] ? centers[i][axis] < centers[j][axis] : i < j;
                     });
    return middle;
  }

  void build(std::uint32_t node, std::uint32_t begin, std::uint32_t end, int depth) {
    Box box;
    Box range;
    for (std::uint32_t i = begin; i < end; ++i) {
      box.extend(boxes[order[i]]);
      range.extend(centers[order[i]]);
    }
    nodes[node].lower = box.lower;
    nodes[node].upper = box.upper;
    if (end - begin <= kLeafSize) {
      nodes[node].first = begin;
      nodes[node].count = end - begin;
      return;
    }
    std::uint32_t middle = depth < kHeuristicDepth ? split_by_area(begin, end, range) : begin;
    if (middle == begin || middle == end) middle = split_in_halves(begin, end, range);
    const auto left = static_cast<std::uint32_t>(nodes.size());
    nodes[node].first = left;
    nodes.resize(nodes.size() + 2);
    build(left, begin, middle, depth + 1);
    build(left + 1, middle, end, depth + 1);
  }
};

AabbTree::AabbTree(const TriangleSoup& soup) {
  if (soup.empty()) return;
  Builder builder(soup, nodes_);
  nodes_.resize(1);
  builder.build(0, 0, static_cast<std::uint32_t>(soup.triangles.size()), 0);
  corners_.reserve(builder.order.size());
  for (const std::uint32_t triangle : builder.order) {
    const Triangle& t = soup.triangles[triangle];
    corners_.push_back({soup.positions[t[0]], soup.positions[t[1]], soup.positions[t[2]], triangle});
  }
}

double AabbTree::squared_distance_to_box(const Node& node, const Point& point) {
  return (node.lower - point).cwiseMax(point - node.upper).cwiseMax(Point::Zero()).squaredNorm();
}

AabbTree::Nearest AabbTree::nearest(const Point& point, double upper_bound) const {
  Nearest best{upper_bound, kNone};
  struct Entry {
    std::uint32_t node;
    double distance;
  };
  std::array<Entry, kStackSize> stack;
  int size = 0;
  if (!nodes_.empty()) stack[static_cast<std::size_t>(size++)] = {0, squared_distance_to_box(nodes_[0], point)};
  while (size > 0) {
    const Entry entry = stack[static_cast<std::size_t>(--size)];
    if (!(entry.distance < best.squared_distance)) continue;
    const Node& node = nodes_[entry.node];
    if (node.count > 0) {
      for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
        const Corners& t = corners_[i];
        const double distance = squared_distance(point, t.a, t.b, t.c);
        if (distance < best.squared_distance) best = {distance, t.triangle};
      }
      continue;
    }
    Entry near{node.first, squared_distance_to_box(nodes_[node.first], point)};
    Entry far{node.first + 1, squared_distance_to_box(nodes_[node.first + 1], point)};
    if (far.distance < near.distance) std::swap(near, far);
    if (far.distance < best.squared_distance) stack[static_cast<std::size_t>(size++)] = far;
    if (near.distance < best.squared_distance) stack[static_cast<std::size_t>(size++)] = near;
  }
  if (best.triangle == kNone) return {};
  return best;
}

void AabbTree::append_overlaps(const Box& box, std::vector<std::uint32_t>& out) const {
  std::array<std::uint32_t, kStackSize> stack;
  int size = 0;
  const auto overlaps = [&box](const Point& lower, const Point& upper) {
    return (lower.array() <= box.upper.array()).all() && (upper.array() >= box.lower.array()).all();
  };
  if (!nodes_.empty()) stack[static_cast<std::size_t>(size++)] = 0;
  while (size > 0) {
    const Node& node = nodes_[stack[static_cast<std::size_t>(--size)]];
    if (!overlaps(node.lower, node.upper)) continue;
    if (node.count == 0) {
      stack[static_cast<std::size_t>(size++)] = node.first + 1;
      stack[static_cast<std::size_t>(size++)] = node.first;
      continue;
    }
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
      const Corners& t = corners_[i];
      if (overlaps(t.a.cwiseMin(t.b).cwiseMin(t.c), t.a.cwiseMax(t.b).cwiseMax(t.c))) out.push_back(t.triangle);
    }
  }
}

}  // namespace voxcarve
