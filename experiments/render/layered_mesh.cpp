#include "experiments/render/layered_mesh.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

namespace voxcarve {

namespace {

void append(DisplayMesh& mesh, const DisplayMesh& other) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), other.positions.begin(), other.positions.end());
  mesh.normals.insert(mesh.normals.end(), other.normals.begin(), other.normals.end());
  mesh.colors.insert(mesh.colors.end(), other.colors.begin(), other.colors.end());
  mesh.two_sided.insert(mesh.two_sided.end(), other.two_sided.begin(), other.two_sided.end());
  for (const Triangle& triangle : other.triangles)
    mesh.triangles.push_back({first + triangle[0], first + triangle[1], first + triangle[2]});
}

/// Stable, so that equal distances keep the order of the layers.
void sort_far_to_near(DisplayMesh& mesh, const Eigen::Vector3d& camera) {
  std::vector<double> distances;
  distances.reserve(mesh.triangles.size());
  for (const Triangle& triangle : mesh.triangles) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const std::uint32_t vertex : triangle) sum += mesh.positions[vertex].cast<double>();
    distances.push_back((sum / 3 - camera).squaredNorm());
  }
  std::vector<std::size_t> order(mesh.triangles.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) { return distances[a] > distances[b]; });
  DisplayMesh sorted;
  for (const std::size_t triangle : order) {
    sorted.triangles.push_back(mesh.triangles[triangle]);
    sorted.two_sided.push_back(mesh.two_sided[triangle]);
  }
  mesh.triangles = std::move(sorted.triangles);
  mesh.two_sided = std::move(sorted.two_sided);
}

}  // namespace

LayeredMesh make_layered_mesh(const LayeredSurface& surface, const View& view, double crease_angle) {
  LayeredMesh result;
  for (const LayeredSurface::Layer& layer : surface.layers) {
    if (layer.surface.empty()) continue;
    const DisplayMesh mesh = make_display_mesh(layer.surface, view.frame, crease_angle, false);
    if (layer.opacity == 1) {
      append(result.opaque, mesh);
      continue;
    }
    append(result.translucent, mesh);
    result.opacities.resize(result.translucent.positions.size(),
                            static_cast<std::uint8_t>(std::lround(255 * layer.opacity)));
  }
  sort_far_to_near(result.translucent, view.camera.position);
  return result;
}

}  // namespace voxcarve
