// Based on [GTLH98, 4]: vertices are numbered as if every point were one vertex, and cut only where that is not so.
#include "methods/hagbi_elsana/level_surface.h"

#include <algorithm>
#include <array>
#include <span>

#include "methods/hagbi_elsana/fan_cutting.h"

namespace voxcarve {

namespace {

constexpr std::uint32_t kNone = LevelWorkspace::kNone;
constexpr std::int64_t kGrain = 1 << 13;

/// One face at a vertex: the corner after the vertex, then the one before it.
std::uint64_t link(std::uint32_t after, std::uint32_t before) {
  return std::uint64_t{after} << 32 | before;
}
std::uint32_t after(std::uint64_t face) {
  return static_cast<std::uint32_t>(face >> 32);
}
std::uint32_t before(std::uint64_t face) {
  return static_cast<std::uint32_t>(face);
}

/// Do the faces around a vertex follow one another in one round, with no edge in common to more than two? `next` gives
/// the face that begins where another ends, or none when there is not just one.
template <class Next>
bool is_one_round(std::span<const std::uint64_t> faces, const Next& next) {
  const std::uint32_t start = after(faces[0]);
  std::uint32_t end = before(faces[0]);
  // Back at the start after all faces but not before: no face was met twice, so all were, and each by its own edge.
  for (std::size_t met = 1; met < faces.size(); ++met) {
    if (end == start) return false;
    const std::size_t face = next(end);
    if (face == faces.size()) return false;
    end = before(faces[face]);
  }
  return end == start;
}

/// May sort the faces.
bool is_one_fan(std::span<std::uint64_t> faces) {
  constexpr std::size_t kFew = 24;
  const std::size_t count = faces.size();
  if (count <= kFew) {
    return is_one_round(faces, [&](std::uint32_t start) {
      std::size_t found = count;
      std::size_t times = 0;
      for (std::size_t f = 0; f < count; ++f) {
        const bool fits = after(faces[f]) == start;
        found = fits ? f : found;
        times += fits;
      }
      return times == 1 ? found : count;
    });
  }
  std::ranges::sort(faces);
  return is_one_round(faces, [&](std::uint32_t start) {
    const auto found = std::ranges::equal_range(faces, start, {}, after);
    return found.size() == 1 ? static_cast<std::size_t>(found.begin() - faces.begin()) : count;
  });
}

/// Triangles with a vertex for every point, in the order of their first corners.
void number_points(const Complement& mesh, const std::vector<std::uint32_t>& faces, LevelWorkspace& workspace,
                   std::vector<Triangle>& triangles) {
  constexpr std::size_t kAhead = 16;  // faces that come so much later are fetched
  workspace.point_of.resize(3 * faces.size());
  workspace.first.assign(3 * faces.size() + 1, 0);
  triangles.resize(faces.size());
  std::uint32_t vertices = 0;
  for (std::size_t k = 0; k < faces.size(); ++k) {
    __builtin_prefetch(&mesh.corners[faces[std::min(k + kAhead, faces.size() - 1)] / 4]);
    const Triangle corners = mesh.face(faces[k] / 4, static_cast<int>(faces[k] % 4));
    for (std::size_t c = 0; c < 3; ++c) {
      std::uint32_t& vertex = workspace.vertex_of[corners[c]];
      if (vertex == kNone) {
        workspace.point_of[vertices] = corners[c];
        vertex = vertices++;
      }
      triangles[k][c] = vertex;
      ++workspace.first[vertex];
    }
  }
  workspace.point_of.resize(vertices);
  workspace.first.resize(vertices + std::size_t{1});
  for (const std::uint32_t point : workspace.point_of) workspace.vertex_of[point] = kNone;
}

/// Puts the faces around each vertex side by side; `first` holds their numbers before, and where they begin after.
void gather_links(const std::vector<Triangle>& triangles, LevelWorkspace& workspace) {
  std::vector<std::uint32_t>& first = workspace.first;
  std::uint32_t sum = 0;
  for (std::uint32_t& place : first) {  // where each vertex's end
    sum += place;
    place = sum;
  }
  workspace.links.resize(sum);
  for (const auto& [a, b, c] : triangles) {
    workspace.links[--first[a]] = link(b, c);
    workspace.links[--first[b]] = link(c, a);
    workspace.links[--first[c]] = link(a, b);
  }
}

/// True when there is a vertex of more than one fan.
bool find_singular(LevelWorkspace& workspace, const RunContext& context) {
  workspace.singular.resize(workspace.point_of.size());
  parallel_for(context, 0, std::ssize(workspace.point_of), kGrain, [&](std::int64_t begin, std::int64_t end) {
    for (auto v = static_cast<std::size_t>(begin); v < static_cast<std::size_t>(end); ++v) {
      const std::uint32_t first = workspace.first[v];
      workspace.singular[v] = !is_one_fan(std::span(workspace.links).subspan(first, workspace.first[v + 1] - first));
    }
  });
  return std::ranges::find(workspace.singular, 1) != workspace.singular.end();
}

}  // namespace

TriangleSoup level_surface(const CarvedSolid& solid, const std::vector<std::uint32_t>& faces, LevelWorkspace& workspace,
                           const RunContext& context) {
  TriangleSoup soup;
  number_points(solid.complement, faces, workspace, soup.triangles);
  context.check_cancelled();
  gather_links(soup.triangles, workspace);
  if (find_singular(workspace, context)) {
    cut_fans(solid, faces, workspace, context, soup);
    return soup;
  }
  soup.positions.reserve(workspace.point_of.size());
  for (const std::uint32_t point : workspace.point_of) soup.positions.push_back(solid.complement.points[point]);
  return soup;
}

}  // namespace voxcarve
