// The scene of a picture, drawn with VTK one panel at a time and put together here.
#include <vtkActor.h>
#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkFloatArray.h>
#include <vtkImageData.h>
#include <vtkLight.h>
#include <vtkNew.h>
#include <vtkPNGWriter.h>
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

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <numbers>
#include <string>

#include "common/run/atomic_file.h"
#include "common/run/errors.h"
#include "experiments/render/camera.h"
#include "experiments/render/captions.h"
#include "experiments/render/display_mesh.h"
#include "experiments/render/layout.h"
#include "experiments/render/offscreen_window.h"
#include "experiments/render/render.h"

namespace voxcarve {

namespace {

constexpr int kSupersampling = 2;      ///< drawn at so many times the size, then averaged
constexpr double kViewAngle = 24;      ///< degrees, vertical: little perspective
constexpr double kFilledShare = 0.92;  ///< of the panel's width or height, by the shape
constexpr unsigned char kSeparator = 208;
constexpr double kSeparatorShare = 1.0 / 400;  ///< of the panel's shorter side
constexpr unsigned char kInk = 24;

/// VTK and GLEW keep process-wide state.
std::mutex& render_mutex() {
  static std::mutex mutex;
  return mutex;
}

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

vtkNew<vtkActor> make_edges(const DisplayMesh& mesh, vtkPoints* points, double opacity) {
  const vtkNew<vtkPolyData> data;
  data->SetPoints(points);
  data->SetLines(make_cells(mesh.edges));
  const vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(data);
  vtkNew<vtkActor> actor;
  actor->SetMapper(mapper);
  vtkProperty& look = *actor->GetProperty();
  look.LightingOff();
  look.SetColor(0.08, 0.08, 0.10);
  look.SetOpacity(opacity);
  look.SetLineWidth(kSupersampling);
  return actor;
}

/// A lamp that moves with the camera: `x` to the right of it, `y` above, `z` before the scene.
void add_lamp(vtkRenderer& renderer, double x, double y, double z, double intensity) {
  const vtkNew<vtkLight> lamp;
  lamp->SetLightTypeToCameraLight();
  lamp->SetPosition(x, y, z);
  lamp->SetFocalPoint(0, 0, 0);
  lamp->SetIntensity(intensity);
  renderer.AddLight(lamp);
}

void aim(vtkCamera& camera, const FittedCamera& fitted, const ViewFrame& view) {
  const Eigen::Vector3d focus = fitted.position - view.back;
  camera.SetPosition(fitted.position.data());
  camera.SetFocalPoint(focus.data());
  camera.SetViewUp(view.up.data());
  camera.SetViewAngle(kViewAngle);
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

/// Draws shapes one after the other into the upper part of a panel.
class PanelPainter {
 public:
  PanelPainter(const std::vector<RenderItem>& items, const RenderOptions& options, int width, int height)
      : options_(options),
        view_(ViewFrame::from_angles(options.azimuth, options.elevation, options.up_axis)),
        width_(width),
        height_(height),
        window_(kSupersampling * width, kSupersampling * height) {
    if (!options.common_camera) return;
    Box box;
    for (const RenderItem& item : items) box.extend(bounds(item.shape));
    common_frame_ = UnitFrame::of(box);
    CameraFitter fitter = make_fitter();
    for (const RenderItem& item : items) add_points(fitter, item.shape, common_frame_);
    common_camera_ = fitter.fit();
  }

  /// RGB of width x height, rows from bottom to top.
  std::vector<unsigned char> paint(const TriangleSoup& shape) {
    const vtkNew<vtkRenderer> renderer;
    renderer->SetBackground(1, 1, 1);
    renderer->AutomaticLightCreationOff();
    add_lamp(*renderer, -0.40, 0.60, 1, 0.93);   // key
    add_lamp(*renderer, 0.90, 0.00, 0.7, 0.35);  // fill
    if (!shape.empty()) add_shape(*renderer, shape);
    window_.window().AddRenderer(renderer);
    const std::vector<unsigned char> pixels = window_.draw();
    window_.window().RemoveRenderer(renderer);
    return average(pixels);
  }

 private:
  CameraFitter make_fitter() const {
    const double tangent = kFilledShare * std::tan(kViewAngle / 2 * std::numbers::pi / 180);
    return {view_, tangent * width_ / height_, tangent};
  }

  static void add_points(CameraFitter& fitter, const TriangleSoup& shape, const UnitFrame& frame) {
    for (const Triangle& triangle : shape.triangles) {
      for (const std::uint32_t vertex : triangle) fitter.add(frame.to_unit(shape.positions[vertex]));
    }
  }

  void add_shape(vtkRenderer& renderer, const TriangleSoup& shape) const {
    UnitFrame frame = common_frame_;
    FittedCamera camera = common_camera_;
    if (!options_.common_camera) {
      frame = UnitFrame::of(bounds(shape));
      CameraFitter fitter = make_fitter();
      add_points(fitter, shape, frame);
      camera = fitter.fit();
    }
    const DisplayMesh mesh = make_display_mesh(shape, frame, options_.crease_angle, options_.wireframe);
    const vtkNew<vtkPoints> points = make_points(mesh);
    renderer.AddActor(make_surface(mesh, points));
    if (options_.wireframe) renderer.AddActor(make_edges(mesh, points, edge_opacity(mesh, camera, height_)));
    aim(*renderer.GetActiveCamera(), camera, view_);
  }

  std::vector<unsigned char> average(const std::vector<unsigned char>& pixels) const {
    constexpr unsigned kSamples = kSupersampling * kSupersampling;
    const auto width = static_cast<std::size_t>(width_);
    const auto height = static_cast<std::size_t>(height_);
    std::vector<unsigned char> averaged(3 * width * height);
    for (std::size_t y = 0; y < height; ++y) {
      for (std::size_t i = 0; i < 3 * width; ++i) {
        unsigned sum = kSamples / 2;
        for (std::size_t sample = 0; sample < kSamples; ++sample) {
          const std::size_t row = kSupersampling * y + sample / kSupersampling;
          const std::size_t column = kSupersampling * (i / 3) + sample % kSupersampling;
          sum += pixels[3 * (row * kSupersampling * width + column) + i % 3];
        }
        averaged[3 * width * y + i] = static_cast<unsigned char>(sum / kSamples);
      }
    }
    return averaged;
  }

  const RenderOptions& options_;
  ViewFrame view_;
  int width_, height_;
  OffscreenWindow window_;
  UnitFrame common_frame_;
  FittedCamera common_camera_;
};

/// Puts panels, captions and separators together.
class Canvas {
 public:
  Canvas(const RenderOptions& options, const PanelGrid& grid)
      : panel_width_(options.panel_width), panel_height_(options.panel_height), grid_(grid) {
    image_.width = grid.columns * panel_width_;
    image_.height = grid.rows * panel_height_;
    image_.rgb.assign(3 * static_cast<std::size_t>(image_.width) * static_cast<std::size_t>(image_.height), 255);
  }

  /// `pixels` as PanelPainter gives them, `height` rows; goes to the top of the panel.
  void place_scene(int panel, const std::vector<unsigned char>& pixels, int height) {
    const std::ptrdiff_t row_size = 3 * static_cast<std::ptrdiff_t>(panel_width_);
    for (int y = 0; y < height; ++y) {
      std::copy_n(pixels.begin() + (height - 1 - y) * row_size, row_size, pixel(left(panel), top(panel) + y));
    }
  }

  /// Centres text in the band below the scene.
  void place_caption(int panel, const CaptionBand& band) {
    const TextMask& text = band.masks[static_cast<std::size_t>(panel)];
    const int x0 = left(panel) + (panel_width_ - text.width) / 2;
    const int y0 = top(panel) + panel_height_ - band.height + band.padding;
    for (int y = 0; y < text.height; ++y) {
      for (int x = 0; x < text.width; ++x) {
        const int ink =
            text.ink[static_cast<std::size_t>(y) * static_cast<std::size_t>(text.width) + static_cast<std::size_t>(x)];
        std::fill_n(pixel(x0 + x, y0 + y), 3, static_cast<unsigned char>(255 - ink * (255 - kInk) / 255));
      }
    }
  }

  RenderedImage finish() {
    const int thickness = std::max(1, static_cast<int>(std::min(panel_width_, panel_height_) * kSeparatorShare));
    for (int column = 1; column < grid_.columns; ++column) {
      draw_separator(column * panel_width_ - thickness / 2, 0, thickness, image_.height);
    }
    for (int row = 1; row < grid_.rows; ++row) {
      draw_separator(0, row * panel_height_ - thickness / 2, image_.width, thickness);
    }
    return std::move(image_);
  }

 private:
  int left(int panel) const { return panel % grid_.columns * panel_width_; }
  int top(int panel) const { return panel / grid_.columns * panel_height_; }
  std::vector<unsigned char>::iterator pixel(int x, int y) {
    return image_.rgb.begin() + 3 * (static_cast<std::ptrdiff_t>(y) * image_.width + x);
  }
  void draw_separator(int x, int y, int width, int height) {
    for (int row = 0; row < height; ++row) std::fill_n(pixel(x, y + row), 3 * width, kSeparator);
  }

  int panel_width_, panel_height_;
  PanelGrid grid_;
  RenderedImage image_;
};

std::string encode_png(const RenderedImage& image) {
  const vtkNew<vtkImageData> data;
  data->SetDimensions(image.width, image.height, 1);
  data->AllocateScalars(VTK_UNSIGNED_CHAR, 3);
  const std::ptrdiff_t row_size = 3 * static_cast<std::ptrdiff_t>(image.width);
  for (int y = 0; y < image.height; ++y) {  // VTK counts rows from the bottom
    std::copy_n(image.rgb.begin() + (image.height - 1 - y) * row_size, row_size,
                static_cast<unsigned char*>(data->GetScalarPointer(0, y, 0)));
  }
  const vtkNew<vtkPNGWriter> writer;
  writer->WriteToMemoryOn();
  writer->SetInputData(data);
  writer->Write();
  vtkUnsignedCharArray* bytes = writer->GetResult();
  if (bytes == nullptr) throw ResourceError("cannot render: the picture could not be encoded as PNG");
  return {bytes->Begin(), bytes->End()};
}

}  // namespace

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

RenderedImage render_image(const std::vector<RenderItem>& items, const RenderOptions& options) {
  check_render_arguments(items, options);
  const std::scoped_lock lock(render_mutex());
  std::vector<std::string> captions;
  for (const RenderItem& item : items) captions.push_back(item.caption);
  const CaptionBand band = set_captions(captions, options.panel_width, options.panel_height);
  const int scene_height = options.panel_height - band.height;

  Canvas canvas(options, PanelGrid::of(items.size(), options.columns));
  PanelPainter painter(items, options, options.panel_width, scene_height);
  for (int panel = 0; panel < static_cast<int>(items.size()); ++panel) {
    canvas.place_scene(panel, painter.paint(items[static_cast<std::size_t>(panel)].shape), scene_height);
    canvas.place_caption(panel, band);
  }
  return canvas.finish();
}

void render_meshes(const std::vector<RenderItem>& items, const RenderOptions& options,
                   const std::filesystem::path& png) {
  write_file_atomically(png, encode_png(render_image(items, options)));
}

}  // namespace voxcarve
