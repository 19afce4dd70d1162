#include "common/mesh/vertex_clustering.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "common/mesh/distinct_triangles.h"
#include "common/mesh/models/primitives.h"
#include "common/mesh/topology.h"
#include "common/run/errors.h"
#include "tests/support/shapes.h"

namespace voxcarve {
namespace {

using test::joined;

constexpr std::array kAll = {ClusterRepresentative::kQuadric, ClusterRepresentative::kMean,
                             ClusterRepresentative::kHeaviest};

TriangleSoup cluster(const TriangleSoup& soup, std::int64_t cells,
                     ClusterRepresentative representative = ClusterRepresentative::kQuadric) {
  RunContext context;
  return cluster_vertices(soup, {.cells = cells, .representative = representative}, context);
}

std::int64_t cells_for(const TriangleSoup& soup, std::int64_t triangles) {
  RunContext context;
  return cluster_cells_for(soup, triangles, context);
}

using Cell = std::array<std::int64_t, 3>;

/// The cell of a position by its definition.
Cell cell_of(const Point& p, const Box& box, std::int64_t cells) {
  Cell cell{};
  const double edge = box.extent().maxCoeff() / static_cast<double>(cells);
  for (int axis = 0; axis < 3; ++axis) {
    const auto many = static_cast<std::int64_t>(std::ceil(box.extent()[axis] / edge - 1e-9));
    const auto index = static_cast<std::int64_t>(std::floor((p[axis] - box.lower[axis]) / edge));
    cell.at(static_cast<std::size_t>(axis)) = std::clamp<std::int64_t>(index, 0, std::max<std::int64_t>(many, 1) - 1);
  }
  return cell;
}

/// Clustering to means with maps and sets.
TriangleSoup slow_clustering(const TriangleSoup& soup, std::int64_t cells) {
  const Box box = bounds(soup);
  std::map<Cell, std::set<std::array<double, 3>>> members;
  for (const Triangle& t : soup.triangles) {
    for (const std::uint32_t v : t) {
      const Point& p = soup.positions[v];
      members[cell_of(p, box, cells)].insert({p[0], p[1], p[2]});
    }
  }
  std::map<Cell, std::uint32_t> used;
  std::vector<std::array<Cell, 3>> left;
  std::set<std::set<Cell>> seen;
  for (const Triangle& t : soup.triangles) {
    std::array<Cell, 3> corners;
    for (std::size_t i = 0; i < 3; ++i) corners.at(i) = cell_of(soup.positions[t.at(i)], box, cells);
    const std::set<Cell> different(corners.begin(), corners.end());
    if (different.size() < 3 || !seen.insert(different).second) continue;
    left.push_back(corners);
    for (const Cell& cell : corners) used[cell] = 0;
  }
  TriangleSoup result;
  for (auto& [cell, index] : used) {
    index = static_cast<std::uint32_t>(result.positions.size());
    Point sum = Point::Zero();
    for (const auto& p : members[cell]) sum += Point(p[0], p[1], p[2]);
    result.positions.push_back(sum / static_cast<double>(members[cell].size()));
  }
  for (const auto& c : left) result.triangles.push_back({used[c[0]], used[c[1]], used[c[2]]});
  return result;
}

/// Nothing on a lattice that cells could share.
TriangleSoup tori() {
  const Eigen::Affine3d turn(Eigen::AngleAxisd(0.7, Point(1, 2, 3).normalized()));
  return transformed(joined({torus(3, 1, 48, 24), torus(1, 0.3, 12, 8)}), turn);
}

TEST(KeepDistinctTriangles, KeepsTheFirstOfEachWithItsColour) {
  TriangleSoup soup;
  soup.positions.assign(4, Point::Zero());  // only indices count
  soup.triangles = {{0, 1, 2}, {1, 1, 2}, {2, 1, 0}, {1, 2, 3}, {1, 2, 0}, {3, 1, 2}, {0, 3, 1}};
  for (int t = 0; t < 7; ++t) soup.triangle_colors.push_back(Color::Constant(0.1F * static_cast<float>(t)));
  const std::vector<Color> colors = soup.triangle_colors;
  const DistinctTrianglesReport report = keep_distinct_triangles(soup);
  EXPECT_EQ(report.collapsed, 1);
  EXPECT_EQ(report.duplicate, 3);
  EXPECT_EQ(soup.triangles, (std::vector<Triangle>{{0, 1, 2}, {1, 2, 3}, {0, 3, 1}}));
  EXPECT_EQ(soup.triangle_colors, (std::vector<Color>{colors[0], colors[3], colors[6]}));
  EXPECT_EQ(soup.positions.size(), 4U);
}

TEST(ClusterVertices, GivesWhatTheSlowTwinGives) {
  const Eigen::Affine3d turn(Eigen::AngleAxisd(1.1, Point(3, 1, 2).normalized()));
  for (const TriangleSoup& soup : {tori(), transformed(icosphere(Point(0.1, 0.2, 0.3), 1.7, 3), turn)}) {
    for (const std::int64_t cells : {2, 3, 5, 8, 13, 21, 40, 200}) {
      const TriangleSoup fast = cluster(soup, cells, ClusterRepresentative::kMean);
      const TriangleSoup slow = slow_clustering(soup, cells);
      EXPECT_EQ(fast.triangles, slow.triangles) << cells;
      ASSERT_EQ(fast.positions.size(), slow.positions.size()) << cells;
      for (std::size_t v = 0; v < fast.positions.size(); ++v)
        EXPECT_LT((fast.positions[v] - slow.positions[v]).norm(), 1e-13) << cells;
    }
  }
}

TEST(ClusterVertices, EveryRepresentativeLiesInItsCellAndEachCellHasOne) {
  const TriangleSoup soup = tori();
  const Box box = bounds(soup);
  for (const ClusterRepresentative kind : kAll) {
    const std::size_t vertices = cluster(soup, 17).positions.size();
    for (const std::int64_t cells : {3, 17}) {
      const TriangleSoup clustered = cluster(soup, cells, kind);
      const double edge = box.extent().maxCoeff() / static_cast<double>(cells);
      std::set<Cell> seen;
      std::set<Cell> corners;
      for (const Triangle& t : soup.triangles) {
        for (const std::uint32_t v : t) corners.insert(cell_of(soup.positions[v], box, cells));
      }
      for (const Point& p : clustered.positions) {
        // On a cell's side rounding decides; a share of 1e-9 inwards it does not.
        const Cell cell = cell_of(p, box, cells);
        const Point middle =
            box.lower + edge * (Point(double(cell[0]), double(cell[1]), double(cell[2])).array() + 0.5).matrix();
        const Cell inner = cell_of(p + 1e-9 * (middle - p), box, cells);
        EXPECT_TRUE(corners.contains(cell) || corners.contains(inner));
        seen.insert(cell);
      }
      EXPECT_FALSE(clustered.empty());
    }
    EXPECT_EQ(cluster(soup, 17, kind).positions.size(), vertices);
  }
}

TEST(ClusterVertices, OneCellLeavesNothing) {
  for (const ClusterRepresentative kind : kAll) EXPECT_EQ(cluster(tori(), 1, kind), TriangleSoup{});
  EXPECT_EQ(cluster({}, 32), TriangleSoup{});
}

TEST(ClusterVertices, FineGridsLeaveTheInput) {
  // Alone in their cells, vertices keep their last bit; they come in the order of the cells, triangles in their own.
  const TriangleSoup soup = icosphere(Point(0.1, 0.2, 0.3), 1, 3);
  for (const ClusterRepresentative kind : kAll) {
    const TriangleSoup same = cluster(soup, kMostClusterCells, kind);
    ASSERT_EQ(same.triangles.size(), soup.triangles.size());
    ASSERT_EQ(same.positions.size(), soup.positions.size());
    for (std::size_t t = 0; t < soup.triangles.size(); ++t) {
      for (std::size_t i = 0; i < 3; ++i)
        EXPECT_EQ(same.positions[same.triangles[t].at(i)], soup.positions[soup.triangles[t].at(i)]);
    }
  }
}

TEST(ClusterVertices, QuadricsKeepTheCornersOfACube) {
  // 3 cells a side of a cube of 12 x 12 squares a face: the corner cells hold the corners, where the planes of three
  // sides meet; the mean lies inside. Cells along an edge keep it, cells of a face its plane.
  const TriangleSoup cube = block_surface(
      {1, 1, 1}, [](int, int, int) { return true; }, 1.0, 12);
  const TriangleSoup sharp = cluster(cube, 3);
  EXPECT_NEAR(signed_volume(sharp), 1, 1e-12);
  EXPECT_NEAR(surface_area(sharp), 6, 1e-12);
  EXPECT_NEAR(bounds(sharp).diagonal(), std::numbers::sqrt3, 1e-12);
  EXPECT_LT(signed_volume(cluster(cube, 3, ClusterRepresentative::kMean)), 0.95);
}

TEST(ClusterVertices, TheHeaviestIsAVertexOfTheInput) {
  const TriangleSoup soup = tori();
  std::set<std::array<double, 3>> positions;
  for (const Point& p : soup.positions) positions.insert({p[0], p[1], p[2]});
  for (const Point& p : cluster(soup, 9, ClusterRepresentative::kHeaviest).positions)
    EXPECT_TRUE(positions.contains({p[0], p[1], p[2]}));
  // Of the vertices of a finely divided cube in the cell of a corner the corner itself has the smallest angle between
  // two of its edges that are farthest apart: a right one, where the others have edges that go on straight. The longest
  // edge, the diagonal of a square, is at most that of the others, and the square root of 2 does not outweigh the 2.
  const TriangleSoup cube = block_surface(
      {1, 1, 1}, [](int, int, int) { return true; }, 1.0, 12);
  const TriangleSoup clustered = cluster(cube, 3, ClusterRepresentative::kHeaviest);
  std::int64_t corners = 0;
  for (const Point& p : clustered.positions) {
    corners += (p.array() == 0 || p.array() == 1).all() ? 1 : 0;
  }
  EXPECT_EQ(corners, 8);
}

TEST(ClusterVertices, AveragesColoursAndKeepsThoseOfTriangles) {
  TriangleSoup soup = colored(icosphere(Point::Zero(), 1, 2), Color(0.25F, 0.5F, 0.75F));
  soup.vertex_colors.assign(soup.positions.size(), Color(0.5F, 0.25F, 1));
  for (const ClusterRepresentative kind : kAll) {
    const TriangleSoup clustered = cluster(soup, 4, kind);
    ASSERT_EQ(clustered.vertex_colors.size(), clustered.positions.size());
    ASSERT_EQ(clustered.triangle_colors.size(), clustered.triangles.size());
    for (const Color& color : clustered.vertex_colors) EXPECT_EQ(color, Color(0.5F, 0.25F, 1));
    for (const Color& color : clustered.triangle_colors) EXPECT_EQ(color, Color(0.25F, 0.5F, 0.75F));
  }
  // Two vertices in the cell about (0, 0, 0), black and white: grey, or one of them.
  TriangleSoup pair;
  pair.positions = {{0, 0, 0}, {0.1, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  pair.triangles = {{0, 2, 3}, {0, 1, 3}};
  pair.vertex_colors = {Color::Zero(), Color::Ones(), Color::Zero(), Color::Zero()};
  EXPECT_EQ(cluster(pair, 2).vertex_colors[0], Color(Color::Constant(0.5F)));
}

TEST(ClusterVertices, EqualPositionsCountOnce) {
  TriangleSoup soup = tori();
  TriangleSoup torn;  // every triangle with vertices of its own
  for (const Triangle& t : soup.triangles) {
    const auto first = static_cast<std::uint32_t>(torn.positions.size());
    for (const std::uint32_t v : t) torn.positions.push_back(soup.positions[v]);
    torn.triangles.push_back({first, first + 1, first + 2});
  }
  for (const ClusterRepresentative kind : kAll) {
    const TriangleSoup a = cluster(soup, 12, kind);
    const TriangleSoup b = cluster(torn, 12, kind);
    EXPECT_EQ(a.triangles, b.triangles);
    ASSERT_EQ(a.positions.size(), b.positions.size());
    if (kind == ClusterRepresentative::kHeaviest) continue;  // of equal weights the first wins, and the order differs
    for (std::size_t v = 0; v < a.positions.size(); ++v) EXPECT_LT((a.positions[v] - b.positions[v]).norm(), 1e-12);
  }
}

TEST(ClusterVertices, IsTheSameOnTwoThreads) {
  for (const ClusterRepresentative kind : kAll) {
    RunContext one;
    RunContext two;
    two.threads = 2;
    const TriangleSoup soup = torus(3, 1, 300, 150);
    EXPECT_EQ(cluster_vertices(soup, {.cells = 150, .representative = kind}, one),
              cluster_vertices(soup, {.cells = 150, .representative = kind}, two));
  }
}

TEST(ClusterCellsFor, MeetsTheBudgetAsWellAsItSays) {
  const TriangleSoup soup = tori();
  for (const std::int64_t budget : {20, 50, 100, 300, 700, 1500, 2300}) {
    const std::int64_t cells = cells_for(soup, budget);
    ASSERT_GT(cells, 1) << budget;
    const auto count = [&](std::int64_t n) { return static_cast<std::int64_t>(cluster(soup, n).triangles.size()); };
    EXPECT_LE(count(cells), budget);
    EXPECT_GT(count(cells), 0);
    // The next one does not fit: else the search would have gone on to it, or the halving to a larger one.
    EXPECT_GT(count(cells + 1), budget);
  }
}

TEST(ClusterCellsFor, TakesTheFinestGridForASoupWithinTheBudget) {
  const TriangleSoup soup = tori();
  EXPECT_EQ(cells_for(soup, static_cast<std::int64_t>(soup.triangles.size())), kMostClusterCells);
}

TEST(ClusterCellsFor, FindsNothingWhereEveryGridLeavesTooManyOrNone) {
  // A closed surface in two cells a side at least has a triangle a corner cell; a budget of 1 is met by none.
  EXPECT_EQ(cells_for(icosphere(Point::Zero(), 1, 3), 1), 0);
}

TEST(ClusterVertices, SurvivesNastyShapes) {
  const TriangleSoup cube = box(Point::Zero(), Point::Ones());
  TriangleSoup line = cube;
  for (Point& p : line.positions) p = Point(p[0] + p[1] + 2 * p[2], 0, 0);
  TriangleSoup point = cube;
  for (Point& p : point.positions) p = Point(7, 7, 7);
  TriangleSoup collapsed = cube;
  collapsed.triangles.assign(20, {1, 1, 2});
  TriangleSoup unused = cube;
  unused.positions.emplace_back(1e9, -1e9, 0);
  for (const ClusterRepresentative kind : kAll) {
    EXPECT_TRUE(cluster(point, 5, kind).empty());
    EXPECT_TRUE(cluster(collapsed, 5, kind).empty());
    EXPECT_EQ(cluster(unused, 2, kind).triangles.size(), 12U);  // a corner a cell
    EXPECT_EQ(cluster(joined({cube, test::inside_out(cube)}), 2, kind).triangles.size(), 12U);
    for (const Point& p : cluster(line, 4, kind).positions) EXPECT_TRUE(p.allFinite());
    for (const double scale : {1e-300, 1e-12, 1e12, 1e300}) {
      const TriangleSoup sphere = icosphere(Point::Zero(), scale, 2);
      const TriangleSoup clustered = cluster(sphere, 6, kind);
      EXPECT_EQ(clustered.triangles, cluster(icosphere(Point::Zero(), 1, 2), 6, kind).triangles) << scale;
      for (const Point& p : clustered.positions) EXPECT_LT((p / scale).norm(), 1.8);  // in a cell about the sphere
    }
  }
}

TEST(ClusterVertices, RefusesWhatMakesNoSense) {
  RunContext context;
  EXPECT_THROW(cluster_vertices(tori(), {.cells = 0}, context), ParameterError);
  EXPECT_THROW(cluster_vertices(tori(), {.cells = kMostClusterCells + 1}, context), ParameterError);
  context.memory_budget = 1000;
  EXPECT_THROW(cluster_vertices(tori(), {}, context), ResourceError);
  EXPECT_THROW(cluster_cells_for(tori(), 100, context), ResourceError);
}

TEST(ClusterCellsFor, StopsWhenItIsCancelled) {
  RunContext context;
  std::stop_source source;
  context.cancellation = source.get_token();
  context.progress = [&](const ProgressEvent& event) {
    if (event.done > 3) source.request_stop();
  };
  EXPECT_THROW(cluster_cells_for(tori(), 100, context), Cancelled);
}

}  // namespace
}  // namespace voxcarve
