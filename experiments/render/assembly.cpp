#include "experiments/render/assembly.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "common/run/errors.h"
#include "experiments/render/view.h"

namespace voxcarve {

namespace {

std::array<Point, 8> corners_of(const Box& box) {
  std::array<Point, 8> corners;
  for (std::size_t i = 0; i < 8; ++i) {
    for (int axis = 0; axis < 3; ++axis)
      corners[i][axis] = ((i >> static_cast<std::size_t>(axis)) & 1U) != 0 ? box.upper[axis] : box.lower[axis];
  }
  return corners;
}

/// Extent of a box along a direction.
double extent_along(const Point& direction, const Box& box) {
  return direction.cwiseAbs().dot(box.extent());
}

/// Bytes that drawing takes for each triangle: the soup, its welded copy, the corner tables and the display mesh.
constexpr std::uint64_t kDrawingBytesATriangle = 400;

}  // namespace

Assembly plan_assembly(const std::vector<AssemblyLevel>& levels, const AssemblyOptions& options,
                       const RenderOptions& render, SceneSize scene) {
  std::vector<std::size_t> drawable;
  Box box;
  for (std::size_t level = 0; level < levels.size(); ++level) {
    if (levels[level].surface.empty()) continue;
    drawable.push_back(level);
    box.extend(bounds(levels[level].surface));
  }
  if (drawable.empty()) throw ParameterError("an assembly needs a level with triangles");

  const ViewFrame direction = view_direction(render);
  const Point right = direction.right;
  const Point away = -ViewFrame::from_angles(render.azimuth, 0, render.up_axis).back;
  const double width = extent_along(right, box);
  const double length = extent_along(away, box);
  const double gap = options.gap * std::max(width, length);
  Assembly assembly;
  for (int row = 0; row < options.rows; ++row) {
    for (int column = 0; column < options.columns; ++column) {
      AssemblyInstance instance;
      instance.column = column;
      instance.row = row;
      instance.offset = (width + gap) * column * right + (length + gap) * row * away;
      for (const Point& corner : corners_of(box)) assembly.framed.push_back(corner + instance.offset);
      assembly.instances.push_back(instance);
    }
  }
  const View view = fit_view(render, scene.width, scene.height, [&](const auto& visit) {
    for (const Point& point : assembly.framed) visit(point);
  });
  const auto triangles = [&](std::size_t level) { return std::ssize(levels[level].surface.triangles); };
  for (std::size_t i = 0; i < assembly.instances.size(); ++i) {
    AssemblyInstance& instance = assembly.instances[i];
    instance.depth = std::numeric_limits<double>::infinity();
    for (std::size_t corner = 8 * i; corner < 8 * i + 8; ++corner)
      instance.depth = std::min(instance.depth, view.depth(assembly.framed[corner], direction));
    const auto detail_pixels = [&](std::size_t level) {
      return levels[level].detail / instance.depth * pixels_at_own_length(render, scene.height);
    };
    std::size_t chosen = drawable.back();
    for (const std::size_t level : drawable) {
      if (detail_pixels(level) > options.pixels) continue;
      chosen = level;
      break;
    }
    instance.level = static_cast<std::int64_t>(chosen);
    instance.detail_pixels = detail_pixels(chosen);
    assembly.triangles += triangles(chosen);
    assembly.finest_triangles += triangles(drawable.back());
  }
  return assembly;
}

TriangleSoup assembly_surface(const std::vector<AssemblyLevel>& levels, const Assembly& assembly, RunContext& context) {
  std::uint64_t held = 0;
  for (const AssemblyLevel& level : levels) {
    held += level.surface.positions.size() * sizeof(Point) + level.surface.triangles.size() * sizeof(Triangle);
  }
  context.require_memory(held + kDrawingBytesATriangle * static_cast<std::uint64_t>(assembly.triangles),
                         "drawing the assembly");
  TriangleSoup surface;
  for (const AssemblyInstance& instance : assembly.instances) {
    context.check_cancelled();
    TriangleSoup moved = levels[static_cast<std::size_t>(instance.level)].surface;
    for (Point& position : moved.positions) position += instance.offset;
    append(surface, moved);
  }
  return surface;
}

}  // namespace voxcarve
