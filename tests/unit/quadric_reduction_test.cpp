#include "common/mesh/quadric_reduction.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>

#include "common/mesh/models/primitives.h"
#include "common/mesh/topology.h"
#include "common/run/errors.h"
#include "tests/support/shapes.h"

namespace voxcarve {
namespace {

using test::joined;

TriangleSoup reduce(const TriangleSoup& soup, std::int64_t triangles, double color_weight = 0.1) {
  RunContext context;
  return reduce_quadric(soup, {.triangles = triangles, .color_weight = color_weight}, context);
}

void expect_closed_genus(const TriangleSoup& soup, std::int64_t components, std::int64_t genus) {
  const SurfaceTopology topology = analyze_topology(soup);
  EXPECT_TRUE(topology.closed);
  EXPECT_TRUE(topology.oriented);
  EXPECT_EQ(topology.nonmanifold_vertices, 0);
  EXPECT_EQ(topology.components, components);
  EXPECT_EQ(topology.genus.value_or(-1), genus);
}

/// The unit square in the plane z = 0, in n x n squares of two triangles.
TriangleSoup square(std::uint32_t n) {
  TriangleSoup soup;
  for (std::uint32_t j = 0; j <= n; ++j) {
    for (std::uint32_t i = 0; i <= n; ++i) soup.positions.emplace_back(double(i) / n, double(j) / n, 0);
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

std::set<std::array<double, 3>> positions_of(const TriangleSoup& soup) {
  std::set<std::array<double, 3>> result;
  for (const Point& p : soup.positions) result.insert({p[0], p[1], p[2]});
  return result;
}

TEST(ReduceQuadric, KeepsTheTopologyAndMeetsTheCount) {
  RunContext context;
  for (const std::int64_t triangles : {1000, 200, 60}) {
    const TriangleSoup reduced = reduce_quadric(torus(3, 1, 48, 24), {.triangles = triangles}, context);
    EXPECT_LE(static_cast<std::int64_t>(reduced.triangles.size()), triangles);
    EXPECT_GT(static_cast<std::int64_t>(reduced.triangles.size()), triangles - 2);  // a collapse takes two
    expect_closed_genus(reduced, 1, 1);
  }
  EXPECT_TRUE(context.notices().empty());
}

TEST(ReduceQuadric, LeavesTheTwelveTrianglesOfABox) {
  // All that is flat costs nothing, so the box is left, its corners to the last bit. 0.1 has no finite binary
  // expansion: nothing is exact by luck.
  const TriangleSoup fine = transformed(block_surface(
                                            {3, 2, 1}, [](int, int, int) { return true; }, 0.1, 12),
                                        Eigen::Affine3d(Eigen::Translation3d(0.7, -0.3, 0.1)));
  std::set<std::array<double, 3>> corners;
  const Box box = bounds(fine);
  for (const double x : {box.lower[0], box.upper[0]}) {
    for (const double y : {box.lower[1], box.upper[1]}) {
      for (const double z : {box.lower[2], box.upper[2]}) corners.insert({x, y, z});
    }
  }
  const TriangleSoup reduced = reduce(fine, 12);
  EXPECT_EQ(reduced.triangles.size(), 12U);
  EXPECT_EQ(positions_of(reduced), corners);
  expect_closed_genus(reduced, 1, 0);
}

TEST(ReduceQuadric, KeepsFlatFacesFlatOnTheWay) {
  // At every count, faces stay in their planes and no triangle turns or folds: area and volume are exact.
  const TriangleSoup fine = block_surface(
      {1, 2, 3}, [](int i, int j, int k) { return i + j + k < 5; }, 1.0, 10);
  for (const std::int64_t triangles : {2000, 700, 300, 100, 50, 20, 12}) {
    const TriangleSoup reduced = reduce(fine, triangles);
    EXPECT_LE(static_cast<std::int64_t>(reduced.triangles.size()), triangles);
    EXPECT_NEAR(signed_volume(reduced), 6, 1e-12);
    EXPECT_NEAR(surface_area(reduced), 22, 1e-12);
    for (const Triangle& t : reduced.triangles) EXPECT_GT(area_vector(reduced, t).norm(), 1e-6);
  }
}

TEST(ReduceQuadric, KeepsTheCornersOfABlockSurface) {
  // An L of three cubes: 12 corners, of which two are concave, and a genus-1 frame of eight: 16 corners.
  const TriangleSoup bend = block_surface(
      {2, 2, 1}, [](int i, int j, int) { return i + j < 2; }, 1.0, 8);
  const TriangleSoup frame = block_surface(
      {3, 3, 1}, [](int i, int j, int) { return i != 1 || j != 1; }, 1.0, 8);
  const TriangleSoup bend_reduced = reduce(bend, 20);
  EXPECT_EQ(bend_reduced.triangles.size(), 20U);  // V - F / 2 = 2
  EXPECT_EQ(bend_reduced.positions.size(), 12U);
  EXPECT_NEAR(signed_volume(bend_reduced), 3, 1e-12);
  const TriangleSoup frame_reduced = reduce(frame, 32);
  EXPECT_EQ(frame_reduced.triangles.size(), 32U);  // V - F / 2 = 0
  EXPECT_NEAR(signed_volume(frame_reduced), 8, 1e-12);
  EXPECT_NEAR(surface_area(frame_reduced), 32, 1e-12);  // 2 * 8 on top and below, 12 outside, 4 inside
  expect_closed_genus(frame_reduced, 1, 1);
}

TEST(ReduceQuadric, LeavesTwoTrianglesOfASquare) {
  const TriangleSoup reduced = reduce(square(20), 2);
  EXPECT_EQ(reduced.triangles.size(), 2U);
  EXPECT_EQ(positions_of(reduced), (std::set<std::array<double, 3>>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}));
  EXPECT_DOUBLE_EQ(surface_area(reduced), 1);
}

TEST(ReduceQuadric, SaysWhenItStopsEarly) {
  // Five components cannot go below 4 triangles each.
  RunContext context;
  std::vector<TriangleSoup> spheres;
  for (int i = 0; i < 5; ++i) spheres.push_back(icosphere(Point(3 * i, 0, 0), 1, 2));
  const TriangleSoup reduced = reduce_quadric(joined(spheres), {.triangles = 8}, context);
  EXPECT_GE(reduced.triangles.size(), 20U);
  expect_closed_genus(reduced, 5, 0);
  ASSERT_EQ(context.notices().size(), 1U);
  EXPECT_NE(context.notices().back().find("the reduction stopped at"), std::string::npos);
}

TEST(ReduceQuadric, LeavesWhatIsWithinTheCount) {
  // Byte for byte, unused vertices and all.
  TriangleSoup soup = colored(box(Point::Zero(), Point::Ones()), Color(0.1F, 0.2F, 0.3F));
  soup.positions.emplace_back(7, 7, 7);
  RunContext context;
  EXPECT_EQ(reduce_quadric(soup, {.triangles = 12}, context), soup);
  EXPECT_EQ(reduce_quadric(TriangleSoup{}, {.triangles = 0}, context), TriangleSoup{});
  EXPECT_TRUE(context.notices().empty());
}

TEST(ReduceQuadric, CutsNonManifoldInputAndSaysSo) {
  // Two boxes that share an edge by index. Cut apart, each has a slit along it: a disc whose boundary has at least 3
  // edges, so 9 vertices with the middle of one side of the slit. Of V - E + F = 1 and 3 F + 3 = 2 E, F = 13.
  const TriangleSoup block = block_surface(
      {1, 1, 1}, [](int, int, int) { return true; }, 1.0, 6);
  const TriangleSoup soup =
      merge_equal_positions(joined({block, transformed(block, Eigen::Affine3d(Eigen::Translation3d(1, 1, 0)))}));
  ASSERT_GT(analyze_topology(soup).nonmanifold_edges, 0);
  RunContext context;
  const TriangleSoup reduced = reduce_quadric(soup, {.triangles = 26}, context);
  EXPECT_EQ(analyze_topology(reduced).nonmanifold_edges, 0);
  EXPECT_EQ(reduced.triangles.size(), 26U);
  EXPECT_NEAR(signed_volume(reduced), 2, 1e-12);
  ASSERT_FALSE(context.notices().empty());
  EXPECT_NE(context.notices().front().find("was cut at singular edges"), std::string::npos);
}

TEST(ReduceQuadric, SurvivesDegenerateAndDuplicateTriangles) {
  TriangleSoup soup = icosphere(Point::Zero(), 1, 3);
  const std::size_t clean = soup.triangles.size();
  for (std::uint32_t i = 0; i < 50; ++i) {
    soup.triangles.push_back(soup.triangles[i * 7]);  // the same twice: three at an edge
    soup.triangles.push_back({i, i, i + 1});          // no area by index
    soup.triangles.push_back({soup.triangles[i][0], soup.triangles[i][2], soup.triangles[i][1]});  // turned
  }
  const TriangleSoup reduced = reduce(soup, 300);
  const SurfaceTopology topology = analyze_topology(reduced);
  EXPECT_EQ(topology.nonmanifold_edges, 0);
  EXPECT_EQ(topology.nonmanifold_vertices, 0);
  EXPECT_TRUE(topology.oriented);
  EXPECT_EQ(topology.collapsed_triangles, 0);
  EXPECT_LT(reduced.triangles.size(), clean);

  // Triangles without area by position: a sphere whose every third vertex lies on the next one.
  TriangleSoup pinched = icosphere(Point::Zero(), 1, 3);
  for (std::size_t v = 0; v + 1 < pinched.positions.size(); v += 3) pinched.positions[v] = pinched.positions[v + 1];
  expect_closed_genus(reduce(pinched, 200), 1, 0);
  TriangleSoup point = icosphere(Point::Zero(), 1, 2);
  for (Point& p : point.positions) p = Point(3, 4, 5);
  expect_closed_genus(reduce(point, 20), 1, 0);
}

TEST(ReduceQuadric, WorksFarFromTheOriginAndAtAnyScale) {
  const TriangleSoup sphere = icosphere(Point::Zero(), 1, 4);
  for (const double scale : {1e-300, 1e-12, 1.0, 1e12, 1e300}) {
    const TriangleSoup scaled = transformed(sphere, Eigen::Affine3d(Eigen::UniformScaling<double>(scale)));
    const TriangleSoup reduced = reduce(scaled, 200);
    EXPECT_EQ(reduced.triangles.size(), 200U);
    // At unit size again. 200 equal triangles have edges with a^2 = 16 pi / (200 sqrt 3) = 0.145; inscribed, their
    // planes lie a^2 / 8 below the sphere on average, so that polyhedron loses 3 a^2 / 8 = 5.4 %. The least squares put
    // vertices outside, so less is lost.
    const TriangleSoup back = transformed(reduced, Eigen::Affine3d(Eigen::UniformScaling<double>(1 / scale)));
    EXPECT_NEAR(signed_volume(back) / signed_volume(sphere), 1, 0.054) << scale;
  }
  for (const double offset : {1e3, 1e9}) {  // at 1e9 coordinates are multiples of 1.2e-7
    const TriangleSoup moved = transformed(sphere, Eigen::Affine3d(Eigen::Translation3d(offset, -offset, offset)));
    const TriangleSoup reduced = reduce(moved, 200);
    EXPECT_EQ(reduced.triangles.size(), 200U);
    expect_closed_genus(reduced, 1, 0);
    EXPECT_NEAR(signed_volume(reduced) / signed_volume(sphere), 1, 0.054) << offset;
  }
  // A cube at 1e9, whose corners are exact there.
  const TriangleSoup cube = transformed(block_surface(
                                            {1, 1, 1}, [](int, int, int) { return true; }, 1.0, 8),
                                        Eigen::Affine3d(Eigen::Translation3d(1e9, 1e9, 1e9)));
  EXPECT_EQ(positions_of(reduce(cube, 12)), positions_of(box(Point::Constant(1e9), Point::Constant(1e9 + 1))));
}

TEST(ReduceQuadric, KeepsAColourBorderStraight) {
  // Red up to x = 0.5, blue from the next column on, and a ramp one column wide between: in position and colour three
  // planes, exactly. So six triangles are enough, with their corners where the planes end.
  constexpr std::uint32_t kColumns = 16;
  TriangleSoup soup = square(kColumns);
  const Color red(1, 0, 0);
  const Color blue(0, 0, 1);
  for (const Point& p : soup.positions) soup.vertex_colors.push_back(p[0] <= 0.5 ? red : blue);
  const TriangleSoup reduced = reduce(soup, 6);
  EXPECT_EQ(reduced.triangles.size(), 6U);
  EXPECT_NEAR(surface_area(reduced), 1, 1e-12);
  std::map<double, int> columns;
  for (std::size_t v = 0; v < reduced.positions.size(); ++v) {
    const Point& p = reduced.positions[v];
    ++columns[p[0]];
    EXPECT_TRUE(p[1] == 0 || p[1] == 1);
    EXPECT_EQ(reduced.vertex_colors[v], p[0] <= 0.5 ? red : blue);
  }
  EXPECT_EQ(columns, (std::map<double, int>{{0, 2}, {0.5, 2}, {0.5 + 1.0 / kColumns, 2}, {1, 2}}));
  // By shape alone the border is nothing.
  EXPECT_EQ(reduce(soup, 2, 0).triangles.size(), 2U);
}

TEST(ReduceQuadric, ReproducesALinearColour) {
  TriangleSoup plane = square(16);
  for (const Point& p : plane.positions) plane.vertex_colors.push_back(p.cast<float>());
  // Linear in position, so one plane in six dimensions: two triangles hold it.
  const TriangleSoup two = reduce(plane, 2);
  EXPECT_EQ(two.triangles.size(), 2U);
  for (std::size_t v = 0; v < two.positions.size(); ++v)
    EXPECT_EQ(two.vertex_colors[v], two.positions[v].cast<float>());

  // On a sphere the colour is linear in space. With position error e the optimum's colour may be off by as much in
  // units of the weight: e = 16 pi / (6 sqrt 3 n) = 0.0048 for n = 1000 (the sagitta), of the diameter 2 half of it.
  TriangleSoup sphere = icosphere(Point::Zero(), 1, 5);
  for (const Point& p : sphere.positions) sphere.vertex_colors.push_back((0.5 * (p + Point::Ones())).cast<float>());
  for (const double weight : {0.01, 0.1, 1.0}) {
    const TriangleSoup reduced = reduce(sphere, 1000, weight);
    EXPECT_EQ(reduced.triangles.size(), 1000U);
    for (std::size_t v = 0; v < reduced.positions.size(); ++v) {
      const Color expected = (0.5 * (reduced.positions[v] + Point::Ones())).cast<float>();
      EXPECT_LT((reduced.vertex_colors[v] - expected).cwiseAbs().maxCoeff(), 0.0048) << weight;
      EXPECT_GE(reduced.vertex_colors[v].minCoeff(), 0);
      EXPECT_LE(reduced.vertex_colors[v].maxCoeff(), 1);
    }
  }
}

TEST(ReduceQuadric, WithoutWeightColoursLeaveTheShapeAlone) {
  TriangleSoup torus_soup = torus(3, 1, 48, 24);
  const TriangleSoup plain = reduce(torus_soup, 500);
  for (const Point& p : torus_soup.positions) {
    torus_soup.vertex_colors.push_back(p[2] > 0 ? Color(1, 1, 1) : Color(0, 0.5F, 0));
  }
  const TriangleSoup carried = reduce(torus_soup, 500, 0);
  EXPECT_EQ(carried.positions, plain.positions);
  EXPECT_EQ(carried.triangles, plain.triangles);
  ASSERT_EQ(carried.vertex_colors.size(), carried.positions.size());
  for (std::size_t v = 0; v < carried.positions.size(); ++v) {
    // Interpolated between the two colours, and pure far from their border.
    const Color& c = carried.vertex_colors[v];
    EXPECT_NEAR(c[1], 0.5F + 0.5F * c[0], 1e-5F);
    EXPECT_EQ(c[0], c[2]);
    if (carried.positions[v][2] > 0.7) {
      EXPECT_EQ(c, Color(1, 1, 1));
    }
    if (carried.positions[v][2] < -0.7) {
      EXPECT_EQ(c, Color(0, 0.5F, 0));
    }
  }
  // Colours that are the same everywhere have no say either.
  for (Color& c : torus_soup.vertex_colors) c = Color(0.25F, 0.5F, 0.75F);
  const TriangleSoup uniform = reduce(torus_soup, 500);
  EXPECT_EQ(uniform.triangles.size(), 500U);
  for (const Color& c : uniform.vertex_colors) EXPECT_LT((c - Color(0.25F, 0.5F, 0.75F)).norm(), 1e-6F);
}

TEST(ReduceQuadric, CarriesTheColoursOfTriangles) {
  // Each side of a block has its colour; triangles that are left are in the planes they were in.
  TriangleSoup block = block_surface(
      {1, 1, 1}, [](int, int, int) { return true; }, 1.0, 8);
  const auto color_of = [](const TriangleSoup& soup, const Triangle& t) {
    const Point normal = area_vector(soup, t).normalized();
    return Color((0.5 * (normal + Point::Ones())).cast<float>());
  };
  for (const Triangle& t : block.triangles) block.triangle_colors.push_back(color_of(block, t));
  for (const bool vertex_colors : {false, true}) {
    block.vertex_colors.clear();
    if (vertex_colors) {
      for (const Point& p : block.positions) block.vertex_colors.push_back(p.cast<float>());
    }
    for (const std::int64_t triangles : {200, 12}) {
      const TriangleSoup reduced = reduce(block, triangles);
      ASSERT_EQ(static_cast<std::int64_t>(reduced.triangles.size()), triangles);
      ASSERT_EQ(reduced.triangle_colors.size(), reduced.triangles.size());
      EXPECT_EQ(reduced.vertex_colors.size(), vertex_colors ? reduced.positions.size() : 0U);
      for (std::size_t t = 0; t < reduced.triangles.size(); ++t) {
        EXPECT_LT((reduced.triangle_colors[t] - color_of(reduced, reduced.triangles[t])).norm(), 1e-6F);
      }
    }
  }
}

TEST(ReduceQuadric, GivesTheSameBytesTwice) {
  TriangleSoup soup = torus(3, 1, 64, 32);
  for (const Point& p : soup.positions) soup.vertex_colors.push_back(Color::Constant(p[0] > 1 ? 1.0F : 0.0F));
  const TriangleSoup once = reduce(soup, 333);
  RunContext threads;
  threads.threads = 4;
  EXPECT_EQ(reduce_quadric(soup, {.triangles = 333}, threads), once);
}

TEST(ReduceQuadric, RefusesAWrongWeight) {
  const TriangleSoup soup = icosphere(Point::Zero(), 1, 1);
  for (const double weight : {-1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    EXPECT_THROW(reduce(soup, 10, weight), ParameterError);
  }
}

TEST(ReduceQuadric, DeclaresItsMemory) {
  const TriangleSoup soup = icosphere(Point::Zero(), 1, 4);
  RunContext context;
  reduce_quadric(soup, {.triangles = 100}, context);
  ASSERT_EQ(context.timings().size(), 1U);
  EXPECT_EQ(context.timings()[0].stage, "reduction");
  EXPECT_GT(context.timings()[0].bytes, soup.triangles.size() * 100);
  EXPECT_LT(context.timings()[0].bytes, soup.triangles.size() * 200);
  context.memory_budget = context.timings()[0].bytes - 1;
  EXPECT_THROW(reduce_quadric(soup, {.triangles = 100}, context), ResourceError);
}

TEST(ReduceQuadric, DeclaresTheMemoryOfCornersThatItCutsApart) {
  // Every other triangle turned: hardly two neighbours agree, so that most corners become vertices of their own, each
  // with a position, the same once more in the reduction, and a quadric of ten numbers.
  TriangleSoup soup = icosphere(Point::Zero(), 1, 4);
  for (std::size_t t = 0; t < soup.triangles.size(); t += 2) std::swap(soup.triangles[t][0], soup.triangles[t][1]);
  const std::size_t vertices = cut_to_manifold(soup).positions.size();
  ASSERT_GT(vertices, 3 * soup.positions.size());
  RunContext context;
  reduce_quadric(soup, {.triangles = 100}, context);
  const std::uint64_t declared = context.timings()[0].bytes;
  EXPECT_GE(declared, vertices * (3 + 3 + 10) * sizeof(double) + soup.triangles.size() * 32);
  context.memory_budget = declared - 1;
  EXPECT_THROW(reduce_quadric(soup, {.triangles = 100}, context), ResourceError);
}

TEST(ReduceQuadric, HoldsTheBoundaryOfZeroAreaTriangles) {
  // Along y = 0 every edge of the square has a vertex in its middle, on a triangle without area. Without planes through
  // those edges the square's lower corners would slide up along its sides.
  TriangleSoup soup = square(8);
  for (std::uint32_t i = 0; i < 8; ++i) {
    const auto middle = static_cast<std::uint32_t>(soup.positions.size());
    soup.positions.push_back(0.5 * (soup.positions[i] + soup.positions[i + 1]));
    soup.triangles.push_back({i + 1, i, middle});
  }
  const TriangleSoup reduced = reduce(soup, 6);
  EXPECT_LE(reduced.triangles.size(), 6U);
  EXPECT_EQ(bounds(reduced).lower, Point(0, 0, 0));
  EXPECT_EQ(bounds(reduced).upper, Point(1, 1, 0));
  double area = 0;
  for (const Triangle& t : reduced.triangles) area += 0.5 * area_vector(reduced, t).z();
  EXPECT_NEAR(area, 1, 1e-9);
}

TEST(ReduceQuadric, LessThanTheComponentsKeepGivesWhatTheLeastGives) {
  // Sixty patches and ten balls keep a triangle or a tetrahedron each, 100 in all. Asking for one triangle must not
  // make the rounds coarser than asking for these: the same collapses come in the same order.
  std::vector<TriangleSoup> parts;
  for (int i = 0; i < 60; ++i) {
    TriangleSoup patch = square(6);
    for (Point& p : patch.positions) {
      p[2] = 0.15 * std::sin(5 * p[0] + i) * std::cos(4 * p[1] + 2 * i);
      p += Point(2 * (i % 8), 2 * (i / 8), 0);
    }
    parts.push_back(patch);
    if (i % 6 == 0) parts.push_back(icosphere(Point(2 * i, 0, 9), 1, 2));
  }
  const TriangleSoup soup = joined(parts);
  const TriangleSoup least = reduce(soup, 100);
  ASSERT_EQ(least.triangles.size(), 100U);
  EXPECT_EQ(reduce(soup, 1), least);
}

TEST(ReduceQuadric, ReportsItsProgress) {
  RunContext context;
  std::int64_t last = 0;
  std::int64_t events = 0;
  context.progress = [&](const ProgressEvent& event) {
    EXPECT_EQ(event.stage, "reduction");
    EXPECT_EQ(event.total, 20480 - 100);
    EXPECT_GE(event.done, last);
    last = event.done;
    ++events;
  };
  reduce_quadric(icosphere(Point::Zero(), 1, 5), {.triangles = 100}, context);
  EXPECT_EQ(last, 20480 - 100);
  EXPECT_GT(events, 5);
}

TEST(ReduceQuadric, CanBeCancelled) {
  RunContext context;
  std::stop_source source;
  context.cancellation = source.get_token();
  context.progress = [&](const ProgressEvent& event) {
    if (event.done > event.total / 4) source.request_stop();
  };
  EXPECT_THROW(reduce_quadric(icosphere(Point::Zero(), 1, 5), {.triangles = 100}, context), Cancelled);
}

}  // namespace
}  // namespace voxcarve
