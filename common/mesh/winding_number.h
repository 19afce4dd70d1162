// The generalised winding number of a triangle soup.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/mesh/triangle_soup.h"

namespace voxcarve {

/// How often a soup winds around a point [JKS13]: the sum of the signed solid angles of its triangles, seen from the
/// point, over 4 pi. Inside a closed, outward oriented surface it is 1, outside 0; where surfaces overlap, the sum; of
/// an open surface, a fraction that varies smoothly away from the triangles and jumps by 1 across each of them.
///
/// Near triangles are summed one by one, clusters of far ones by an expansion [BDS18]. The same soup gives the same
/// numbers; queries are const and may run on several threads at once. The soup is not kept.
class WindingNumber {
 public:
  /// Absolute; see the constructor.
  static constexpr double kAccuracy = 1e-3;

  /// Builds in O(m log m). The soup must be finite and its indices valid; it may be empty. `multiplicity` is empty, or
  /// says how often each triangle counts: a negative number counts it turned round, 0 leaves it out. Triangles without
  /// area count nothing.
  ///
  /// `accuracy` is the largest error wanted of `at` against the full sum, absolute, in turns; less is faster. It is not
  /// guaranteed: the error of each cluster has a proven bound of kClusterShare * accuracy, and the errors of all
  /// clusters, which mostly cancel, were measured to stay below `accuracy` together. Rounding adds about 1e-13.
  ///
  /// Throws InputError when `multiplicity` has neither no nor as many entries as the soup has triangles, and
  /// ParameterError when `accuracy` is not positive.
  explicit WindingNumber(const TriangleSoup& soup, std::span<const std::int32_t> multiplicity = {},
                         double accuracy = kAccuracy);

  /// The winding number around a finite point, in about O(log m). Always finite. A triangle that holds the point, to
  /// rounding, counts as the mean of its two sides, which is 0: so the result is the share of the directions that lead
  /// inside, 1/2 on a solid's face, 1/4 on a right-angled edge. At a point that is off a triangle by little more than
  /// rounding it is the limit from a side, or beside an edge anything between the limits, or a little beyond.
  ///
  /// Around a closed surface, rounding the result gives the right integer at points whose distance from the surface is
  /// more than 1e-12 of its diagonal and of the largest coordinate; beside slivers more by one over the sine of their
  /// least angle.
  double at(const Point& point) const;

  /// Memory that building needs at its peak, at most, in bytes; less stays.
  static std::uint64_t memory_estimate(std::size_t triangles);

  /// The part of `accuracy` that each cluster's error may take.
  static constexpr double kClusterShare = 0.125;

 private:
  /// In the order of a walk that visits a node before its children. Coordinates are those of `normalized`.
  struct Node {
    Point center;             ///< of mass of its triangles
    double near_squared = 0;  ///< a point nearer than the root of this opens the node
    std::uint32_t first = 0;  ///< position in corners_
    std::uint32_t count = 0;  ///< of triangles
    std::uint32_t skip = 0;   ///< the next node that is not below this one; of a leaf, the next node
  };
  /// Homogeneous harmonic polynomials of the direction from a point to a node's centre; coefficients in the order
  /// x, y, z; x^2, y^2, z^2, xy, yz, zx; x^3, y^3, z^3, x^2 y, y^2 z, z^2 x, x y^2, y z^2, z x^2, xyz.
  struct Expansion {
    std::array<double, 3> first{};
    std::array<double, 6> second{};
    std::array<double, 10> third{};
  };
  struct Corners {
    Point a, b, c;
    double multiplicity = 0;
  };
  struct Builder;

  Point normalized(const Point& point) const { return scale_ * (point - center_); }
  static double turns(const Corners& triangle, const Point& point);

  std::vector<Node> nodes_;
  std::vector<Expansion> expansions_;  ///< one a node
  std::vector<Corners> corners_;       ///< in the order of the leaves
  Point center_ = Point::Zero();       ///< of the soup's box
  double scale_ = 1;                   ///< a power of two that brings the box's size near 1
};

}  // namespace voxcarve
