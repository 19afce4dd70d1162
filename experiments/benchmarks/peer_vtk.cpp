// VTK 9.1: solid voxelization by image stencils, isosurface by flying edges.
// vtkSMPTools.h is no C++20 (it names constructors with their template arguments); it forwards to this.
#include <SMP/Common/vtkSMPToolsAPI.h>
#include <vtkCellArray.h>
#include <vtkFloatArray.h>
#include <vtkFlyingEdges3D.h>
#include <vtkImageData.h>
#include <vtkImageStencilData.h>
#include <vtkImageStencilToImage.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataToImageStencil.h>
#include <vtkSmartPointer.h>

#include <algorithm>
#include <array>

#include "experiments/benchmarks/peers.h"

namespace voxcarve::bench {

namespace {

vtk::detail::smp::vtkSMPToolsAPI& smp_tools() {
  return vtk::detail::smp::vtkSMPToolsAPI::GetInstance();
}

vtkSmartPointer<vtkPolyData> to_vtk(const TriangleSoup& soup) {
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  points->SetNumberOfPoints(static_cast<vtkIdType>(soup.positions.size()));
  for (std::size_t v = 0; v < soup.positions.size(); ++v)
    points->SetPoint(static_cast<vtkIdType>(v), soup.positions[v].data());
  vtkNew<vtkCellArray> triangles;
  for (const Triangle& t : soup.triangles) triangles->InsertNextCell({t[0], t[1], t[2]});
  vtkSmartPointer<vtkPolyData> mesh = vtkSmartPointer<vtkPolyData>::New();
  mesh->SetPoints(points);
  mesh->SetPolys(triangles);
  return mesh;
}

/// The last voxel along each axis, as VTK's extents want it.
std::array<int, 3> last_voxel(const GridFrame& frame) {
  const Index3 last = frame.dims - Index3::Ones();
  return {static_cast<int>(last[0]), static_cast<int>(last[1]), static_cast<int>(last[2])};
}

}  // namespace

CountingPeer vtk_voxelization(const TriangleSoup& soup, const GridFrame& frame) {
  return [mesh = to_vtk(soup), frame] {
    const Point first = frame.center(Index3::Zero());
    const std::array<int, 3> last = last_voxel(frame);
    vtkNew<vtkPolyDataToImageStencil> stencil;
    stencil->SetInputData(mesh);
    stencil->SetOutputOrigin(first[0], first[1], first[2]);
    stencil->SetOutputSpacing(frame.voxel_size, frame.voxel_size, frame.voxel_size);
    stencil->SetOutputWholeExtent(0, last[0], 0, last[1], 0, last[2]);
    vtkNew<vtkImageStencilToImage> mask;
    mask->SetInputConnection(stencil->GetOutputPort());
    mask->SetInsideValue(1);
    mask->SetOutsideValue(0);
    mask->SetOutputScalarTypeToUnsignedChar();
    const auto made = timed([&] {
      mask->Update();
      return mask->GetOutput();
    });
    const auto* voxels = static_cast<const unsigned char*>(made.result->GetScalarPointer());
    return Timed<std::int64_t>{made.seconds, std::count(voxels, voxels + frame.voxels(), 1)};
  };
}

CountingPeer vtk_isosurface(const Grid<float>& field, float iso_value, int threads) {
  const GridFrame& frame = field.frame;
  vtkNew<vtkFloatArray> values;
  constexpr int kNotOwned = 1;
  // VTK only reads them.
  values->SetArray(const_cast<float*>(field.values.data()), static_cast<vtkIdType>(field.values.size()), kNotOwned);
  const Point first = frame.center(Index3::Zero());
  const std::array<int, 3> last = last_voxel(frame);
  vtkSmartPointer<vtkImageData> image = vtkSmartPointer<vtkImageData>::New();
  image->SetExtent(0, last[0], 0, last[1], 0, last[2]);
  image->SetOrigin(first[0], first[1], first[2]);
  image->SetSpacing(frame.voxel_size, frame.voxel_size, frame.voxel_size);
  image->GetPointData()->SetScalars(values);
  return [image, iso_value, threads] {
    smp_tools().Initialize(threads);
    vtkNew<vtkFlyingEdges3D> edges;
    edges->SetInputData(image);
    edges->SetValue(0, iso_value);
    edges->ComputeNormalsOff();
    edges->ComputeGradientsOff();
    edges->ComputeScalarsOff();
    const auto made = timed([&] {
      edges->Update();
      return edges->GetOutput();
    });
    return Timed<std::int64_t>{made.seconds, made.result->GetNumberOfPolys()};
  };
}

std::string vtk_smp_backend() {
  return smp_tools().GetBackend();
}

}  // namespace voxcarve::bench
