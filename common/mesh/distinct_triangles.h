// What merging vertices leaves behind in a soup.
#pragma once

#include <cstdint>

#include "common/mesh/triangle_soup.h"

namespace voxcarve {

/// What `keep_distinct_triangles` dropped.
struct DistinctTrianglesReport {
  std::int64_t collapsed = 0;  ///< triangles that name a vertex twice
  std::int64_t duplicate = 0;  ///< triangles of the same three vertices as an earlier one, whichever way round
};

/// Drops triangles that name a vertex twice and all but the first of those with the same three vertices, by index. The
/// others keep their order and their colours; positions stay as they are. O(m log m) for m triangles, with 16 bytes for
/// each beside the soup.
DistinctTrianglesReport keep_distinct_triangles(TriangleSoup& soup);

}  // namespace voxcarve
