// Small shapes and panels, and what is measured in a rendered image, for the tests of rendering.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <limits>

#include "experiments/render/render.h"
#include "tests/unit/metric_shapes.h"

namespace voxcarve::test {

/// The cube [-1, 1]^3, outward.
inline TriangleSoup cube() {
  return make_box(Point::Constant(-1), Point::Constant(1));
}

inline TriangleSoup moved(TriangleSoup soup, double scale, const Point& offset) {
  for (Point& position : soup.positions) position = scale * position + offset;
  return soup;
}

inline RenderOptions small_panels() {
  RenderOptions options;
  options.panel_width = 200;
  options.panel_height = 160;
  return options;
}

inline RenderOptions front_view() {
  RenderOptions options = small_panels();
  options.azimuth = options.elevation = 0;
  return options;
}

struct Pixel {
  int red, green, blue;
  bool white() const { return red == 255 && green == 255 && blue == 255; }
  bool grey() const { return red == green && green == blue; }
};

inline Pixel pixel(const RenderedImage& image, int x, int y) {
  const auto at =
      3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(x));
  return {image.rgb[at], image.rgb[at + 1], image.rgb[at + 2]};
}

/// The pixels of [x_begin, x_end) that satisfy `wanted`: their number and their box, bounds included.
struct Extent {
  int count = 0;
  int left = std::numeric_limits<int>::max(), right = -1;
  int top = std::numeric_limits<int>::max(), bottom = -1;
};

template <typename Predicate>
Extent extent_of(const RenderedImage& image, int x_begin, int x_end, Predicate wanted) {
  Extent extent;
  for (int y = 0; y < image.height; ++y) {
    for (int x = x_begin; x < x_end; ++x) {
      if (!wanted(pixel(image, x, y))) continue;
      ++extent.count;
      extent.left = std::min(extent.left, x);
      extent.right = std::max(extent.right, x);
      extent.top = std::min(extent.top, y);
      extent.bottom = std::max(extent.bottom, y);
    }
  }
  return extent;
}

inline Extent drawn(const RenderedImage& image) {
  return extent_of(image, 0, image.width, [](const Pixel& p) { return !p.white(); });
}

}  // namespace voxcarve::test

/// Skips the test, visibly, where nothing can be rendered.
#define VOXCARVE_REQUIRE_RENDERING() \
  if (!voxcarve::rendering_available()) GTEST_SKIP() << "this build or this machine cannot render"
