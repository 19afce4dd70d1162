// What goes wrong in polygonal models, done to sound ones on purpose: single defects, and places on a block surface
// where larger ones have room.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <functional>
#include <map>
#include <span>
#include <vector>

#include "common/mesh/triangle_soup.h"

namespace voxcarve {

/// Cuts `triangle` in two at the middle of its side from `corner` to the next one. The neighbour keeps the whole side:
/// a T-joint. One triangle and one vertex more.
void add_t_joint(TriangleSoup& soup, std::size_t triangle, std::size_t corner);

/// The same, and a third triangle of zero area over the side, so that every edge still has two triangles. Two triangles
/// and one vertex more. The area is exactly zero where the middle of the side is a double.
void add_zero_area_face(TriangleSoup& soup, std::size_t triangle, std::size_t corner);

/// A rectangle of squares on a plane of a block surface, at least one square away from the plane's edge.
struct SurfacePatch {
  Eigen::Vector3i low;               ///< its lower corner, in squares
  int u = 0;                         ///< axis along its width
  int v = 0;                         ///< axis along its height
  std::vector<std::size_t> squares;  ///< row by row along u; square q has the triangles 2 q and 2 q + 1
};

/// The squares of a block surface by place. `soup` is as `block_surface` makes it with squares of edge 1: triangles 2 q
/// and 2 q + 1 are one square with integer corners. Two squares in one place on the same side are not allowed.
class SquareIndex {
 public:
  /// Is a patch allowed to use the square with this lower corner, on the side `side` (-1 or 1) of `axis`?
  using Filter = std::function<bool(const Eigen::Vector3i& low, int axis, int side)>;

  explicit SquareIndex(const TriangleSoup& soup, const Filter& filter = {});

  /// Up to `count` patches of width x height squares, spread over the surface, always the same ones. No two share a
  /// square or are nearer than one square; turned by 90 degrees where only that fits.
  std::vector<SurfacePatch> choose_patches(std::size_t count, int width, int height) const;

 private:
  using Place = std::array<int, 5>;  ///< axis, side, lower corner

  std::vector<Place> places_;  ///< by square
  std::map<Place, std::size_t> square_at_;
};

/// Removes the triangles of the patches, and the vertices that nothing uses any more.
void cut_holes(TriangleSoup& soup, std::span<const SurfacePatch> patches);

/// Slits patches of 2 squares' height along their middle line, `width` wide at its inner vertices and closed at its two
/// ends. A patch of n squares' length gets 2 n boundary edges.
void cut_cracks(TriangleSoup& soup, std::span<const SurfacePatch> patches, double width);

/// Adds the triangles of the patches once more, on the same vertices.
void duplicate_patches(TriangleSoup& soup, std::span<const SurfacePatch> patches);

}  // namespace voxcarve
