#include "common/mesh/stitching.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <random>

#include "common/mesh/gluing.h"
#include "common/mesh/io/mesh_io.h"
#include "common/mesh/models/primitives.h"
#include "common/mesh/topology.h"
#include "common/run/errors.h"
#include "tests/support/shapes.h"
#include "tests/unit/metric_shapes.h"
#include "tests/unit/stitching_shapes.h"

namespace voxcarve {
namespace {

using test::closed_topology;
using test::cracked_cube;
using test::faces;
using test::has_notice;
using test::inside_out;
using test::joined;
using test::translated;
using test::unit_cube;

TEST(Stitch, LeavesAClosedManifoldAsItIs) {
  RunContext context;
  const TriangleSoup cube = unit_cube();
  const TriangleSoup result = stitch(cube, {.tolerance = 0.1}, context);
  EXPECT_EQ(merge_equal_positions(cube), result);  // the order of vertices is that of their first use
  EXPECT_TRUE(context.notices().empty());
}

TEST(Stitch, ClosesTheCracksBetweenSixFaces) {
  // A corner of the cube stands in three faces, at (0, g, g) and so on, at most sqrt(2) g apart. They meet at their
  // mean, 2/3 g from the old corner along each axis: a cube of side 1 - 4/3 g. Eight corners of three become one each.
  for (const double gap : {0.01, 0.001}) {
    RunContext context;
    const TriangleSoup result = stitch(cracked_cube(gap), {.tolerance = 1.5 * gap}, context);
    const SurfaceTopology topology = closed_topology(result);
    EXPECT_EQ(topology.components, 1);
    EXPECT_EQ(topology.genus, 0);
    EXPECT_EQ(result.triangles.size(), 12U);
    EXPECT_EQ(result.positions.size(), 8U);
    EXPECT_NEAR(signed_volume(result), std::pow(1 - 4 * gap / 3, 3), 1e-12);
    EXPECT_TRUE(has_notice(context, "merged 16 border vertices"));
  }
}

TEST(Stitch, JoinsEqualPositionsAloneWithoutATolerance) {
  RunContext context;
  EXPECT_EQ(closed_topology(stitch(cracked_cube(0), {}, context)).components, 1);
  EXPECT_TRUE(has_notice(context, "merged 16 vertices of equal positions"));
  // With cracks and no tolerance each face is a sheet of its own, and becomes closed by its other side.
  const TriangleSoup apart = stitch(cracked_cube(0.01), {}, context);
  EXPECT_EQ(closed_topology(apart).components, 6);
  EXPECT_NEAR(signed_volume(apart), 0, 1e-12);
}

TEST(Stitch, TurnsFacesToAgree) {
  // However many faces are turned, and whichever the first is, the closed cube has its outside out.
  for (int mask = 0; mask < 64; ++mask) {
    RunContext context;
    std::vector<TriangleSoup> parts = faces(0.01, [](int) { return 1; });
    for (std::size_t f = 0; f < 6; ++f)
      if ((mask >> f & 1) != 0) parts[f] = inside_out(parts[f]);
    const TriangleSoup result = stitch(joined(parts), {.tolerance = 0.02}, context);
    EXPECT_EQ(closed_topology(result).genus, 0);
    const double side = 1 - 0.04 / 3;
    EXPECT_NEAR(signed_volume(result), (mask == 63 ? -1 : 1) * side * side * side, 1e-12) << mask;
  }
}

TEST(Stitch, ClosesTJoints) {
  // One face is divided into 3 x 3 squares: two vertices on each of its sides lie on undivided edges of neighbours.
  for (const double gap : {0.0, 0.01}) {
    RunContext context;
    const TriangleSoup soup = joined(faces(gap, [](int face) { return face == 2 ? 3 : 1; }));
    const TriangleSoup result = stitch(soup, {.tolerance = 0.02}, context);
    const SurfaceTopology topology = closed_topology(result);
    EXPECT_EQ(topology.components, 1);
    EXPECT_EQ(topology.genus, 0);
    // 18 triangles of the divided face, 10 of the others and two more on each side of it; nothing was filled.
    EXPECT_EQ(result.triangles.size(), 18U + 10 + 8);
    EXPECT_TRUE(has_notice(context, "split 4 border edges"));
    EXPECT_FALSE(has_notice(context, "filled"));
    EXPECT_NEAR(signed_volume(result), 1, gap == 0 ? 1e-12 : 0.05);
  }
}

TEST(Stitch, ClosesBordersOfUnrelatedDivisions) {
  // Every face has its own division, and cracks are narrower and wider than the pieces of the borders.
  for (const double gap : {0.0, 0.002, 0.02}) {
    RunContext context;
    const TriangleSoup soup = joined(faces(gap, [](int face) { return 3 + 5 * face; }));
    const TriangleSoup result = stitch(soup, {.tolerance = 0.03}, context);
    const SurfaceTopology topology = closed_topology(result);
    EXPECT_EQ(topology.components, 1) << gap;
    EXPECT_EQ(topology.genus, 0) << gap;
    EXPECT_NEAR(signed_volume(result), 1, 6 * 0.03) << gap;
  }
}

TEST(Stitch, DoesNotCollapseAFinelyDividedBorder) {
  // An open box whose rim has pieces of a hundredth, and a tolerance of five of them: nothing is there to be joined.
  RunContext context;
  std::vector<TriangleSoup> parts = faces(0.0, [](int) { return 100; });
  parts.pop_back();
  const TriangleSoup result = stitch(joined(parts), {.tolerance = 0.05}, context);
  EXPECT_EQ(closed_topology(result).genus, 0);
  EXPECT_NEAR(signed_volume(result), 1, 1e-9);
  EXPECT_FALSE(has_notice(context, "nearby"));
  EXPECT_TRUE(has_notice(context, "filled 1 hole with 398 triangles"));  // 400 edges
}

TEST(Stitch, ClosesASlitWithinOnePart) {
  // A cube with a slit in its upper face: both sides of the slit belong to one border, which leads around its ends.
  // Five vertices stand on either side.
  RunContext context;
  TriangleSoup cube = joined(faces(0.0, [](int) { return 8; }));
  cube = merge_equal_positions(cube);
  // Opens the edges along y = 0.5 of the face z = 1 between x = 0.25 and 0.75 by moving copies of their vertices.
  const double half_width = 0.004;
  TriangleSoup slit = cube;
  std::vector<std::uint32_t> copy(cube.positions.size(), 0);
  for (std::uint32_t v = 0; v < cube.positions.size(); ++v) {
    const Point p = cube.positions[v];
    if (std::abs(p[2] - 1) > 1e-9 || std::abs(p[1] - 0.5) > 1e-9 || p[0] < 0.2 || p[0] > 0.8) continue;
    copy[v] = static_cast<std::uint32_t>(slit.positions.size());
    slit.positions.push_back(p + Point(0, half_width, 0));
    slit.positions[v] -= Point(0, half_width, 0);
  }
  for (Triangle& t : slit.triangles) {
    const double y = (cube.positions[t[0]][1] + cube.positions[t[1]][1] + cube.positions[t[2]][1]) / 3;
    if (y < 0.5) continue;
    for (std::uint32_t& v : t)
      if (copy[v] != 0) v = copy[v];
  }
  ASSERT_EQ(analyze_topology(slit).boundary_loops, 1);
  const TriangleSoup result = stitch(slit, {.tolerance = 0.02}, context);
  EXPECT_EQ(closed_topology(result).genus, 0);
  EXPECT_NEAR(signed_volume(result), 1, 1e-9);  // every pair meets where it was
  EXPECT_TRUE(has_notice(context, "merged 5 border vertices"));
  EXPECT_FALSE(has_notice(context, "filled"));
}

TEST(Stitch, LeavesPartsThatCutThroughEachOtherApart) {
  RunContext context;
  const TriangleSoup two = joined({cracked_cube(0.005), translated(cracked_cube(0.005), Point(0.4, 0.3, 0.2))});
  const TriangleSoup result = stitch(two, {.tolerance = 0.01}, context);
  const SurfaceTopology topology = closed_topology(result);
  EXPECT_EQ(topology.components, 2);
  EXPECT_EQ(topology.genus, 0);
  EXPECT_NEAR(signed_volume(result), 2 * std::pow(1 - 0.02 / 3, 3), 1e-12);
}

TEST(Stitch, TakesSolidsApartThatTouch) {
  // In a vertex, an edge and a face (of which one wall is dropped as a duplicate, and filled again).
  for (const Point& shift : {Point(1, 1, 1), Point(1, 1, 0), Point(1, 0, 0)}) {
    RunContext context;
    const TriangleSoup result = stitch(joined({unit_cube(), translated(unit_cube(), shift)}), {}, context);
    const SurfaceTopology topology = closed_topology(result);
    EXPECT_EQ(topology.components, 2) << shift.transpose();
    EXPECT_EQ(topology.genus, 0);
    EXPECT_NEAR(signed_volume(result), 2, 1e-12);
    EXPECT_NEAR(surface_area(result), 12, 1e-12);
  }
}

TEST(Stitch, DropsWhatIsUseless) {
  RunContext context;
  TriangleSoup soup = unit_cube();
  soup.triangles.push_back(soup.triangles[4]);                                                   // a duplicate
  soup.triangles.push_back({soup.triangles[4][1], soup.triangles[4][0], soup.triangles[4][2]});  // and a double wall
  soup.triangles.push_back({0, 0, 1});
  soup.positions.emplace_back(0.5, 0, 0);
  soup.triangles.push_back({0, 1, 8});  // no area
  const TriangleSoup result = stitch(soup, {}, context);
  EXPECT_EQ(result.triangles, stitch(unit_cube(), {}, context).triangles);
  EXPECT_EQ(result.positions.size(), 8U);
  EXPECT_TRUE(has_notice(context, "dropped 2 triangles without area"));
  EXPECT_TRUE(has_notice(context, "dropped 2 duplicate triangles"));
}

TEST(Stitch, KeepsColours) {
  RunContext context;
  const std::array<Color, 6> palette = {Color(1, 0, 0), Color(0, 1, 0), Color(0, 0, 1),
                                        Color(1, 1, 0), Color(0, 1, 1), Color(1, 0, 1)};
  std::vector<TriangleSoup> by_triangle = faces(0.01, [](int face) { return face == 2 ? 3 : 1; });
  std::vector<TriangleSoup> by_vertex = by_triangle;
  for (std::size_t f = 0; f < 6; ++f) {
    by_triangle[f].triangle_colors.assign(by_triangle[f].triangles.size(), palette[f]);
    by_vertex[f].vertex_colors.assign(by_vertex[f].positions.size(), palette[f]);
  }
  // Colours at the vertices cannot stay where six faces share them, so they move to the triangles.
  for (const TriangleSoup& soup : {joined(by_triangle), joined(by_vertex)}) {
    const TriangleSoup result = stitch(soup, {.tolerance = 0.02}, context);
    ASSERT_EQ(result.triangle_colors.size(), result.triangles.size());
    for (std::size_t t = 0; t < result.triangles.size(); ++t) {
      Eigen::Index axis = 0;
      const Point normal = area_vector(result, result.triangles[t]);
      normal.cwiseAbs().maxCoeff(&axis);
      const Color& expected = palette.at(static_cast<std::size_t>(2 * axis + (normal[axis] > 0 ? 1 : 0)));
      EXPECT_LT((result.triangle_colors[t] - expected).norm(), 1e-6F);
    }
  }
  EXPECT_TRUE(has_notice(context, "different colours"));
  // Where merged vertices agree, they keep their colours, and a filled face takes its neighbours'.
  TriangleSoup smooth = cracked_cube(0);
  for (const Point& p : smooth.positions) smooth.vertex_colors.push_back(p.cast<float>());
  const TriangleSoup result = stitch(smooth, {}, context);
  EXPECT_TRUE(result.triangle_colors.empty());
  ASSERT_EQ(result.vertex_colors.size(), result.positions.size());
  for (std::size_t v = 0; v < result.positions.size(); ++v)
    EXPECT_EQ(result.vertex_colors[v], result.positions[v].cast<float>());
  std::vector<TriangleSoup> open = faces(0, [](int) { return 1; });
  open.pop_back();
  const TriangleSoup filled = stitch(colored(joined(open), palette[4]), {}, context);
  EXPECT_EQ(filled.triangle_colors, std::vector<Color>(12, palette[4]));
}

TEST(Stitch, WorksAtEverySizeAndPlace) {
  for (const double scale : {1e-300, 1e-12, 1.0, 1e12, 1e300}) {
    RunContext context;
    TriangleSoup soup = cracked_cube(0.01);
    for (Point& p : soup.positions) p *= scale;
    const TriangleSoup result = stitch(soup, {.tolerance = 0.02 * scale}, context);
    EXPECT_EQ(closed_topology(result).genus, 0) << scale;
    EXPECT_EQ(result.positions.size(), 8U) << scale;
  }
  RunContext context;
  const TriangleSoup far = stitch(translated(cracked_cube(0.01), Point::Constant(1e9)), {.tolerance = 0.02}, context);
  EXPECT_EQ(closed_topology(far).genus, 0);
  EXPECT_EQ(far.positions.size(), 8U);
}

TEST(Stitch, GivesTheSameTwice) {
  TriangleSoup soup = joined(faces(0.004, [](int face) { return 2 + 3 * face; }));
  soup = joined({soup, translated(soup, Point(0.5, 0.5, 0.003))});
  RunContext one;
  RunContext two;
  two.threads = 2;
  EXPECT_EQ(stitch(soup, {.tolerance = 0.01}, one), stitch(soup, {.tolerance = 0.01}, two));
  EXPECT_EQ(one.notices(), two.notices());
}

TEST(Stitch, SurvivesRandomSoups) {
  // Few vertices and many triangles: edges of many triangles, one-sided parts, holes of every form.
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    RunContext context;
    std::mt19937_64 generator(seed);
    TriangleSoup soup;
    const std::uint32_t vertices = 4 + static_cast<std::uint32_t>(generator() % 12);
    for (std::uint32_t v = 0; v < vertices; ++v) {
      const auto number = [&] { return static_cast<double>(generator() % (seed % 2 == 0 ? 3 : 1000)); };
      const double x = number();
      const double y = number();
      soup.positions.emplace_back(x, y, number());
    }
    const auto any = [&] { return static_cast<std::uint32_t>(generator() % vertices); };
    const std::size_t triangles = 1 + generator() % 40;
    for (std::size_t t = 0; t < triangles; ++t) {
      const std::uint32_t a = any();
      const std::uint32_t b = any();
      soup.triangles.push_back({a, b, any()});
    }
    const double tolerance = seed % 3 == 0 ? 0 : seed % 3 == 1 ? 0.5 : 200;
    const TriangleSoup result = stitch(soup, {.tolerance = tolerance}, context);
    closed_topology(result);
    if (HasFailure()) FAIL() << "seed " << seed;
  }
}

TEST(Stitch, IsCancelledAndDeclaresItsMemory) {
  RunContext context;
  context.memory_budget = 100;
  EXPECT_THROW(stitch(unit_cube(), {}, context), ResourceError);
  std::stop_source source;
  RunContext stopped;
  stopped.cancellation = source.get_token();
  source.request_stop();
  EXPECT_THROW(stitch(unit_cube(), {}, stopped), Cancelled);
}

TEST(Stitch, DeclaresTheMemoryOfAllPairsOfNearVertices) {
  // 300 loose triangles within the tolerance of each other: 900 vertices, all but those of one triangle paired, are
  // 900 * 897 / 2 = 403,650 pairs. Of 24 bytes at least each, they exceed what the triangles alone are allowed.
  std::mt19937_64 generator(7);
  const auto number = [&generator] { return static_cast<double>(generator() >> 11) * 0x1p-53; };
  TriangleSoup soup;
  for (std::uint32_t t = 0; t < 300; ++t) {
    for (int corner = 0; corner < 3; ++corner) {
      const double x = number();
      const double y = number();
      soup.positions.emplace_back(x, y, number());
    }
    soup.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
  }
  RunContext context;
  context.memory_budget = 300 * 600 + 403650 * 24;
  EXPECT_THROW(stitch(soup, {.tolerance = 2}, context), ResourceError);
  RunContext enough;
  closed_topology(stitch(soup, {.tolerance = 2}, enough));
  ASSERT_FALSE(enough.timings().empty());
  const auto stitching =
      std::ranges::find_if(enough.timings(), [](const StageTiming& timing) { return timing.stage == "stitching"; });
  ASSERT_NE(stitching, enough.timings().end());
  EXPECT_GE(stitching->bytes, context.memory_budget);
}

TEST(Stitch, ClosesTheExternalModels) {
  VOXCARVE_REQUIRE_DATA(folder, "nasty");
  int closed = 0;
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) files.push_back(entry.path());
  for (const char* name : {"chair_gothic.obj", "office_chair.obj", "teapot.obj", "motor.obj", "csg_featuretype.ply"})
    files.push_back(folder.parent_path() / name);
  for (const auto& file : files) {
    SCOPED_TRACE(file.filename().string());
    TriangleSoup soup;
    try {
      soup = read_mesh(file);
    } catch (const InputError&) {
      continue;  // files that no reader takes are there too
    }
    RunContext context;
    const TriangleSoup result = stitch(soup, {.tolerance = 0.002 * bounds(soup).diagonal()}, context);
    closed_topology(result);
    ++closed;
  }
  EXPECT_GE(closed, 15);
}

TEST(Glue, CountsCopiesWhateverElseIsUnused) {
  // Few vertices and many triangles, so that edges are crowded and neighbours disagree. Vertices that no triangle uses
  // change neither the result nor the count.
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    RunContext context;
    std::mt19937_64 generator(seed);
    TriangleSoup soup;
    const std::uint32_t vertices = 4 + static_cast<std::uint32_t>(generator() % 6);
    const auto below = [&generator](std::uint32_t end) { return static_cast<std::uint32_t>(generator() % end); };
    for (std::uint32_t v = 0; v < vertices; ++v) {
      const double x = below(1000);
      const double y = below(1000);
      soup.positions.emplace_back(x, y, below(1000));
    }
    for (std::uint32_t t = 4 + below(24); t > 0; --t) {
      const std::uint32_t a = below(vertices);
      const std::uint32_t b = below(vertices);
      const Triangle triangle = {a, b, below(vertices)};
      if (has_distinct_corners(triangle)) soup.triangles.push_back(triangle);
    }
    remove_unused_vertices(soup);
    orient(soup, context);
    TriangleSoup more = soup;
    for (int i = 0; i < 5; ++i) more.positions.emplace_back(2000, 2000, i);
    const GlueReport expected = glue_to_manifold(soup, context);
    EXPECT_EQ(glue_to_manifold(more, context).copied_vertices, expected.copied_vertices) << seed;
    EXPECT_EQ(more, soup) << seed;
  }
}

TEST(Orient, KeepsPatchesThatAgree) {
  RunContext context;
  TriangleSoup cube = inside_out(unit_cube());
  const TriangleSoup before = cube;
  EXPECT_EQ(orient(cube, context).turned, 0);
  EXPECT_EQ(cube, before);
}

}  // namespace
}  // namespace voxcarve
