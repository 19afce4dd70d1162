#include "common/mesh/pair_collapse.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>
#include <set>

#include "common/mesh/models/primitives.h"
#include "common/mesh/topology.h"
#include "common/mesh/vertex_pairs.h"
#include "common/run/errors.h"
#include "tests/support/pair_collapse_twin.h"
#include "tests/support/shapes.h"

namespace voxcarve {
namespace {

using test::joined;
using test::slow_pairs;
using test::SlowPairCollapse;

constexpr std::uint64_t kPlenty = 1U << 24;

TriangleSoup collapse(const TriangleSoup& soup, std::int64_t triangles, double threshold) {
  RunContext context;
  return collapse_pairs(soup, {.triangles = triangles, .threshold = threshold}, context);
}

TriangleSoup shifted(const TriangleSoup& soup, const Point& step) {
  return transformed(soup, Eigen::Affine3d(Eigen::Translation3d(step)));
}

/// Every vertex moved by up to `amount` along each axis, the same for the same seed: no two costs are equal.
TriangleSoup jittered(TriangleSoup soup, double amount, std::uint32_t seed) {
  std::mt19937 generator(seed);
  for (Point& p : soup.positions) {
    for (int axis = 0; axis < 3; ++axis) p[axis] += amount * (double(generator()) / 2147483648.0 - 1);
  }
  return soup;
}

/// The square [0, 1]^2 at height z, in n x n squares of two triangles.
TriangleSoup sheet(std::uint32_t n, double z) {
  TriangleSoup soup;
  for (std::uint32_t j = 0; j <= n; ++j) {
    for (std::uint32_t i = 0; i <= n; ++i) soup.positions.emplace_back(double(i) / n, double(j) / n, z);
  }
  for (std::uint32_t j = 0; j < n; ++j) {
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::uint32_t a = j * (n + 1) + i;
      soup.triangles.push_back({a, a + 1, a + n + 2});
      soup.triangles.push_back({a, a + n + 2, a + n + 1});
    }
  }
  return soup;
}

TEST(VertexPairs, AreThoseOfEveryPairTried) {
  TriangleSoup soup =
      jittered(joined({icosphere(Point::Zero(), 0.5, 2), icosphere(Point(0.1, 0, 0), 0.4, 2)}), 0.02, 1);
  soup.positions.emplace_back(0, 0, 0);  // that no triangle uses
  std::size_t last = 0;
  for (const double threshold : {0.0, 1e-9, 0.03, 0.1, 0.37, 5.0}) {
    RunContext context;
    const auto found = find_vertex_pairs(soup.positions, soup.triangles, threshold, kPlenty, context);
    const std::set<VertexPair> expected = slow_pairs(soup, threshold);
    EXPECT_TRUE(std::ranges::equal(found, expected)) << threshold;
    EXPECT_GE(found.size(), last);
    last = found.size();
  }
  EXPECT_EQ(last, 324U * 323U / 2);  // 162 vertices a sphere (10 * 4^2 + 2); all pairs within 5
}

TEST(VertexPairs, ThresholdIsStrict) {
  // Three vertices 1, 1 and 2 apart, of three triangles with other corners far off.
  TriangleSoup soup;
  for (const double x : {0.0, 1.0, 2.0}) {
    soup.positions.insert(soup.positions.end(), {Point(x, 0, 0), Point(x, 100 + 50 * x, 0), Point(x, 0, 100 + 50 * x)});
  }
  soup.triangles = {{0, 1, 2}, {3, 4, 5}, {6, 7, 8}};
  RunContext context;
  EXPECT_EQ(find_vertex_pairs(soup.positions, soup.triangles, 1, kPlenty, context).size(), 9U);
  EXPECT_EQ(find_vertex_pairs(soup.positions, soup.triangles, 1.0001, kPlenty, context).size(), 11U);
  EXPECT_EQ(find_vertex_pairs(soup.positions, soup.triangles, 2.0001, kPlenty, context).size(), 12U);
}

TEST(VertexPairs, TooManyAreRefusedByNameOfTheThreshold) {
  // 162 vertices have 162 * 161 / 2 = 13041 pairs.
  const TriangleSoup soup = icosphere(Point::Zero(), 0.5, 2);
  RunContext context;
  EXPECT_EQ(find_vertex_pairs(soup.positions, soup.triangles, 2, 13041, context).size(), 13041U);
  try {
    find_vertex_pairs(soup.positions, soup.triangles, 2, 13040, context);
    FAIL();
  } catch (const ResourceError& error) {
    EXPECT_NE(std::string(error.what()).find("threshold"), std::string::npos) << error.what();
  }
}

/// How often a pair was postponed.
std::int64_t expect_same_contractions(const TriangleSoup& soup, double threshold, std::size_t triangles) {
  std::vector<PairContraction> contractions;
  RunContext context;
  PairCollapseOptions options{.triangles = static_cast<std::int64_t>(triangles), .threshold = threshold};
  options.watcher = [&](const PairContraction& contraction) { contractions.push_back(contraction); };
  const TriangleSoup reduced = collapse_pairs(soup, options, context);
  SlowPairCollapse slow(soup, threshold, options.boundary_weight);
  for (const PairContraction& contraction : contractions) {
    EXPECT_GT(slow.triangles(), triangles);
    EXPECT_TRUE(slow.step());
    EXPECT_EQ(contraction.kept, slow.last.kept);
    EXPECT_EQ(contraction.gone, slow.last.gone);
    EXPECT_EQ(contraction.inverting, slow.last.inverting);
    EXPECT_LT((contraction.point - slow.last.point).norm(), 1e-8);
    if (testing::Test::HasFailure()) return 0;  // all that follows differs too
  }
  EXPECT_LE(slow.triangles(), triangles);
  EXPECT_EQ(reduced.triangles.size(), slow.triangles());
  // Vertices are renumbered in order, triangles keep theirs.
  std::set<std::uint32_t> used;
  for (const Triangle& t : slow.triangle_list()) used.insert(t.begin(), t.end());
  std::map<std::uint32_t, std::uint32_t> renumbered;
  for (const std::uint32_t v : used) renumbered.insert({v, static_cast<std::uint32_t>(renumbered.size())});
  for (std::size_t t = 0; t < reduced.triangles.size(); ++t) {
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_EQ(reduced.triangles[t].at(i), renumbered.at(slow.triangle_list()[t].at(i)));
  }
  return slow.postponements;
}

/// Triangles between random points of the unit cube: nothing is a manifold, and nearly every contraction inverts.
TriangleSoup random_soup(std::uint32_t vertices, std::size_t triangles, std::uint32_t seed) {
  TriangleSoup soup;
  soup.positions.assign(vertices, Point::Zero());
  soup = jittered(std::move(soup), 1, seed);
  std::mt19937 generator(seed);
  std::set<std::set<std::uint32_t>> seen;
  while (soup.triangles.size() < triangles) {
    Triangle corners{};
    for (std::uint32_t& corner : corners) corner = static_cast<std::uint32_t>(generator() % vertices);
    if (has_distinct_corners(corners) && seen.insert({corners[0], corners[1], corners[2]}).second)
      soup.triangles.push_back(corners);
  }
  return soup;
}

TEST(CollapsePairs, MakesTheContractionsOfTheSlowTwin) {
  const TriangleSoup rough = jittered(icosphere(Point::Zero(), 1, 1), 0.15, 3);
  expect_same_contractions(rough, 0, 10);
  EXPECT_GT(expect_same_contractions(random_soup(30, 40, 7), 0.3, 1), 0);
  EXPECT_GT(expect_same_contractions(random_soup(40, 100, 8), 0, 3), 0);
  expect_same_contractions(jittered(joined({rough, shifted(rough, Point(1.2, 0.9, 0))}), 0.05, 4), 0.2, 8);
  expect_same_contractions(jittered(sheet(5, 0), 0.08, 5), 0.1, 4);
  expect_same_contractions(jittered(joined({sheet(4, 0), sheet(4, 0.1)}), 0.03, 6), 0.15, 6);
}

TEST(CollapsePairs, MakesInvertingContractionsWhenNoOtherIsLeft) {
  // A soup in which the twin comes to that too.
  const TriangleSoup soup = random_soup(10, 48, 10);
  expect_same_contractions(soup, 0, 1);
  RunContext context;
  int inverting = 0;
  PairCollapseOptions options{.triangles = 1, .threshold = 0};
  options.watcher = [&](const PairContraction& contraction) { inverting += contraction.inverting ? 1 : 0; };
  EXPECT_LE(collapse_pairs(soup, options, context).triangles.size(), 1U);
  EXPECT_GT(inverting, 0);
}

TEST(CollapsePairs, JoinsNearSolidsWithinTheThreshold) {
  // Two cubes 0.05 apart whose facing sides match vertex by vertex; the box is 2.05 x 1 x 1, its diagonal 2.49.
  const TriangleSoup cube = block_surface(
      {1, 1, 1}, [](int, int, int) { return true; }, 1.0, 4);
  const TriangleSoup cubes = joined({cube, shifted(cube, Point(1.05, 0, 0))});
  // Down to 24 triangles, two boxes, all contractions are free. Of the next ones those of two facing corners cost
  // least.
  EXPECT_EQ(analyze_topology(collapse(cubes, 22, 0.0)).components, 2);
  EXPECT_EQ(analyze_topology(collapse(cubes, 22, 0.01)).components, 2);  // 0.025: too short
  const TriangleSoup one = collapse(cubes, 22, 0.03);                    // 0.075
  EXPECT_EQ(analyze_topology(one).components, 1);
  EXPECT_LE(one.triangles.size(), 22U);
}

TEST(CollapsePairs, JoinsParallelSheets) {
  // Two squares come to lie on each other halfway, and one goes as a duplicate.
  const TriangleSoup sheets = joined({sheet(8, 0), sheet(8, 0.01)});
  EXPECT_EQ(analyze_topology(collapse(sheets, 4, 0)).components, 2);
  const TriangleSoup one = collapse(sheets, 2, 0.02);
  ASSERT_EQ(one.triangles.size(), 2U);
  ASSERT_EQ(one.positions.size(), 4U);
  for (const Point& p : one.positions) EXPECT_NEAR(p[2], 0.005, 1e-9);
  EXPECT_NEAR(surface_area(one), 1, 1e-9);
}

TEST(CollapsePairs, WithoutThresholdComponentsStayApart) {
  // An edge has both its ends in one component, so that contractions of edges never join two.
  std::vector<TriangleSoup> spheres;
  for (int i = 0; i < 5; ++i) spheres.push_back(icosphere(Point(2.001 * i, 0, 0), 1, 2));
  const TriangleSoup soup = joined(spheres);
  std::set<std::uint32_t> gone;
  PairCollapseOptions options{.triangles = 100, .threshold = 0};
  options.watcher = [&](const PairContraction& contraction) {
    EXPECT_EQ(contraction.kept / 162, contraction.gone / 162);  // 162 vertices a sphere
    EXPECT_TRUE(gone.insert(contraction.gone).second);          // each goes once
    EXPECT_FALSE(gone.contains(contraction.kept));
  };
  RunContext context;
  const TriangleSoup reduced = collapse_pairs(soup, options, context);
  EXPECT_LE(reduced.triangles.size(), 100U);
  EXPECT_EQ(analyze_topology(reduced).components, 5);
}

TEST(CollapsePairs, APlaneStaysAPlane) {
  // To the last bit: all displacements across it are products with zero. The corners of the square stay too.
  const TriangleSoup reduced = collapse(sheet(20, 0.1), 2, 0);
  ASSERT_EQ(reduced.triangles.size(), 2U);
  for (const Point& p : reduced.positions) {
    EXPECT_EQ(p[2], 0.1);
    EXPECT_TRUE((p[0] == 0 || p[0] == 1) && (p[1] == 0 || p[1] == 1)) << p.transpose();
  }
  EXPECT_DOUBLE_EQ(surface_area(reduced), 1);
}

TEST(CollapsePairs, ACubeKeepsItsCorners) {
  const TriangleSoup fine = shifted(block_surface(
                                        {1, 1, 1}, [](int, int, int) { return true; }, 0.7, 10),
                                    Point(0.1, -0.3, 0.7));
  const Box box = bounds(fine);
  for (const PlaneWeight weight : {PlaneWeight::kArea, PlaneWeight::kUniform}) {
    RunContext context;
    const TriangleSoup reduced =
        collapse_pairs(fine, {.triangles = 12, .threshold = 0.01, .plane_weight = weight}, context);
    ASSERT_EQ(reduced.triangles.size(), 12U);
    std::set<std::array<double, 3>> corners;
    for (const Point& p : reduced.positions) {
      corners.insert({p[0], p[1], p[2]});
      for (int axis = 0; axis < 3; ++axis) EXPECT_TRUE(p[axis] == box.lower[axis] || p[axis] == box.upper[axis]);
    }
    EXPECT_EQ(corners.size(), 8U);
    EXPECT_NEAR(signed_volume(reduced), 0.343, 1e-12);
  }
}

TEST(CollapsePairs, DropsDuplicatesWhicheverWayRound) {
  // Contracting an edge of a tetrahedron leaves two triangles of the same three vertices: one is kept.
  TriangleSoup soup;
  soup.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  soup.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  EXPECT_EQ(collapse(soup, 3, 0).triangles.size(), 1U);
  // And those of the input count once.
  soup.triangles = {{0, 1, 2}, {0, 1, 2}, {1, 0, 2}, {0, 0, 1}, {1, 2, 3}};
  const TriangleSoup reduced = collapse(soup, 2, 0);
  EXPECT_EQ(reduced.triangles, (std::vector<Triangle>{{0, 1, 2}, {1, 2, 3}}));
  EXPECT_EQ(reduced.positions, soup.positions);
}

TEST(CollapsePairs, MeetsEveryCountDownToNothing) {
  // Each of three far triangles vanishes with its first edge.
  TriangleSoup soup;
  for (int i = 0; i < 3; ++i) {
    const Point at(10.0 * i, 0, 0);
    soup.positions.insert(soup.positions.end(), {at, at + Point(1, 0, 0), at + Point(0, 1 + i, 0)});
    const auto first = static_cast<std::uint32_t>(3 * i);
    soup.triangles.push_back({first, first + 1, first + 2});
  }
  RunContext context;
  EXPECT_EQ(collapse_pairs(soup, {.triangles = 2, .threshold = 0}, context).triangles.size(), 2U);
  EXPECT_TRUE(collapse_pairs(soup, {.triangles = 0, .threshold = 0}, context).empty());
}

TEST(CollapsePairs, CarriesColours) {
  TriangleSoup soup = joined({colored(icosphere(Point::Zero(), 1, 2), Color(1, 0, 0)),
                              colored(icosphere(Point(3, 0, 0), 1, 2), Color(0, 0, 1))});
  for (const Point& p : soup.positions) soup.vertex_colors.push_back(p[0] < 1.5 ? Color(1, 0, 0) : Color(0, 0, 1));
  const TriangleSoup reduced = collapse(soup, 80, 0.01);
  ASSERT_EQ(reduced.vertex_colors.size(), reduced.positions.size());
  ASSERT_EQ(reduced.triangle_colors.size(), reduced.triangles.size());
  for (std::size_t v = 0; v < reduced.positions.size(); ++v)
    EXPECT_EQ(reduced.vertex_colors[v], reduced.positions[v][0] < 1.5 ? Color(1, 0, 0) : Color(0, 0, 1));
  for (std::size_t t = 0; t < reduced.triangles.size(); ++t)
    EXPECT_EQ(reduced.triangle_colors[t],
              reduced.positions[reduced.triangles[t][0]][0] < 1.5 ? Color(1, 0, 0) : Color(0, 0, 1));
}

TEST(CollapsePairs, GivesTheSameBytesAgain) {
  const TriangleSoup soup = joined({torus(3, 1, 48, 24), torus(1, 0.3, 12, 8)});
  EXPECT_EQ(collapse(soup, 300, 0.02), collapse(soup, 300, 0.02));
}

TEST(CollapsePairs, SurvivesNastyShapes) {
  EXPECT_EQ(collapse({}, 0, 0.1), TriangleSoup{});
  const TriangleSoup cube = box(Point::Zero(), Point::Ones());
  EXPECT_EQ(collapse(cube, 12, 0.1), cube);  // within the count
  TriangleSoup collapsed = cube;
  collapsed.triangles.assign(20, {1, 1, 2});
  EXPECT_TRUE(collapse(collapsed, 4, 0.1).empty());
  TriangleSoup line = sheet(4, 0);
  for (Point& p : line.positions) p = Point(p[0] + p[1], 0, 0);
  TriangleSoup point = cube;
  for (Point& p : point.positions) p = Point(7, 7, 7);
  for (const TriangleSoup& soup : {line, point, joined({cube, cube}), joined({cube, test::inside_out(cube)})}) {
    for (const double threshold : {0.0, 1e-300, 0.1, 1.0}) {
      const TriangleSoup reduced = collapse(soup, 6, threshold);
      EXPECT_LE(reduced.triangles.size(), 6U);
      for (const Point& p : reduced.positions) EXPECT_TRUE(p.allFinite());
      for (const Triangle& t : reduced.triangles) EXPECT_TRUE(has_distinct_corners(t));
    }
  }
  for (const double scale : {1e-300, 1e-12, 1e12, 1e300}) {
    const TriangleSoup sphere = icosphere(Point::Zero(), scale, 2);
    const TriangleSoup reduced = collapse(sphere, 50, 0.05);
    EXPECT_LE(reduced.triangles.size(), 50U);
    for (const Point& p : reduced.positions) EXPECT_LT((p / scale).norm(), 1.2);
  }
}

TEST(CollapsePairs, RefusesWhatMakesNoSense) {
  const TriangleSoup soup = icosphere(Point::Zero(), 1, 2);
  RunContext context;
  EXPECT_THROW(collapse_pairs(soup, {.triangles = 10, .threshold = -1}, context), ParameterError);
  EXPECT_THROW(collapse_pairs(soup, {.triangles = 10, .threshold = std::nan("")}, context), ParameterError);
  EXPECT_THROW(collapse_pairs(soup, {.triangles = 10, .boundary_weight = -1}, context), ParameterError);
  context.memory_budget = 1000;
  EXPECT_THROW(collapse_pairs(soup, {.triangles = 10}, context), ResourceError);
  // Enough for the 480 edges, not for the 13041 pairs.
  context.memory_budget = 400000;
  EXPECT_EQ(collapse_pairs(soup, {.triangles = 10, .threshold = 0}, context).triangles.size(), 10U);
  try {
    collapse_pairs(soup, {.triangles = 10, .threshold = 1}, context);
    FAIL();
  } catch (const ResourceError& error) {
    EXPECT_NE(std::string(error.what()).find("lower the threshold"), std::string::npos) << error.what();
  }
}

TEST(CollapsePairs, StopsWhenItIsCancelled) {
  const TriangleSoup soup = icosphere(Point::Zero(), 1, 3);
  RunContext context;
  std::stop_source source;
  context.cancellation = source.get_token();
  context.progress = [&](const ProgressEvent& event) {
    if (event.stage == "pair collapse" && event.done > 100) source.request_stop();
  };
  EXPECT_THROW(collapse_pairs(soup, {.triangles = 10}, context), Cancelled);
}

}  // namespace
}  // namespace voxcarve
