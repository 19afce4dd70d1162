// Is there anything on a ray?
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "common/mesh/triangle_soup.h"
#include "common/run/context.h"

namespace voxcarve {

/// A flat tree of boxes, four to a node, over the triangles of a soup, for rays that need no more than a yes or no.
/// The same soup gives the same answers; queries are const and may run on several threads at once. The soup is not
/// kept.
class OcclusionTree {
 public:
  /// A direction of many rays.
  class Direction {
   public:
    /// `vector` has unit length.
    explicit Direction(const Point& vector);
    const Point& vector() const { return vector_; }

   private:
    friend class OcclusionTree;
    Point vector_;
    std::array<float, 3> inverse_;
  };
  /// Where a ray of one direction was blocked last. The next one that starts near by is likely blocked there too, which
  /// saves time and changes no answer.
  struct Hint {
    std::uint32_t node = 0;
    std::uint32_t facet = 0;
    bool operator==(const Hint&) const = default;
  };

  /// All coordinates of `soup` and of rays' origins must lie in [-2, 2]. Every side of a triangle is moved outward by
  /// `growth`, at most 1e-3 and in the same unit, so that no ray slips through cracks that are narrower than twice
  /// that. Triangles without area, to rounding, block nothing. Throws Cancelled.
  OcclusionTree(const TriangleSoup& soup, double growth, const RunContext& context);

  /// True when the ray from `origin`, without its origin, meets a triangle.
  bool blocks(const Point& origin, const Direction& direction, Hint& hint) const;

  /// Bytes that a tree over so many triangles holds at most, also while it is built.
  static std::uint64_t memory_estimate(std::uint64_t triangles);
  /// Bytes that this tree holds.
  std::uint64_t memory() const;

 private:
  static constexpr std::size_t kLanes = 4;
  using Lanes = Eigen::Array<float, kLanes, 1>;
  /// A triangle as a plane and the barycentric coordinates of its second and third corner as functions of position.
  struct Facet {
    Point normal;
    double offset;  ///< of the plane: normal . x = offset
    std::array<Point, 2> gradient;
    std::array<double, 2> constant;
    std::array<double, 3> slack;  ///< by corner, the first last: `growth` as a barycentric coordinate
  };
  struct Node {
    std::array<Lanes, 3> lower;  ///< by axis
    std::array<Lanes, 3> upper;
    std::array<std::uint32_t, kLanes> first{};  ///< of a leaf: position in facets_; else the child
    std::array<std::uint8_t, kLanes> count{};   ///< of a leaf: its facets; else 0
    Node();
  };
  struct OpenLanes {
    std::array<std::size_t, kLanes> lane{};
    std::size_t size = 0;
  };
  struct Builder;

  /// An upper bound of the nodes of a tree over so many triangles.
  static std::uint64_t most_nodes(std::uint64_t triangles);
  static bool meets(const Facet& facet, const Point& origin, const Point& direction);
  /// The lanes whose boxes the ray may meet, nearest first. Empty lanes are never among them.
  static OpenLanes open_lanes(const Node& node, const std::array<float, 3>& origin, const Direction& direction);
  /// Whether the facets of a lane block the ray; a lane that is no leaf has none.
  bool leaf_blocks(const Node& node, std::size_t lane, const Point& origin, const Point& direction, Hint& hint) const;

  std::vector<Node> nodes_;
  std::vector<Facet> facets_;
};

}  // namespace voxcarve
