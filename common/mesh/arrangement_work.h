// What an arrangement works on, and how it is cleaned up between the steps.
#pragma once

#include <cstdint>
#include <vector>

#include "common/mesh/triangle_soup.h"
#include "common/run/context.h"

namespace voxcarve {

struct ArrangementWork {
  TriangleSoup soup;  ///< without colours
  // Of each triangle:
  std::vector<std::int32_t> multiplicity;
  std::vector<std::uint32_t> source;  ///< ascending
  std::vector<bool> suspects;         ///< it may be degenerate, have a twin or cross others; two others do not cross
  std::size_t old_vertices = 0;       ///< the first so many positions are the soup's own

  void reserve(std::size_t triangles);
  void append(const Triangle& corners, std::int32_t its_multiplicity, std::uint32_t its_source, bool suspect);
  /// A triangle of another work with the same positions.
  void append(const ArrangementWork& other, std::uint32_t triangle);
};

/// How many of each kind a clean-up took away.
struct Removed {
  std::int64_t vertices = 0;
  std::int64_t degenerate = 0;
  std::int64_t duplicates = 0;
};

/// Renames every used vertex to the first at its position, drops triangles that are degenerate, adds up the
/// multiplicities of triangles with the same vertices in the first of them, and drops unused vertices. What is left
/// keeps its order and its place. Throws Cancelled.
Removed clean_up(ArrangementWork& work, const RunContext& context);

}  // namespace voxcarve
