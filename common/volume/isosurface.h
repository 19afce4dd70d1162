// Volume to closed manifold surface.
#pragma once

#include "common/mesh/triangle_soup.h"
#include "common/run/context.h"
#include "common/volume/grid.h"

namespace voxcarve {

/// The surface {density = iso_value} of {density >= iso_value}, by marching cubes on the voxel centres [NT03, 5.1].
/// Closed (outside the grid the density is 0), oriented with normals to the exterior, everywhere 2-manifold, vertices
/// shared, no zero-area triangle: crossings keep a distance of 2^-10 voxel from the samples, and up to a quarter of one
/// far from the origin, where a voxel has few of the coordinates' last digits (at least eight, as `voxel_frame` sees
/// to). Empty when nothing is inside. Throws ParameterError unless 0 < iso_value, and ResourceError, before any of it
/// is made, for a surface that exceeds the memory budget or has 2^32 vertices.
///
/// Every crossed grid edge has one vertex. Vertices come by rows of samples along x, row after row along y and then z:
/// first those on the edges of the row, then on the y-edges that start at its samples, then on the z-edges; triangles
/// come in the order of their cells, x fastest. The same bytes on any number of threads.
TriangleSoup isosurface(const DensityVolume& volume, float iso_value, RunContext& context);

/// The same of a binary volume, whose surface passes midway between interior and exterior voxel centres.
TriangleSoup isosurface(const BinaryVolume& volume, RunContext& context);

/// The same of a scalar field with values of any size; at the border of the grid the surface closes on the outer faces
/// of the border voxels.
TriangleSoup scalar_isosurface(const Grid<float>& field, float iso_value, RunContext& context);

}  // namespace voxcarve
