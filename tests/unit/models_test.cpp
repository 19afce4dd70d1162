// The procedural models: closed, oriented, of the stated counts, genus and volume; and the catalogue of external ones.
#include <gmock/gmock-matchers.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <map>
#include <numbers>
#include <numeric>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "common/mesh/models/catalogue.h"
#include "common/mesh/models/primitives.h"
#include "common/mesh/models/procedural.h"
#include "common/run/errors.h"

namespace voxcarve {
namespace {

using std::numbers::pi;
using testing::HasSubstr;

// Relative error of sums of up to a few hundred thousand products of doubles.
constexpr double kRounding = 1e-11;

void expect_relative(double actual, double expected) {
  EXPECT_NEAR(actual, expected, kRounding * std::abs(expected));
}

/// The connected components by shared vertices, each with the vertices that it uses.
std::vector<TriangleSoup> parts_of(const TriangleSoup& soup) {
  std::vector<std::uint32_t> parent(soup.positions.size());
  std::iota(parent.begin(), parent.end(), 0U);
  const auto root = [&](std::uint32_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (const auto& [a, b, c] : soup.triangles) {
    parent[root(b)] = root(a);
    parent[root(c)] = root(a);
  }
  std::map<std::uint32_t, std::vector<std::size_t>> triangles_of;
  for (std::size_t t = 0; t < soup.triangles.size(); ++t) triangles_of[root(soup.triangles[t][0])].push_back(t);
  std::vector<TriangleSoup> parts;
  for (const auto& [name, triangles] : triangles_of) {
    TriangleSoup part;
    std::map<std::uint32_t, std::uint32_t> renamed;
    for (const std::size_t t : triangles) {
      Triangle triangle{};
      for (std::size_t corner = 0; corner < 3; ++corner) {
        const std::uint32_t vertex = soup.triangles[t][corner];
        const auto [entry, added] = renamed.try_emplace(vertex, static_cast<std::uint32_t>(part.positions.size()));
        if (added) part.positions.push_back(soup.positions[vertex]);
        triangle[corner] = entry->second;
      }
      part.triangles.push_back(triangle);
      if (!soup.triangle_colors.empty()) part.triangle_colors.push_back(soup.triangle_colors[t]);
    }
    parts.push_back(std::move(part));
  }
  return parts;
}

using Edge = std::array<std::uint32_t, 2>;

std::vector<Edge> sorted_directed_edges(const TriangleSoup& soup) {
  std::vector<Edge> edges;
  for (const auto& [a, b, c] : soup.triangles) edges.insert(edges.end(), {{a, b}, {b, c}, {c, a}});
  std::ranges::sort(edges);
  return edges;
}

/// True when the triangles about every vertex form a single fan: as many as the fan that starts at one of them.
bool has_single_fans(const TriangleSoup& soup) {
  std::map<Edge, std::uint32_t> opposite;
  std::vector<std::size_t> degree(soup.positions.size(), 0);
  std::vector<Edge> start(soup.positions.size());
  for (const Triangle& t : soup.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      opposite[{t[i], t[(i + 1) % 3]}] = t[(i + 2) % 3];
      ++degree[t[i]];
      start[t[i]] = {t[i], t[(i + 1) % 3]};
    }
  }
  for (std::uint32_t vertex = 0; vertex < soup.positions.size(); ++vertex) {
    std::size_t steps = 0;
    Edge edge = start[vertex];
    do {
      edge[1] = opposite.at(edge);
      ++steps;
    } while (edge != start[vertex] && steps <= degree[vertex]);
    if (steps != degree[vertex]) return false;
  }
  return true;
}

/// Closed, consistently oriented, without degenerate triangles, without unused vertices.
void expect_closed(const TriangleSoup& soup, const std::string& name) {
  SCOPED_TRACE(name);
  validate(soup, name);
  const std::vector<Edge> edges = sorted_directed_edges(soup);
  EXPECT_EQ(std::ranges::adjacent_find(edges), edges.end()) << "a directed edge stands in two triangles";
  std::size_t unmatched = 0;
  for (const Edge& edge : edges) unmatched += std::ranges::binary_search(edges, Edge{edge[1], edge[0]}) ? 0 : 1;
  EXPECT_EQ(unmatched, 0U);
  const auto degenerate = [&](const Triangle& triangle) { return is_degenerate(soup, triangle); };
  EXPECT_EQ(std::ranges::count_if(soup.triangles, degenerate), 0);
  TriangleSoup used = soup;
  remove_unused_vertices(used);
  EXPECT_EQ(used.positions.size(), soup.positions.size());
}

/// Of one closed component: 2 - 2 genus = V - E + F, and E = 3 F / 2.
long genus_of(const TriangleSoup& part) {
  const auto vertices = static_cast<long>(part.positions.size());
  const auto triangles = static_cast<long>(part.triangles.size());
  const long euler = vertices - 3 * triangles / 2 + triangles;
  EXPECT_EQ(euler % 2, 0);
  return (2 - euler) / 2;
}

std::string parameter_error(const std::string& spec) {
  try {
    make_procedural(spec);
  } catch (const ParameterError& error) {
    return error.what();
  }
  return "no ParameterError";
}

double polygon_area(int sides, double circumradius) {
  return sides / 2.0 * circumradius * circumradius * std::sin(2 * pi / sides);
}

// --- building blocks ---------------------------------------------------------------------------------------------

TEST(Primitives, AreClosedOutwardSpheres) {
  // Triangle counts as the header states them.
  const std::vector<Point> bend = {{0, 0, 0}, {0, 0, 1}, {0, 0.5, 2}, {1, 1, 2.5}};
  const std::vector<Eigen::Vector2d> bead = {{1, 0}, {2, 1}, {0, 3}};
  const Eigen::Affine3d mirror(Eigen::Scaling(-1.0, 1.0, 2.0));
  const std::vector<std::pair<TriangleSoup, std::size_t>> solids = {
      {box({0, 0, 0}, {1, 2, 3}), 12},
      {uv_sphere({1, 2, 3}, 2, 7, 5), 2 * 7 * 4},
      {uv_sphere({0, 0, 0}, 1, 3, 2), 6},
      {icosphere({1, 0, 0}, 2, 3), 20 * 64},
      {cylinder({1, 1, 1}, {2, 3, 4}, 0.5, 9), 4 * 8},
      {capsule({0, 0, 0}, 1, {1, 2, 3}, 0.5, 8, 6), 2 * 8 * 5},
      {capsule({0, 0, 0}, 0.2, {0, -3, 0}, 1, 5, 3), 2 * 5 * 2},
      {swept_tube(bend, 0.2, 6), 3 * 12 + 2 * 4},
      {lathe(bead, 5), 5 * 2 + 5 + 3},
      {transformed(uv_sphere({0, 0, 0}, 1, 8, 8), mirror), 2 * 8 * 7},
      {block_surface(
           {1, 2, 1}, [](int, int, int) { return true; }, 1, 3),
       10 * 9 * 2}};
  for (std::size_t i = 0; i < solids.size(); ++i) {
    const auto& [soup, triangles] = solids[i];
    expect_closed(soup, "solid " + std::to_string(i));
    EXPECT_TRUE(has_single_fans(soup)) << i;
    EXPECT_EQ(soup.triangles.size(), triangles) << i;
    EXPECT_EQ(genus_of(soup), 0) << i;
    EXPECT_GT(signed_volume(soup), 0) << i;
  }
}

TEST(Primitives, HaveTheVolumesOfTheirFormulas) {
  expect_relative(signed_volume(box({0, 0, 0}, {1, 2, 3})), 6);
  // Icosahedron of circumradius 1: edge 4 / sqrt(10 + 2 sqrt 5), volume 5 (3 + sqrt 5) / 12 edge^3.
  const double edge = 4 / std::sqrt(10 + 2 * std::sqrt(5.0));
  expect_relative(signed_volume(icosphere({0, 0, 0}, 1, 0)), 5 * (3 + std::sqrt(5.0)) / 12 * edge * edge * edge);
  expect_relative(signed_volume(cylinder({0, 0, 0}, {0, 3, 4}, 2, 6)), polygon_area(6, 2) * 5);
  // Lathe: frusta of pentagons, A h (r0^2 + r0 r1 + r1^2) / 3 with A of radius 1: (1 + 2 + 4) / 3 and 4 * 2 / 3.
  const std::vector<Eigen::Vector2d> bead = {{1, 0}, {2, 1}, {0, 3}};
  expect_relative(signed_volume(lathe(bead, 5)), polygon_area(5, 1) * (7.0 + 8.0) / 3);
  // A straight tube in three pieces is a cylinder.
  const std::vector<Point> straight = {{0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {5, 5, 5}};
  expect_relative(signed_volume(swept_tube(straight, 0.5, 8)), polygon_area(8, 0.5) * 5 * std::sqrt(3.0));
}

TEST(Primitives, SphereAndCapsuleVerticesLieOnTheirBalls) {
  for (const Point& p : uv_sphere({1, 2, 3}, 2, 9, 7).positions) EXPECT_NEAR((p - Point(1, 2, 3)).norm(), 2, 1e-14);
  for (const Point& p : icosphere({0, 0, 0}, 3, 3).positions) EXPECT_NEAR(p.norm(), 3, 1e-14);
  // Three belts: pole, touching circle, touching circle, pole. The tangent cone meets each ball at a right angle, so
  // every vertex has distance 1 or 0.5 of the centre of the ball that it lies on.
  const Point a(0, 0, 0);
  const Point b(3, 0, 0);
  for (const Point& p : capsule(a, 1, b, 0.5, 8, 3).positions) {
    EXPECT_LT(std::min(std::abs((p - a).norm() - 1), std::abs((p - b).norm() - 0.5)), 1e-14);
  }
}

TEST(Primitives, LoftRefusesRingsThatDoNotFit) {
  const Ring triangle = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const Ring square = {{0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  const Ring pole = {{0, 0, 1}};
  using Rings = std::vector<Ring>;
  EXPECT_THROW(loft(Rings{triangle}), InputError);
  EXPECT_THROW(loft(Rings{triangle, square}), InputError);
  EXPECT_THROW(loft(Rings{pole, pole}), InputError);
  EXPECT_THROW(loft(Rings{triangle, pole, triangle}), InputError);
  EXPECT_THROW(loft(Rings{pole, triangle, triangle}, LoftEnds::kJoined), InputError);
  EXPECT_NO_THROW(loft(Rings{triangle, pole}));
  EXPECT_NO_THROW(loft(Rings{pole, triangle}));
  EXPECT_THROW(capsule({0, 0, 0}, 2, {1, 0, 0}, 0.5, 8, 4), InputError);  // one ball holds the other
  EXPECT_THROW(swept_tube(std::vector<Point>{{0, 0, 0}}, 1, 8), InputError);
}

// --- every model -------------------------------------------------------------------------------------------------

class EveryModel : public testing::TestWithParam<std::string> {};

TEST_P(EveryModel, HasClosedOutwardManifoldParts) {
  const TriangleSoup soup = make_procedural(GetParam());
  expect_closed(soup, GetParam());
  EXPECT_TRUE(has_single_fans(soup));
  // No two vertices coincide within a part: shared vertices are shared by index.
  for (const TriangleSoup& part : parts_of(soup)) {
    EXPECT_EQ(merge_equal_positions(part).positions.size(), part.positions.size());
    EXPECT_GT(signed_volume(part), 0);
  }
}

TEST_P(EveryModel, IsTheSameTwice) {
  EXPECT_EQ(make_procedural(GetParam()), make_procedural(GetParam()));
}

TEST_P(EveryModel, HasASchemaWithHelpAndValidDefaults) {
  const ModelInfo& info = find_procedural_model(GetParam()).info;
  EXPECT_FALSE(info.summary.empty());
  for (const ParameterSpec& spec : info.parameters.specs) {
    EXPECT_FALSE(spec.help.empty()) << spec.name;
    EXPECT_FALSE(spec.unit.empty()) << spec.name;
    EXPECT_TRUE(std::isfinite(spec.minimum) && std::isfinite(spec.maximum)) << spec.name;
    const std::string value = to_string(spec.default_value);
    EXPECT_NO_THROW(Parameters::parse(info.parameters, std::vector{spec.name + "=" + value}, info.name)) << spec.name;
  }
}

std::vector<std::string> model_names() {
  std::vector<std::string> names;
  for (const ProceduralModel& model : procedural_models()) names.push_back(model.info.name);
  return names;
}

std::string test_name(const testing::TestParamInfo<std::string>& info) {
  std::string name = info.param;
  std::ranges::replace(name, '-', '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(Procedural, EveryModel, testing::ValuesIn(model_names()), test_name);

TEST(Procedural, ListsTheModelsInOrder) {
  const std::vector<std::string> expected = {
      "chair", "genus-n", "interpenetrating-figure", "perforated-box", "sphereflake", "torus", "two-spheres"};
  EXPECT_EQ(model_names(), expected);
}

// --- one by one --------------------------------------------------------------------------------------------------

TEST(Torus, HasGenusOneAndTheVolumeOfItsWedges) {
  const TriangleSoup soup = make_procedural("torus?major=2&minor=0.5&segments=24&tube_segments=10");
  EXPECT_EQ(soup.triangles.size(), 2U * 24 * 10);
  ASSERT_EQ(parts_of(soup).size(), 1U);
  EXPECT_EQ(genus_of(soup), 1);
  // Each of the 24 wedges: points at distance rho of the axis sweep chords, so the volume is the integral of
  // 2 rho sin(a) cos(a), a = pi / 24, over the section: sin(2 a) times its area times its centroid's distance, 2.
  expect_relative(signed_volume(soup), 24 * std::sin(2 * pi / 24) * polygon_area(10, 0.5) * 2);
}

TEST(GenusN, HasThatGenusAndVolume) {
  for (const int genus : {0, 1, 2, 3, 7, 40}) {
    for (const int subdivision : {1, 2, 5}) {
      const std::string spec = "genus-n?genus=" + std::to_string(genus) + "&subdivision=" + std::to_string(subdivision);
      const TriangleSoup soup = make_procedural(spec);
      expect_closed(soup, spec);
      EXPECT_TRUE(has_single_fans(soup)) << spec;
      ASSERT_EQ(parts_of(soup).size(), 1U) << spec;
      EXPECT_EQ(genus_of(soup), genus) << spec;
      // 3 (2 g + 1) cubes less g; exposed squares: see genus.cpp.
      expect_relative(signed_volume(soup), 5 * genus + 3);
      EXPECT_EQ(soup.triangles.size(), static_cast<std::size_t>(2 * (18 * genus + 14) * subdivision * subdivision));
    }
  }
}

TEST(PerforatedBox, HasOneHundredHoles) {
  const TriangleSoup soup = make_procedural("perforated-box");
  ASSERT_EQ(parts_of(soup).size(), 1U);
  EXPECT_EQ(genus_of(soup), 100);
  // Per hole 2 rings of 4 + 4 and 8 of its wall; 40 outer cell edges with 2 each.
  EXPECT_EQ(soup.triangles.size(), 100U * 24 + 80);
  // 1 x 1 x 0.2, each hole takes (0.5 * 0.1)^2 of the area.
  expect_relative(signed_volume(soup), 0.2 * (1 - 100 * 0.0025));
  // Top and bottom 0.75 each, rim 4 * 0.2, walls 100 * 4 * 0.05 * 0.2: no face overlaps another.
  expect_relative(surface_area(soup), 2 * 0.75 + 0.8 + 4);
}

TEST(PerforatedBox, HolesOfAnyNumberOfSides) {
  for (const int sides : {4, 5, 6, 7, 8, 11, 12, 48}) {
    for (const double width : {0.01, 0.5, 0.8}) {
      const std::string spec = "perforated-box?holes=3&sides=" + std::to_string(sides) +
                               "&thickness=0.5&hole_width=" + to_string(ParameterValue(width));
      const TriangleSoup soup = make_procedural(spec);
      expect_closed(soup, spec);
      EXPECT_TRUE(has_single_fans(soup)) << spec;
      EXPECT_EQ(genus_of(soup), 9) << spec;
      // A regular polygon about a circle of radius w / 2: n (w / 2)^2 tan(pi / n), in units of the pitch, 1 / 3.
      const double hole = sides * (width / 2) * (width / 2) * std::tan(pi / sides) / 9;
      expect_relative(signed_volume(soup), 0.5 * (1 - 9 * hole));
      // All of the top's triangles face up and their areas add up to the top's: they do not overlap.
      double top = 0;
      for (const Triangle& triangle : soup.triangles) {
        const Point normal = area_vector(soup, triangle);
        const bool on_top = std::ranges::all_of(triangle, [&](auto v) { return soup.positions[v].z() == 0.5; });
        if (!on_top) continue;
        EXPECT_GT(normal.z(), 0) << spec;
        top += normal.z() / 2;
      }
      expect_relative(top, 1 - 9 * hole);
    }
  }
}

TEST(TwoSpheres, AreTwoSpheresAtTheirDistance) {
  const TriangleSoup soup = make_procedural("two-spheres?distance=5&radius=2&subdivision=2");
  const std::vector<TriangleSoup> parts = parts_of(soup);
  ASSERT_EQ(parts.size(), 2U);
  for (const TriangleSoup& part : parts) {
    EXPECT_EQ(part.triangles.size(), 320U);
    EXPECT_EQ(genus_of(part), 0);
    expect_relative(signed_volume(part), 8 * signed_volume(icosphere(Point::Zero(), 1, 2)));
  }
  // The icosahedron's vertices nearest to the x axis lie at (+-g, 0, +-1) / sqrt(1 + g^2); its edges' midpoints, which
  // subdivision pushes onto the sphere, at (+-1, 0, 0): so each sphere reaches 2 from its centre along x.
  EXPECT_NEAR(bounds(soup).lower.x(), -4.5, 1e-14);
  EXPECT_NEAR(bounds(soup).upper.x(), 4.5, 1e-14);
}

TEST(Sphereflake, Has820TouchingSpheres) {
  const TriangleSoup soup = make_procedural("sphereflake?subdivision=0");
  const std::vector<TriangleSoup> parts = parts_of(soup);
  ASSERT_EQ(parts.size(), 820U);  // 1 + 9 + 81 + 729
  std::vector<Point> centers;
  std::vector<double> radii;
  for (const TriangleSoup& part : parts) {
    EXPECT_EQ(genus_of(part), 0);
    centers.push_back(std::accumulate(part.positions.begin(), part.positions.end(), Point(Point::Zero())) / 12);
    radii.push_back((part.positions[0] - centers.back()).norm());
  }
  // A third of the radius a generation. Spheres never overlap; each of the 819 children touches its parent, and nothing
  // else touches: siblings' families only meet in the limit of infinite depth.
  std::map<long, int> spheres_of_scale;
  int touching = 0;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    ++spheres_of_scale[std::lround(1 / radii[i])];
    for (std::size_t j = 0; j < i; ++j) {
      const double clearance = (centers[i] - centers[j]).norm() - radii[i] - radii[j];
      EXPECT_GT(clearance, -1e-13);
      touching += clearance < 1e-13 ? 1 : 0;
    }
  }
  EXPECT_EQ(touching, 819);
  EXPECT_EQ(spheres_of_scale, (std::map<long, int>{{1, 1}, {3, 9}, {9, 81}, {27, 729}}));
  // A generation has 9 times the spheres of 1/27 of the volume: 1 + 1/3 + 1/9 + 1/27 = 40/27.
  expect_relative(signed_volume(soup), signed_volume(icosphere(Point::Zero(), 1, 0)) * 40 / 27);
}

TEST(Sphereflake, HasSixChildrenAroundTheEquatorAndThreeAbove) {
  const std::vector<TriangleSoup> parts = parts_of(make_procedural("sphereflake?depth=1&subdivision=0&radius=3"));
  ASSERT_EQ(parts.size(), 10U);
  std::multiset<long> heights;
  for (const TriangleSoup& part : parts) {
    const Point center = std::accumulate(part.positions.begin(), part.positions.end(), Point(Point::Zero())) / 12;
    heights.insert(std::lround(1000 * center.z()));
  }
  // The root and six at height 0; three at 4 sqrt(2/3) = 3.266.
  EXPECT_EQ(heights, (std::multiset<long>{0, 0, 0, 0, 0, 0, 0, 3266, 3266, 3266}));
}

// --- figure ------------------------------------------------------------------------------------------------------

/// Parity of a skew ray's crossings with a closed part.
bool is_inside(const TriangleSoup& part, const Point& point) {
  const Point direction = Point(0.5377, 0.8339, 0.1249).normalized();
  bool inside = false;
  for (const Triangle& t : part.triangles) {
    const Point a = part.positions[t[0]] - point;
    const Point b = part.positions[t[1]] - point;
    const Point c = part.positions[t[2]] - point;
    const double u = direction.dot(a.cross(b));
    const double v = direction.dot(b.cross(c));
    const double w = direction.dot(c.cross(a));
    const bool crosses = (u > 0 && v > 0 && w > 0) || (u < 0 && v < 0 && w < 0);
    if (crosses && (v * a + w * b + u * c).dot(direction) / (u + v + w) > 0) inside = !inside;
  }
  return inside;
}

TEST(Figure, HasFifteenColouredPartsAndThePapersSize) {
  const TriangleSoup soup = make_procedural("interpenetrating-figure");
  EXPECT_EQ(soup.triangles.size(), 15U * 2 * 32 * 14);
  EXPECT_NEAR(static_cast<double>(soup.triangles.size()), 13'476, 0.02 * 13'476);  // [NT03, Fig. 7]
  const std::vector<TriangleSoup> parts = parts_of(soup);
  ASSERT_EQ(parts.size(), 15U);
  std::set<std::array<float, 3>> colors;
  for (const TriangleSoup& part : parts) {
    EXPECT_EQ(genus_of(part), 0);
    ASSERT_EQ(part.triangle_colors.size(), part.triangles.size());
    const Color& color = part.triangle_colors[0];
    EXPECT_TRUE(std::ranges::all_of(part.triangle_colors, [&](const Color& other) { return other == color; }));
    EXPECT_TRUE((color.array() >= 0).all() && (color.array() <= 1).all());
    colors.insert({color[0], color[1], color[2]});
  }
  EXPECT_EQ(colors.size(), 6U);  // skin, felt, jacket, sleeves, trousers, shoes
}

TEST(Figure, PartsInterpenetrateAndHangTogether) {
  const std::vector<TriangleSoup> parts = parts_of(make_procedural("interpenetrating-figure?slices=12&stacks=9"));
  ASSERT_EQ(parts.size(), 15U);
  // Two parts overlap when a vertex of one lies inside the other.
  std::vector<std::set<std::size_t>> overlaps(parts.size());
  for (std::size_t i = 0; i < parts.size(); ++i) {
    for (std::size_t j = 0; j < parts.size(); ++j) {
      if (i == j) continue;
      const auto within = [&](const Point& point) { return is_inside(parts[j], point); };
      if (std::ranges::any_of(parts[i].positions, within)) {
        overlaps[i].insert(j);
        overlaps[j].insert(i);
      }
    }
  }
  std::set<std::size_t> reached = {0};
  std::vector<std::size_t> open = {0};
  while (!open.empty()) {
    const std::size_t part = open.back();
    open.pop_back();
    for (const std::size_t next : overlaps[part]) {
      if (reached.insert(next).second) open.push_back(next);
    }
  }
  EXPECT_EQ(reached.size(), 15U);
  // Part 2 is the torso; head, two upper arms and two upper legs continue into it.
  EXPECT_TRUE(std::ranges::includes(overlaps[2], std::set<std::size_t>{0, 3, 4, 9, 10}));
}

// --- chair -------------------------------------------------------------------------------------------------------

TEST(Chair, HasThePapersSizeAndSeparateBars) {
  const TriangleSoup soup = make_procedural("chair");
  EXPECT_NEAR(static_cast<double>(soup.triangles.size()), 3'261, 0.02 * 3'261);  // [NT03, Fig. 9]
  // Sections of 12 points: 11 slats of 8 belts and 4 legs of 9, two caps of 10 each.
  EXPECT_EQ(soup.triangles.size(), 11U * (24 * 8 + 20) + 4U * (24 * 9 + 20));
  const std::vector<TriangleSoup> parts = parts_of(soup);
  ASSERT_EQ(parts.size(), 15U);
  for (const TriangleSoup& part : parts) EXPECT_EQ(genus_of(part), 0);
  // The height is 1 and the longest side.
  EXPECT_EQ(bounds(soup).extent().z(), 1.0);
  EXPECT_EQ(bounds(soup).extent().maxCoeff(), 1.0);
}

TEST(Chair, HasTheVolumeOfItsBars) {
  // A bar's section: a rectangle whose corners, squares of side c, became fans of two triangles of 45 degrees.
  const double c = 0.005;
  const auto section = [&](double width, double height) {
    return width * height - 4 * c * c + 4 * 2 * 0.5 * c * c * std::sin(pi / 4);
  };
  // gap 0.045, joint and bow 0.0225. Bowing shears a slat, which keeps its volume.
  const double back_width = (0.985 - (0.45 - 0.0225) - 5 * 0.045) / 6;
  const double seat_width = (0.48 - 0.05 - 0.0225 - 4 * 0.045) / 5;
  const double back = 6 * section(0.045, back_width) * (0.46 - 2 * (0.05 + 0.0225));
  const double seat = 5 * section(seat_width, 0.045) * 0.46;
  // Below the seat, frusta from 0.7 to 1: height 0.4275, mean section (0.49 + 0.7 + 1) / 3.
  const double lower = 4 * section(0.05, 0.05) * 0.4275 * (0.49 + 0.7 + 1) / 3;
  const double upper = 2 * section(0.05, 0.05) * (1 - 0.4275);
  expect_relative(signed_volume(make_procedural("chair")), back + seat + lower + upper);
}

TEST(Chair, BarsAreAJointOrAGapApart) {
  const TriangleSoup soup = make_procedural("chair?back_slats=3&seat_slats=2");
  const std::vector<TriangleSoup> parts = parts_of(soup);
  ASSERT_EQ(parts.size(), 9U);  // front leg, post, front leg, post, 2 seat slats, 3 back slats
  std::vector<Box> boxes;
  for (const TriangleSoup& part : parts) boxes.push_back(bounds(part));
  const double gap = 0.045;
  EXPECT_NEAR(boxes[5].lower.y() - boxes[4].upper.y(), gap, 1e-15);      // seat slats
  EXPECT_NEAR(boxes[7].lower.z() - boxes[6].upper.z(), gap, 1e-15);      // back slats
  EXPECT_NEAR(boxes[6].lower.x() - boxes[1].upper.x(), gap / 2, 1e-15);  // back slat and left post
  EXPECT_NEAR(boxes[3].lower.x() - boxes[8].upper.x(), gap / 2, 1e-15);  // back slat and right post
  // Back and seat: a joint, and what the bow 4 u (1 - u) gap / 2 has become where the slat ends, a joint from the post.
  const double u = (gap / 2) / (0.46 - 2 * 0.05);
  EXPECT_NEAR(boxes[6].lower.y() - boxes[5].upper.y(), gap / 2 + 4 * u * (1 - u) * gap / 2, 1e-15);
  EXPECT_NEAR(boxes[3].lower.y() - boxes[5].upper.y(), gap / 2, 1e-15);  // post and seat
  // Front leg and seat, whose slats hang through between the legs: compare with the slat's end.
  double slat_end = 1;
  for (const Point& p : parts[4].positions) slat_end = p.x() == 0 ? std::min(slat_end, p.z()) : slat_end;
  EXPECT_NEAR(slat_end - boxes[0].upper.z(), gap / 2, 1e-15);
  // No two bars overlap: no vertex lies inside another bar.
  for (std::size_t i = 0; i < parts.size(); ++i) {
    for (std::size_t j = 0; j < parts.size(); ++j) {
      if (i == j) continue;
      EXPECT_TRUE(std::ranges::none_of(parts[i].positions, [&](const Point& p) { return is_inside(parts[j], p); }));
    }
  }
}

// --- specs -------------------------------------------------------------------------------------------------------

TEST(Specs, ParseNamesAndParameters) {
  EXPECT_EQ(make_procedural("torus"), make_procedural("torus?major=1&minor=0.4"));
  EXPECT_EQ(make_procedural("torus?"), make_procedural("torus"));
  EXPECT_EQ(make_procedural("genus-n?genus=2&subdivision=1").triangles.size(), 100U);  // 2 * (18 * 2 + 14)
}

TEST(Specs, UnknownNamesAreRefusedWithTheNearest) {
  EXPECT_THAT(parameter_error("tors"), HasSubstr("'tors'; did you mean 'torus'?"));
  EXPECT_THAT(parameter_error("turbin_blade"), HasSubstr("did you mean 'turbine_blade'?"));  // an external one
  EXPECT_THAT(parameter_error("motor?x=1"), HasSubstr("'motor' is an external model"));
  EXPECT_THAT(parameter_error("xyzzyxyzzy"), testing::EndsWith("no model is called 'xyzzyxyzzy'"));
  EXPECT_THAT(parameter_error(""), HasSubstr("no model is called ''"));
  EXPECT_THAT(parameter_error("torus?majr=2"), HasSubstr("torus has no parameter 'majr'; did you mean 'major'?"));
}

TEST(Specs, BadValuesAreRefused) {
  EXPECT_THAT(parameter_error("torus?major"), HasSubstr("not of the form name=value"));
  EXPECT_THAT(parameter_error("torus?major=2&&minor=1"), HasSubstr("not of the form name=value"));
  EXPECT_THAT(parameter_error("torus?major=big"), HasSubstr("must be a real number"));
  EXPECT_THAT(parameter_error("torus?major=nan"), HasSubstr("must be a real number"));
  EXPECT_THAT(parameter_error("torus?segments=2"), HasSubstr("at least 3"));
  EXPECT_THAT(parameter_error("torus?major=1&minor=1"), HasSubstr("minor must be less than major"));
  EXPECT_THAT(parameter_error("genus-n?genus=-1"), HasSubstr("at least 0"));
  EXPECT_THAT(parameter_error("perforated-box?hole_width=0.9"), HasSubstr("at most 0.8"));
  EXPECT_THAT(parameter_error("chair?back_slats=40"), HasSubstr("slats narrower than"));
}

TEST(Specs, AbsurdSizesAreRefusedBeforeAnythingIsBuilt) {
  for (const char* spec :
       {"torus?segments=100000&tube_segments=100000", "genus-n?genus=500000&subdivision=1000",
        "perforated-box?holes=2000&sides=10000", "two-spheres?subdivision=9", "sphereflake?depth=6&subdivision=8",
        "interpenetrating-figure?slices=10000&stacks=10000", "chair?slat_segments=10000&corner_segments=1000"}) {
    const std::string message = parameter_error(spec);
    EXPECT_TRUE(message.find("limit of 20 million") != std::string::npos ||
                message.find("at most 8") != std::string::npos)
        << spec << ": " << message;
  }
}

TEST(Specs, RefusalsOfSizeStateTheCount) {
  // One more belt than 20 million allow: 2 * 5000 * 2001.
  EXPECT_THAT(parameter_error("torus?segments=5000&tube_segments=2001"),
              HasSubstr("20010000 triangles, more than the limit of 20 million"));
  // A cuboid of 14 squares: 28 * 846^2.
  EXPECT_THAT(parameter_error("genus-n?genus=0&subdivision=846"), HasSubstr("20040048 triangles"));
}

// --- catalogue ---------------------------------------------------------------------------------------------------

TEST(Catalogue, EntriesAreCompleteAndUnique) {
  std::set<std::string> names;
  for (const ExternalModel& model : external_models()) {
    SCOPED_TRACE(model.name);
    EXPECT_TRUE(names.insert(model.name).second);
    EXPECT_FALSE(model.file.empty());
    EXPECT_FALSE(model.stands_for.empty());
    EXPECT_TRUE(model.source.starts_with("github.com/"));
    EXPECT_FALSE(model.licence.empty());
    EXPECT_EQ(model.sha256.size(), 64U);
    EXPECT_EQ(model.sha256.find_first_not_of("0123456789abcdef"), std::string::npos);
    EXPECT_EQ(model.file.ends_with(".nrrd"), model.kind == ExternalKind::kVolume);
    EXPECT_EQ(to_string(model.kind), model.kind == ExternalKind::kVolume ? "volume" : "mesh");
    // A name means one model.
    EXPECT_EQ(std::ranges::count(model_names(), model.name), 0);
  }
  EXPECT_TRUE(names.contains("motor"));
}

TEST(Catalogue, FindsFilesAndSaysWhereToGetThem) {
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "voxcarve_catalogue_test";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  const auto message = [&](const std::filesystem::path& where) -> std::string {
    try {
      find_external("motor", where);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no InputError";
  };
  EXPECT_THAT(message(""), testing::AllOf(HasSubstr("VOXCARVE_DATA"), HasSubstr("motor.obj"), HasSubstr("vtk-data")));
  EXPECT_THAT(message(folder / "nowhere"), testing::AllOf(HasSubstr("is not a folder"), HasSubstr("vtk-data")));
  EXPECT_THAT(message(folder), testing::AllOf(HasSubstr("there is no"), HasSubstr("motor.obj"), HasSubstr("vtk-data")));
  std::ofstream(folder / "motor.obj") << "v 0 0 0\n";
  EXPECT_EQ(find_external("motor", folder), folder / "motor.obj");
  EXPECT_THROW(find_external("moter", folder), ParameterError);
  std::filesystem::remove_all(folder);
}

TEST(Catalogue, AgreesWithTheDataFolder) {
  const char* data = std::getenv("VOXCARVE_DATA");
  if (data == nullptr) GTEST_SKIP() << "VOXCARVE_DATA is unset: no data folder to compare the catalogue with";
  std::ifstream manifest(std::filesystem::path(data) / "MANIFEST.csv");
  if (!manifest) GTEST_SKIP() << data << " has no MANIFEST.csv";
  std::stringstream text;
  text << manifest.rdbuf();
  std::map<std::string, std::string> row_of_file;
  for (std::string line; std::getline(text, line);) {
    const std::size_t first = line.find(',');
    row_of_file[line.substr(first + 1, line.find(',', first + 1) - first - 1)] = line;
  }
  for (const ExternalModel& model : external_models()) {
    EXPECT_NO_THROW(find_external(model.name, data)) << model.name;
    ASSERT_TRUE(row_of_file.contains(model.file)) << model.file;
    EXPECT_THAT(row_of_file[model.file], HasSubstr("," + model.sha256 + ","));
    EXPECT_TRUE(row_of_file[model.file].starts_with(model.name + ",")) << model.name;
  }
}

}  // namespace
}  // namespace voxcarve
