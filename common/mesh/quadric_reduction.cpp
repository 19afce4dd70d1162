// Based on [GH97], edges only, and on [GH98] for colours; differs in the weights of triangles (weight_of), in
// quadrics that are kept about their own vertices, and in a flip check. The order of collapses: quadric_collapse.h.
#include "common/mesh/quadric_reduction.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "common/mesh/quadric_collapse.h"
#include "common/mesh/topology.h"
#include "common/mesh/unit_frame.h"
#include "common/run/errors.h"

namespace voxcarve {

namespace {

constexpr std::uint32_t kNone = CornerTable::kNone;

/// A triangle weighs the power 3/4 of its area. With power 1 the mean error is least, and detail in small triangles
/// gives way to it; with power 0 the result depends on how finely the input is divided.
double weight_of(double area) {
  const double root = std::sqrt(area);
  return root * std::sqrt(root);
}

/// What a plane through a boundary edge weighs against a triangle as large as the edge's square.
constexpr double kBoundaryWeight = 10;

/// The oriented manifold that is reduced, and its connectivity.
struct Manifold {
  const TriangleSoup& soup() const { return cut ? *cut : input; }

  const TriangleSoup& input;
  std::optional<TriangleSoup> cut;  ///< where the input is no manifold
  std::optional<CornerTable> table;
};

std::uint64_t bytes_of(const TriangleSoup& soup) {
  return soup.triangles.size() * sizeof(Triangle) + soup.positions.size() * sizeof(Point) +
         (soup.triangle_colors.size() + soup.vertex_colors.size()) * sizeof(Color);
}

Manifold make_manifold(const TriangleSoup& soup, RunContext& context) {
  Manifold manifold{soup, std::nullopt, CornerTable::build(soup.triangles, soup.positions.size(), context)};
  if (manifold.table) return manifold;
  context.require_memory(cut_memory_estimate(soup), "cutting the surface for its reduction");
  manifold.cut = cut_to_manifold(soup, &context);
  const TriangleSoup& cut = *manifold.cut;
  if (cut.positions.size() > soup.positions.size()) {
    context.notice("the surface was cut at singular edges and vertices before its reduction: " +
                   std::to_string(soup.positions.size()) + " vertices became " + std::to_string(cut.positions.size()));
  }
  context.require_memory(bytes_of(cut) + CornerTable::memory_estimate(cut.triangles.size(), cut.positions.size()),
                         "the reduction");
  manifold.table = CornerTable::build(cut.triangles, cut.positions.size(), context);
  if (!manifold.table) throw MethodFailure("the surface could not be cut to a manifold for its reduction");
  return manifold;
}

template <int N>
using VectorOf = typename Quadric<N>::Vector;

/// Position, and colour in units of the diagonal where it takes part.
template <int N>
std::vector<VectorOf<N>> make_points(const TriangleSoup& soup, const UnitFrame& frame, double color_weight) {
  std::vector<VectorOf<N>> points(soup.positions.size());
  for (std::size_t v = 0; v < points.size(); ++v) {
    points[v].template head<3>() = frame.to_unit(soup.positions[v]);
    if constexpr (N == 6) {
      points[v].template tail<3>() = color_weight * soup.vertex_colors[v].template cast<double>();
    }
  }
  return points;
}

/// Adds the planes that hold the boundary in place to the quadrics of its vertices.
template <int N>
void add_boundary(const CornerTable& table, const std::vector<VectorOf<N>>& points, std::uint32_t half_edge,
                  const Eigen::Vector3d& area, std::vector<Quadric<N>>& quadrics) {
  const std::uint32_t start = table.start(half_edge);
  const std::uint32_t end = table.end(half_edge);
  const Eigen::Vector3d edge = (points[end] - points[start]).template head<3>();
  const Eigen::Vector3d across = edge.cross(area);
  const double length = across.norm();
  if (!(length > 0)) return;
  const auto plane = Quadric<N>::of_plane(across / length, kBoundaryWeight * weight_of(edge.squaredNorm()));
  quadrics[start] += plane;
  quadrics[end] += plane;
}

/// The area vector of a triangle, twice as long as its area.
template <int N>
Eigen::Vector3d twice_area_of(const CornerTable& table, const std::vector<VectorOf<N>>& points, std::uint32_t t) {
  const Triangle corner = table.corners(t);
  const Eigen::Vector3d first = (points[corner[1]] - points[corner[0]]).template head<3>();
  const Eigen::Vector3d second = (points[corner[2]] - points[corner[0]]).template head<3>();
  return first.cross(second);
}

/// The largest of the area vectors next to a triangle.
template <int N>
Eigen::Vector3d largest_area_beside(const CornerTable& table, const std::vector<VectorOf<N>>& points, std::uint32_t t) {
  Eigen::Vector3d largest = Eigen::Vector3d::Zero();
  for (std::uint32_t half_edge = 4 * t; half_edge < 4 * t + 3; ++half_edge) {
    const std::uint32_t twin = table.twin(half_edge);
    if (twin == kNone) continue;
    const Eigen::Vector3d area = twice_area_of<N>(table, points, CornerTable::triangle_of(twin));
    if (area.squaredNorm() > largest.squaredNorm()) largest = area;
  }
  return largest;
}

template <int N>
std::vector<Quadric<N>> make_quadrics(const CornerTable& table, const std::vector<VectorOf<N>>& points) {
  std::vector<Quadric<N>> quadrics(points.size());
  for (std::uint32_t t = 0; t < table.slots(); ++t) {
    const Triangle corner = table.corners(t);
    Eigen::Vector3d area = twice_area_of<N>(table, points, t);
    const double twice_area = area.norm();
    if (twice_area > 0) {
      const double weight = weight_of(0.5 * twice_area);
      // The triangle's plane passes through each corner, so its quadric is the same about all three.
      const auto quadric = N == 3 ? Quadric<N>::of_plane(area / twice_area, weight)
                                  : Quadric<N>::of_span(points[corner[1]] - points[corner[0]],
                                                        points[corner[2]] - points[corner[0]], weight);
      for (const std::uint32_t vertex : corner) quadrics[vertex] += quadric;
    } else {
      area = largest_area_beside<N>(table, points, t);  // what the boundary stands on then
    }
    for (std::uint32_t half_edge = 4 * t; half_edge < 4 * t + 3; ++half_edge) {
      if (table.twin(half_edge) == kNone) add_boundary<N>(table, points, half_edge, area, quadrics);
    }
  }
  return quadrics;
}

/// What is left, with the colours of `soup` where the collapse did not take care of them.
template <int N>
TriangleSoup to_soup(const QuadricCollapse<N>& collapse, const TriangleSoup& soup, const UnitFrame& frame,
                     double color_weight) {
  const CornerTable& table = collapse.table();
  TriangleSoup result;
  result.triangles.reserve(table.triangles());
  result.positions.reserve(table.vertices());
  if (!soup.triangle_colors.empty()) result.triangle_colors.reserve(table.triangles());
  if (!soup.vertex_colors.empty()) result.vertex_colors.reserve(table.vertices());
  std::vector<std::uint32_t> new_vertex(table.vertices(), kNone);
  for (std::uint32_t v = 0; v < table.vertices(); ++v) {
    if (table.leaving(v) == kNone) continue;
    new_vertex[v] = static_cast<std::uint32_t>(result.positions.size());
    const std::uint32_t source = collapse.vertex_source(v);  // what did not move keeps its last bit
    const VectorOf<N>& point = collapse.point(v);
    result.positions.push_back(source != kNone ? soup.positions[source] : frame.from_unit(point.template head<3>()));
    if constexpr (N == 6) {
      const Eigen::Vector3d color = point.template tail<3>() / color_weight;
      result.vertex_colors.push_back(source != kNone ? soup.vertex_colors[source]
                                                     : Color(color.cwiseMax(0.0).cwiseMin(1.0).template cast<float>()));
    } else if (!collapse.carried_colors.empty()) {
      result.vertex_colors.push_back(collapse.carried_colors[v]);
    }
  }
  for (std::uint32_t t = 0; t < table.slots(); ++t) {
    if (table.removed(t)) continue;
    const Triangle corner = table.corners(t);
    result.triangles.push_back({new_vertex[corner[0]], new_vertex[corner[1]], new_vertex[corner[2]]});
    if (!soup.triangle_colors.empty())
      result.triangle_colors.push_back(soup.triangle_colors[collapse.triangle_source(t)]);
  }
  return result;
}

template <int N>
TriangleSoup reduce(Manifold&& manifold, std::uint32_t triangles, double color_weight, Stage& stage) {
  const TriangleSoup& soup = manifold.soup();
  const UnitFrame frame(soup);
  std::vector<VectorOf<N>> points = make_points<N>(soup, frame, color_weight);
  std::vector<Quadric<N>> quadrics = make_quadrics<N>(*manifold.table, points);
  QuadricCollapse<N> collapse(*std::move(manifold.table), std::move(points), std::move(quadrics));
  if (N == 3) collapse.carried_colors = soup.vertex_colors;
  collapse.run(triangles, stage);
  return to_soup<N>(collapse, soup, frame, color_weight);
}

/// Of a reduction of a manifold; the result comes while the collapse still holds what it is made of.
template <int N>
std::uint64_t memory_estimate(const TriangleSoup& soup) {
  const std::size_t triangles = soup.triangles.size();
  const std::size_t vertices = soup.positions.size();
  return std::max(CornerTable::memory_estimate(triangles, vertices),
                  QuadricCollapse<N>::memory_estimate(triangles, vertices) + bytes_of(soup));
}

}  // namespace

TriangleSoup reduce_quadric(const TriangleSoup& soup, const QuadricReductionOptions& options, RunContext& context) {
  if (!(options.color_weight >= 0) || !std::isfinite(options.color_weight)) {
    throw ParameterError("the weight of colours in the reduction is not a number from 0 up");
  }
  const auto before = static_cast<std::int64_t>(soup.triangles.size());
  const std::int64_t wanted = std::max<std::int64_t>(options.triangles, 0);
  if (before <= wanted) return soup;
  constexpr std::int64_t kMostTriangles = std::int64_t{1} << 30;
  if (before >= kMostTriangles) throw ResourceError("a surface of 2^30 triangles or more cannot be reduced");
  Stage stage(context, "reduction", before - wanted);
  const bool with_colors = options.color_weight > 0 && !soup.vertex_colors.empty();
  const auto require_memory = [&](const TriangleSoup& reduced, std::uint64_t held) {
    context.require_memory(held + (with_colors ? memory_estimate<6>(reduced) : memory_estimate<3>(reduced)),
                           "the reduction");
  };
  require_memory(soup, 0);  // at least; before any work
  Manifold manifold = make_manifold(soup, context);
  if (manifold.cut) require_memory(*manifold.cut, bytes_of(*manifold.cut));  // corners cut apart are vertices
  const auto goal = static_cast<std::uint32_t>(wanted);
  TriangleSoup reduced = with_colors ? reduce<6>(std::move(manifold), goal, options.color_weight, stage)
                                     : reduce<3>(std::move(manifold), goal, options.color_weight, stage);
  if (static_cast<std::int64_t>(reduced.triangles.size()) > wanted) {
    context.notice("the reduction stopped at " + std::to_string(reduced.triangles.size()) + " triangles, above the " +
                   std::to_string(wanted) +
                   " asked for: no further edge may collapse without changing the topology or flipping a triangle");
  }
  return reduced;
}

}  // namespace voxcarve
