// TetGen in its child: what it promises of its results, on exact predicates.
#include "methods/hagbi_elsana/tetgen_child.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "common/mesh/io/mesh_io.h"
#include "common/mesh/models/primitives.h"
#include "tests/support/shapes.h"
#include "tests/support/tetgen_runs.h"
#include "tests/unit/child_test.h"

namespace voxcarve {
namespace {

using test::joined;
using test::tetrahedralized;
using test::unit_tetrahedron;
using Kind = TetgenFailure::Kind;

CGAL::Orientation exact_orientation(const Point& a, const Point& b, const Point& c, const Point& d) {
  using P = CGAL::Exact_predicates_inexact_constructions_kernel::Point_3;
  return CGAL::orientation(P(a[0], a[1], a[2]), P(b[0], b[1], b[2]), P(c[0], c[1], c[2]), P(d[0], d[1], d[2]));
}

Triangle sorted(Triangle t) {
  std::ranges::sort(t);
  return t;
}

/// The corners but the i-th.
Triangle face(const std::array<std::uint32_t, 4>& cell, std::size_t i) {
  Triangle t{};
  std::size_t k = 0;
  for (std::size_t j = 0; j < 4; ++j) {
    if (j != i) t.at(k++) = cell.at(j);
  }
  return sorted(t);
}

/// Cell and corner of the cell that is across face i; nothing beyond the hull.
using Owners = std::map<Triangle, std::vector<std::pair<std::size_t, std::size_t>>>;

Owners owners_of_faces(const Tetrahedralization& result) {
  Owners owners;
  for (std::size_t t = 0; t < result.tetrahedra.size(); ++t) {
    for (std::size_t i = 0; i < 4; ++i) owners[face(result.tetrahedra[t], i)].emplace_back(t, i);
  }
  return owners;
}

double volume_of(const Tetrahedralization& result) {
  double six_volumes = 0;
  for (const auto& [a, b, c, d] : result.tetrahedra) {
    const Point origin = result.points[a];
    six_volumes += (result.points[b] - origin).cross(result.points[c] - origin).dot(result.points[d] - origin);
  }
  return six_volumes / 6;
}

std::uint32_t first_equal_used(const TriangleSoup& complex, std::uint32_t vertex) {
  std::uint32_t first = vertex;
  for (const Triangle& t : complex.triangles) {
    for (const std::uint32_t v : t) {
      if (v < first && complex.positions[v] == complex.positions[vertex]) first = v;
    }
  }
  return first;
}

/// Points are the complex's bits; cells are positive, fit together and fill a convex body that holds all points.
void expect_tetrahedralizes(const TriangleSoup& complex, const Tetrahedralization& result) {
  ASSERT_EQ(result.points.size(), complex.positions.size() + result.steiner_points);
  for (std::size_t i = 0; i < complex.positions.size(); ++i) ASSERT_EQ(result.points[i], complex.positions[i]);
  ASSERT_EQ(result.neighbors.size(), result.tetrahedra.size());

  std::set<std::uint32_t> used;
  for (const auto& cell : result.tetrahedra) {
    const auto [a, b, c, d] = cell;
    used.insert(cell.begin(), cell.end());
    ASSERT_EQ(exact_orientation(result.points[a], result.points[b], result.points[c], result.points[d]),
              CGAL::POSITIVE);
  }
  for (std::size_t i = complex.positions.size(); i < result.points.size(); ++i) {
    EXPECT_TRUE(used.contains(static_cast<std::uint32_t>(i))) << "Steiner point " << i;
  }
  std::size_t hull_faces = 0;
  for (const auto& [corners, cells] : owners_of_faces(result)) {
    ASSERT_LE(cells.size(), 2U);
    const auto [t, i] = cells.front();
    const std::int32_t neighbor = result.neighbors[t].at(i);
    if (cells.size() == 2) {
      const auto [u, j] = cells.back();
      ASSERT_EQ(neighbor, static_cast<std::int32_t>(u));
      ASSERT_EQ(result.neighbors[u].at(j), static_cast<std::int32_t>(t));
      continue;
    }
    ASSERT_EQ(neighbor, -1);
    ++hull_faces;
    if (complex.positions.size() > 3000) continue;
    // No point lies on the other side of a hull face than the corner opposite to it.
    const auto side = [&](std::uint32_t v) {
      return exact_orientation(result.points[corners[0]], result.points[corners[1]], result.points[corners[2]],
                               result.points[v]);
    };
    const CGAL::Orientation inside = side(result.tetrahedra[t].at(i));
    for (const std::uint32_t v : used) ASSERT_NE(side(v), -inside);
  }
  EXPECT_GE(hull_faces, 4U);
  for (const Triangle& t : complex.triangles) {
    if (complex.positions.size() > 3000) break;
    for (const std::uint32_t v : t) EXPECT_TRUE(used.contains(first_equal_used(complex, v)));
  }
}

/// Each triangle is exactly one facet, as it stands in the complex, and a face of the cells.
void expect_whole_facets(const TriangleSoup& complex, const Tetrahedralization& result) {
  ASSERT_EQ(result.facets.size(), complex.triangles.size());
  const Owners owners = owners_of_faces(result);
  for (std::uint32_t f = 0; f < result.facets.size(); ++f) {
    EXPECT_EQ(result.facet_source[f], f);
    EXPECT_EQ(result.facets[f], complex.triangles[f]);
    EXPECT_TRUE(owners.contains(sorted(result.facets[f])));
  }
}

/// The tetrahedralization of a complex, with all of that looked at.
Tetrahedralization whole_tetrahedralization(const TriangleSoup& complex) {
  Tetrahedralization result = tetrahedralized(complex);
  expect_tetrahedralizes(complex, result);
  expect_whole_facets(complex, result);
  return result;
}

/// The Schoenhardt prism: the top of a triangular prism turned by 30 degrees, the diagonals of its sides reflex. It
/// cannot be tetrahedralized without a further point.
TriangleSoup schoenhardt_prism() {
  TriangleSoup soup;
  for (int k = 0; k < 6; ++k) {
    const double angle = std::numbers::pi * (k % 3 * 2.0 / 3 + (k < 3 ? 0 : 1.0 / 6));
    soup.positions.emplace_back(std::cos(angle), std::sin(angle), k < 3 ? 0 : 1);
  }
  soup.triangles = {{0, 2, 1}, {3, 4, 5}};
  for (std::uint32_t k = 0; k < 3; ++k) {
    const std::uint32_t next = (k + 1) % 3;
    // The turn moves top vertex k towards bottom vertex k + 1, so the diagonal from k to top k + 1 is the longer one.
    soup.triangles.push_back({k, next, next + 3});
    soup.triangles.push_back({k, next + 3, k + 3});
  }
  return soup;
}

class TetgenChild : public test::ChildTest {};

TEST_F(TetgenChild, ATetrahedronIsOneTetrahedron) {
  const TriangleSoup complex = unit_tetrahedron();
  const Tetrahedralization result = whole_tetrahedralization(complex);
  EXPECT_EQ(result.tetrahedra.size(), 1U);
  EXPECT_EQ(result.steiner_points, 0U);
  EXPECT_EQ(result.neighbors.front(), (std::array<std::int32_t, 4>{-1, -1, -1, -1}));
  EXPECT_GT(result.peak_bytes, 0U);
  EXPECT_GT(result.seconds, 0);
}

TEST_F(TetgenChild, ACubeAndNestedCubes) {
  const TriangleSoup cube = box(Point(0, 0, 0), Point(1, 1, 1));
  const Tetrahedralization single = whole_tetrahedralization(cube);
  EXPECT_NEAR(volume_of(single), 1, 1e-14);

  const TriangleSoup nested = joined({box(Point(0, 0, 0), Point(3, 3, 3)), box(Point(1, 1, 1), Point(2, 2, 2))});
  const Tetrahedralization both = whole_tetrahedralization(nested);
  EXPECT_NEAR(volume_of(both), 27, 1e-12);
}

TEST_F(TetgenChild, HullFacesThatAreNotTheModelsAreNoFacets) {
  // The hull of two unit cubes, two apart along x, is a box of 3 x 1 x 1.
  const TriangleSoup complex = joined({box(Point(0, 0, 0), Point(1, 1, 1)), box(Point(2, 0, 0), Point(3, 1, 1))});
  const Tetrahedralization result = whole_tetrahedralization(complex);
  EXPECT_NEAR(volume_of(result), 3, 1e-13);
}

TEST_F(TetgenChild, SteinerPointsKeepTrianglesWhole) {
  const TriangleSoup complex = schoenhardt_prism();
  const Tetrahedralization result = whole_tetrahedralization(complex);
  EXPECT_GE(result.steiner_points, 1U);
}

TEST_F(TetgenChild, SplitFacetsTileTheirSources) {
  // Delaunay spheres about the box's long edges hold vertices of the small box, so the edges must be split.
  const TriangleSoup complex =
      joined({box(Point(0, 0, 0), Point(16, 1, 1)), box(Point(8, -0.25, 0.25), Point(8.25, -0.125, 0.5))});
  const Tetrahedralization result = tetrahedralized(complex, FacetSplitting::kAllowed);
  expect_tetrahedralizes(complex, result);
  EXPECT_GT(result.facets.size(), complex.triangles.size());
  EXPECT_TRUE(std::ranges::is_sorted(result.facet_source));
  const Owners owners = owners_of_faces(result);
  std::vector<Point> areas(complex.triangles.size(), Point::Zero());
  for (std::size_t f = 0; f < result.facets.size(); ++f) {
    const auto [a, b, c] = result.facets[f];
    EXPECT_TRUE(owners.contains(sorted(result.facets[f])));
    const Point area = (result.points[b] - result.points[a]).cross(result.points[c] - result.points[a]);
    EXPECT_GT(area.dot(area_vector(complex, complex.triangles[result.facet_source[f]])), 0);
    areas[result.facet_source[f]] += area;
  }
  for (std::size_t s = 0; s < areas.size(); ++s) {
    const Point whole = area_vector(complex, complex.triangles[s]);
    EXPECT_LT((areas[s] - whole).norm(), 1e-12 * whole.norm());
  }
}

TEST_F(TetgenChild, UnusedPointsKeepTheirPlace) {
  TriangleSoup complex = unit_tetrahedron();
  // An unused point in front, one far away in the middle, one at the end.
  complex.positions.insert(complex.positions.begin() + 2, Point(9, 9, 9));
  complex.positions.insert(complex.positions.begin(), Point(0.25, 0.25, 0.25));
  complex.positions.emplace_back(-5, 0, 0);
  for (Triangle& t : complex.triangles) {
    for (std::uint32_t& v : t) v += v < 2 ? 1 : 2;
  }
  const Tetrahedralization result = whole_tetrahedralization(complex);
  EXPECT_EQ(result.tetrahedra.size(), 1U);
}

TEST_F(TetgenChild, EqualPointsAreOneAndEqualTrianglesToo) {
  TriangleSoup soup = unit_tetrahedron();
  TriangleSoup complex;  // every triangle with three points of its own; 0 and -0 are the same place
  for (const Triangle& t : soup.triangles) {
    const auto first = static_cast<std::uint32_t>(complex.positions.size());
    for (const std::uint32_t v : t) complex.positions.push_back(soup.positions[v]);
    complex.triangles.push_back({first, first + 1, first + 2});
  }
  complex.positions[3] = Point(-0.0, 0, 0);
  complex.triangles.push_back({11, 10, 9});  // the last triangle again, turned round
  const Tetrahedralization result = tetrahedralized(complex);
  expect_tetrahedralizes(complex, result);
  EXPECT_EQ(result.tetrahedra.size(), 1U);
  EXPECT_EQ(result.facet_source, (std::vector<std::uint32_t>{0, 1, 2, 3}));
  // Positions in order: 0:A 1:C 2:B, 3:A 4:B 5:D, 6:B 7:C 8:D, 9:C 10:A 11:D.
  EXPECT_EQ(result.facets, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 5}, {2, 1, 5}, {1, 0, 5}}));
  EXPECT_TRUE(std::signbit(result.points[3][0]));
}

TEST_F(TetgenChild, CoordinatesOfAnySize) {
  const TriangleSoup unit = joined({icosphere(Point(0.5, 0.25, 0), 1, 2), icosphere(Point(3, 0, 0), 0.5, 1)});
  for (const double scale : {1e12, 1e-12, 1e150, 1e-150}) {
    SCOPED_TRACE(scale);
    TriangleSoup complex = unit;
    for (Point& p : complex.positions) p *= scale;
    whole_tetrahedralization(complex);
  }
}

TEST_F(TetgenChild, PowersOfTwoChangeNothingElse) {
  const TriangleSoup unit = schoenhardt_prism();
  const Tetrahedralization expected = tetrahedralized(unit);
  for (const int exponent : {-60, 1, 45}) {
    TriangleSoup complex = unit;
    for (Point& p : complex.positions) p *= std::ldexp(1, exponent);
    const Tetrahedralization result = tetrahedralized(complex);
    EXPECT_EQ(result.tetrahedra, expected.tetrahedra);
    EXPECT_EQ(result.neighbors, expected.neighbors);
    ASSERT_EQ(result.points.size(), expected.points.size());
    for (std::size_t i = 0; i < result.points.size(); ++i) {
      EXPECT_EQ(result.points[i], Point(expected.points[i] * std::ldexp(1, exponent)));
    }
  }
}

TEST_F(TetgenChild, SameInputSameResult) {
  const TriangleSoup complex = joined({torus(2, 0.5, 24, 12), icosphere(Point::Zero(), 0.75, 2)});
  for (const FacetSplitting splitting : {FacetSplitting::kNone, FacetSplitting::kAllowed}) {
    const Tetrahedralization one = tetrahedralized(complex, splitting);
    RunContext context;
    context.threads = 4;
    const Tetrahedralization two = tetrahedralize(complex, splitting, {}, context);
    expect_tetrahedralizes(complex, one);
    EXPECT_EQ(one.points, two.points);
    EXPECT_EQ(one.tetrahedra, two.tetrahedra);
    EXPECT_EQ(one.neighbors, two.neighbors);
    EXPECT_EQ(one.facets, two.facets);
    EXPECT_EQ(one.facet_source, two.facet_source);
  }
}

TEST_F(TetgenChild, TheLeastVolumeThereIsIsNotFlat) {
  TriangleSoup square;
  square.positions = {{0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, std::nextafter(1.0, 2.0)}};
  square.triangles = {{0, 1, 2}, {0, 2, 3}};
  try {
    expect_tetrahedralizes(square, tetrahedralized(square));
  } catch (const TetgenFailure& failure) {
    EXPECT_NE(failure.kind(), Kind::kFlat) << failure.what();
  }
}

TEST_F(TetgenChild, PointsTooCloseToTellApartAreNeverMergedSilently) {
  // Two tetrahedra whose tips are 1e-11 apart: either both points are in use, or there is a failure.
  TriangleSoup other = unit_tetrahedron();
  for (Point& p : other.positions) p = Point(-p[0] - 1e-11, -p[1], -p[2]);
  const TriangleSoup complex = joined({unit_tetrahedron(), test::inside_out(other)});
  for (const FacetSplitting splitting : {FacetSplitting::kNone, FacetSplitting::kAllowed}) {
    try {
      const Tetrahedralization result = tetrahedralized(complex, splitting);
      expect_tetrahedralizes(complex, result);
    } catch (const TetgenFailure& failure) {
      EXPECT_EQ(failure.kind(), Kind::kRefused) << failure.what();
    }
  }
}

TEST_F(TetgenChild, RealModels) {
  int seen = 0;
  for (const char* name : {"bunny_base_holes.ply", "csg_featuretype.ply", "csg_plate_holes.stl"}) {
    const auto path = test::data_file(name);
    if (!path) continue;
    SCOPED_TRACE(name);
    ++seen;
    TriangleSoup complex = merge_equal_positions(read_mesh(*path));
    std::erase_if(complex.triangles, [&](const Triangle& t) { return is_degenerate(complex, t); });
    const Tetrahedralization result = whole_tetrahedralization(complex);
    RecordProperty(name, std::to_string(result.peak_bytes));
  }
  if (seen == 0) GTEST_SKIP() << "needs models in the folder VOXCARVE_DATA";
}

}  // namespace
}  // namespace voxcarve
