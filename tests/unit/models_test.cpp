// The procedural models: closed, oriented, of the stated counts, genus and volume; and the catalogue of external ones.
#include <gmock/gmock-matchers.h>
#include <gtest/gtest.h>

#include "tests/unit/model_checks.h"

namespace voxcarve {
namespace {

using namespace test;

/// The model as built here: the large one with few triangles, everything else as it comes.
std::string small_spec(const std::string& name) {
  return name == "blade" ? "blade?detail=0.05" : name == "pine" ? "pine?pairs=500" : name;
}

/// Those whose surfaces have defects on purpose, or are open, have tests of their own.
std::vector<std::string> sound_models() {
  const std::set<std::string> others = {"elm", "engine", "pine", "yucca"};
  std::vector<std::string> names = model_names();
  std::erase_if(names, [&](const std::string& name) { return others.contains(name) || name.starts_with("cracked-"); });
  return names;
}

class EveryModel : public testing::TestWithParam<std::string> {};
class SoundModel : public testing::TestWithParam<std::string> {};

TEST_P(SoundModel, HasClosedOutwardManifoldParts) {
  const TriangleSoup soup = make_procedural(small_spec(GetParam()));
  expect_closed(soup, GetParam());
  EXPECT_TRUE(has_single_fans(soup));
  // No two vertices coincide within a part: shared vertices are shared by index.
  for (const TriangleSoup& part : parts_of(soup)) {
    EXPECT_EQ(merge_equal_positions(part).positions.size(), part.positions.size());
    EXPECT_GT(signed_volume(part), 0);
  }
}

TEST_P(EveryModel, IsTheSameTwice) {
  const std::string spec = small_spec(GetParam());
  EXPECT_EQ(make_procedural(spec), make_procedural(spec));
}

TEST_P(EveryModel, HasASchemaWithHelpAndValidDefaults) {
  const ModelInfo& info = find_procedural_model(GetParam()).info;
  EXPECT_FALSE(info.summary.empty());
  for (const ParameterSpec& spec : info.parameters.specs) {
    EXPECT_FALSE(spec.help.empty()) << spec.name;
    if (spec.type != ParameterType::kSwitch && spec.type != ParameterType::kChoice) {
      EXPECT_FALSE(spec.unit.empty()) << spec.name;
      EXPECT_TRUE(std::isfinite(spec.minimum) && std::isfinite(spec.maximum)) << spec.name;
    }
    const std::string value = to_string(spec.default_value);
    EXPECT_NO_THROW(Parameters::parse(info.parameters, std::vector{spec.name + "=" + value}, info.name)) << spec.name;
  }
}

std::string test_name(const testing::TestParamInfo<std::string>& info) {
  std::string name = info.param;
  std::ranges::replace(name, '-', '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(Procedural, EveryModel, testing::ValuesIn(model_names()), test_name);
INSTANTIATE_TEST_SUITE_P(Procedural, SoundModel, testing::ValuesIn(sound_models()), test_name);

TEST(Procedural, ListsTheModelsInOrder) {
  const std::vector<std::string> expected = {"blade",
                                             "bolt",
                                             "chair",
                                             "cracked-cracks",
                                             "cracked-cracks-interpenetrating",
                                             "cracked-double-walls",
                                             "cracked-holes",
                                             "cracked-holes-interpenetrating",
                                             "cracked-interpenetrating",
                                             "cracked-nonmanifold-edges",
                                             "cracked-nonmanifold-vertices",
                                             "cracked-redundant-polygons",
                                             "cracked-shared-walls",
                                             "cracked-t-joints",
                                             "cracked-zero-area",
                                             "elm",
                                             "engine",
                                             "foot-bones",
                                             "genus-n",
                                             "geospheres",
                                             "interpenetrating-figure",
                                             "mechanical-part",
                                             "mushrooms",
                                             "perforated-box",
                                             "pine",
                                             "sconce",
                                             "sphereflake",
                                             "torso-ribs",
                                             "torus",
                                             "two-spheres",
                                             "yucca"};
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

}  // namespace
}  // namespace voxcarve
