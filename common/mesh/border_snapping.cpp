// Own work; the aim is that of [BS95] and of the crack filling that [NT03, 2] surveys. Pairs of border vertices are
// taken from the nearest to the farthest, and a group forms only where each of its members may join each other.
#include "common/mesh/border_snapping.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <queue>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "common/mesh/aabb_tree.h"
#include "common/mesh/topology.h"

namespace voxcarve {

namespace {

constexpr int kRounds = 4;
/// Two places of one border are the two sides of a crack when the way along the border is this many times longer than
/// the way across; at corners and in curves it is not.
constexpr double kDetour = 3;
constexpr std::int64_t kComparisonsACheck = 1 << 18;  // for cancellation
constexpr std::int64_t kPairsACheck = 1 << 12;

using VertexPair = std::pair<std::uint32_t, std::uint32_t>;

/// An edge with one triangle.
struct BorderEdge {
  std::uint32_t from = 0, to = 0;  ///< in the direction of the triangle
  EdgeUse use;
};

/// The borders of a soup, to be asked what lies near.
class Borders {
 public:
  explicit Borders(const TriangleSoup& soup) : soup_(soup), edges_(collect(soup)), tree_(as_soup(soup, edges_)) {
    neighbours_.resize(2 * edges_.size());
    first_.assign(soup.positions.size() + 1, 0);
    for (const BorderEdge& edge : edges_) {
      ++first_[edge.from + std::size_t{1}];
      ++first_[edge.to + std::size_t{1}];
    }
    for (std::size_t v = 1; v < first_.size(); ++v) first_[v] += first_[v - 1];
    std::vector<std::size_t> fill(first_.begin(), first_.end() - 1);
    for (const BorderEdge& edge : edges_) {
      neighbours_[fill[edge.from]++] = edge.to;
      neighbours_[fill[edge.to]++] = edge.from;
    }
    for (std::uint32_t v = 0; v + std::size_t{1} < first_.size(); ++v)
      if (first_[v + std::size_t{1}] > first_[v]) vertices_.push_back(v);
  }

  const std::vector<BorderEdge>& edges() const { return edges_; }
  const std::vector<std::uint32_t>& vertices() const { return vertices_; }  ///< ascending

  /// Indices of the border edges whose boxes come within `reach` of a vertex, ascending.
  std::vector<std::uint32_t> edges_near(std::uint32_t vertex, double reach) const {
    std::vector<std::uint32_t> found;
    const Point& p = soup_.positions[vertex];
    tree_.append_overlaps({p - Point::Constant(reach), p + Point::Constant(reach)}, found);
    std::ranges::sort(found);
    return found;
  }

  /// The vertices that a way of at most `reach` along the border leads to, with its length.
  std::map<std::uint32_t, double> along(std::uint32_t vertex, double reach) const {
    std::map<std::uint32_t, double> length;
    std::priority_queue<std::pair<double, std::uint32_t>, std::vector<std::pair<double, std::uint32_t>>, std::greater<>>
        front;
    front.emplace(0.0, vertex);
    while (!front.empty()) {
      const auto [way, at] = front.top();
      front.pop();
      if (!length.try_emplace(at, way).second) continue;
      for (std::size_t n = first_[at]; n < first_[at + std::size_t{1}]; ++n) {
        const double longer = way + (soup_.positions[neighbours_[n]] - soup_.positions[at]).norm();
        if (longer <= reach) front.emplace(longer, neighbours_[n]);
      }
    }
    return length;
  }

 private:
  static std::vector<BorderEdge> collect(const TriangleSoup& soup) {
    const EdgeTable table(soup);
    std::vector<BorderEdge> edges;
    for (std::size_t e = 0; e < table.size(); ++e) {
      if (table.uses(e).size() != 1) continue;
      const EdgeUse use = table.uses(e)[0];
      edges.push_back({use.forward ? table.low(e) : table.high(e), use.forward ? table.high(e) : table.low(e), use});
    }
    return edges;
  }
  static TriangleSoup as_soup(const TriangleSoup& soup, const std::vector<BorderEdge>& edges) {
    TriangleSoup segments;
    for (const BorderEdge& edge : edges) {
      const auto first = static_cast<std::uint32_t>(segments.positions.size());
      segments.positions.push_back(soup.positions[edge.from]);
      segments.positions.push_back(soup.positions[edge.to]);
      segments.triangles.push_back({first, first + 1, first + 1});
    }
    return segments;
  }

  const TriangleSoup& soup_;
  std::vector<BorderEdge> edges_;
  AabbTree tree_;  ///< of the edges
  std::vector<std::uint32_t> vertices_;
  std::vector<std::size_t> first_;  ///< by vertex, into neighbours_
  std::vector<std::uint32_t> neighbours_;
};

double distance(const TriangleSoup& soup, std::uint32_t u, std::uint32_t v) {
  return (soup.positions[u] - soup.positions[v]).norm();
}

/// Two border vertices that may become one.
struct NearPair {
  double distance = 0;
  std::uint32_t low = 0, high = 0;

  bool operator<(const NearPair& other) const {
    return std::tie(distance, low, high) < std::tie(other.distance, other.low, other.high);
  }
};

/// The sides of triangles between border vertices, ascending.
std::vector<VertexPair> border_sides(const TriangleSoup& soup, const Borders& borders) {
  std::vector<std::uint8_t> on_border(soup.positions.size(), 0);
  for (const std::uint32_t v : borders.vertices()) on_border[v] = 1;
  std::vector<VertexPair> sides;
  for (const Triangle& t : soup.triangles) {
    for (std::size_t c = 0; c < 3; ++c) {
      const VertexPair side = std::minmax(t[c], t[(c + 1) % 3]);
      if (on_border[side.first] != 0 && on_border[side.second] != 0) sides.push_back(side);
    }
  }
  std::ranges::sort(sides);
  return sides;
}

/// All pairs within the tolerance that may become one, in the order of their vertices. Up to the square of the vertices
/// in number, so their memory is declared as it grows.
std::vector<NearPair> matching_pairs(const TriangleSoup& soup, const Borders& borders, double tolerance,
                                     RunContext& context) {
  // Thrice, while the list moves to twice the place; or twice, and an entry of either vertex in the other's partners.
  constexpr std::uint64_t kBytesAPair = 3 * sizeof(NearPair);
  static_assert(kBytesAPair >= 2 * sizeof(NearPair) + 2 * sizeof(std::uint32_t));
  const std::vector<VertexPair> sides = border_sides(soup, borders);
  std::vector<NearPair> pairs;
  std::vector<std::uint32_t> near;
  for (const std::uint32_t u : borders.vertices()) {
    context.check_cancelled();
    near.clear();
    for (const std::uint32_t e : borders.edges_near(u, tolerance)) {
      for (const std::uint32_t v : {borders.edges()[e].from, borders.edges()[e].to})
        if (v > u && distance(soup, u, v) <= tolerance) near.push_back(v);
    }
    if (near.empty()) continue;
    std::ranges::sort(near);
    near.erase(std::unique(near.begin(), near.end()), near.end());
    context.require_memory(soup.triangles.size() * kStitchBytesPerTriangle + (pairs.size() + near.size()) * kBytesAPair,
                           "stitching");
    const auto ways = borders.along(u, kDetour * tolerance);
    const auto first_side = std::ranges::lower_bound(sides, VertexPair(u, 0));
    const auto last_side = std::ranges::lower_bound(first_side, sides.end(), VertexPair(u + 1, 0));
    for (const std::uint32_t v : near) {
      // Corners of one triangle stay apart.
      if (std::binary_search(first_side, last_side, VertexPair(u, v))) continue;
      const auto way = ways.find(v);
      const double length = distance(soup, u, v);
      if (way == ways.end() || way->second >= kDetour * length) pairs.push_back({length, u, v});
    }
  }
  return pairs;
}

/// Groups of vertices of which each is paired with each. What a group is paired with as a whole is kept with it, so
/// that joining costs no more than the pairs it takes away.
class Groups {
 public:
  /// `pairs` in the order of their vertices.
  Groups(std::size_t vertices, const std::vector<NearPair>& pairs)
      : group_of_(vertices), members_(vertices), first_(vertices + 1, 0) {
    for (std::uint32_t v = 0; v < vertices; ++v) group_of_[v] = v;
    for (const NearPair& pair : pairs) {
      ++first_[pair.low + std::size_t{1}];
      ++first_[pair.high + std::size_t{1}];
      members_[pair.low] = {pair.low};
      members_[pair.high] = {pair.high};
    }
    for (std::size_t v = 0; v < vertices; ++v) first_[v + 1] += first_[v];
    end_.assign(first_.begin(), first_.end() - 1);
    partners_.resize(2 * pairs.size());
    for (const NearPair& pair : pairs) {  // in this order every list ascends
      partners_[end_[pair.low]++] = pair.high;
      partners_[end_[pair.high]++] = pair.low;
    }
  }

  /// Joins the groups of both vertices when all of their members are paired.
  void join(std::uint32_t u, std::uint32_t v) {
    std::uint32_t large = group_of_[u];
    std::uint32_t small = group_of_[v];
    if (large == small) return;
    if (members_[large].size() < members_[small].size()) std::swap(large, small);
    const auto partners = [this](std::uint32_t group) {
      return std::span(partners_).subspan(first_[group], end_[group] - first_[group]);
    };
    const auto of_large = partners(large);
    if (!std::ranges::all_of(members_[small], [&](auto m) { return std::ranges::binary_search(of_large, m); })) return;
    const auto of_small = partners(small);
    std::size_t kept = first_[large];
    auto other = of_small.begin();
    for (const std::uint32_t partner : of_large) {
      while (other != of_small.end() && *other < partner) ++other;
      if (other != of_small.end() && *other == partner) partners_[kept++] = partner;
    }
    end_[large] = kept;
    for (const std::uint32_t m : members_[small]) group_of_[m] = large;
    members_[large].insert(members_[large].end(), members_[small].begin(), members_[small].end());
    members_[small] = {};
  }

  /// The groups of two and more, each ascending.
  std::vector<std::vector<std::uint32_t>> take() {
    std::erase_if(members_, [](const auto& members) { return members.size() < 2; });
    for (auto& members : members_) std::ranges::sort(members);
    return std::move(members_);
  }

 private:
  std::vector<std::uint32_t> group_of_;              ///< by vertex: the vertex that its group is named after
  std::vector<std::vector<std::uint32_t>> members_;  ///< by group
  std::vector<std::size_t> first_, end_;             ///< by group, into partners_
  std::vector<std::uint32_t> partners_;              ///< the vertices that every member is paired with, ascending
};

/// Groups the vertices of the pairs, the nearest pairs first.
std::vector<std::vector<std::uint32_t>> group(std::size_t vertices, std::vector<NearPair> pairs,
                                              const RunContext& context) {
  Groups groups(vertices, pairs);
  std::int64_t compared = 0;
  std::sort(pairs.begin(), pairs.end(), [&](const NearPair& a, const NearPair& b) {
    if (++compared % kComparisonsACheck == 0) context.check_cancelled();
    return a < b;
  });
  std::int64_t visited = 0;
  for (const NearPair& pair : pairs) {
    if (++visited % kPairsACheck == 0) context.check_cancelled();
    groups.join(pair.low, pair.high);
  }
  return groups.take();
}

void merge_vertices(TriangleSoup& soup, double tolerance, SnapReport& report, RunContext& context) {
  const Borders borders(soup);
  const auto groups = group(soup.positions.size(), matching_pairs(soup, borders, tolerance, context), context);
  if (groups.empty()) return;
  std::vector<std::uint32_t> renamed(soup.positions.size());
  for (std::uint32_t v = 0; v < renamed.size(); ++v) renamed[v] = v;
  for (const auto& members : groups) {
    Point sum = Point::Zero();
    for (const std::uint32_t v : members) {
      sum += soup.positions[v];
      renamed[v] = members[0];
      if (!soup.vertex_colors.empty()) {
        const Color difference = soup.vertex_colors[v] - soup.vertex_colors[members[0]];
        report.mixes_colors = report.mixes_colors || difference.cwiseAbs().maxCoeff() > kVisibleColor;
      }
    }
    soup.positions[members[0]] = sum / static_cast<double>(members.size());
    report.merged_vertices += static_cast<std::int64_t>(members.size()) - 1;
  }
  for (Triangle& triangle : soup.triangles) {
    for (std::uint32_t& vertex : triangle) vertex = renamed[vertex];
  }
}

/// A vertex on the border edge of another triangle.
struct Joint {
  std::uint32_t triangle = 0;
  std::uint8_t corner = 0;  ///< the edge runs from this corner to the next
  double share = 0;         ///< of the way along it
  std::uint32_t vertex = 0;

  bool operator<(const Joint& other) const {
    return std::tie(triangle, corner, share, vertex) <
           std::tie(other.triangle, other.corner, other.share, other.vertex);
  }
};

/// For every border vertex the nearest border edge that it lies on within the tolerance, sorted.
std::vector<Joint> find_joints(const TriangleSoup& soup, double tolerance, const RunContext& context) {
  const Borders borders(soup);
  std::vector<Joint> joints;
  for (const std::uint32_t u : borders.vertices()) {
    context.check_cancelled();
    const Point& p = soup.positions[u];
    double nearest = tolerance;
    Joint joint;
    bool found = false;
    std::map<std::uint32_t, double> ways;
    for (const std::uint32_t e : borders.edges_near(u, tolerance)) {
      const BorderEdge& edge = borders.edges()[e];
      const Triangle& t = soup.triangles[edge.use.triangle];
      if (t[0] == u || t[1] == u || t[2] == u) continue;
      const Point& a = soup.positions[edge.from];
      const Point along = soup.positions[edge.to] - a;
      const double share = (p - a).dot(along) / along.squaredNorm();
      if (!(share > 0 && share < 1)) continue;
      const double length = along.norm();
      const double across = (a + share * along - p).norm();
      if (across > nearest || (found && across == nearest)) continue;
      if (ways.empty()) ways = borders.along(u, kDetour * tolerance);
      const auto way_by = [&](std::uint32_t end, double rest) {
        const auto way = ways.find(end);
        return way == ways.end() || way->second + rest >= kDetour * across;
      };
      if (!way_by(edge.from, share * length) || !way_by(edge.to, (1 - share) * length)) continue;
      nearest = across;
      joint = {edge.use.triangle, edge.use.corner, share, u};
      found = true;
    }
    if (found) joints.push_back(joint);
  }
  std::sort(joints.begin(), joints.end());
  return joints;
}

/// Splits a triangle into a fan about the corner opposite to its divided edge. False, and nothing is changed, when a
/// part would have no area or be turned over.
bool split_triangle(TriangleSoup& soup, std::span<const Joint> joints) {
  const Triangle whole = soup.triangles[joints[0].triangle];
  const std::size_t corner = joints[0].corner;
  const std::uint32_t apex = whole[(corner + 2) % 3];
  std::vector<std::uint32_t> chain = {whole[corner]};
  for (const Joint& joint : joints) chain.push_back(joint.vertex);
  chain.push_back(whole[(corner + 1) % 3]);
  const Point up = area_vector(soup, whole);
  std::vector<Triangle> parts;
  for (std::size_t i = 0; i + 1 < chain.size(); ++i) {
    parts.push_back({chain[i], chain[i + 1], apex});
    if (!has_distinct_corners(parts.back()) || !(area_vector(soup, parts.back()).dot(up) > 0)) return false;
  }
  soup.triangles[joints[0].triangle] = parts[0];
  for (std::size_t i = 1; i < parts.size(); ++i) {
    soup.triangles.push_back(parts[i]);
    if (!soup.triangle_colors.empty()) soup.triangle_colors.push_back(soup.triangle_colors[joints[0].triangle]);
  }
  return true;
}

/// A triangle takes up the vertices on one of its edges; those on the others wait for the next round.
void split_edges(TriangleSoup& soup, double tolerance, SnapReport& report, const RunContext& context) {
  const std::vector<Joint> joints = find_joints(soup, tolerance, context);
  for (std::size_t i = 0; i < joints.size();) {
    std::size_t on_edge = i;
    while (on_edge < joints.size() && joints[on_edge].triangle == joints[i].triangle &&
           joints[on_edge].corner == joints[i].corner) {
      ++on_edge;
    }
    if (split_triangle(soup, std::span(joints).subspan(i, on_edge - i))) ++report.split_edges;
    const std::uint32_t triangle = joints[i].triangle;
    while (i < joints.size() && joints[i].triangle == triangle) ++i;
  }
}

}  // namespace

SnapReport snap_borders(TriangleSoup& soup, double tolerance, RunContext& context) {
  SnapReport report;
  for (int round = 0; round < kRounds; ++round) {
    const std::int64_t before = report.merged_vertices + report.split_edges;
    context.check_cancelled();
    merge_vertices(soup, tolerance, report, context);
    context.check_cancelled();
    split_edges(soup, tolerance, report, context);
    if (report.merged_vertices + report.split_edges == before) break;
  }
  return report;
}

}  // namespace voxcarve
