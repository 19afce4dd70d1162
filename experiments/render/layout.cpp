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
constexpr std::int64_t kMaxVoxelsAside = 65536;              ///< ray positions are 32 bits with 15 after the point
constexpr std::size_t kMaxTriangles = std::size_t{1} << 29;  ///< three corners each, numbered in 32 bits with a sign

void check_range(const char* name, double value, double least, double greatest) {
  if (value >= least && value <= greatest) return;
  throw ParameterError("picture: " + std::string(name) + " is " + format_real(value) + ", must be from " +
                       format_real(least) + " to " + format_real(greatest));
}

void check_options(const RenderOptions& options) {
  check_range("columns", options.columns, 0, std::numeric_limits<int>::max());
  check_range("crease_angle", options.crease_angle, 0, 180);
  check_range("azimuth", options.azimuth, -360, 360);
  check_range("elevation", options.elevation, -90, 90);
  check_range("view_angle", options.view_angle, 1, 120);
  check_range("magnification", options.magnification, 1, kMaxMagnification);
  const int smallest_panel = kMinPanelSize * options.magnification;
  check_range("panel_width", options.panel_width, smallest_panel, kMaxPanelSize);
  check_range("panel_height", options.panel_height, smallest_panel, kMaxPanelSize);
  if (options.up_axis != "y" && options.up_axis != "z") {
    throw ParameterError("picture: up_axis is '" + options.up_axis + "', must be y or z");
  }
}

void check_content(const TriangleSoup& soup, const std::string& name) {
  if (soup.empty()) return;
  validate(soup, name);
  if (soup.triangles.size() > kMaxTriangles) {
    throw ResourceError(name + " has more than " + std::to_string(kMaxTriangles) + " triangles; reduce it first");
  }
}

template <class T>
void check_grid(const Grid<T>& grid, const std::string& name) {
  const Index3& dims = grid.frame.dims;
  if (grid.values.empty() || (dims.array() < 1).any()) throw InputError(name + " has no voxel");
  if ((dims.array() > kMaxVoxelsAside).any()) {
    throw ResourceError(name + " has more than " + std::to_string(kMaxVoxelsAside) + " voxels a side");
  }
  if (static_cast<std::int64_t>(grid.values.size()) != dims.prod())
    throw InputError(name + ": its values do not fill its grid");
}

void check_content(const BinaryVolume& volume, const std::string& name) {
  check_grid(volume, name);
}

void check_content(const ScalarVolume& volume, const std::string& name) {
  check_grid(volume.grid, name);
  if (!std::isfinite(volume.iso_value) ||
      !std::ranges::all_of(volume.grid.values, [](float value) { return std::isfinite(value); })) {
    throw InputError(name + " holds a value that is not finite");
  }
}

void check_content(const LayeredSurface& layered, const std::string& name) {
  for (const LayeredSurface::Layer& layer : layered.layers) {
    if (!(layer.opacity >= 0 && layer.opacity <= 1))
      throw InputError(name + " has a layer of opacity " + format_real(layer.opacity) + ", must be from 0 to 1");
    check_content(layer.surface, name);
  }
}

void check_content(const SlicePicture& slice, const std::string& name) {
  if (slice.width < 1 || slice.height < 1) throw InputError(name + " has no voxel");
  const auto voxels = static_cast<std::size_t>(slice.width * slice.height);
  if (slice.colors.size() != voxels || (!slice.above_iso.empty() && slice.above_iso.size() != voxels))
    throw InputError(name + ": its colours do not fill its slice");
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
    const std::string name = "shape " + std::to_string(i + 1) + " of the picture";
    std::visit([&name](const auto& content) { check_content(content, name); }, items[i].content);
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
