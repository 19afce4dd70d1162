// Surfaces, edges and translucent layers.
#include "experiments/render/mesh_actor.h"

#include <vtkActor.h>
#include <vtkCameraPass.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkFloatArray.h>
#include <vtkLightsPass.h>
#include <vtkNew.h>
#include <vtkOpaquePass.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderPassCollection.h>
#include <vtkRenderer.h>
#include <vtkSequencePass.h>
#include <vtkShaderProperty.h>
#include <vtkTranslucentPass.h>
#include <vtkTypeInt32Array.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <array>
#include <cstddef>

namespace voxcarve {

namespace {

constexpr Rgb8 kDarkLine = {20, 20, 26};
constexpr Rgb8 kLightLine = {200, 200, 206};
constexpr int kDarkSurface = 64;  ///< luminance, of 255, below which lines are light

/// Copies triples of numbers into a VTK array.
template <typename Array, typename Triple>
void fill(Array& array, const std::vector<Triple>& triples) {
  array.SetNumberOfComponents(3);
  array.SetNumberOfTuples(static_cast<vtkIdType>(triples.size()));
  auto* out = array.GetPointer(0);
  for (const Triple& triple : triples) out = std::copy_n(triple.data(), 3, out);
}

/// Cells of equal size from tuples of vertex indices.
template <std::size_t Size>
vtkNew<vtkCellArray> make_cells(const std::vector<std::array<std::uint32_t, Size>>& tuples) {
  const vtkNew<vtkTypeInt32Array> connectivity;
  connectivity->SetNumberOfValues(static_cast<vtkIdType>(Size * tuples.size()));
  vtkTypeInt32* out = connectivity->GetPointer(0);
  for (const auto& tuple : tuples) {
    out = std::transform(tuple.begin(), tuple.end(), out, [](std::uint32_t i) { return static_cast<vtkTypeInt32>(i); });
  }
  vtkNew<vtkCellArray> cells;
  cells->SetData(static_cast<vtkIdType>(Size), connectivity);
  return cells;
}

vtkNew<vtkPoints> make_points(const DisplayMesh& mesh) {
  const vtkNew<vtkFloatArray> coordinates;
  fill(*coordinates, mesh.positions);
  vtkNew<vtkPoints> points;
  points->SetData(coordinates);
  return points;
}

constexpr double kAmbient = 0.2;  ///< share of the light that comes from everywhere

/// Dull red where a surface is seen from behind, whatever its own colour (VTK's backface property gives way to
/// colours).
constexpr const char* kTintBehind = R"(//VTK::Color::Impl
  if (gl_FrontFacing == false) {
    ambientColor = 0.2 * vec3(0.66, 0.35, 0.30);
    diffuseColor = 0.8 * vec3(0.66, 0.35, 0.30);
    specularColor = vec3(0.0);
  }
)";

/// A visible face turns its interpolated normal to the camera at least a little; else the last row of triangles before
/// a silhouette, where interpolated normals point away from the camera, is black and toothed.
constexpr const char* kFaceCamera = R"(//VTK::Normal::Impl
  vec3 toCamera = normalize(-vertexVC.xyz);
  float facing = dot(normalVCVSOutput, toCamera);
  if (facing < 0.05) normalVCVSOutput = normalize(normalVCVSOutput + (0.05 - facing) * toCamera);
)";

/// What all surfaces have in common.
vtkNew<vtkActor> make_lit_actor(const DisplayMesh& mesh, vtkPoints* points, const std::vector<Triangle>& triangles,
                                vtkUnsignedCharArray* colors) {
  const vtkNew<vtkFloatArray> normals;
  fill(*normals, mesh.normals);
  const vtkNew<vtkPolyData> data;
  data->SetPoints(points);
  data->SetPolys(make_cells(triangles));
  data->GetPointData()->SetNormals(normals);
  data->GetPointData()->SetScalars(colors);

  const vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(data);
  mapper->SetColorModeToDirectScalars();
  vtkNew<vtkActor> actor;
  actor->SetMapper(mapper);
  vtkProperty& look = *actor->GetProperty();
  look.SetInterpolationToPhong();
  look.SetAmbient(kAmbient);
  look.SetDiffuse(1 - kAmbient);
  look.SetSpecular(0.06);
  look.SetSpecularPower(24);
  vtkShaderProperty& shader = *actor->GetShaderProperty();
  shader.AddFragmentShaderReplacement("//VTK::Color::Impl", true, kTintBehind, false);
  shader.AddFragmentShaderReplacement("//VTK::Normal::Impl", true, kFaceCamera, false);
  return actor;
}

/// The triangles that are two-sided, or those that are not. Behind the front of a two-sided one lies the back of the
/// other, at the same depth: that must not be drawn, or the two take turns from pixel to pixel.
vtkNew<vtkActor> make_surface(const DisplayMesh& mesh, vtkPoints* points, bool two_sided) {
  std::vector<Triangle> triangles;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (mesh.two_sided[t] == two_sided) triangles.push_back(mesh.triangles[t]);
  }
  const vtkNew<vtkUnsignedCharArray> colors;
  fill(*colors, mesh.colors);
  vtkNew<vtkActor> actor = make_lit_actor(mesh, points, triangles, colors);
  if (!mesh.edges.empty()) {
    // Edges lie in the surface: it steps back a little, more where it is seen at a slant.
    vtkMapper::SetResolveCoincidentTopologyToPolygonOffset();
    actor->GetMapper()->SetRelativeCoincidentTopologyPolygonOffsetParameters(1, 1);
  }
  actor->GetProperty()->SetBackfaceCulling(two_sided ? 1 : 0);
  return actor;
}

/// Dark lines, and light ones where the surface is dark. Colours are those of the edges' ends.
vtkNew<vtkUnsignedCharArray> make_edge_colors(const DisplayMesh& mesh) {
  std::vector<Rgb8> colors;
  for (const auto& [a, b] : mesh.edges) {
    int luminance = 0;  // ITU-R BT.601, in thousandths, of both ends
    for (const std::uint32_t end : {a, b}) {
      const Rgb8& color = mesh.colors[end];
      luminance += 299 * color[0] + 587 * color[1] + 114 * color[2];
    }
    colors.push_back(luminance < 2000 * kDarkSurface ? kLightLine : kDarkLine);
  }
  vtkNew<vtkUnsignedCharArray> array;
  fill(*array, colors);
  return array;
}

/// Opaque things, then translucent ones as they come, blended.
vtkNew<vtkCameraPass> make_ordered_passes() {
  const vtkNew<vtkRenderPassCollection> passes;
  passes->AddItem(vtkNew<vtkLightsPass>());
  passes->AddItem(vtkNew<vtkOpaquePass>());
  passes->AddItem(vtkNew<vtkTranslucentPass>());
  const vtkNew<vtkSequencePass> sequence;
  sequence->SetPasses(passes);
  vtkNew<vtkCameraPass> camera;
  camera->SetDelegatePass(sequence);
  return camera;
}

}  // namespace

void add_surface(vtkRenderer& renderer, const DisplayMesh& mesh) {
  const vtkNew<vtkPoints> points = make_points(mesh);
  for (const bool two_sided : {false, true}) {
    if (std::ranges::count(mesh.two_sided, two_sided) > 0) renderer.AddActor(make_surface(mesh, points, two_sided));
  }
}

void add_edges(vtkRenderer& renderer, const DisplayMesh& mesh, double opacity, float width) {
  const vtkNew<vtkPolyData> data;
  data->SetPoints(make_points(mesh));
  data->SetLines(make_cells(mesh.edges));
  data->GetCellData()->SetScalars(make_edge_colors(mesh));
  const vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(data);
  mapper->SetColorModeToDirectScalars();
  const vtkNew<vtkActor> actor;
  actor->SetMapper(mapper);
  vtkProperty& look = *actor->GetProperty();
  look.LightingOff();
  look.SetOpacity(opacity);
  look.SetLineWidth(width);
  renderer.AddActor(actor);
}

void add_translucent(vtkRenderer& renderer, const DisplayMesh& mesh, const std::vector<std::uint8_t>& opacities) {
  const vtkNew<vtkUnsignedCharArray> colors;
  colors->SetNumberOfComponents(4);
  colors->SetNumberOfTuples(static_cast<vtkIdType>(mesh.colors.size()));
  unsigned char* out = colors->GetPointer(0);
  for (std::size_t i = 0; i < mesh.colors.size(); ++i) {
    out = std::copy_n(mesh.colors[i].data(), 3, out);
    *out++ = opacities[i];
  }
  const vtkNew<vtkActor> actor = make_lit_actor(mesh, make_points(mesh), mesh.triangles, colors);
  actor->GetProperty()->SetBackfaceCulling(1);
  actor->ForceTranslucentOn();
  renderer.AddActor(actor);
  renderer.SetPass(make_ordered_passes());
}

}  // namespace voxcarve
