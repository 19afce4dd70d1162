// The libraries that the kernels are measured against. This header knows none of them, and each is optional but CGAL.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "common/mesh/triangle_soup.h"
#include "common/volume/grid.h"
#include "experiments/benchmarks/harness.h"

namespace voxcarve::bench {

/// One run of a peer on the input that it was prepared for. Of a voxelization the result is the number of interior
/// voxels, of an isosurface that of triangles and of a labelling that of components, counted after the clock has
/// stopped. Volumes are copied then, too.
using CountingPeer = std::function<Timed<std::int64_t>()>;
using FilteringPeer = std::function<Timed<BinaryVolume>()>;
using DistancePeer = std::function<Timed<Grid<std::int32_t>>()>;
using FieldPeer = std::function<Timed<Grid<float>>()>;
using ReducingPeer = std::function<Timed<TriangleSoup>()>;

/// Which libraries were found when the build was configured. The functions below of one that was not return an empty
/// function.
struct PeersAtHand {
  bool vtk = false;
  bool openvdb = false;
  bool itk = false;
  bool meshoptimizer = false;
};
PeersAtHand peers_at_hand();

/// vtkPolyDataToImageStencil, then vtkImageStencilToImage into a mask of bytes; both are timed. One thread: neither
/// filter has more.
CountingPeer vtk_voxelization(const TriangleSoup& soup, const GridFrame& frame);

/// vtkFlyingEdges3D on the grid's own memory, without normals, gradients and scalars.
CountingPeer vtk_isosurface(const Grid<float>& field, float iso_value, int threads);

/// "TBB", "STDThread", ...: how VTK's filters share their work; empty when VTK was not built in.
std::string vtk_smp_backend();

/// openvdb::tools::meshToVolume, then sdfInteriorMask and copyToDense into a mask of bytes; all three are timed. The
/// narrow band is one voxel wide on either side, the least that a mask needs.
CountingPeer openvdb_voxelization(const TriangleSoup& soup, const GridFrame& frame, int threads);

/// Opening by a ball of a whole number of voxels from two squared distance maps of
/// itk::SignedMaurerDistanceMapImageFilter, each followed by a threshold to bytes; all four filters are timed. `volume`
/// lives as long as the peer and has a layer of exterior all around: ITK does not see beyond it.
FilteringPeer itk_opening(const BinaryVolume& volume, std::int64_t radius, int threads);

/// The squared distance map of itk::SignedMaurerDistanceMapImageFilter in floats: to the nearest interior voxel, and in
/// the interior, negative, to the nearest one at its border.
DistancePeer itk_squared_distance(const BinaryVolume& volume, int threads);

/// itk::ConnectedComponentImageFilter into labels of 32 bits, of the interior by faces.
CountingPeer itk_labelling(const BinaryVolume& volume, int threads);

/// itk::SmoothingRecursiveGaussianImageFilter in floats, with sigma in voxels: three recursive passes that approximate
/// the Gaussian without a cut-off. The field's last values repeat beyond the grid.
FieldPeer itk_gaussian(const Grid<float>& field, double sigma, int threads);

/// meshopt_simplify without options and without a limit of the error, positions as float. One thread.
ReducingPeer meshoptimizer_reduction(const TriangleSoup& soup, std::int64_t triangles);

/// CGAL's edge_collapse with Garland-Heckbert's cost and placement and its bound on turning normals. One thread.
/// Building the mesh is not timed. `soup` is a manifold.
ReducingPeer cgal_reduction(const TriangleSoup& soup, std::int64_t triangles);

}  // namespace voxcarve::bench
