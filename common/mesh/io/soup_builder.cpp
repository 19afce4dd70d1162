#include "common/mesh/io/soup_builder.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <utility>

#include "common/mesh/io/polygon.h"
#include "common/run/errors.h"

namespace voxcarve::mesh_io {

namespace {

const Color kNone = Color::Constant(-1.0F);  // until the range of the others is known

/// Brings colours into [0, 1]. Those of a file in which one channel exceeds 1 are meant in [0, 255].
void normalize(std::vector<Color>& colors, bool are_bytes) {
  const auto exceeds_unit = [](const Color& color) { return (color.array() > 1).any(); };
  const float scale = are_bytes || std::ranges::any_of(colors, exceeds_unit) ? 255.0F : 1.0F;
  for (Color& color : colors) {
    const Color normal = (color / scale).cwiseMax(0.0F).cwiseMin(1.0F);
    color = color == kNone ? Color(Color::Constant(0.5F)) : normal;
  }
}

}  // namespace

void SoupBuilder::add_vertex(const Point& position, const std::optional<Color>& color) {
  positions_.push_back(position);
  if (!color) return;
  vertex_colors_.resize(positions_.size() - 1, kNone);
  vertex_colors_.push_back(*color);
}

void SoupBuilder::end_face(std::size_t place, const std::optional<Color>& color) {
  const std::size_t begin = faces_.empty() ? 0 : faces_.back().end;
  if (corners_.size() - begin < 3) {
    corners_.resize(begin);
    return;
  }
  if (color) {
    face_colors_.resize(faces_.size(), kNone);
    face_colors_.push_back(*color);
  }
  faces_.push_back({corners_.size(), place});
}

void SoupBuilder::fail(std::size_t place, std::string_view message) const {
  throw InputError(name_, fmt::format("{} {}", place_unit_, place), message);
}

void SoupBuilder::refuse_vertex(std::int64_t vertex, std::size_t place) const {
  if (positions_.empty()) fail(place, fmt::format("a face refers to vertex {}", vertex + base_));
  const auto count = static_cast<std::int64_t>(positions_.size());
  fail(place, fmt::format("a face refers to vertex {}, outside {} to {}", vertex + base_, base_, count - 1 + base_));
}

void SoupBuilder::triangulate(TriangleSoup& soup) const {
  soup.triangles.reserve(corners_.size() - 2 * faces_.size());
  std::size_t begin = 0;
  for (std::size_t face = 0; face < faces_.size(); ++face) {
    const std::span<const std::uint32_t> corners(corners_.data() + begin, faces_[face].end - begin);
    begin = faces_[face].end;
    if (!triangulate_polygon(soup.positions, corners, soup.triangles)) {
      fail(faces_[face].place, fmt::format("a non-convex face of {} corners; at most {} are supported", corners.size(),
                                           kMaxNonConvexCorners));
    }
    if (!face_colors_.empty()) soup.triangle_colors.resize(soup.triangles.size(), face_colors_[face]);
  }
}

TriangleSoup SoupBuilder::finish() {
  if (faces_.empty()) throw InputError(name_ + ": the mesh has no triangle");
  if (largest_ >= static_cast<std::int64_t>(positions_.size())) refuse_vertex(largest_, largest_place_);
  if (!vertex_colors_.empty()) vertex_colors_.resize(positions_.size(), kNone);
  if (!face_colors_.empty()) face_colors_.resize(faces_.size(), kNone);
  normalize(face_colors_, face_colors_are_bytes);
  normalize(vertex_colors_, vertex_colors_are_bytes);
  TriangleSoup soup;
  soup.positions = std::move(positions_);
  soup.vertex_colors = std::move(vertex_colors_);
  triangulate(soup);
  return soup;
}

}  // namespace voxcarve::mesh_io
