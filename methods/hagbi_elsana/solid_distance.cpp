#include "methods/hagbi_elsana/solid_distance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include "common/mesh/aabb_tree.h"
#include "methods/hagbi_elsana/tetrahedron.h"

namespace voxcarve {

namespace {

using Corners = std::array<Point, 4>;

/// The model's surface, as walls and sides of the inside.
TriangleSoup model_surface(const Complement& mesh) {
  TriangleSoup surface;
  surface.positions = mesh.points;
  for (std::uint32_t t = 0; t < mesh.size(); ++t) {
    for (int i = 0; i < 4; ++i) {
      if (mesh.is_barrier(t, i)) surface.triangles.push_back(mesh.face(t, i));
    }
  }
  return surface;
}

class Nearness {
 public:
  Nearness(const TriangleSoup& surface, double distance, const RunContext& context)
      : surface_(surface), tree_(surface), distance_(distance), context_(context) {}

  /// True only where all of the tetrahedron is near enough; false also where that takes too long to prove.
  bool holds(const Corners& corners) {
    pieces_left_ = kMostPieces;
    return all_near(corners);
  }

 private:
  static constexpr double kSlack = 5e-4;
  static constexpr int kMostPieces = 20000;

  bool all_near(const Corners& corners) {
    if (--pieces_left_ < 0) return false;
    if (pieces_left_ % 1024 == 0) context_.check_cancelled();
    const Point center = 0.25 * (corners[0] + corners[1] + (corners[2] + corners[3]));
    double radius = 0;
    for (const Point& corner : corners) radius = std::max(radius, (corner - center).norm());
    const AabbTree::Nearest nearest = tree_.nearest(center);
    const double there = std::sqrt(nearest.squared_distance);
    if (there > distance_) return false;
    // The distance to M changes by no more than the way.
    if (there + radius <= distance_) return true;
    // The distance to a triangle is convex: it is greatest in a corner.
    const Triangle& t = surface_.triangles[nearest.triangle];
    const auto far = [&](const Point& p) {
      return squared_distance(p, surface_.positions[t[0]], surface_.positions[t[1]], surface_.positions[t[2]]) >
             distance_ * distance_;
    };
    if (std::ranges::none_of(corners, far)) return true;
    if (radius <= kSlack * distance_) return false;
    return halves_are_near(corners);
  }

  bool halves_are_near(const Corners& corners) {
    std::pair<std::size_t, std::size_t> longest{0, 1};
    double most = -1;
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = i + 1; j < 4; ++j) {
        const double length = (corners[i] - corners[j]).squaredNorm();
        if (length <= most) continue;
        most = length;
        longest = {i, j};
      }
    }
    const Point middle = 0.5 * (corners[longest.first] + corners[longest.second]);
    Corners half = corners;
    half[longest.first] = middle;
    if (!all_near(half)) return false;
    half = corners;
    half[longest.second] = middle;
    return all_near(half);
  }

  const TriangleSoup& surface_;
  AabbTree tree_;
  double distance_;
  const RunContext& context_;
  int pieces_left_ = 0;
};

}  // namespace

std::optional<std::uint32_t> step_within(const CarvingStream& stream, double distance, RunContext& context) {
  const Complement& mesh = stream.complement();
  if (mesh.first_ghost == 0) return 0;
  const TriangleSoup surface = model_surface(mesh);
  Nearness near(surface, distance, context);
  std::vector<std::uint32_t> late_first(mesh.first_ghost);
  std::iota(late_first.begin(), late_first.end(), 0U);
  std::ranges::stable_sort(late_first, std::ranges::greater(), [&](std::uint32_t t) { return stream.steps()[t]; });
  Stage stage(context, "distance from the model", std::int64_t{mesh.first_ghost});
  for (const std::uint32_t t : late_first) {
    stage.advance(1);
    const TetrahedronCorners& c = mesh.corners[t];
    if (near.holds({mesh.points[c[0]], mesh.points[c[1]], mesh.points[c[2]], mesh.points[c[3]]})) continue;
    if (stream.steps()[t] == kNeverCarved) return std::nullopt;
    return stream.steps()[t];  // gone after the step that carves it
  }
  return 0;
}

}  // namespace voxcarve
