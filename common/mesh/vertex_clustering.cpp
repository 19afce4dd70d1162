// Based on [RB93], with the representative of [Lin00] by default; differs in dropping what is no triangle any more, in
// weighting planes by area instead of squared area and in keeping the optimum inside its cell.
#include "common/mesh/vertex_clustering.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "common/mesh/distinct_triangles.h"
#include "common/mesh/topology.h"
#include "common/run/errors.h"

namespace voxcarve {

namespace {

constexpr int kIndexBits = 21;

/// The grid, and lengths in units of its cells from the lower corner of the box.
class ClusterGrid {
 public:
  ClusterGrid(const Box& box, std::int64_t cells) : lower_(box.lower), cells_(static_cast<double>(cells)) {
    const double longest = box.extent().maxCoeff();
    if (longest > 0) longest_ = longest;
    upper_ = ((to_cells(box.upper).array().ceil().max(1.0)).min(cells_) - 1).matrix();
  }

  Point to_cells(const Point& point) const { return (point - lower_) / longest_ * cells_; }
  Point from_cells(const Point& point) const { return lower_ + point / cells_ * longest_; }

  /// The indices of the cell of a point in cell units. The box's upper sides belong to the last cells.
  Point cell_of(const Point& point) const { return point.array().floor().max(0).min(upper_.array()).matrix(); }
  static std::uint64_t key_of(const Point& cell) {
    std::uint64_t key = 0;
    for (int axis = 0; axis < 3; ++axis) key = (key << kIndexBits) + static_cast<std::uint64_t>(cell[axis]);
    return key;
  }

 private:
  Point lower_;
  Point upper_;  ///< indices of the last cell
  double longest_ = 1;
  double cells_;
};

/// Which vertices are in one cell.
struct Clusters {
  std::vector<std::uint32_t> of_vertex;
  std::vector<std::uint32_t> members;      ///< vertices by cluster, each in order
  std::vector<std::uint32_t> first = {0};  ///< clusters + 1 offsets into members

  std::size_t size() const { return first.size() - 1; }
};

Clusters find_clusters(const TriangleSoup& soup, const ClusterGrid& grid) {
  std::vector<std::pair<std::uint64_t, std::uint32_t>> order(soup.positions.size());
  for (std::uint32_t v = 0; v < order.size(); ++v)
    order[v] = {ClusterGrid::key_of(grid.cell_of(grid.to_cells(soup.positions[v]))), v};
  std::sort(order.begin(), order.end());
  Clusters clusters;
  clusters.of_vertex.resize(order.size());
  clusters.members.reserve(order.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) {
    if (i > 0 && order[i].first != order[i - 1].first) clusters.first.push_back(i);
    clusters.of_vertex[order[i].second] = static_cast<std::uint32_t>(clusters.size());
    clusters.members.push_back(order[i].second);
  }
  clusters.first.push_back(static_cast<std::uint32_t>(order.size()));
  return clusters;
}

/// The quadric z'Az + 2 b'z + c of the displacement z from the middle of a cell, without its constant.
struct CellQuadric {
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
  Point linear = Point::Zero();
};

/// The optimum of a quadric nearest to a point, both about the middle of the cell.
Point optimum_near(const CellQuadric& quadric, const Point& start) {
  constexpr double kFlat = 1e-3;  // of the largest eigenvalue: directions in which the planes decide nothing [Lin00]
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(quadric.matrix);
  const Point slope = quadric.linear + quadric.matrix * start;
  Point result = start;
  for (int i = 0; i < 3; ++i) {
    const double value = solver.eigenvalues()[i];
    if (!(value > kFlat * solver.eigenvalues()[2])) continue;
    const Point direction = solver.eigenvectors().col(i);
    result -= direction.dot(slope) / value * direction;
  }
  return result;
}

/// Each triangle's plane counts in the cells of all its corners, once for each corner [Lin00].
std::vector<CellQuadric> make_quadrics(const TriangleSoup& soup, const ClusterGrid& grid, const Clusters& clusters) {
  std::vector<CellQuadric> quadrics(clusters.size());
  for (const Triangle& triangle : soup.triangles) {
    std::array<Point, 3> corners;
    std::ranges::transform(triangle, corners.begin(), [&](auto v) { return grid.to_cells(soup.positions[v]); });
    const Point area = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    const double length = area.norm();
    if (!(length > 0)) continue;
    const Point normal = area / length;
    for (std::size_t i = 0; i < 3; ++i) {
      const Point middle = grid.cell_of(corners.at(i)) + Point::Constant(0.5);
      CellQuadric& quadric = quadrics[clusters.of_vertex[triangle.at(i)]];
      quadric.matrix += length * normal * normal.transpose();
      quadric.linear -= length * normal.dot(corners.at(i) - middle) * normal;
    }
  }
  return quadrics;
}

/// The grading of [RB93]: a vertex counts by the length of its longest edge, for it bounds large parts, and against the
/// largest angle between two of its edges, for one at a sharp corner is often on a silhouette.
std::vector<double> grade_vertices(const TriangleSoup& soup, const ClusterGrid& grid) {
  // Of a hub, so many of its edges are compared; the rest counts by length alone.
  constexpr std::size_t kMostEdges = 64;
  std::vector<std::vector<std::uint32_t>> neighbours(soup.positions.size());
  const EdgeTable edges(soup);
  for (std::size_t edge = 0; edge < edges.size(); ++edge) {
    neighbours[edges.low(edge)].push_back(edges.high(edge));
    neighbours[edges.high(edge)].push_back(edges.low(edge));
  }
  std::vector<double> weights(soup.positions.size());
  std::vector<Point> directions;
  for (std::size_t v = 0; v < weights.size(); ++v) {
    directions.clear();
    double longest = 0;
    double least_cosine = 1;
    const Point start = grid.to_cells(soup.positions[v]);
    for (const std::uint32_t neighbour : neighbours[v]) {
      const Point edge = grid.to_cells(soup.positions[neighbour]) - start;
      const double length = edge.norm();
      longest = std::max(longest, length);
      if (!(length > 0) || directions.size() == kMostEdges) continue;
      for (const Point& other : directions) least_cosine = std::min(least_cosine, other.dot(edge / length));
      directions.push_back(edge / length);
    }
    // An angle of almost nothing is a sliver's, and not worth more than one of a degree.
    constexpr double kLeastAngle = std::numbers::pi / 180;
    weights[v] = longest / std::max(std::acos(std::max(least_cosine, -1.0)), kLeastAngle);
  }
  return weights;
}

/// One vertex a cluster.
class Representatives {
 public:
  Representatives(const TriangleSoup& soup, const ClusterGrid& grid, const Clusters& clusters,
                  ClusterRepresentative kind)
      : soup_(soup), grid_(grid), clusters_(clusters), kind_(kind) {
    if (kind == ClusterRepresentative::kQuadric) quadrics_ = make_quadrics(soup, grid, clusters);
    if (kind == ClusterRepresentative::kHeaviest) weights_ = grade_vertices(soup, grid);
  }

  Point position(std::size_t cluster) const {
    if (const auto vertex = only_vertex(cluster)) return soup_.positions[*vertex];
    Point mean = Point::Zero();
    for (const std::uint32_t vertex : members(cluster)) mean += grid_.to_cells(soup_.positions[vertex]);
    mean /= static_cast<double>(members(cluster).size());
    if (kind_ == ClusterRepresentative::kMean) return grid_.from_cells(mean);
    const Point cell = grid_.cell_of(grid_.to_cells(soup_.positions[members(cluster).front()]));
    const Point middle = cell + Point::Constant(0.5);
    const Point optimum = middle + optimum_near(quadrics_[cluster], mean - middle);
    return grid_.from_cells(optimum.cwiseMax(cell).cwiseMin(cell + Point::Ones()));
  }

  Color color(std::size_t cluster) const {
    if (const auto vertex = only_vertex(cluster)) return soup_.vertex_colors[*vertex];
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const std::uint32_t vertex : members(cluster)) sum += soup_.vertex_colors[vertex].cast<double>();
    return (sum / static_cast<double>(members(cluster).size())).cast<float>();
  }

 private:
  std::span<const std::uint32_t> members(std::size_t cluster) const {
    return std::span(clusters_.members)
        .subspan(clusters_.first[cluster], clusters_.first[cluster + 1] - clusters_.first[cluster]);
  }

  /// The vertex that the cluster takes as it is.
  std::optional<std::uint32_t> only_vertex(std::size_t cluster) const {
    const auto vertices = members(cluster);
    if (vertices.size() == 1) return vertices.front();
    if (kind_ != ClusterRepresentative::kHeaviest) return std::nullopt;
    return *std::ranges::max_element(vertices, {}, [&](std::uint32_t v) { return weights_[v]; });
  }

  const TriangleSoup& soup_;
  const ClusterGrid& grid_;
  const Clusters& clusters_;
  ClusterRepresentative kind_;
  std::vector<CellQuadric> quadrics_;
  std::vector<double> weights_;
};

/// The triangles that are left, naming clusters.
TriangleSoup name_clusters(const TriangleSoup& soup, const Clusters& clusters) {
  TriangleSoup result;
  result.triangles.reserve(soup.triangles.size());
  result.triangle_colors = soup.triangle_colors;
  for (const Triangle& t : soup.triangles)
    result.triangles.push_back({clusters.of_vertex[t[0]], clusters.of_vertex[t[1]], clusters.of_vertex[t[2]]});
  keep_distinct_triangles(result);
  return result;
}

/// Bytes beside `soup`: a copy of it, the result, the sorted vertices and triangles, and a quadric or the edges about
/// each vertex.
std::uint64_t memory_estimate(const TriangleSoup& soup) {
  constexpr std::uint64_t kVertex = 2 * (sizeof(Point) + sizeof(Color)) + sizeof(CellQuadric) + 64;
  constexpr std::uint64_t kTriangle = 2 * (sizeof(Triangle) + sizeof(Color)) + 100;
  return soup.positions.size() * kVertex + soup.triangles.size() * kTriangle;
}

/// How many triangles a grid leaves of a soup whose equal positions are merged.
std::int64_t count_left(const TriangleSoup& soup, const Box& box, std::int64_t cells, Stage& stage) {
  stage.advance(1);
  const Clusters clusters = find_clusters(soup, ClusterGrid(box, cells));
  stage.advance(0);
  return static_cast<std::int64_t>(name_clusters(soup, clusters).triangles.size());
}

}  // namespace

TriangleSoup cluster_vertices(const TriangleSoup& soup, const VertexClusteringOptions& options, RunContext& context) {
  if (options.cells < 1 || options.cells > kMostClusterCells)
    throw ParameterError("the cells of the vertex clustering are not from 1 to " + std::to_string(kMostClusterCells));
  Stage stage(context, "vertex clustering", 3);
  context.require_memory(memory_estimate(soup), "the vertex clustering");
  const TriangleSoup merged = merge_equal_positions(soup);
  stage.advance(1);
  const ClusterGrid grid(bounds(merged), options.cells);
  const Clusters clusters = find_clusters(merged, grid);
  TriangleSoup result = name_clusters(merged, clusters);
  stage.advance(1);
  if (result.empty()) return {};
  const Representatives representatives(merged, grid, clusters, options.representative);
  stage.advance(1);
  result.positions.resize(clusters.size());
  if (!merged.vertex_colors.empty()) result.vertex_colors.resize(clusters.size());
  constexpr std::int64_t kGrain = 4096;
  const auto count = static_cast<std::int64_t>(clusters.size());
  parallel_for(context, 0, count, kGrain, [&](std::int64_t first, std::int64_t last) {
    for (auto cluster = static_cast<std::size_t>(first); cluster < static_cast<std::size_t>(last); ++cluster) {
      result.positions[cluster] = representatives.position(cluster);
      if (!result.vertex_colors.empty()) result.vertex_colors[cluster] = representatives.color(cluster);
    }
  });
  remove_unused_vertices(result);
  return result;
}

std::int64_t cluster_cells_for(const TriangleSoup& soup, std::int64_t triangles, RunContext& context) {
  constexpr int kTrials = 128;  // at most: 20 to double, 20 to halve, 64 and 64 nearby
  Stage stage(context, "cell search", kTrials);
  context.require_memory(memory_estimate(soup), "the search for a grid");
  if (static_cast<std::int64_t>(soup.triangles.size()) <= triangles) return kMostClusterCells;
  const TriangleSoup merged = merge_equal_positions(soup);
  const Box box = bounds(merged);
  const auto left = [&](std::int64_t cells) { return count_left(merged, box, cells, stage); };
  std::int64_t fits = 1;  // which leaves nothing
  std::int64_t too_fine = 2;
  while (left(too_fine) <= triangles) {
    if (too_fine == kMostClusterCells) return too_fine;
    fits = too_fine;
    too_fine *= 2;
  }
  while (too_fine - fits > 1) {
    const std::int64_t middle = fits + (too_fine - fits) / 2;
    (left(middle) <= triangles ? fits : too_fine) = middle;
  }
  const auto is_good = [&](std::int64_t cells) {
    const std::int64_t count = left(cells);
    return count > 0 && count <= triangles;
  };
  const std::int64_t reach = std::clamp<std::int64_t>(fits / 8, 8, 64);
  for (std::int64_t cells = std::min(too_fine + reach - 1, kMostClusterCells); cells > too_fine; --cells) {
    if (is_good(cells)) return cells;
  }
  for (std::int64_t cells = fits; cells > std::max<std::int64_t>(fits - reach, 1); --cells) {
    if (is_good(cells)) return cells;
  }
  return 0;
}

}  // namespace voxcarve
