// Panels are drawn one after the other and put together here; what draws them, and whether it can, is decided
// elsewhere.
#include "experiments/render/render.h"

#include <algorithm>
#include <cstddef>
#include <optional>

#include "common/run/atomic_file.h"
#include "common/run/errors.h"
#include "common/volume/io/png.h"
#include "experiments/render/canvas.h"
#include "experiments/render/captions.h"
#include "experiments/render/layout.h"
#include "experiments/render/scene_painter.h"

namespace voxcarve {

std::mutex& render_mutex() {
  static std::mutex mutex;
  return mutex;
}

namespace {

SceneSize scene_below(const RenderOptions& options, int caption_height) {
  return {options.panel_width / options.magnification, (options.panel_height - caption_height) / options.magnification};
}

/// Every pixel as a square of `factor` pixels a side, in the middle of `width` columns; the rest is white.
std::vector<unsigned char> enlarged(const std::vector<unsigned char>& rgb, SceneSize size, int factor, int width) {
  const int left = (width - factor * size.width) / 2;
  std::vector<unsigned char> large(
      3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(factor) * static_cast<std::size_t>(size.height),
      255);
  for (int y = 0; y < factor * size.height; ++y) {
    for (int x = 0; x < factor * size.width; ++x) {
      const auto from = rgb.begin() + 3 * (static_cast<std::ptrdiff_t>(y / factor) * size.width + x / factor);
      std::copy_n(from, 3, large.begin() + 3 * (static_cast<std::ptrdiff_t>(y) * width + left + x));
    }
  }
  return large;
}

}  // namespace

SceneSize scene_size(const std::vector<std::string>& captions, const RenderOptions& options) {
  const std::scoped_lock lock(render_mutex());
  return scene_below(options, set_captions(captions, options.panel_width, options.panel_height).height);
}

RenderedImage render_image(const std::vector<RenderItem>& items, const RenderOptions& options) {
  check_render_arguments(items, options);
  const std::scoped_lock lock(render_mutex());
  std::vector<std::string> captions;
  std::vector<const SlicePicture*> slices;
  for (const RenderItem& item : items) {
    captions.push_back(item.caption);
    if (const auto* slice = std::get_if<SlicePicture>(&item.content)) slices.push_back(slice);
  }
  // Slices need no painter of scenes, so they can be drawn where there is none.
  std::optional<ScenePainter> scenes;
  const CaptionBand band = set_captions(captions, options.panel_width, options.panel_height);
  const int scene_height = options.panel_height - band.height;
  const SceneSize size = scene_below(options, band.height);
  if (slices.size() < items.size()) scenes.emplace(items, options, size.width, size.height);
  const SlicePainter slice_painter(slices, options.common_camera, options.panel_width, scene_height);

  Canvas canvas(options, PanelGrid::of(items.size(), options.columns));
  for (int panel = 0; panel < static_cast<int>(items.size()); ++panel) {
    if (options.cancellation.stop_requested()) throw Cancelled();
    const RenderContent& content = items[static_cast<std::size_t>(panel)].content;
    const auto* slice = std::get_if<SlicePicture>(&content);
    if (slice != nullptr) {
      canvas.place_scene(panel, slice_painter.paint(*slice, options.cancellation));
    } else {
      canvas.place_scene(panel, enlarged(scenes->paint(content), size, options.magnification, options.panel_width));
    }
    canvas.place_caption(panel, band);
  }
  return canvas.finish();
}

void render_meshes(const std::vector<RenderItem>& items, const RenderOptions& options,
                   const std::filesystem::path& png) {
  const RenderedImage image = render_image(items, options);
  write_file_atomically(png, encode_png(image.width, image.height, 3, image.rgb));
}

}  // namespace voxcarve
