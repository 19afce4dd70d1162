#include "experiments/render/layout.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

#include "common/run/errors.h"
#include "common/run/text.h"

namespace voxcarve {

namespace {

constexpr int kLongestSingleRow = 4;
constexpr std::size_t kMaxTriangles = std::size_t{1} << 29;  ///< three corners each, numbered in 32 bits with a sign

void check_range(const char* name, double value, double least, double greatest) {
  if (value >= least && value <= greatest) return;
  throw ParameterError("picture: " + std::string(name) + " is " + format_real(value) + ", must be from " +
                       format_real(least) + " to " + format_real(greatest));
}

void check_options(const RenderOptions& options) {
  check_range("panel_width", options.panel_width, kMinPanelSize, kMaxPanelSize);
  check_range("panel_height", options.panel_height, kMinPanelSize, kMaxPanelSize);
  check_range("columns", options.columns, 0, std::numeric_limits<int>::max());
  check_range("crease_angle", options.crease_angle, 0, 180);
  check_range("azimuth", options.azimuth, -360, 360);
  check_range("elevation", options.elevation, -90, 90);
  if (options.up_axis != "y" && options.up_axis != "z") {
    throw ParameterError("picture: up_axis is '" + options.up_axis + "', must be y or z");
  }
}

}  // namespace

void check_render_arguments(const std::vector<RenderItem>& items, const RenderOptions& options) {
  if (items.empty()) throw ParameterError("picture: there is nothing to render, give at least one shape");
  check_options(options);
  const PanelGrid grid = PanelGrid::of(items.size(), options.columns);
  const std::int64_t panels = static_cast<std::int64_t>(grid.columns) * grid.rows;
  const std::int64_t pixels = panels * options.panel_width * options.panel_height;
  if (pixels > kMaxPicturePixels) {
    throw ParameterError("picture: " + std::to_string(panels) + " panels of " + std::to_string(options.panel_width) +
                         " x " + std::to_string(options.panel_height) + " pixels are " + std::to_string(pixels) +
                         " pixels, more than " + std::to_string(kMaxPicturePixels) + "; use smaller panels");
  }
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (items[i].shape.empty()) continue;
    const std::string name = "shape " + std::to_string(i + 1) + " of the picture";
    validate(items[i].shape, name);
    if (items[i].shape.triangles.size() > kMaxTriangles) {
      throw ResourceError(name + " has more than " + std::to_string(kMaxTriangles) + " triangles; reduce it first");
    }
  }
}

PanelGrid PanelGrid::of(std::size_t items, int columns) {
  const int count = static_cast<int>(std::min<std::size_t>(items, std::numeric_limits<int>::max()));
  PanelGrid grid;
  if (columns > 0) {
    grid.columns = std::min(columns, count);
  } else if (count <= kLongestSingleRow) {
    grid.columns = count;
  } else {
    grid.columns = static_cast<int>(std::ceil(std::sqrt(count)));
  }
  grid.rows = (count - 1) / grid.columns + 1;
  return grid;
}

}  // namespace voxcarve
