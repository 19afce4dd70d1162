#include "common/mesh/triangle_soup.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cmath>
#include <string>
#include <unordered_map>

#include "common/run/errors.h"

namespace voxcarve {

namespace {

constexpr std::uint32_t kUnset = std::numeric_limits<std::uint32_t>::max();
const Color kMidGrey = Color::Constant(0.5F);

struct PositionHash {
  std::size_t operator()(const Point& p) const {
    std::uint64_t hash = 0x9e3779b97f4a7c15ULL;
    for (int axis = 0; axis < 3; ++axis) {
      hash ^= std::bit_cast<std::uint64_t>(p[axis] + 0.0);  // + 0.0 turns -0 into 0
      hash *= 0xff51afd7ed558ccdULL;
      hash ^= hash >> 32;
    }
    return static_cast<std::size_t>(hash);
  }
};

}  // namespace

Box bounds(const TriangleSoup& soup) {
  Box box;
  for (const Triangle& triangle : soup.triangles) {
    for (const std::uint32_t vertex : triangle) box.extend(soup.positions[vertex]);
  }
  return box;
}

Point area_vector(const TriangleSoup& soup, const Triangle& t) {
  const Point& a = soup.positions[t[0]];
  return (soup.positions[t[1]] - a).cross(soup.positions[t[2]] - a);
}

double surface_area(const TriangleSoup& soup) {
  double twice_area = 0;
  for (const Triangle& triangle : soup.triangles) twice_area += area_vector(soup, triangle).norm();
  return twice_area / 2;
}

double signed_volume(const TriangleSoup& soup) {
  const Point center = bounds(soup).center();
  double six_volumes = 0;
  for (const Triangle& t : soup.triangles) {
    const Point a = soup.positions[t[0]] - center;
    const Point b = soup.positions[t[1]] - center;
    const Point c = soup.positions[t[2]] - center;
    six_volumes += a.dot(b.cross(c));
  }
  return six_volumes / 6;
}

bool is_degenerate(const TriangleSoup& soup, const Triangle& t) {
  return t[0] == t[1] || t[1] == t[2] || t[0] == t[2] || area_vector(soup, t).isZero(0);
}

TriangleSoup merge_equal_positions(const TriangleSoup& soup) {
  TriangleSoup merged;
  merged.triangle_colors = soup.triangle_colors;
  merged.triangles.reserve(soup.triangles.size());
  std::unordered_map<Point, std::uint32_t, PositionHash> index_of;
  index_of.reserve(soup.positions.size());
  for (const Triangle& triangle : soup.triangles) {
    Triangle renamed{};
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const Point& position = soup.positions[triangle[corner]];
      const auto [entry, added] = index_of.try_emplace(position, static_cast<std::uint32_t>(merged.positions.size()));
      if (added) {
        merged.positions.push_back(position);
        if (!soup.vertex_colors.empty()) merged.vertex_colors.push_back(soup.vertex_colors[triangle[corner]]);
      }
      renamed[corner] = entry->second;
    }
    merged.triangles.push_back(renamed);
  }
  return merged;
}

void remove_unused_vertices(TriangleSoup& soup) {
  std::vector<std::uint32_t> renamed(soup.positions.size(), kUnset);
  for (const Triangle& triangle : soup.triangles) {
    for (const std::uint32_t vertex : triangle) renamed[vertex] = 0;
  }
  std::uint32_t kept = 0;
  for (std::size_t vertex = 0; vertex < renamed.size(); ++vertex) {
    if (renamed[vertex] == kUnset) continue;
    soup.positions[kept] = soup.positions[vertex];
    if (!soup.vertex_colors.empty()) soup.vertex_colors[kept] = soup.vertex_colors[vertex];
    renamed[vertex] = kept++;
  }
  soup.positions.resize(kept);
  if (!soup.vertex_colors.empty()) soup.vertex_colors.resize(kept);
  for (Triangle& triangle : soup.triangles) {
    for (std::uint32_t& vertex : triangle) vertex = renamed[vertex];
  }
}

namespace {

void append_colors(std::vector<Color>& colors, std::size_t old_size, const std::vector<Color>& other,
                   std::size_t other_size) {
  if (colors.empty() && other.empty()) return;
  colors.resize(old_size, kMidGrey);
  colors.insert(colors.end(), other.begin(), other.end());
  colors.resize(old_size + other_size, kMidGrey);
}

}  // namespace

void append(TriangleSoup& soup, const TriangleSoup& other) {
  append_colors(soup.vertex_colors, soup.positions.size(), other.vertex_colors, other.positions.size());
  append_colors(soup.triangle_colors, soup.triangles.size(), other.triangle_colors, other.triangles.size());
  const auto offset = static_cast<std::uint32_t>(soup.positions.size());
  soup.positions.insert(soup.positions.end(), other.positions.begin(), other.positions.end());
  soup.triangles.reserve(soup.triangles.size() + other.triangles.size());
  for (const Triangle& t : other.triangles) soup.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
}

void validate(const TriangleSoup& soup, std::string_view name) {
  const std::string owner(name);
  if (soup.triangles.empty()) throw InputError(owner + " has no triangle");
  if (!soup.vertex_colors.empty() && soup.vertex_colors.size() != soup.positions.size()) {
    throw InputError(owner + " has " + std::to_string(soup.vertex_colors.size()) + " vertex colours for " +
                     std::to_string(soup.positions.size()) + " vertices");
  }
  if (!soup.triangle_colors.empty() && soup.triangle_colors.size() != soup.triangles.size()) {
    throw InputError(owner + " has " + std::to_string(soup.triangle_colors.size()) + " triangle colours for " +
                     std::to_string(soup.triangles.size()) + " triangles");
  }
  for (std::size_t vertex = 0; vertex < soup.positions.size(); ++vertex) {
    if (!soup.positions[vertex].allFinite()) {
      throw InputError(owner + ": vertex " + std::to_string(vertex) + " has a coordinate that is not finite");
    }
  }
  for (std::size_t index = 0; index < soup.triangles.size(); ++index) {
    for (const std::uint32_t vertex : soup.triangles[index]) {
      if (vertex >= soup.positions.size()) {
        throw InputError(owner + ": triangle " + std::to_string(index) + " refers to vertex " + std::to_string(vertex) +
                         " of " + std::to_string(soup.positions.size()));
      }
    }
  }
}

}  // namespace voxcarve
