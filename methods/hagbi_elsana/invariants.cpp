#include "methods/hagbi_elsana/invariants.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "common/mesh/topology.h"
#include "common/run/text.h"
#include "methods/hagbi_elsana/tetrahedron.h"

namespace voxcarve {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

/// Exact.
CGAL::Orientation orientation(const Point& a, const Point& b, const Point& c, const Point& d) {
  const auto exact = [](const Point& p) { return Kernel::Point_3(p[0], p[1], p[2]); };
  return CGAL::orientation(exact(a), exact(b), exact(c), exact(d));
}

std::string number(std::size_t count) {
  return with_thousands(static_cast<std::int64_t>(count));
}

class StreamChecker {
 public:
  StreamChecker(const CarvingStream& stream, RunContext& context)
      : stream_(stream), mesh_(stream.complement()), context_(context) {}

  std::vector<InvariantCheck> run() {
    check_first_level();
    check_volumes();
    check_vertices();
    check_components();
    check_containment();
    check_last_level();
    return std::move(checks_);
  }

 private:
  void add(const char* name, bool holds, std::string detail) { checks_.push_back({name, holds, std::move(detail)}); }
  bool is_carved(std::uint32_t t, std::uint32_t step) const { return stream_.steps()[t] <= step; }

  /// A closed surface of genus 0 that is convex at each of its edges is the boundary of a convex body.
  void check_first_level() {
    const SurfaceTopology topology = analyze_topology(stream_.extract(0, &context_));
    bool convex = true;
    for (std::uint32_t ghost = mesh_.first_ghost; ghost < mesh_.size(); ++ghost) {
      const Triangle face = mesh_.face(ghost, 3);
      for (std::size_t i = 0; i < 3; ++i) {
        const TetrahedronCorners& beside = mesh_.corners[mesh_.neighbors[ghost][i]];
        for (std::size_t c = 0; c < 3; ++c) {
          convex = convex && orientation(mesh_.points[face[0]], mesh_.points[face[1]], mesh_.points[face[2]],
                                         mesh_.points[beside[c]]) != CGAL::POSITIVE;
        }
      }
    }
    add("the first level is convex, one component of genus 0",
        convex && topology.components == 1 && topology.genus == 0,
        number(stream_.vertices(0)) + " vertices, " + std::to_string(topology.components) + " components, genus " +
            (topology.genus ? std::to_string(*topology.genus) : topology.genus_reason));
  }

  void check_volumes() {
    std::size_t inverted = 0;
    for (std::uint32_t t = 0; t < mesh_.first_ghost; ++t) {
      const TetrahedronCorners& c = mesh_.corners[t];
      inverted +=
          orientation(mesh_.points[c[0]], mesh_.points[c[1]], mesh_.points[c[2]], mesh_.points[c[3]]) != CGAL::POSITIVE;
    }
    context_.check_cancelled();
    add("solids are nested, their volume falls", inverted == 0,
        number(mesh_.first_ghost) + " tetrahedra, " + number(inverted) + " without a positive volume");
  }

  void check_vertices() {
    // A vertex of the model keeps a face once it has one.
    std::vector<std::uint32_t> born(mesh_.model_points, kNeverCarved);
    std::vector<std::uint32_t> gone(mesh_.model_points, 0);
    for (std::uint32_t t = 0; t < mesh_.size(); ++t) {
      const std::uint32_t at = stream_.steps()[t];
      if (at == kNeverCarved) continue;
      for (int i = 0; i < 4; ++i) {
        const std::uint32_t until =
            mesh_.is_barrier(t, i) ? kNeverCarved : stream_.steps()[mesh_.neighbors[t][static_cast<std::size_t>(i)]];
        if (until <= at) continue;
        for (const std::uint32_t point : mesh_.face(t, i)) {
          if (point >= mesh_.model_points) continue;
          born[point] = std::min(born[point], at);
          gone[point] = std::max(gone[point], until);
        }
      }
    }
    std::size_t vanish = 0;
    std::size_t seen = 0;
    for (std::size_t point = 0; point < born.size(); ++point) {
      seen += born[point] != kNeverCarved;
      vanish += born[point] != kNeverCarved && gone[point] != kNeverCarved;
    }
    add("vertices of the model never vanish", vanish == 0,
        number(seen) + " of " + number(born.size()) + " appear, " + number(vanish) + " vanish");
  }

  void check_components() {
    const std::vector<std::uint32_t> components = stream_.closed_components(context_);
    add("components of the closed set never grow fewer", std::ranges::is_sorted(components),
        number(components.front()) + " at first, " + number(components.back()) + " at last");
  }

  void check_containment() {
    const auto& levels = stream_.levels();
    const std::size_t checked = std::min<std::size_t>(levels.size(), Method::kCheckedLevels);
    std::size_t bare = 0;
    double worst = 0;
    for (std::size_t i = 0; i < checked; ++i) {
      context_.check_cancelled();
      const std::uint32_t step = levels[checked == 1 ? 0 : i * (levels.size() - 1) / (checked - 1)];
      const TriangleSoup surface = stream_.extract(step, &context_);
      bare += bare_walls(step, surface);
      worst = std::max(worst, volume_error(step, surface));
    }
    constexpr double kRounding = 1e-9;  // of the hull's volume: sums of as many terms as there are tetrahedra
    add("levels contain the model, and their silhouettes its", bare == 0 && worst <= kRounding,
        std::to_string(checked) + " levels; triangles of the model that are neither seen nor under the surface: " +
            number(bare) + "; volume off by " + format_real(worst) + " of the hull's at most");
  }

  /// Triangles of the model with a carved tetrahedron beside them that the surface does not have.
  std::size_t bare_walls(std::uint32_t step, const TriangleSoup& surface) const {
    const auto key = [](const Point& a, const Point& b, const Point& c) {
      std::array<std::array<double, 3>, 3> corners = {{{a[0], a[1], a[2]}, {b[0], b[1], b[2]}, {c[0], c[1], c[2]}}};
      std::ranges::rotate(corners, std::ranges::min_element(corners));
      return corners;
    };
    std::vector<std::array<std::array<double, 3>, 3>> seen;
    seen.reserve(surface.triangles.size());
    for (const Triangle& t : surface.triangles) {
      seen.push_back(key(surface.positions[t[0]], surface.positions[t[1]], surface.positions[t[2]]));
    }
    std::ranges::sort(seen);
    std::size_t bare = 0;
    for (std::uint32_t t = 0; t < mesh_.size(); ++t) {
      if (!is_carved(t, step)) continue;
      for (int i = 0; i < 4; ++i) {
        if (!mesh_.is_wall(t, i)) continue;
        const Triangle face = mesh_.face(t, i);
        bare +=
            !std::ranges::binary_search(seen, key(mesh_.points[face[0]], mesh_.points[face[1]], mesh_.points[face[2]]));
      }
    }
    return bare;
  }

  /// Of the surface's volume against that of the hull less what was carved.
  double volume_error(std::uint32_t step, const TriangleSoup& surface) {
    if (hull_volume_ == 0) hull_volume_ = signed_volume(stream_.extract(0, &context_));
    double carved = 0;
    for (std::uint32_t t = 0; t < mesh_.first_ghost; ++t) {
      if (is_carved(t, step)) carved += volume(mesh_.points, mesh_.corners[t]);
    }
    return std::abs(signed_volume(surface) - (hull_volume_ - carved)) / hull_volume_;
  }

  void check_last_level() {
    std::size_t foreign = 0;
    std::size_t left = 0;
    for (std::uint32_t t = 0; t < mesh_.size(); ++t) {
      left += stream_.steps()[t] == kNeverCarved;
      for (int i = 0; i < 4 && stream_.steps()[t] != kNeverCarved; ++i) {
        foreign +=
            !mesh_.is_barrier(t, i) && stream_.steps()[mesh_.neighbors[t][static_cast<std::size_t>(i)]] == kNeverCarved;
      }
    }
    add("the last level is the model's boundary", foreign == 0,
        number(stream_.triangles(stream_.last_step())) + " triangles, " + number(foreign) +
            " not of the model; tetrahedra left in shut voids: " + number(left));
  }

  const CarvingStream& stream_;
  const Complement& mesh_;
  RunContext& context_;
  double hull_volume_ = 0;
  std::vector<InvariantCheck> checks_;
};

}  // namespace

std::vector<InvariantCheck> check_stream(const CarvingStream& stream, RunContext& context) {
  return StreamChecker(stream, context).run();
}

}  // namespace voxcarve
