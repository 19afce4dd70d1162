// Candidates from the box tree, then signs of determinants that CGAL evaluates exactly where floating point leaves them
// open. What two triangles in different planes have in common is an interval of the line in which the planes meet; it
// ends where a vertex or an edge of one lies in the other. These are found by signs alone, without constructing a
// point.
#include "common/mesh/triangle_crossings.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>
#include <atomic>
#include <numeric>
#include <optional>

#include "common/mesh/box_pairs.h"
#include "common/mesh/triangle_separation.h"

namespace voxcarve {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Signs = std::array<int, 3>;

constexpr std::int64_t kTrianglesAChunk = 4096;
constexpr std::int64_t kBlocksAChunk = 64;

int orientation(const Point& a, const Point& b, const Point& c, const Point& d) {
  const auto exact = [](const Point& p) { return Kernel::Point_3(p[0], p[1], p[2]); };
  return CGAL::orientation(exact(a), exact(b), exact(c), exact(d));
}

/// Of the projections along an axis.
int orientation(const Point& a, const Point& b, const Point& c, int axis) {
  const int u = (axis + 1) % 3;
  const int v = (axis + 2) % 3;
  const auto exact = [u, v](const Point& p) { return Kernel::Point_2(p[u], p[v]); };
  return CGAL::orientation(exact(a), exact(b), exact(c));
}

/// An axis along which the triangle does not project to a line.
int projection_axis(const Point& a, const Point& b, const Point& c) {
  for (const int axis : {0, 1}) {
    if (orientation(a, b, c, axis) != 0) return axis;
  }
  return 2;
}

/// Whether every two of the signs agree, zero agreeing with both.
bool agree(const Signs& signs) {
  return std::min({signs[0], signs[1], signs[2]}) >= 0 || std::max({signs[0], signs[1], signs[2]}) <= 0;
}

/// The test of two triangles of a soup.
class PairTest {
 public:
  PairTest(const TriangleSoup& soup, std::uint32_t first, std::uint32_t second)
      : soup_(soup), names_{first, second}, triangles_{soup.triangles[first], soup.triangles[second]} {}

  std::optional<Crossing> run() {
    int shared = 0;
    for (const std::uint32_t vertex : triangles_[0]) shared += has_corner(1, vertex) ? 1 : 0;
    if (shared == 3) return {};
    if (!find_sides(0)) return {};
    Crossing crossing{names_[0], names_[1], false, {}};
    if (sides_[0] == Signs{0, 0, 0}) {
      if (!meet_in_plane(shared)) return {};
      crossing.coplanar = true;
      return crossing;
    }
    // The planes meet in the line of a common edge, and there is nothing else in it.
    if (shared == 2 || !find_sides(1)) return {};
    find_ends();
    bool forbidden = false;
    for (std::size_t i = 0; i < ends_count_; ++i) forbidden |= !is_common(ends_[i].point);
    if (!forbidden) return {};
    crossing.ends = {ends_[0].point, ends_[ends_count_ - 1].point};
    return crossing;
  }

 private:
  /// An end of the common interval; of an edge that meets an edge of the other triangle, `other` is that one.
  struct End {
    ContactPoint point;
    std::array<std::uint32_t, 2> other{};
  };

  const Point& corner(int which, std::size_t i) const {
    return soup_.positions[triangles_[static_cast<std::size_t>(which)][i % 3]];
  }
  std::uint32_t name(int which, std::size_t i) const { return triangles_[static_cast<std::size_t>(which)][i % 3]; }
  bool has_corner(int which, std::uint32_t vertex) const {
    const Triangle& t = triangles_[static_cast<std::size_t>(which)];
    return t[0] == vertex || t[1] == vertex || t[2] == vertex;
  }
  bool is_common(const ContactPoint& point) const {
    return point.is_vertex() && has_corner(0, point.from) && has_corner(1, point.from);
  }

  /// On which sides of the other's plane the corners of a triangle are. False when none but common vertices are in the
  /// plane and all others on one side, so that nothing else can be common.
  bool find_sides(int which) {
    Signs& side = sides_[static_cast<std::size_t>(which)];
    bool in_plane = false;
    for (std::size_t i = 0; i < 3; ++i) {
      if (has_corner(1 - which, name(which, i))) continue;  // exactly in the plane: 0
      side[i] = orientation(corner(1 - which, 0), corner(1 - which, 1), corner(1 - which, 2), corner(which, i));
      in_plane |= side[i] == 0;
    }
    return in_plane || !agree(side);
  }

  /// Whether a point of a triangle's plane is in the closed triangle.
  bool contains(int which, const Point& p, int axis) const {
    Signs turn{};
    for (std::size_t i = 0; i < 3; ++i) turn[i] = orientation(corner(which, i), corner(which, i + 1), p, axis);
    return agree(turn);
  }

  bool contains(int which, const Point& p) const {
    return contains(which, p, projection_axis(corner(which, 0), corner(which, 1), corner(which, 2)));
  }

  void add(const ContactPoint& point, std::array<std::uint32_t, 2> other = {}) {
    if (ends_count_ < 2) ends_[ends_count_++] = {point, other};
  }

  /// Where the edge from corner i of a triangle goes through the inside of the other or through one of its edges. The
  /// ends of the edge are strictly on both sides.
  void add_piercing(int which, std::size_t i) {
    const int facing = 1 - which;
    Signs turn{};
    std::size_t zeros = 0;
    std::size_t zero = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      turn[k] = orientation(corner(which, i), corner(which, i + 1), corner(facing, k), corner(facing, k + 1));
      if (turn[k] != 0) continue;
      ++zeros;
      zero = k;
    }
    if (zeros == 2 || !agree(turn)) return;  // two: through a corner, which was found as a vertex
    std::array<std::uint32_t, 2> edge{name(which, i), name(which, i + 1)};
    std::sort(edge.begin(), edge.end());
    std::array<std::uint32_t, 2> other{};
    if (zeros == 1) {
      other = {name(facing, zero), name(facing, zero + 1)};
      std::sort(other.begin(), other.end());
      for (std::size_t k = 0; k < ends_count_; ++k) {  // two edges that meet are found from both triangles
        if (ends_[k].other == edge && std::array{ends_[k].point.from, ends_[k].point.to} == other) return;
      }
    }
    add({edge[0], edge[1], names_[static_cast<std::size_t>(facing)]}, other);
  }

  /// Different ends are different points, so there are at most two.
  void find_ends() {
    for (const int which : {0, 1}) {
      for (std::size_t i = 0; i < 3; ++i) {
        if (sides_[static_cast<std::size_t>(which)][i] != 0) continue;
        const std::uint32_t vertex = name(which, i);
        const bool common = has_corner(1 - which, vertex);
        if (common ? which == 0 : contains(1 - which, corner(which, i))) add({vertex, vertex, 0});
      }
    }
    for (const int which : {0, 1}) {
      const Signs& side = sides_[static_cast<std::size_t>(which)];
      for (std::size_t i = 0; i < 3; ++i) {
        if (side[i] * side[(i + 1) % 3] < 0) add_piercing(which, i);
      }
    }
  }

  /// Whether the closed edge from corner i of a triangle meets the other closed triangle in their common plane.
  bool edge_meets(int which, std::size_t i, int axis) const {
    const Point& p = corner(which, i);
    const Point& q = corner(which, i + 1);
    const int facing = 1 - which;
    if (contains(facing, p, axis) || contains(facing, q, axis)) return true;
    for (std::size_t k = 0; k < 3; ++k) {
      const Point& a = corner(facing, k);
      const Point& b = corner(facing, k + 1);
      // Both ends are outside of the triangle, so an edge that meets it at all crosses two sides, or two at a corner.
      if (orientation(p, q, a, axis) * orientation(p, q, b, axis) <= 0 &&
          orientation(a, b, p, axis) * orientation(a, b, q, axis) < 0) {
        return true;
      }
    }
    return false;
  }

  bool meet_in_plane(int shared) const {
    const int axis = projection_axis(corner(0, 0), corner(0, 1), corner(0, 2));
    for (const int which : {0, 1}) {
      for (std::size_t i = 0; i < 3; ++i) {
        const bool first_common = has_corner(1 - which, name(which, i));
        const bool second_common = has_corner(1 - which, name(which, i + 1));
        if (shared == 2 && first_common && second_common) {
          // Beside a whole common edge nothing else is common iff the third corners are on different sides of it.
          std::size_t third = 0;
          while (has_corner(which, name(1 - which, third))) ++third;
          return orientation(corner(which, i), corner(which, i + 1), corner(which, i + 2), axis) ==
                 orientation(corner(which, i), corner(which, i + 1), corner(1 - which, third), axis);
        }
        // A triangle is what its corner sees of the opposite edge: from a common corner, whatever else is common is
        // seen on one of the two opposite edges, and lies in the other triangle there or nearer.
        if (shared == 0 || (shared == 1 && !first_common && !second_common)) {
          if (edge_meets(which, i, axis)) return true;
        }
      }
    }
    return false;
  }

  const TriangleSoup& soup_;
  std::array<std::uint32_t, 2> names_;
  std::array<Triangle, 2> triangles_;
  std::array<Signs, 2> sides_{};
  std::array<End, 2> ends_{};
  std::size_t ends_count_ = 0;
};

/// Tests every pair with overlapping boxes.
class CrossingSearch {
 public:
  CrossingSearch(const TriangleSoup& soup, const std::vector<bool>* suspects, RunContext& context)
      : soup_(soup), suspects_(suspects), context_(context) {}

  std::vector<Crossing> run() {
    Stage stage(context_, "finding crossing triangles", static_cast<std::int64_t>(soup_.triangles.size()));
    context_.require_memory(soup_.triangles.size() * kBytesATriangle, "finding crossing triangles");
    const std::vector<std::uint32_t> names = triangles_to_test();
    stage.set_total(static_cast<std::int64_t>(names.size()));
    const BoxPairs pairs(boxes_of(names), context_);
    std::vector<Item> items(names.size());  // in the order of the pairs: a triangle is tested with those near it
    for_each(items.size(), [&](std::size_t place) { items[place] = item_of(names[pairs.order()[place]]); });

    const auto blocks = static_cast<std::int64_t>(pairs.block_count());
    std::vector<std::vector<Crossing>> found(static_cast<std::size_t>((blocks + kBlocksAChunk - 1) / kBlocksAChunk));
    std::atomic<std::uint64_t> count = 0;
    parallel_for(context_, 0, blocks, kBlocksAChunk, [&](std::int64_t begin, std::int64_t end) {
      std::vector<Crossing>& here = found[static_cast<std::size_t>(begin / kBlocksAChunk)];
      for (std::int64_t block = begin; block < end; ++block) {
        const std::size_t before = here.size();
        pairs.visit_pairs(static_cast<std::size_t>(block), context_,
                          [&](std::size_t i, std::size_t j) { test(items[i], items[j], here); });
        if (here.size() == before) continue;
        const std::uint64_t so_far = count += here.size() - before;
        // Once in the chunks, once in the result.
        context_.require_memory(soup_.triangles.size() * kBytesATriangle + so_far * 2 * sizeof(Crossing),
                                "the list of crossing triangles");
      }
      stage.advance((end - begin) * static_cast<std::int64_t>(BoxPairs::kBlockSize));
    });
    std::vector<Crossing> crossings;
    crossings.reserve(count);
    for (const auto& part : found) crossings.insert(crossings.end(), part.begin(), part.end());
    std::sort(crossings.begin(), crossings.end(), [](const Crossing& a, const Crossing& b) {
      return a.first != b.first ? a.first < b.first : a.second < b.second;
    });
    return crossings;
  }

 private:
  struct Item {
    CorneredTriangle triangle;
    std::uint32_t name = 0;
    bool suspect = false;
  };
  static constexpr std::uint64_t kBytesATriangle =
      sizeof(std::uint32_t) + sizeof(Box) + BoxPairs::kBytesABox + sizeof(Item);

  template <class Body>
  void for_each(std::size_t count, const Body& body) const {
    parallel_for(context_, 0, static_cast<std::int64_t>(count), kTrianglesAChunk,
                 [&body](std::int64_t begin, std::int64_t end) {
                   for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) body(i);
                 });
  }

  bool is_suspect(std::uint32_t triangle) const { return suspects_ == nullptr || (*suspects_)[triangle]; }

  Box box_of(std::uint32_t triangle) const {
    Box box;
    for (const std::uint32_t vertex : soup_.triangles[triangle]) box.extend(soup_.positions[vertex]);
    return box;
  }

  std::vector<Box> boxes_of(const std::vector<std::uint32_t>& names) const {
    std::vector<Box> boxes(names.size());
    for_each(names.size(), [&](std::size_t i) { boxes[i] = box_of(names[i]); });
    return boxes;
  }

  Item item_of(std::uint32_t name) const {
    return {CorneredTriangle(soup_, soup_.triangles[name]), name, is_suspect(name)};
  }

  /// The suspects and what comes near one.
  std::vector<std::uint32_t> triangles_to_test() const {
    std::vector<std::uint32_t> names(soup_.triangles.size());
    std::iota(names.begin(), names.end(), 0U);
    if (suspects_ == nullptr) return names;
    std::vector<std::uint32_t> suspects = names;
    std::erase_if(suspects, [this](std::uint32_t triangle) { return !is_suspect(triangle); });
    const BoxPairs suspect_boxes(boxes_of(suspects), context_);
    std::vector<char> taken(names.size());
    for_each(names.size(), [&](std::size_t i) {
      taken[i] = is_suspect(names[i]) || suspect_boxes.any_overlaps(box_of(names[i])) ? 1 : 0;
    });
    std::erase_if(names, [&taken](std::uint32_t triangle) { return taken[triangle] == 0; });
    return names;
  }

  void test(const Item& one, const Item& other, std::vector<Crossing>& out) const {
    if (!one.suspect && !other.suspect) return;
    if (certainly_apart(one.triangle, other.triangle)) return;
    const auto [first, second] = std::minmax(one.name, other.name);
    if (const auto crossing = PairTest(soup_, first, second).run()) out.push_back(*crossing);
  }

  const TriangleSoup& soup_;
  const std::vector<bool>* suspects_;  ///< null: all are
  RunContext& context_;
};

}  // namespace

bool are_collinear(const Point& a, const Point& b, const Point& c) {
  return orientation(a, b, c, 0) == 0 && orientation(a, b, c, 1) == 0 && orientation(a, b, c, 2) == 0;
}

std::vector<Crossing> find_crossings(const TriangleSoup& soup, RunContext& context) {
  return CrossingSearch(soup, nullptr, context).run();
}

std::vector<Crossing> find_crossings(const TriangleSoup& soup, const std::vector<bool>& suspects, RunContext& context) {
  return CrossingSearch(soup, &suspects, context).run();
}

}  // namespace voxcarve
