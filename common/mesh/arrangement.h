// Making a soup a piecewise linear complex.
#pragma once

#include <cstdint>
#include <vector>

#include "common/mesh/triangle_soup.h"
#include "common/run/context.h"

namespace voxcarve {

/// What stood in the way of a soup being a piecewise linear complex.
struct ArrangementReport {
  std::int64_t merged_vertices = 0;       ///< used vertices at the position of an earlier one
  std::int64_t degenerate_triangles = 0;  ///< with a repeated position, or collinear; dropped
  std::int64_t duplicate_triangles = 0;   ///< with the same three positions as an earlier one
  /// Pairs of the others that meet elsewhere than in a common vertex or a whole common edge.
  std::int64_t crossing_pairs = 0;
  std::int64_t rounding_pairs = 0;   ///< such pairs that rounding the new vertices made, in all passes
  std::int64_t split_triangles = 0;  ///< triangles that a pass replaced by parts, in all passes
  std::int64_t new_vertices = 0;     ///< of the complex, at no vertex of the soup
  std::int64_t passes = 0;           ///< how often crossings were resolved; 0 when there were none
};

/// A soup as a piecewise linear complex: triangles meet only in common vertices and whole common edges, by index; no
/// two vertices have the same position, no two triangles the same three vertices, and none is collinear.
struct Arrangement {
  TriangleSoup complex;  ///< without unused vertices and without colours
  /// Per triangle: how often the soup has it in this orientation less how often in the opposite one. 0 is possible: two
  /// such walls back to back.
  std::vector<std::int32_t> multiplicity;
  std::vector<std::uint32_t> source;  ///< per triangle, ascending: the first triangle of the soup that it is a part of
  ArrangementReport report;
};

/// Merges vertices at equal positions, drops degenerate triangles, merges those that coincide, and splits triangles
/// where they meet otherwise than a complex allows: by exact intersections, one constrained Delaunay triangulation for
/// a triangle or a connected group of coplanar ones, and rounding of the new vertices to the nearest double. Where
/// rounding made new crossings, new vertices at them are merged with others within 2^-48 of the largest coordinate
/// (16 times that after each further pass, so at the most within 2^-32), and the step is repeated if need be.
///
/// What the soup covers is covered still, up to that rounding and merging; so the winding number, the sum over the
/// triangles of multiplicity times solid angle, is the soup's at every point that these did not sweep over. Vertices of
/// the soup stay where they are and in their order, new ones come last; parts are oriented like their `source`. A soup
/// that is a complex already comes back as it was, apart from unused vertices and colours.
///
/// The same bytes on any number of threads, and up to rounding at any scale. Throws InputError when the soup is not
/// valid (`validate`), MethodFailure when crossings are left after five passes, ResourceError and Cancelled.
Arrangement arrange(const TriangleSoup& soup, RunContext& context);

}  // namespace voxcarve
