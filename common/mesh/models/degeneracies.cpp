#include "common/mesh/models/degeneracies.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

namespace voxcarve {

namespace {

/// Splits a triangle at the middle of one of its sides; returns the middle's vertex.
std::uint32_t split_side(TriangleSoup& soup, std::size_t triangle, std::size_t corner) {
  const Triangle old = soup.triangles[triangle];
  const std::uint32_t a = old[corner];
  const std::uint32_t b = old[(corner + 1) % 3];
  const std::uint32_t c = old[(corner + 2) % 3];
  const auto middle = static_cast<std::uint32_t>(soup.positions.size());
  soup.positions.emplace_back(0.5 * (soup.positions[a] + soup.positions[b]));
  soup.triangles[triangle] = {a, middle, c};
  soup.triangles.push_back({middle, b, c});
  if (!soup.triangle_colors.empty()) soup.triangle_colors.push_back(Color(soup.triangle_colors[triangle]));
  return middle;
}

Eigen::Vector3i lattice_point(const Point& position) {
  return {static_cast<int>(std::lround(position.x())), static_cast<int>(std::lround(position.y())),
          static_cast<int>(std::lround(position.z()))};
}

}  // namespace

void add_t_joint(TriangleSoup& soup, std::size_t triangle, std::size_t corner) {
  split_side(soup, triangle, corner);
}

void add_zero_area_face(TriangleSoup& soup, std::size_t triangle, std::size_t corner) {
  const std::uint32_t a = soup.triangles[triangle][corner];
  const std::uint32_t b = soup.triangles[triangle][(corner + 1) % 3];
  const std::uint32_t middle = split_side(soup, triangle, corner);
  soup.triangles.push_back({a, b, middle});
  if (!soup.triangle_colors.empty()) soup.triangle_colors.push_back(Color(soup.triangle_colors[triangle]));
}

SquareIndex::SquareIndex(const TriangleSoup& soup, const Filter& filter) {
  for (std::size_t square = 0; 2 * square + 1 < soup.triangles.size(); ++square) {
    const Triangle& first = soup.triangles[2 * square];
    const Eigen::Vector3i a = lattice_point(soup.positions[first[0]]);
    const Eigen::Vector3i c = lattice_point(soup.positions[first[2]]);  // opposite: the two differ on u and v
    const int axis = a.x() == c.x() ? 0 : a.y() == c.y() ? 1 : 2;
    const int side = area_vector(soup, first)[axis] > 0 ? 1 : -1;
    const Eigen::Vector3i low = a.cwiseMin(c);
    places_.push_back({axis, side, low.x(), low.y(), low.z()});
    if (!filter || filter(low, axis, side)) square_at_.emplace(places_.back(), square);
  }
}

std::vector<SurfacePatch> SquareIndex::choose_patches(std::size_t count, int width, int height) const {
  std::vector<SurfacePatch> patches;
  const std::size_t squares = places_.size();
  std::set<std::size_t> taken;   // squares of patches
  std::set<std::size_t> fringe;  // the squares around them
  // Steps of the golden section visit every square once and land far from the last ones.
  auto step = static_cast<std::size_t>(std::lround(0.618034 * static_cast<double>(squares)));
  while (std::gcd(step, squares) > 1) ++step;
  const auto try_patch = [&](const Place& place, bool turned) {
    const int axis = place[0];
    SurfacePatch patch{{place[2], place[3], place[4]}, (axis + 1) % 3, (axis + 2) % 3, {}};
    if (turned) std::swap(patch.u, patch.v);
    std::vector<std::size_t> around;
    for (int j = -1; j <= height; ++j) {
      for (int i = -1; i <= width; ++i) {
        const Eigen::Vector3i low = patch.low + i * Eigen::Vector3i::Unit(patch.u) + j * Eigen::Vector3i::Unit(patch.v);
        const auto entry = square_at_.find({axis, place[1], low.x(), low.y(), low.z()});
        if (entry == square_at_.end() || taken.contains(entry->second)) return false;
        const bool inner = i >= 0 && i < width && j >= 0 && j < height;
        if (inner && fringe.contains(entry->second)) return false;
        (inner ? patch.squares : around).push_back(entry->second);
      }
    }
    taken.insert(patch.squares.begin(), patch.squares.end());
    fringe.insert(around.begin(), around.end());
    patches.push_back(std::move(patch));
    return true;
  };
  for (std::size_t k = 0; k < squares && patches.size() < count; ++k) {
    const Place& place = places_[k * step % squares];
    if (!try_patch(place, false)) try_patch(place, true);
  }
  return patches;
}

void cut_holes(TriangleSoup& soup, std::span<const SurfacePatch> patches) {
  std::vector<bool> removed(soup.triangles.size(), false);
  for (const SurfacePatch& patch : patches) {
    for (const std::size_t square : patch.squares) removed[2 * square] = removed[2 * square + 1] = true;
  }
  std::size_t index = 0;
  std::erase_if(soup.triangles, [&](const Triangle&) { return removed[index++]; });
  remove_unused_vertices(soup);
}

void cut_cracks(TriangleSoup& soup, std::span<const SurfacePatch> patches, double width) {
  for (const SurfacePatch& patch : patches) {
    const std::size_t length = patch.squares.size() / 2;
    const Point across = Point::Unit(patch.v);
    const int line = patch.low[patch.v] + 1;
    std::map<std::uint32_t, std::uint32_t> twin_of;  // inner vertices of the line, and their copies below it
    for (std::size_t square = 0; square < length; ++square) {
      for (std::size_t side = 0; side < 2; ++side) {
        for (std::uint32_t& vertex : soup.triangles[2 * patch.squares[square] + side]) {
          const Eigen::Vector3i at = lattice_point(soup.positions[vertex]);
          const int along = at[patch.u] - patch.low[patch.u];
          if (at[patch.v] != line || along == 0 || along == static_cast<int>(length)) continue;
          const auto [entry, added] = twin_of.try_emplace(vertex, static_cast<std::uint32_t>(soup.positions.size()));
          if (added) soup.positions.push_back(Point(soup.positions[vertex]));
          vertex = entry->second;
        }
      }
    }
    for (const auto& [above, below] : twin_of) {
      soup.positions[above] += width / 2 * across;
      soup.positions[below] -= width / 2 * across;
    }
  }
}

void duplicate_patches(TriangleSoup& soup, std::span<const SurfacePatch> patches) {
  for (const SurfacePatch& patch : patches) {
    for (const std::size_t square : patch.squares) {
      for (std::size_t side = 0; side < 2; ++side) {
        soup.triangles.push_back(Triangle(soup.triangles[2 * square + side]));
      }
    }
  }
}

}  // namespace voxcarve
