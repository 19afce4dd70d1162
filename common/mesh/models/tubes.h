// Tubes of varying section, and closed surfaces of known genus where such tubes branch and meet. All lengths are in
// model units.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "common/mesh/models/primitives.h"
#include "common/mesh/triangle_soup.h"

namespace voxcarve {

/// The half axes of an elliptic section: along the tube's reference direction, and across it.
struct HalfAxes {
  double along;
  double across;
};

/// Sections of `sides` points at the points of `path` (at least two, consecutive ones differ), perpendicular to its
/// smoothed direction. `reference` is nowhere parallel to that direction and keeps the sections from turning about it.
/// `half_axes` is asked with the share of the path's length up to the point, from 0 to 1.
std::vector<Ring> tube_rings(std::span<const Point> path, const Point& reference,
                             const std::function<HalfAxes(double share)>& half_axes, int sides);

/// The same with each section no more than the point of the path at either end: a spindle. At least three points.
std::vector<Ring> spindle_rings(std::span<const Point> path, const Point& reference,
                                const std::function<HalfAxes(double share)>& half_axes, int sides);

/// `segments` + 1 points along the polyline `path`, at least 3 segments: its ends, and between them points equally far
/// apart along it, of which the first and the last are `stand_off` from the ends.
std::vector<Point> evenly_spaced(std::span<const Point> path, int segments, double stand_off);

/// One closed surface of bodies (lofts) and of tubes of eight sides that sprout from openings in them, or in other
/// tubes. Vertices are shared. Its genus is (bridges - bodies + 1) where all hangs together: every body is a sphere, a
/// bridge between separate pieces joins them and any other adds a handle, and a sprout changes nothing. That nothing
/// intersects is the caller's affair.
class TubeNetwork {
 public:
  static constexpr std::size_t kSides = 8;

  /// An opening of four quads, as the eight vertices of its rim, counterclockwise seen from outside.
  struct Opening {
    std::array<std::uint32_t, kSides> rim;
    Point center;  ///< the vertex that was in the middle
    Point normal;  ///< of length 1, outward
  };

  /// A loft with its ends closed, poles or flat. Returns its number, for `open`.
  std::size_t add_body(std::span<const Ring> rings);

  /// Takes away the four quads about point `side` of ring `ring`. Throws InputError when one of them is not there: at
  /// an end, at a pole, or in another opening.
  Opening open(std::size_t piece, std::size_t ring, std::size_t side);

  /// A tube out of an opening through `rings`, of eight points each; the last may be a pole, otherwise it gets a cap.
  /// Returns its number, for `open`: ring 0 is the rim.
  std::size_t add_sprout(const Opening& from, std::span<const Ring> rings);

  /// A tube from one opening through `rings`, of eight points each, to another.
  std::size_t add_bridge(const Opening& from, std::span<const Ring> rings, const Opening& to);

  /// All of it. Vertices that stood in the middle of an opening are left out.
  TriangleSoup surface() const;

 private:
  using RingOfVertices = std::vector<std::uint32_t>;

  struct Piece {
    std::vector<RingOfVertices> rings;
    bool capped_at_start = false;
    bool capped_at_end = false;
    std::vector<std::array<std::size_t, 2>> removed;  ///< quads: ring, side
  };

  RingOfVertices add_vertices(const Ring& ring);
  /// `rim`, so rotated that its points lie as those of `ring` do, both taken about their own centres.
  RingOfVertices aligned(RingOfVertices rim, const Ring& ring) const;
  static bool has_quad(const Piece& piece, std::size_t ring, std::size_t side);

  std::vector<Point> positions_;
  std::vector<Piece> pieces_;
};

}  // namespace voxcarve
