// Nearest-triangle queries.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "common/mesh/triangle_soup.h"

namespace voxcarve {

/// Squared distance from `point` to the closed triangle (a, b, c), in squared model units. A triangle without area is
/// the segment or point that it is. Exactly 0 at a corner; otherwise within a few units in the last place of the
/// largest coordinate difference, slivers included.
double squared_distance(const Point& point, const Point& a, const Point& b, const Point& c);

/// A flat tree of axis-aligned boxes over the triangles of a soup. The same soup gives the same tree; queries are const
/// and may run on several threads at once. The soup is not kept.
class AabbTree {
 public:
  struct Nearest {
    double squared_distance = std::numeric_limits<double>::infinity();
    std::uint32_t triangle = kNone;  ///< index in the soup
  };
  static constexpr std::uint32_t kNone = 0xffffffffU;

  /// Builds by binned surface-area heuristic, at most four triangles a leaf, in O(m log m). The soup must be finite.
  explicit AabbTree(const TriangleSoup& soup);

  /// The nearest triangle whose squared distance is less than `upper_bound`, or kNone with an infinite distance when
  /// there is none. Which of several equally near triangles is named depends on nothing but the arguments.
  Nearest nearest(const Point& point, double upper_bound = std::numeric_limits<double>::infinity()) const;

  /// Appends the triangles whose boxes meet the closed box, in an order of the tree's own.
  void append_overlaps(const Box& box, std::vector<std::uint32_t>& out) const;

  bool empty() const { return corners_.empty(); }

 private:
  struct Node {
    Point lower;
    Point upper;
    std::uint32_t first = 0;  ///< of a leaf: position in corners_; else the left child, the right one follows it
    std::uint32_t count = 0;  ///< of a leaf: number of triangles; else 0
  };
  struct Corners {
    Point a, b, c;
    std::uint32_t triangle;
  };
  struct Builder;

  static double squared_distance_to_box(const Node& node, const Point& point);

  std::vector<Node> nodes_;
  std::vector<Corners> corners_;  ///< in the order of the leaves
};

}  // namespace voxcarve
