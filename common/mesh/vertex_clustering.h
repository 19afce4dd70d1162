// Simplification by merging the vertices in each cell of a grid.
#pragma once

#include <cstdint>

#include "common/mesh/triangle_soup.h"
#include "common/run/context.h"

namespace voxcarve {

/// Where the vertices of a cell go.
enum class ClusterRepresentative {
  kQuadric,  ///< the point of the cell with the least sum of squared distances to the planes around [Lin00]
  kMean,     ///< the mean of the vertices
  kHeaviest  ///< the vertex of the greatest weight by the grading of [RB93]
};

struct VertexClusteringOptions {
  std::int64_t cells = 32;  ///< along the longest side of the bounding box; at least 1
  ClusterRepresentative representative = ClusterRepresentative::kQuadric;
};

/// The most cells along a side.
constexpr std::int64_t kMostClusterCells = std::int64_t{1} << 20;

/// Vertex clustering [RB93]: a grid of cubes is laid over the bounding box, from its lower corner, and all vertices in
/// a cell become one. Triangles with corners in fewer than three cells vanish, where [RB93] keeps edges and points to
/// be drawn; of triangles with the same three vertices, whichever way round, the first is kept. The result is empty
/// when nothing else is left, as it always is with one cell.
///
/// Vertices of equal position count once. Every representative lies in its cell, up to rounding; one that is alone in
/// its cell keeps its coordinates to the last bit. Nothing is promised of the topology. Vertex colours are averaged in
/// a cell, or the heaviest vertex's; triangle colours and the order of the triangles stay. Clusters come in the order
/// of x, then y, then z. The same bytes for the same input, whatever the number of threads. Throws
/// ParameterError for cells out of range, ResourceError before exceeding the memory budget, and Cancelled.
TriangleSoup cluster_vertices(const TriangleSoup& soup, const VertexClusteringOptions& options, RunContext& context);

/// A number of cells along the longest side with which `cluster_vertices` leaves at most `triangles`, but some; 0 when
/// none was found. The number of triangles does not rise steadily with the number of cells. The search doubles the
/// cells until there are too many triangles, halves the interval to a number that fits and whose next one does not, and
/// then looks through the numbers above it, up to an eighth (8 of them at least, 64 at most), and takes the largest
/// that fits; where there is none and that number leaves no triangle, likewise below. So there may be finer grids that
/// fit, but only farther off. A soup of at most `triangles` gets kMostClusterCells. Throws ResourceError and Cancelled.
std::int64_t cluster_cells_for(const TriangleSoup& soup, std::int64_t triangles, RunContext& context);

}  // namespace voxcarve
