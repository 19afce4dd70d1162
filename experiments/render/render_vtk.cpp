// The scene of a panel, drawn with VTK.
#include <vtkActor.h>
#include <vtkCallbackCommand.h>
#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkFloatArray.h>
#include <vtkLight.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkShaderProperty.h>
#include <vtkTypeInt32Array.h>
#include <vtkUnsignedCharArray.h>
#include <vtkVolume.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <mutex>
#include <numbers>
#include <optional>

#include "common/run/errors.h"
#include "experiments/render/camera.h"
#include "experiments/render/display_mesh.h"
#include "experiments/render/offscreen_window.h"
#include "experiments/render/scene_painter.h"
#include "experiments/render/volume_actor.h"

namespace voxcarve {

namespace {

constexpr int kSupersampling = 2;  ///< drawn at so many times the size, then averaged
constexpr double kViewAngle = 24;  ///< degrees, vertical: little perspective
constexpr Rgb8 kDarkLine = {20, 20, 26};
constexpr Rgb8 kLightLine = {200, 200, 206};
constexpr int kDarkSurface = 64;       ///< luminance, of 255, below which lines are light
constexpr double kFilledShare = 0.92;  ///< of the panel's width or height, by the shape

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

vtkNew<vtkActor> make_surface(const DisplayMesh& mesh, vtkPoints* points) {
  const vtkNew<vtkFloatArray> normals;
  fill(*normals, mesh.normals);
  const vtkNew<vtkUnsignedCharArray> colors;
  fill(*colors, mesh.colors);
  const vtkNew<vtkPolyData> data;
  data->SetPoints(points);
  data->SetPolys(make_cells(mesh.triangles));
  data->GetPointData()->SetNormals(normals);
  data->GetPointData()->SetScalars(colors);

  const vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(data);
  mapper->SetColorModeToDirectScalars();
  if (!mesh.edges.empty()) {
    // Edges lie in the surface: it steps back a little, more where it is seen at a slant.
    vtkMapper::SetResolveCoincidentTopologyToPolygonOffset();
    mapper->SetRelativeCoincidentTopologyPolygonOffsetParameters(1, 1);
  }
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

vtkNew<vtkActor> make_edges(const DisplayMesh& mesh, vtkPoints* points, double opacity) {
  const vtkNew<vtkPolyData> data;
  data->SetPoints(points);
  data->SetLines(make_cells(mesh.edges));
  data->GetCellData()->SetScalars(make_edge_colors(mesh));
  const vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(data);
  mapper->SetColorModeToDirectScalars();
  vtkNew<vtkActor> actor;
  actor->SetMapper(mapper);
  vtkProperty& look = *actor->GetProperty();
  look.LightingOff();
  look.SetOpacity(opacity);
  look.SetLineWidth(kSupersampling);
  return actor;
}

/// A lamp that moves with the camera: `x` to the right of it, `y` above, `z` before the scene.
/// Ambient light is a matter of surfaces for meshes, and of lamps too for the ray caster: `ambient` is what it is
/// there.
void add_lamp(vtkRenderer& renderer, double x, double y, double z, double intensity, double ambient) {
  const vtkNew<vtkLight> lamp;
  lamp->SetLightTypeToCameraLight();
  lamp->SetPosition(x, y, z);
  lamp->SetFocalPoint(0, 0, 0);
  lamp->SetIntensity(intensity);
  lamp->SetAmbientColor(ambient, ambient, ambient);
  renderer.AddLight(lamp);
}

/// `aspect`: width over height. The ray caster takes the renderer's, which VTK 9.1 now and then leaves at 1; the
/// camera's own takes precedence everywhere.
void aim(vtkCamera& camera, const FittedCamera& fitted, const ViewFrame& view, double aspect) {
  const Eigen::Vector3d focus = fitted.position - view.back;
  camera.SetPosition(fitted.position.data());
  camera.SetFocalPoint(focus.data());
  camera.SetViewUp(view.up.data());
  camera.SetViewAngle(kViewAngle);
  camera.UseExplicitAspectRatioOn();
  camera.SetExplicitAspectRatio(aspect);
  camera.SetClippingRange(0.99 * fitted.nearest, 1.01 * fitted.farthest);
}

/// Fainter lines where they lie dense, so that the shading stays visible: in proportion to the mean length of an edge
/// in pixels, up to 12 pixels or so.
double edge_opacity(const DisplayMesh& mesh, const FittedCamera& camera, int height) {
  double length = 0;
  for (const auto& [a, b] : mesh.edges) length += static_cast<double>((mesh.positions[a] - mesh.positions[b]).norm());
  const double pixels_per_unit =
      height / ((camera.nearest + camera.farthest) * std::tan(kViewAngle / 2 * std::numbers::pi / 180));
  const double pixels = pixels_per_unit * length / static_cast<double>(std::max<std::size_t>(1, mesh.edges.size()));
  return std::clamp(pixels / 12, 0.12, 0.85);
}

/// Calls visit(point) with points whose convex hull holds what will be drawn.
template <class Visit>
void for_each_point(const RenderContent& content, const Visit& visit) {
  if (const auto* soup = std::get_if<TriangleSoup>(&content)) {
    for (const Triangle& triangle : soup->triangles) {
      for (const std::uint32_t vertex : triangle) visit(soup->positions[vertex]);
    }
  } else if (const auto* binary = std::get_if<BinaryVolume>(&content)) {
    for (const Point& point : interior_hull(*binary)) visit(point);
  } else if (const auto* scalar = std::get_if<ScalarVolume>(&content)) {
    for (const Point& point : interior_hull(*scalar)) visit(point);
  }
}

/// The part of the model that a picture shows, and the camera that holds it.
struct View {
  UnitFrame frame;
  FittedCamera camera;
};

}  // namespace

class ScenePainter::Impl {
 public:
  Impl(const std::vector<RenderItem>& items, const RenderOptions& options, int width, int height)
      : options_(options),
        direction_(ViewFrame::from_angles(options.azimuth, options.elevation, options.up_axis)),
        width_(width),
        height_(height),
        window_(kSupersampling * width, kSupersampling * height) {
    const vtkNew<vtkCallbackCommand> stop;
    stop->SetClientData(const_cast<std::stop_token*>(&options.cancellation));
    stop->SetCallback([](vtkObject* window, unsigned long, void* token, void*) {
      if (static_cast<const std::stop_token*>(token)->stop_requested())
        static_cast<vtkRenderWindow*>(window)->SetAbortRender(1);
    });
    window_.window().AddObserver(vtkCommand::AbortCheckEvent, stop);
    if (!options.common_camera) return;
    std::vector<const RenderContent*> contents;
    for (const RenderItem& item : items) contents.push_back(&item.content);
    common_view_ = view_of(contents);
  }

  std::vector<unsigned char> paint(const RenderContent& content) {
    const vtkNew<vtkRenderer> renderer;
    renderer->SetBackground(1, 1, 1);
    renderer->AutomaticLightCreationOff();
    add_lamp(*renderer, -0.40, 0.60, 1, 0.93, 1);   // key
    add_lamp(*renderer, 0.90, 0.00, 0.7, 0.35, 0);  // fill
    const View view = options_.common_camera ? common_view_ : view_of({&content});
    DisplayVolume volume;  // outlives its actor
    if (const auto* soup = std::get_if<TriangleSoup>(&content)) {
      if (!soup->empty()) add_mesh(*renderer, *soup, view);
    } else if (const auto* binary = std::get_if<BinaryVolume>(&content)) {
      volume = make_display_volume(*binary, view.frame);
    } else if (const auto* scalar = std::get_if<ScalarVolume>(&content)) {
      volume = make_display_volume(*scalar, view.frame);
    }
    if (!volume.samples.empty()) add_volume(*renderer, volume);
    aim(*renderer->GetActiveCamera(), view.camera, direction_, static_cast<double>(width_) / height_);
    window_.window().AddRenderer(renderer);
    const std::vector<unsigned char> pixels = window_.draw();
    window_.window().RemoveRenderer(renderer);
    if (options_.cancellation.stop_requested()) throw Cancelled();
    return average(pixels);
  }

 private:
  View view_of(const std::vector<const RenderContent*>& contents) const {
    Box box;
    for (const RenderContent* content : contents)
      for_each_point(*content, [&box](const Point& point) { box.extend(point); });
    const UnitFrame frame = UnitFrame::of(box);
    const double tangent = kFilledShare * std::tan(kViewAngle / 2 * std::numbers::pi / 180);
    CameraFitter fitter(direction_, tangent * width_ / height_, tangent);
    for (const RenderContent* content : contents)
      for_each_point(*content, [&](const Point& point) { fitter.add(frame.to_unit(point)); });
    return {frame, fitter.fit()};
  }

  void add_mesh(vtkRenderer& renderer, const TriangleSoup& soup, const View& view) const {
    const DisplayMesh mesh = make_display_mesh(soup, view.frame, options_.crease_angle, options_.wireframe);
    const vtkNew<vtkPoints> points = make_points(mesh);
    renderer.AddActor(make_surface(mesh, points));
    if (options_.wireframe) renderer.AddActor(make_edges(mesh, points, edge_opacity(mesh, view.camera, height_)));
  }

  std::vector<unsigned char> average(const std::vector<unsigned char>& pixels) const {
    constexpr unsigned kSamples = kSupersampling * kSupersampling;
    const auto width = static_cast<std::size_t>(width_);
    const auto height = static_cast<std::size_t>(height_);
    std::vector<unsigned char> averaged(3 * width * height);
    for (std::size_t y = 0; y < height; ++y) {  // from the bottom, as OpenGL counts
      for (std::size_t i = 0; i < 3 * width; ++i) {
        unsigned sum = kSamples / 2;
        for (std::size_t sample = 0; sample < kSamples; ++sample) {
          const std::size_t row = kSupersampling * y + sample / kSupersampling;
          const std::size_t column = kSupersampling * (i / 3) + sample % kSupersampling;
          sum += pixels[3 * (row * kSupersampling * width + column) + i % 3];
        }
        averaged[3 * width * (height - 1 - y) + i] = static_cast<unsigned char>(sum / kSamples);
      }
    }
    return averaged;
  }

  const RenderOptions& options_;
  ViewFrame direction_;
  int width_, height_;
  OffscreenWindow window_;
  View common_view_;
};

ScenePainter::ScenePainter(const std::vector<RenderItem>& items, const RenderOptions& options, int width, int height)
    : impl_(std::make_unique<Impl>(items, options, width, height)) {}
ScenePainter::~ScenePainter() = default;

std::vector<unsigned char> ScenePainter::paint(const RenderContent& content) {
  return impl_->paint(content);
}

bool rendering_available() {
  static const bool available = [] {
    const std::scoped_lock lock(render_mutex());
    try {
      OffscreenWindow(kMinPanelSize, kMinPanelSize);
      return true;
    } catch (const ResourceError&) {
      return false;
    }
  }();
  return available;
}

}  // namespace voxcarve
