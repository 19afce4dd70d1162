// Boxes in single precision, padded by more than the roundings of the slab test; triangles in double precision.
#include "metrics/occlusion_tree.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace voxcarve {

namespace {

constexpr std::uint32_t kLeafSize = 4;
constexpr std::uint32_t kCheckSize = 1 << 16;  // triangles of a node that is worth a look at the stop token
constexpr std::size_t kStackSize = 64;         // at most 3 entries a level and 16 levels
// Differences of coordinates are below 4. Rounding a corner, the origin, their difference, the direction, its inverse
// and the product costs at most six times 2^-24 of that.
constexpr double kBoxRounding = 3e-6;
constexpr float kLeastComponent = 1e-8F;  // of a direction in the slab test: turns the ray by less than the padding
constexpr double kFlattest = 1e-13;       // height by length below which a triangle's normal is noise

}  // namespace

OcclusionTree::Direction::Direction(const Point& vector) : vector_(vector) {
  for (int axis = 0; axis < 3; ++axis) {
    const auto component = static_cast<float>(vector[axis]);
    inverse_[static_cast<std::size_t>(axis)] =
        1.0F / std::copysign(std::max(std::abs(component), kLeastComponent), component);
  }
}

struct OcclusionTree::Builder {
  struct Entry {
    Eigen::Vector3f center;
    std::uint32_t triangle;
  };

  const TriangleSoup& soup;
  const double growth;
  const RunContext& context;
  std::vector<Node>& nodes;
  std::vector<Facet>& facets;
  std::vector<Entry> entries;

  static bool is_flat(const Point& ab, const Point& ac, const Point& normal) {
    const double longest = std::max({ab.squaredNorm(), ac.squaredNorm(), (ac - ab).squaredNorm()});
    return !(normal.norm() > kFlattest * longest) || !(normal.squaredNorm() > 0);
  }

  void make_entries() {
    entries.reserve(soup.triangles.size());
    for (std::uint32_t i = 0; i < soup.triangles.size(); ++i) {
      const Triangle& t = soup.triangles[i];
      const Point& a = soup.positions[t[0]];
      const Point ab = soup.positions[t[1]] - a;
      const Point ac = soup.positions[t[2]] - a;
      if (!is_flat(ab, ac, ab.cross(ac))) entries.push_back({(a + (ab + ac) / 3).cast<float>(), i});
    }
  }

  Facet make_facet(const Triangle& t) const {
    const Point& a = soup.positions[t[0]];
    const Point ab = soup.positions[t[1]] - a;
    const Point ac = soup.positions[t[2]] - a;
    const Point normal = ab.cross(ac);
    const double square = normal.squaredNorm();
    Facet facet;
    facet.normal = normal.normalized();
    facet.offset = facet.normal.dot(a);
    facet.gradient = {ac.cross(normal) / square, normal.cross(ab) / square};
    facet.constant = {-facet.gradient[0].dot(a), -facet.gradient[1].dot(a)};
    // The gradient of a barycentric coordinate is one by the height over the side where it is zero.
    facet.slack = {growth * (facet.gradient[0] + facet.gradient[1]).norm(), growth * facet.gradient[0].norm(),
                   growth * facet.gradient[1].norm()};
    return facet;
  }

  /// The position that splits the entries [begin, end) in halves along the axis on which their centres spread most.
  std::uint32_t halve(std::uint32_t begin, std::uint32_t end) {
    Eigen::Vector3f lower = entries[begin].center;
    Eigen::Vector3f upper = lower;
    for (std::uint32_t i = begin + 1; i < end; ++i) {
      lower = lower.cwiseMin(entries[i].center);
      upper = upper.cwiseMax(entries[i].center);
    }
    Eigen::Index axis = 0;
    (upper - lower).maxCoeff(&axis);
    const std::uint32_t middle = begin + (end - begin + 1) / 2;
    std::nth_element(entries.begin() + begin, entries.begin() + middle, entries.begin() + end,
                     [axis](const Entry& i, const Entry& j) {
                       return i.center[axis] != j.center[axis] ? i.center[axis] < j.center[axis]
                                                               : i.triangle < j.triangle;
                     });
    return middle;
  }

  void set_lane(std::uint32_t node, std::size_t lane, const Box& box) {
    const auto index = static_cast<Eigen::Index>(lane);
    // The padding swallows the rounding to single precision.
    const double padding = 2 * growth + kBoxRounding;  // clipped corners reach less than twice the growth
    for (std::size_t axis = 0; axis < 3; ++axis) {
      nodes[node].lower[axis][index] = static_cast<float>(box.lower[static_cast<Eigen::Index>(axis)] - padding);
      nodes[node].upper[axis][index] = static_cast<float>(box.upper[static_cast<Eigen::Index>(axis)] + padding);
    }
  }

  /// The node over the entries [begin, end), of which there is one at least; gives their box.
  Box build(std::uint32_t node, std::uint32_t begin, std::uint32_t end) {
    if (end - begin >= kCheckSize) context.check_cancelled();
    std::array<std::uint32_t, kLanes + 1> cut = {begin, end, end, end, end};
    if (end - begin > kLeafSize) {
      cut[2] = halve(begin, end);
      cut[1] = cut[2] - begin > kLeafSize ? halve(begin, cut[2]) : cut[2];
      cut[3] = end - cut[2] > kLeafSize ? halve(cut[2], end) : end;
    }
    Box whole;
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const std::uint32_t count = cut[lane + 1] - cut[lane];
      if (count == 0) continue;
      Box box;
      if (count <= kLeafSize) {
        nodes[node].first[lane] = static_cast<std::uint32_t>(facets.size());
        nodes[node].count[lane] = static_cast<std::uint8_t>(count);
        for (std::uint32_t i = cut[lane]; i < cut[lane + 1]; ++i) {
          const Triangle& t = soup.triangles[entries[i].triangle];
          for (const std::uint32_t v : t) box.extend(soup.positions[v]);
          facets.push_back(make_facet(t));
        }
      } else {
        const auto child = static_cast<std::uint32_t>(nodes.size());
        nodes[node].first[lane] = child;
        nodes.emplace_back();
        box = build(child, cut[lane], cut[lane + 1]);
      }
      set_lane(node, lane, box);
      whole.extend(box);
    }
    return whole;
  }
};

OcclusionTree::Node::Node() {
  lower.fill(Lanes::Constant(std::numeric_limits<float>::infinity()));
  upper.fill(Lanes::Constant(-std::numeric_limits<float>::infinity()));
}

OcclusionTree::OcclusionTree(const TriangleSoup& soup, double growth, const RunContext& context) {
  Builder builder{soup, growth, context, nodes_, facets_, {}};
  builder.make_entries();
  nodes_.reserve(most_nodes(builder.entries.size()));
  nodes_.emplace_back();
  facets_.reserve(builder.entries.size());
  if (!builder.entries.empty()) builder.build(0, 0, static_cast<std::uint32_t>(builder.entries.size()));
}

// By induction a node over n > 4 triangles heads at most (4 n - 5) / 15 nodes, itself included. Its lanes hold quarters
// of n, of which those over more than 4 triangles, m of them, become nodes. With m = 4 there are at most
// 1 + (4 n - 4 * 5) / 15 = (4 n - 5) / 15. With m < 4 quarters are of 4 and 5 at most, since no two differ by more than
// one, and only those of 5 are nodes, of leaves alone: for m > 0, n = 16 + m and 1 + m <= (4 n - 5) / 15; for m = 0,
// 1 <= (4 n - 5) / 15 from n = 5 on. A tree over fewer has one node.
std::uint64_t OcclusionTree::most_nodes(std::uint64_t triangles) {
  return triangles * 4 / 15 + 1;
}

std::uint64_t OcclusionTree::memory_estimate(std::uint64_t triangles) {
  return triangles * (sizeof(Facet) + sizeof(Builder::Entry)) + most_nodes(triangles) * sizeof(Node);
}

std::uint64_t OcclusionTree::memory() const {
  return nodes_.capacity() * sizeof(Node) + facets_.capacity() * sizeof(Facet);
}

bool OcclusionTree::meets(const Facet& facet, const Point& origin, const Point& direction) {
  const double along = (facet.offset - facet.normal.dot(origin)) / facet.normal.dot(direction);
  if (!(along > 0)) return false;
  const Point point = origin + along * direction;
  const double v = facet.gradient[0].dot(point) + facet.constant[0];
  const double w = facet.gradient[1].dot(point) + facet.constant[1];
  const double u = 1 - v - w;
  // Above 1 only beyond a corner: this clips the tips that moved sides have where they meet at a sharp angle.
  return v >= -facet.slack[1] && v <= 1 + facet.slack[1] && w >= -facet.slack[2] && w <= 1 + facet.slack[2] &&
         u >= -facet.slack[0] && u <= 1 + facet.slack[0];
}

OcclusionTree::OpenLanes OcclusionTree::open_lanes(const Node& node, const std::array<float, 3>& origin,
                                                   const Direction& direction) {
  Lanes enter = Lanes::Zero();
  Lanes leave = Lanes::Constant(std::numeric_limits<float>::infinity());
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const float inverse = direction.inverse_[axis];
    const bool forward = inverse > 0;
    enter = enter.max(((forward ? node.lower[axis] : node.upper[axis]) - origin[axis]) * inverse);
    leave = leave.min(((forward ? node.upper[axis] : node.lower[axis]) - origin[axis]) * inverse);
  }
  OpenLanes open;
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    const auto index = static_cast<Eigen::Index>(lane);
    if (!(enter[index] <= leave[index])) continue;
    std::size_t place = open.size++;
    for (; place > 0 && enter[static_cast<Eigen::Index>(open.lane[place - 1])] > enter[index]; --place) {
      open.lane[place] = open.lane[place - 1];
    }
    open.lane[place] = lane;
  }
  return open;
}

bool OcclusionTree::leaf_blocks(const Node& node, std::size_t lane, const Point& origin, const Point& direction,
                                Hint& hint) const {
  for (std::uint32_t i = node.first[lane]; i < node.first[lane] + node.count[lane]; ++i) {
    if (!meets(facets_[i], origin, direction)) continue;
    hint.facet = i;
    return true;
  }
  return false;
}

bool OcclusionTree::blocks(const Point& origin, const Direction& direction, Hint& hint) const {
  if (facets_.empty()) return false;
  // Boxes never hide a facet that is met, so what the hint finds would be found from the root too.
  if (meets(facets_[hint.facet], origin, direction.vector_)) return true;
  const std::array<float, 3> start = {static_cast<float>(origin[0]), static_cast<float>(origin[1]),
                                      static_cast<float>(origin[2])};
  const auto leaves_block = [&](const Node& node, const OpenLanes& open) {
    for (std::size_t i = 0; i < open.size; ++i) {
      if (leaf_blocks(node, open.lane[i], origin, direction.vector_, hint)) return true;
    }
    return false;
  };
  if (hint.node != 0 && leaves_block(nodes_[hint.node], open_lanes(nodes_[hint.node], start, direction))) return true;
  std::array<std::uint32_t, kStackSize> stack;
  std::size_t size = 0;
  stack[size++] = 0;
  while (size > 0) {
    const std::uint32_t index = stack[--size];
    const Node& node = nodes_[index];
    const auto open = open_lanes(node, start, direction);
    if (leaves_block(node, open)) {
      hint.node = index;
      return true;
    }
    for (std::size_t i = open.size; i-- > 0;) {  // so that the nearest is next
      const std::size_t lane = open.lane[i];
      if (node.count[lane] == 0) stack[size++] = node.first[lane];
    }
  }
  return false;
}

}  // namespace voxcarve
