#include "experiments/render/canvas.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace voxcarve {

namespace {

constexpr unsigned char kSeparator = 208;
constexpr double kSeparatorShare = 1.0 / 400;  ///< of the panel's shorter side
constexpr unsigned char kInk = 24;

}  // namespace

Canvas::Canvas(const RenderOptions& options, const PanelGrid& grid)
    : panel_width_(options.panel_width), panel_height_(options.panel_height), grid_(grid) {
  image_.width = grid.columns * panel_width_;
  image_.height = grid.rows * panel_height_;
  image_.rgb.assign(3 * static_cast<std::size_t>(image_.width) * static_cast<std::size_t>(image_.height), 255);
}

void Canvas::place_scene(int panel, const std::vector<unsigned char>& rgb) {
  const std::ptrdiff_t row_size = 3 * static_cast<std::ptrdiff_t>(panel_width_);
  const int height = static_cast<int>(static_cast<std::ptrdiff_t>(rgb.size()) / row_size);
  for (int y = 0; y < height; ++y)
    std::copy_n(rgb.begin() + y * row_size, row_size, pixel(left(panel), top(panel) + y));
}

void Canvas::place_caption(int panel, const CaptionBand& band) {
  if (band.masks.empty()) return;
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

RenderedImage Canvas::finish() {
  const int thickness = std::max(1, static_cast<int>(std::min(panel_width_, panel_height_) * kSeparatorShare));
  for (int column = 1; column < grid_.columns; ++column) {
    draw_separator(column * panel_width_ - thickness / 2, 0, thickness, image_.height);
  }
  for (int row = 1; row < grid_.rows; ++row) {
    draw_separator(0, row * panel_height_ - thickness / 2, image_.width, thickness);
  }
  return std::move(image_);
}

std::vector<unsigned char>::iterator Canvas::pixel(int x, int y) {
  return image_.rgb.begin() + 3 * (static_cast<std::ptrdiff_t>(y) * image_.width + x);
}

void Canvas::draw_separator(int x, int y, int width, int height) {
  for (int row = 0; row < height; ++row) std::fill_n(pixel(x, y + row), 3 * width, kSeparator);
}

}  // namespace voxcarve
