#include "common/mesh/arrangement.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <random>

#include "common/mesh/aabb_tree.h"
#include "common/mesh/io/mesh_io.h"
#include "common/mesh/triangle_crossings.h"
#include "common/run/errors.h"
#include "tests/support/shapes.h"
#include "tests/unit/arrangement_checks.h"
#include "tests/unit/metric_shapes.h"

namespace voxcarve {
namespace {

using test::flaw;
using test::flipped;
using test::joined;
using test::lattice_soup;
using test::make_box;
using test::translated;
using test::unit_cube;
using test::winding_number;

Arrangement arranged(const TriangleSoup& soup, int threads = 1) {
  RunContext context;
  context.threads = threads;
  return arrange(soup, context);
}

TriangleSoup triangles(std::vector<Point> corners) {
  TriangleSoup soup;
  soup.positions = std::move(corners);
  for (std::uint32_t i = 0; i + 2 < soup.positions.size(); i += 3) soup.triangles.push_back({i, i + 1, i + 2});
  return soup;
}

/// The winding number of the soup at random points in and around its box, but those nearer than `distance`. `samples`
/// points are compared, in units of whole windings to 1e-9: some thousand terms of 1e-16 relative error each, divided
/// by the relative distance.
void expect_same_winding(const TriangleSoup& soup, const Arrangement& a, int samples, std::uint64_t seed) {
  const Box box = bounds(soup);
  const AabbTree tree(soup);
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> share(-0.2, 1.2);
  const double distance = 1e-3 * box.diagonal();
  for (int compared = 0; compared < samples;) {
    const Point p = box.lower + Point(share(random), share(random), share(random)).cwiseProduct(box.extent()) +
                    Point(share(random), share(random), share(random)) * (0.01 * box.diagonal());
    if (tree.nearest(p).squared_distance < distance * distance) continue;
    ++compared;
    ASSERT_NEAR(winding_number(soup, p), winding_number(a, p), 1e-9) << p.transpose();
  }
}

/// Random points of each are on the other, up to `tolerance`; but collinear triangles are not part of a surface.
void expect_same_surface(const TriangleSoup& soup, const Arrangement& a, double tolerance, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> share(0, 1);
  const auto expect_inside = [&](const TriangleSoup& part, const TriangleSoup& whole) {
    const AabbTree tree(whole);
    for (std::size_t t = 0; t < part.triangles.size(); ++t) {
      const auto c = test::corners_of(part, t);
      if (test::exactly_collinear(c)) continue;
      for (int k = 0; k < 3; ++k) {
        const double s = share(random);
        const double r = share(random) * (1 - s);
        const Point p = c[0] + s * (c[1] - c[0]) + r * (c[2] - c[0]);
        ASSERT_LE(tree.nearest(p).squared_distance, tolerance * tolerance) << "triangle " << t;
      }
    }
  };
  expect_inside(soup, a.complex);
  expect_inside(a.complex, soup);
}

/// How many triangles have each multiplicity.
std::map<int, int> count_multiplicities(const Arrangement& a) {
  std::map<int, int> counts;
  for (const int m : a.multiplicity) ++counts[m];
  return counts;
}

double area_of_multiplicity(const Arrangement& a, int multiplicity) {
  double area = 0;
  for (std::size_t t = 0; t < a.complex.triangles.size(); ++t)
    if (a.multiplicity[t] == multiplicity) area += area_vector(a.complex, a.complex.triangles[t]).norm() / 2;
  return area;
}

TEST(Arrange, TwoTrianglesThatCross) {
  // The second goes through z = 0 along y = 0 from x = 1 to x = 3; the first has y = 0 from x = 0 to x = 4. So the
  // first has a slit inside, from (1,0,0) to (3,0,0); the second is cut from side to side.
  const TriangleSoup soup = triangles({{0, -1, 0}, {4, 0, 0}, {0, 1, 0}, {2, 0, 1}, {0, 0, -1}, {4, 0, -1}});
  const Arrangement a = arranged(soup);
  EXPECT_EQ(flaw(a), std::nullopt);
  EXPECT_EQ(a.report.crossing_pairs, 1);
  EXPECT_EQ(a.report.split_triangles, 2);
  EXPECT_EQ(a.report.new_vertices, 2);
  EXPECT_EQ(a.report.passes, 1);
  EXPECT_EQ(a.complex.positions.size(), 8U);
  for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(a.complex.positions[i], soup.positions[i]);
  // A triangle with two vertices inside has 5 parts (Euler: 3 + 2 * inner - 2 = 5), one with a vertex on two sides 3.
  EXPECT_EQ(std::count(a.source.begin(), a.source.end(), 0U), 5);
  EXPECT_EQ(std::count(a.source.begin(), a.source.end(), 1U), 3);
  EXPECT_EQ(count_multiplicities(a), (std::map<int, int>{{1, 8}}));
  expect_same_winding(soup, a, 50, 1);
  for (std::size_t t = 0; t < a.source.size(); ++t) {  // parts are oriented like their source
    EXPECT_GT(area_vector(a.complex, a.complex.triangles[t]).dot(area_vector(soup, soup.triangles[a.source[t]])), 0);
  }
}

TEST(Arrange, InterpenetratingCubes) {
  const TriangleSoup soup = joined(unit_cube(), translated(unit_cube(), Point(0.5, 0.25, 0.375)));
  const Arrangement a = arranged(soup);
  EXPECT_EQ(flaw(a), std::nullopt);
  expect_same_winding(soup, a, 100, 2);
  expect_same_surface(soup, a, 1e-14, 2);
  EXPECT_NEAR(winding_number(a, Point(0.75, 0.6, 0.7)), 2, 1e-12);
  EXPECT_EQ(count_multiplicities(a).size(), 1U);
  EXPECT_NEAR(area_of_multiplicity(a, 1), 12, 1e-12);
}

TEST(Arrange, CubesThatShareAPartOfAFace) {
  // At x = 1 the faces overlap in 0.5 x 0.75, with opposite orientations. Of their areas, 1 each, the rest remains.
  const TriangleSoup soup = joined(unit_cube(), translated(unit_cube(), Point(1, 0.5, 0.25)));
  const Arrangement a = arranged(soup);
  EXPECT_EQ(flaw(a), std::nullopt);
  EXPECT_NEAR(area_of_multiplicity(a, 0), 0.375, 1e-15);
  EXPECT_NEAR(area_of_multiplicity(a, 1), 12 - 2 * 0.375, 1e-13);
  EXPECT_EQ(count_multiplicities(a).size(), 2U);
  EXPECT_EQ(a.report.rounding_pairs, 0);
  expect_same_winding(soup, a, 100, 3);
}

TEST(Arrange, CoplanarTrianglesAddUp) {
  // Right triangles with legs 2; the second is shifted by 1 along x. They overlap in a triangle with legs 1: area 1/2.
  const TriangleSoup one = triangles({{0, 0, 0}, {2, 0, 0}, {0, 2, 0}});
  const TriangleSoup shifted = translated(one, Point(1, 0, 0));
  const Arrangement same = arranged(joined(one, shifted));
  EXPECT_EQ(flaw(same), std::nullopt);
  EXPECT_EQ(area_of_multiplicity(same, 2), 0.5);
  EXPECT_EQ(area_of_multiplicity(same, 1), 3);
  const Arrangement opposite = arranged(joined(one, flipped(shifted)));
  EXPECT_EQ(flaw(opposite), std::nullopt);
  EXPECT_EQ(area_of_multiplicity(opposite, 0), 0.5);
  EXPECT_EQ(area_of_multiplicity(opposite, 1), 3);
  for (std::size_t t = 0; t < opposite.source.size(); ++t) {
    const double up = area_vector(opposite.complex, opposite.complex.triangles[t])[2];
    EXPECT_EQ(up > 0, opposite.source[t] == 0);  // what both cover is a part of the first
  }
}

TEST(Arrange, DuplicatesCountWithTheirOrientation) {
  const TriangleSoup cube = unit_cube();
  const Arrangement twice = arranged(joined(cube, cube));
  EXPECT_EQ(twice.complex, cube);
  EXPECT_EQ(twice.multiplicity, std::vector<std::int32_t>(12, 2));
  EXPECT_EQ(twice.report.duplicate_triangles, 12);
  EXPECT_EQ(twice.report.merged_vertices, 8);
  EXPECT_EQ(twice.report.passes, 0);
  const Arrangement fold = arranged(joined(cube, flipped(cube)));
  EXPECT_EQ(fold.complex, cube);
  EXPECT_EQ(fold.multiplicity, std::vector<std::int32_t>(12, 0));
  // Two turned ones outweigh one: the triangle that stays is the first, so its multiplicity is 1 - 2.
  EXPECT_EQ(arranged(joined(joined(cube, flipped(cube)), flipped(cube))).multiplicity,
            std::vector<std::int32_t>(12, -1));
}

TEST(Arrange, TJointsAndSliversAreCut) {
  // The middle of the first triangle's long side is a vertex of two others.
  const TriangleSoup joint =
      triangles({{0, 0, 0}, {2, 0, 0}, {1, 1, 0}, {0, 0, 0}, {1, -1, 0}, {1, 0, 0}, {1, 0, 0}, {1, -1, 0}, {2, 0, 0}});
  const Arrangement a = arranged(joint);
  EXPECT_EQ(flaw(a), std::nullopt);
  EXPECT_EQ(a.complex.triangles.size(), 4U);
  EXPECT_EQ(a.report.new_vertices, 0);
  EXPECT_EQ(a.report.merged_vertices, 4);
  EXPECT_EQ(a.report.crossing_pairs, 2);
  // With a collinear triangle over the joint the soup is closed by its indices, and the same once it is dropped.
  TriangleSoup sliver = joint;
  sliver.triangles.push_back({0, 5, 1});
  const Arrangement b = arranged(sliver);
  EXPECT_EQ(b.report.degenerate_triangles, 1);
  EXPECT_EQ(b.complex, a.complex);
  // A joint out of the plane: the third triangle touches the side of the first from above.
  const Arrangement c = arranged(triangles({{0, 0, 0}, {2, 0, 0}, {1, 1, 0}, {1, 0, 0}, {1, 0, 1}, {2, 0, 1}}));
  EXPECT_EQ(flaw(c), std::nullopt);
  EXPECT_EQ(c.complex.triangles.size(), 3U);
}

TEST(Arrange, ThreePlanesThroughOnePoint) {
  // Around (1/3, 1/3, 1/3), which is no number of the computer, lines of three planes meet; it is one vertex.
  const double t = 1.0 / 3;
  const TriangleSoup soup = triangles(
      {{t, -3, -3}, {t, 5, -3}, {t, 0, 5}, {-3, t, -3}, {5, t, -3}, {0, t, 5}, {-3, -3, t}, {5, -3, t}, {0, 5, t}});
  const Arrangement a = arranged(soup);
  EXPECT_EQ(flaw(a), std::nullopt);
  EXPECT_EQ(std::count(a.complex.positions.begin(), a.complex.positions.end(), Point(t, t, t)), 1);
  expect_same_winding(soup, a, 50, 4);
}

TEST(Arrange, PlanesOfNoAxisThroughOnePoint) {
  // The edges of both octahedra's mid-sections meet the other's faces in points with denominators 3 and 7.
  TriangleSoup octahedron;
  octahedron.positions = {{7, 0, 0}, {-7, 0, 0}, {0, 7, 0}, {0, -7, 0}, {0, 0, 7}, {0, 0, -7}};
  octahedron.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  TriangleSoup turned = octahedron;
  for (Point& p : turned.positions) p = Point(p[0] + p[1], p[1] - p[0], p[2]) / 7 * 5;
  TriangleSoup third = octahedron;
  for (Point& p : third.positions) p = Point(p[2] + 1, p[0] + p[1], p[1] - p[0]);
  const TriangleSoup soup = joined(joined(octahedron, turned), third);
  const Arrangement a = arranged(soup);
  EXPECT_EQ(flaw(a), std::nullopt);
  expect_same_winding(soup, a, 100, 5);
  EXPECT_NEAR(winding_number(a, Point::Zero()), 3, 1e-9);
}

TEST(Arrange, ACleanMeshStaysAsItIs) {
  const TriangleSoup torus = test::torus(1, 0.4, 48, 24);
  const Arrangement a = arranged(torus);
  EXPECT_EQ(a.complex, torus);
  EXPECT_EQ(a.report.passes, 0);
  EXPECT_EQ(a.report.crossing_pairs + a.report.merged_vertices + a.report.new_vertices, 0);
  EXPECT_EQ(a.multiplicity, std::vector<std::int32_t>(torus.triangles.size(), 1));
  for (std::uint32_t i = 0; i < a.source.size(); ++i) EXPECT_EQ(a.source[i], i);
  // Colours and unused vertices go; their absence changes no index of the others.
  TriangleSoup extra = torus;
  extra.positions.emplace_back(9, 9, 9);
  extra.vertex_colors.assign(extra.positions.size(), Color::Zero());
  EXPECT_EQ(arranged(extra).complex, torus);
}

TEST(Arrange, RandomSoupsOnLattices) {
  for (std::uint64_t seed = 0; seed < test::case_count(std::uint64_t{120}); ++seed) {
    SCOPED_TRACE(seed);
    const int count = 30 + static_cast<int>(seed % 3) * 5;
    const TriangleSoup soup = lattice_soup(count, 3 + static_cast<int>(seed % 3), seed);
    const Arrangement a = arranged(soup);
    ASSERT_EQ(flaw(a), std::nullopt);
    expect_same_winding(soup, a, 10, seed);
    expect_same_surface(soup, a, 1e-14, seed);  // coordinates below 5: units in the last place below 1e-15
  }
}

TEST(Arrange, LargerSoupsOnLattices) {
  for (const int count : {100, 200}) {
    if (count > 100 && test::case_count(10) < 10) continue;  // every pair of parts is checked: long under sanitizers
    SCOPED_TRACE(count);
    const TriangleSoup soup = lattice_soup(count, 4, static_cast<std::uint64_t>(count));
    const Arrangement a = arranged(soup);
    ASSERT_EQ(flaw(a), std::nullopt);
    expect_same_winding(soup, a, 20, 7);
  }
}

TEST(Arrange, RandomSoupsWithoutALattice) {
  // Coordinates with all their bits, so new vertices are nearly all rounded.
  for (std::uint64_t seed = 0; seed < test::case_count(std::uint64_t{20}); ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> share(-1, 1);
    TriangleSoup soup = lattice_soup(40, 2, seed);
    for (Point& p : soup.positions) p = Point(share(random), share(random), share(random));
    const Arrangement a = arranged(soup);
    ASSERT_EQ(flaw(a), std::nullopt);
    expect_same_winding(soup, a, 10, seed);
    expect_same_surface(soup, a, 1e-14, seed);  // coordinates below 1, and the points themselves are rounded
    EXPECT_GT(a.report.new_vertices, 100);
  }
}

TEST(Arrange, NearlyCoplanarFansEnd) {
  // Copies of a grid, each turned by some units in the last place: planes that are nearly the same meet everywhere.
  for (int copies = 2; copies <= 4; ++copies) {
    SCOPED_TRACE(copies);
    TriangleSoup soup;
    for (int k = 0; k < copies; ++k) {
      TriangleSoup sheet = make_box(Point(0.1, 0.2, 0.3), Point(1.1, 0.9, 0.7));
      for (Point& p : sheet.positions) {
        p = Point(p[0] + k * 1.3e-15 * p[1], p[1] - k * 0.7e-15 * p[2], p[2] + k * 2.1e-15 * p[0]);
      }
      soup = k == 0 ? sheet : joined(soup, sheet);
    }
    const Arrangement a = arranged(soup);
    EXPECT_EQ(flaw(a), std::nullopt);
    expect_same_winding(soup, a, 20, 8);
  }
}

TEST(Arrange, ScaleChangesNothing) {
  // Powers of two scale every number exactly: the complex is the same, scaled, down to the last bit.
  const TriangleSoup soup = joined(unit_cube(), translated(test::torus(0.5, 0.25, 12, 8), Point(0.3, 0.7, 0.55)));
  const Arrangement a = arranged(soup);
  ASSERT_EQ(flaw(a), std::nullopt);
  for (const int exponent : {-40, 40, -200, 200}) {
    SCOPED_TRACE(exponent);
    TriangleSoup scaled = soup;
    for (Point& p : scaled.positions) p *= std::ldexp(1.0, exponent);
    Arrangement b = arranged(scaled);
    for (Point& p : b.complex.positions) p *= std::ldexp(1.0, -exponent);
    EXPECT_EQ(b.complex, a.complex);
    EXPECT_EQ(b.multiplicity, a.multiplicity);
  }
  // Powers of ten do not, but the result is a complex there too.
  for (const double scale : {1e-12, 1e12}) {
    TriangleSoup scaled = soup;
    for (Point& p : scaled.positions) p *= scale;
    const Arrangement b = arranged(scaled);
    EXPECT_EQ(flaw(b), std::nullopt);
    EXPECT_EQ(b.complex.triangles.size(), a.complex.triangles.size());
  }
}

TEST(Arrange, FarFromTheOrigin) {
  // A coordinate's last place is worth 1e-10 and 1e-6 of a cube; new vertices fall on few places.
  for (const double offset : {1e6, 1e10}) {
    SCOPED_TRACE(offset);
    const TriangleSoup near = joined(unit_cube(), translated(test::torus(0.5, 0.25, 24, 16), Point(0.3, 0.7, 0.55)));
    const TriangleSoup soup = translated(near, Point::Constant(offset));
    const Arrangement a = arranged(soup);
    EXPECT_EQ(flaw(a), std::nullopt);
    EXPECT_NEAR(winding_number(a, Point(0.3, 0.7, 0.95).array() + offset), 1, 1e-9);   // the cube's alone
    EXPECT_NEAR(winding_number(a, Point(0.7, 0.8, 0.55).array() + offset), 2, 1e-9);   // in both
    EXPECT_NEAR(winding_number(a, Point(-0.2, 0.7, 0.55).array() + offset), 1, 1e-9);  // the torus's alone
    EXPECT_NEAR(winding_number(a, Point(1.5, 0.7, 0.55).array() + offset), 0, 1e-9);
  }
}

TEST(Arrange, TheSameOnAnyNumberOfThreads) {
  for (const int side : {4, 1000}) {
    const TriangleSoup soup = lattice_soup(80, side, 5);
    const Arrangement one = arranged(soup, 1);
    const Arrangement two = arranged(soup, 2);
    EXPECT_EQ(one.complex, two.complex);
    EXPECT_EQ(one.multiplicity, two.multiplicity);
    EXPECT_EQ(one.source, two.source);
  }
}

TEST(Arrange, ArrangingTwiceChangesNothing) {
  const Arrangement once = arranged(lattice_soup(60, 5, 11));
  const Arrangement again = arranged(once.complex);
  EXPECT_EQ(again.complex, once.complex);
  EXPECT_EQ(again.report.crossing_pairs, 0);
}

TEST(Arrange, CancelsAndRefuses) {
  RunContext context;
  EXPECT_THROW(arrange({}, context), InputError);
  std::stop_source stop;
  context.cancellation = stop.get_token();
  int events = 0;
  context.progress = [&](const ProgressEvent& event) {
    if (event.stage == "arrangement" && ++events == 2) stop.request_stop();
  };
  EXPECT_THROW(arrange(lattice_soup(80, 5, 1), context), Cancelled);
  RunContext poor;
  poor.memory_budget = 1000;
  EXPECT_THROW(arrange(unit_cube(), poor), ResourceError);
  // Collinear triangles only: nothing is left, and that is no error.
  EXPECT_TRUE(arranged(triangles({{0, 0, 0}, {1, 1, 1}, {2, 2, 2}})).complex.empty());
}

TEST(ArrangeData, RealModelsBecomeComplexes) {
  const char* folder = std::getenv("VOXCARVE_DATA");
  if (folder == nullptr) GTEST_SKIP() << "VOXCARVE_DATA does not name a folder of models";
  std::vector<std::filesystem::path> paths;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file() && mesh_format(entry.path())) paths.push_back(entry.path());
  }
  std::sort(paths.begin(), paths.end());
  int crossing = 0;
  int unresolved = 0;
  for (const auto& path : paths) {
    SCOPED_TRACE(path.filename().string());
    TriangleSoup soup;
    try {
      soup = read_mesh(path);
    } catch (const InputError&) {  // the folder has files that are no meshes
      continue;
    }
    if (soup.triangles.size() > 70000) continue;
    try {
      const Arrangement a = arranged(soup, 2);
      // Pairs once more, by the fast test, whose twin is compared elsewhere; the slow one takes minutes here.
      RunContext context;
      EXPECT_TRUE(find_crossings(a.complex, context).empty());
      const ArrangementReport& r = a.report;
      crossing += r.crossing_pairs > 0 ? 1 : 0;
      std::printf("%-34s %6zu triangles, %6ld crossings, %ld after rounding, %ld passes, %6ld new vertices\n",
                  path.filename().c_str(), soup.triangles.size(), static_cast<long>(r.crossing_pairs),
                  static_cast<long>(r.rounding_pairs), static_cast<long>(r.passes), static_cast<long>(r.new_vertices));
      if (a.complex.triangles.size() < 20000 && !a.complex.empty()) expect_same_winding(soup, a, 3, 9);
    } catch (const MethodFailure& failure) {
      ++unresolved;
      std::printf("%-34s %s\n", path.filename().c_str(), failure.what());
    }
  }
  EXPECT_GE(crossing, 20);
  EXPECT_LE(unresolved, 0);
}

}  // namespace
}  // namespace voxcarve
