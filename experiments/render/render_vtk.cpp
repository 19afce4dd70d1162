// The scene of a panel, drawn with VTK.
#include <vtkCallbackCommand.h>
#include <vtkCamera.h>
#include <vtkLight.h>
#include <vtkNew.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkVolume.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <mutex>
#include <optional>

#include "common/run/errors.h"
#include "experiments/render/camera.h"
#include "experiments/render/display_mesh.h"
#include "experiments/render/layered_mesh.h"
#include "experiments/render/mesh_actor.h"
#include "experiments/render/offscreen_window.h"
#include "experiments/render/scene_painter.h"
#include "experiments/render/view.h"
#include "experiments/render/volume_actor.h"

namespace voxcarve {

namespace {

constexpr int kSupersampling = 2;  ///< drawn at so many times the size, then averaged

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
void aim(vtkCamera& camera, const FittedCamera& fitted, const ViewFrame& view, double view_angle, double aspect) {
  const Eigen::Vector3d focus = fitted.position - view.back;
  camera.SetPosition(fitted.position.data());
  camera.SetFocalPoint(focus.data());
  camera.SetViewUp(view.up.data());
  camera.SetViewAngle(view_angle);
  camera.UseExplicitAspectRatioOn();
  camera.SetExplicitAspectRatio(aspect);
  camera.SetClippingRange(0.99 * fitted.nearest, 1.01 * fitted.farthest);
}

/// Fainter lines where they lie dense, so that the shading stays visible: in proportion to the mean length of an edge
/// in pixels, up to 12 pixels or so.
double edge_opacity(const DisplayMesh& mesh, const FittedCamera& camera, double pixels_at_own_length) {
  double length = 0;
  for (const auto& [a, b] : mesh.edges) length += static_cast<double>((mesh.positions[a] - mesh.positions[b]).norm());
  const double pixels_per_unit = 2 * pixels_at_own_length / (camera.nearest + camera.farthest);
  const double pixels = pixels_per_unit * length / static_cast<double>(std::max<std::size_t>(1, mesh.edges.size()));
  return std::clamp(pixels / 12, 0.12, 0.85);
}

template <class Visit>
void for_each_corner(const TriangleSoup& soup, const Visit& visit) {
  for (const Triangle& triangle : soup.triangles) {
    for (const std::uint32_t vertex : triangle) visit(soup.positions[vertex]);
  }
}

/// Calls visit(point) with points whose convex hull holds what will be drawn.
template <class Visit>
void for_each_point(const RenderContent& content, const Visit& visit) {
  if (const auto* soup = std::get_if<TriangleSoup>(&content)) {
    for_each_corner(*soup, visit);
  } else if (const auto* binary = std::get_if<BinaryVolume>(&content)) {
    for (const Point& point : interior_hull(*binary)) visit(point);
  } else if (const auto* scalar = std::get_if<ScalarVolume>(&content)) {
    for (const Point& point : interior_hull(*scalar)) visit(point);
  } else if (const auto* layered = std::get_if<LayeredSurface>(&content)) {
    for (const LayeredSurface::Layer& layer : layered->layers) for_each_corner(layer.surface, visit);
  }
}

}  // namespace

class ScenePainter::Impl {
 public:
  Impl(const std::vector<RenderItem>& items, const RenderOptions& options, int width, int height)
      : options_(options),
        samples_(options.aliased ? 1 : kSupersampling),
        width_(width),
        height_(height),
        window_(samples_ * width, samples_ * height) {
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
    } else if (const auto* layered = std::get_if<LayeredSurface>(&content)) {
      const LayeredMesh mesh = make_layered_mesh(*layered, view, options_.crease_angle);
      if (!mesh.opaque.triangles.empty()) add_surface(*renderer, mesh.opaque);
      if (!mesh.translucent.triangles.empty()) add_translucent(*renderer, mesh.translucent, mesh.opacities);
    } else if (const auto* binary = std::get_if<BinaryVolume>(&content)) {
      volume = make_display_volume(*binary, view.frame);
    } else if (const auto* scalar = std::get_if<ScalarVolume>(&content)) {
      volume = make_display_volume(*scalar, view.frame);
    }
    if (!volume.samples.empty()) add_volume(*renderer, volume);
    aim(*renderer->GetActiveCamera(), view.camera, view_direction(options_), options_.view_angle,
        static_cast<double>(width_) / height_);
    window_.window().AddRenderer(renderer);
    const std::vector<unsigned char> pixels = window_.draw();
    window_.window().RemoveRenderer(renderer);
    if (options_.cancellation.stop_requested()) throw Cancelled();
    return average(pixels);
  }

 private:
  View view_of(const std::vector<const RenderContent*>& contents) const {
    return fit_view(options_, width_, height_, [&](const auto& visit) {
      for (const Point& point : options_.framed) visit(point);
      if (!options_.framed.empty()) return;
      for (const RenderContent* content : contents) for_each_point(*content, visit);
    });
  }

  void add_mesh(vtkRenderer& renderer, const TriangleSoup& soup, const View& view) const {
    const DisplayMesh mesh = make_display_mesh(soup, view.frame, options_.crease_angle, options_.wireframe);
    add_surface(renderer, mesh);
    if (!options_.wireframe) return;
    const double opacity = edge_opacity(mesh, view.camera, pixels_at_own_length(options_, height_));
    add_edges(renderer, mesh, opacity, static_cast<float>(samples_));
  }

  std::vector<unsigned char> average(const std::vector<unsigned char>& pixels) const {
    const auto side = static_cast<std::size_t>(samples_);
    const auto count = static_cast<unsigned>(samples_ * samples_);
    const auto width = static_cast<std::size_t>(width_);
    const auto height = static_cast<std::size_t>(height_);
    std::vector<unsigned char> averaged(3 * width * height);
    for (std::size_t y = 0; y < height; ++y) {  // from the bottom, as OpenGL counts
      for (std::size_t i = 0; i < 3 * width; ++i) {
        unsigned sum = count / 2;
        for (std::size_t sample = 0; sample < side * side; ++sample) {
          const std::size_t row = side * y + sample / side;
          const std::size_t column = side * (i / 3) + sample % side;
          sum += pixels[3 * (row * side * width + column) + i % 3];
        }
        averaged[3 * width * (height - 1 - y) + i] = static_cast<unsigned char>(sum / count);
      }
    }
    return averaged;
  }

  const RenderOptions& options_;
  int samples_;  ///< a side of a pixel
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
