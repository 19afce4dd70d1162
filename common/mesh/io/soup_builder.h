// Collects what a mesh file holds and makes a soup of it.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/mesh/triangle_soup.h"

namespace voxcarve::mesh_io {

/// A colour of channels in [0, 1] or [0, 255], whatever the file says, kept within what any file can mean.
inline Color make_color(double red, double green, double blue) {
  return Point(red, green, blue).cwiseMax(0.0).cwiseMin(255.0).cast<float>();
}

/// Vertices and polygons in the order of a file. Faces may refer to vertices that come later, so indices are checked,
/// and polygons triangulated, at the end; `place` is the line or the byte that a face stands at, for messages.
class SoupBuilder {
 public:
  /// Set when a channel that colours do not keep, such as alpha, shows that they lie in [0, 255].
  bool vertex_colors_are_bytes = false;
  bool face_colors_are_bytes = false;

  /// `place_unit` is "line" or "byte"; `base` is the number that the file gives its first vertex.
  SoupBuilder(std::string_view name, std::string_view place_unit, std::int64_t base)
      : name_(name), place_unit_(place_unit), base_(base) {}

  /// A vertex; without a colour where it has none.
  void add_vertex(const Point& position, const std::optional<Color>& color = std::nullopt);

  /// A corner of the face that `end_face` ends; `vertex` counts from 0. Throws InputError when that is negative.
  void add_corner(std::int64_t vertex, std::size_t place) {
    if (vertex < 0 || vertex > kLargestVertex) refuse_vertex(vertex, place);
    if (vertex > largest_) {
      largest_ = vertex;
      largest_place_ = place;
    }
    corners_.push_back(static_cast<std::uint32_t>(vertex));
  }
  /// Ends a face; one of fewer than three corners is dropped.
  void end_face(std::size_t place, const std::optional<Color>& color = std::nullopt);

  std::size_t vertex_count() const { return positions_.size(); }
  /// Makes room; the caller knows that the file is large enough for them.
  void reserve_vertices(std::size_t count) { positions_.reserve(count); }

  /// The soup; the builder is then used up. Throws InputError for indices out of range and for a mesh without
  /// triangles.
  TriangleSoup finish();

  [[noreturn]] void fail(std::size_t place, std::string_view message) const;

 private:
  struct Face {
    std::size_t end;  // of its corners
    std::size_t place;
  };
  static constexpr std::int64_t kLargestVertex = std::numeric_limits<std::uint32_t>::max();
  [[noreturn]] void refuse_vertex(std::int64_t vertex, std::size_t place) const;
  void triangulate(TriangleSoup& soup) const;

  std::string name_;
  std::string place_unit_;
  std::int64_t base_;
  std::vector<Point> positions_;
  std::vector<Color> vertex_colors_;  // none, or at most one a position
  std::vector<std::uint32_t> corners_;
  std::vector<Face> faces_;
  std::vector<Color> face_colors_;  // none, or at most one a face
  std::int64_t largest_ = -1;
  std::size_t largest_place_ = 0;
};

}  // namespace voxcarve::mesh_io
