// geospheres, mushrooms, foot-bones, torso-ribs and sconce: closed, of the papers' sizes and of known genus; and the
// tubes that the last two are made of.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "common/mesh/models/tubes.h"
#include "tests/unit/model_checks.h"

namespace voxcarve {
namespace {

using namespace test;

/// Within a tenth of the paper's figure.
void expect_near_paper(std::size_t actual, double paper) {
  EXPECT_NEAR(static_cast<double>(actual), paper, 0.1 * paper);
}

/// How many parts there are of each number of vertices; all closed and of genus 0.
std::map<std::size_t, int> closed_parts(const TriangleSoup& soup, const std::string& name) {
  expect_closed(soup, name);
  std::map<std::size_t, int> sizes;
  for (const TriangleSoup& part : parts_of(soup)) {
    EXPECT_EQ(genus_of(part), 0);
    EXPECT_GT(signed_volume(part), 0);
    ++sizes[part.positions.size()];
  }
  return sizes;
}

/// The greatest distance of a part's positions from their mean.
double extent_about_mean(const TriangleSoup& part, Point& mean) {
  mean = Point::Zero();
  for (const Point& position : part.positions) mean += position / static_cast<double>(part.positions.size());
  double extent = 0;
  for (const Point& position : part.positions) extent = std::max(extent, (position - mean).norm());
  return extent;
}

// --- tubes -------------------------------------------------------------------------------------------------------

std::vector<Ring> straight_tube(const Point& from, const Point& to, int points, double radius, int sides) {
  std::vector<Point> path;
  for (int i = 0; i < points; ++i) path.emplace_back(from + (to - from) * i / (points - 1));
  return tube_rings(
      path, Point(0.1, 0.2, 1),
      [&](double) {
        return HalfAxes{radius, radius};
      },
      sides);
}

TEST(Tubes, SpacePointsEvenlyBetweenTheStandOffs) {
  const std::vector<Point> corner = {{0, 0, 0}, {4, 0, 0}, {4, 6, 0}};
  // Length 10: at 0, 1, then every (10 - 2) / 4 = 2, that is 3, 5, 7, 9, and 10.
  const std::vector<Point> expected = {{0, 0, 0}, {1, 0, 0}, {3, 0, 0}, {4, 1, 0}, {4, 3, 0}, {4, 5, 0}, {4, 6, 0}};
  const std::vector<Point> points = evenly_spaced(corner, 6, 1);
  ASSERT_EQ(points.size(), expected.size());
  for (std::size_t i = 0; i < points.size(); ++i) EXPECT_LT((points[i] - expected[i]).norm(), 1e-14) << i;
}

TEST(Tubes, HaveEllipticSectionsAlongTheReference) {
  const std::vector<Point> path = {{0, 0, 0}, {2, 0, 0}, {8, 0, 0}};
  const auto axes = [](double share) { return HalfAxes{1 + share, 0.5}; };
  const std::vector<Ring> rings = tube_rings(path, Point::UnitZ(), axes, 4);
  // Travel is along x, so z cross-wise is x cross z = -y. A quarter of the way the half axis along z is 1.25.
  const Ring expected = {{2, 0, 1.25}, {2, -0.5, 0}, {2, 0, -1.25}, {2, 0.5, 0}};
  for (std::size_t k = 0; k < 4; ++k) EXPECT_LT((rings[1][k] - expected[k]).norm(), 1e-14) << k;
  // Counterclockwise seen against travel: a loft has a positive volume. A prism of squares would have 2 * h * a * b.
  EXPECT_GT(signed_volume(loft(rings)), 0);
  const std::vector<Ring> spindle = spindle_rings(path, Point::UnitZ(), axes, 4);
  EXPECT_EQ(spindle.front(), Ring{path.front()});
  EXPECT_EQ(spindle.back(), Ring{path.back()});
  EXPECT_EQ(spindle[1], rings[1]);
}

TEST(TubeNetwork, BridgesJoinBodiesAndThenMakeHandles) {
  TubeNetwork network;
  const std::size_t left = network.add_body(straight_tube({-3, 0, -2}, {-3, 0, 2}, 9, 1, 12));
  const std::size_t right = network.add_body(straight_tube({3, 0, -2}, {3, 0, 2}, 9, 1, 12));
  const auto join = [&](std::size_t ring) {
    // Point 0 of these sections lies along the reference, nearly (0.1, 0.2): the bridges pass outside the bodies.
    const TubeNetwork::Opening from = network.open(left, ring, 0);
    const TubeNetwork::Opening to = network.open(right, ring, 0);
    const Point up = Point(0, 3, 0);
    return network.add_bridge(from, straight_tube(from.center + up, to.center + up, 6, 0.2, 8), to);
  };
  EXPECT_EQ(parts_of(network.surface()).size(), 2U);
  join(2);
  // Two bodies of 9 rings of 12 with two openings, a bridge of 6 rings of 8.
  EXPECT_EQ(network.surface().positions.size(), 2U * 9 * 12 - 2 + 6 * 8);
  for (int genus = 0; genus < 3; ++genus) {
    const TriangleSoup soup = network.surface();
    expect_closed(soup, "network");
    EXPECT_TRUE(has_single_fans(soup));
    EXPECT_EQ(parts_of(soup).size(), 1U);
    EXPECT_EQ(genus_of(soup), genus);  // bridges - bodies + 1
    if (genus < 2) join(genus == 0 ? 4 : 6);
  }
}

TEST(TubeNetwork, SproutsOfSproutsChangeNoGenus) {
  TubeNetwork network;
  const std::size_t body = network.add_body(straight_tube({0, 0, -2}, {0, 0, 2}, 9, 1, 12));
  const TubeNetwork::Opening opening = network.open(body, 4, 3);
  EXPECT_NEAR(opening.normal.norm(), 1, 1e-14);
  // The opening is symmetric about its radius, in whose direction it therefore looks.
  EXPECT_LT((opening.normal - Point(opening.center.x(), opening.center.y(), 0).normalized()).norm(), 1e-12);
  const std::size_t sprout = network.add_sprout(
      opening, straight_tube(opening.center + 0.3 * opening.normal, opening.center + 2 * opening.normal, 7, 0.3, 8));
  const TubeNetwork::Opening twig = network.open(sprout, 4, 0);  // ring 0 is the rim
  network.add_sprout(twig, std::vector<Ring>{{twig.center + twig.normal}});
  const TriangleSoup soup = network.surface();
  expect_closed(soup, "sprouts");
  EXPECT_TRUE(has_single_fans(soup));
  EXPECT_EQ(genus_of(soup), 0);
  EXPECT_EQ(soup.positions.size(), 9U * 12 - 1 + 7 * 8 - 1 + 1);
}

TEST(TubeNetwork, RefusesOpeningsWhereThereIsNoRoom) {
  TubeNetwork network;
  const std::size_t body = network.add_body(straight_tube({0, 0, 0}, {0, 0, 1}, 6, 1, 12));
  EXPECT_THROW(network.open(body, 0, 3), InputError);
  EXPECT_THROW(network.open(body, 5, 3), InputError);
  EXPECT_THROW(network.open(body, 2, 12), InputError);
  network.open(body, 2, 3);
  EXPECT_THROW(network.open(body, 2, 4), InputError);  // shares two quads
  EXPECT_THROW(network.open(body, 3, 2), InputError);  // shares one
  EXPECT_NO_THROW(network.open(body, 4, 3));           // shares an edge's worth of rim, and no quad
}

// --- spheres, mushrooms, bones -------------------------------------------------------------------------------------

TEST(Geospheres, AreEightAtTheCornersOfABox) {
  const TriangleSoup soup = make_procedural("geospheres?width=4&depth=5&height=6");
  // 10 * 4^2 + 2 vertices a sphere.
  EXPECT_EQ(closed_parts(soup, "geospheres"), (std::map<std::size_t, int>{{162, 8}}));
  std::set<std::array<double, 3>> centers;
  for (const TriangleSoup& part : parts_of(soup)) {
    Point mean;
    EXPECT_NEAR(extent_about_mean(part, mean), 1, 1e-13);
    centers.insert(
        {std::round(mean.x() * 1e9) / 1e9, std::round(mean.y() * 1e9) / 1e9, std::round(mean.z() * 1e9) / 1e9});
  }
  std::set<std::array<double, 3>> corners;
  for (const double x : {-2.0, 2.0}) {
    for (const double y : {-2.5, 2.5}) {
      for (const double z : {-3.0, 3.0}) corners.insert({x, y, z});
    }
  }
  EXPECT_EQ(centers, corners);
}

TEST(Mushrooms, HaveThePapersSize) {
  const TriangleSoup soup = make_procedural("mushrooms");
  expect_near_paper(soup.positions.size(), 4'515);  // [HE10, Table 1]
  expect_near_paper(soup.triangles.size(), 9'000);
  // 9 + 4 + 10 rings of 13 and two poles.
  EXPECT_EQ(closed_parts(soup, "mushrooms"), (std::map<std::size_t, int>{{301, 15}}));
}

TEST(Mushrooms, StandOnTheGroundClearOfEachOther) {
  const double gap = 0.2;
  std::vector<Box> boxes;
  const std::vector<TriangleSoup> parts = parts_of(make_procedural("mushrooms?gap=0.2&mushrooms=40&seed=3"));
  ASSERT_EQ(parts.size(), 40U);
  for (const TriangleSoup& part : parts) EXPECT_EQ(bounds(part).lower.z(), 0);
  // Seen from above, no vertex of one comes nearer to one of another than the gap.
  for (std::size_t i = 0; i < parts.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      double nearest = 1e9;
      for (const Point& a : parts[i].positions) {
        for (const Point& b : parts[j].positions) nearest = std::min(nearest, (a - b).head<2>().squaredNorm());
      }
      EXPECT_GE(std::sqrt(nearest), gap);
    }
  }
}

TEST(FootBones, AreTwentySixOfThePapersSize) {
  const TriangleSoup soup = make_procedural("foot-bones");
  expect_near_paper(soup.positions.size(), 2'154);  // [HE10, Fig. 8]
  expect_near_paper(soup.triangles.size(), 4'204);
  // 14 phalanges, 5 metatarsals, 3 cuneiforms, navicular and cuboid, talus, calcaneus: see bodies.cpp.
  EXPECT_EQ(closed_parts(soup, "foot-bones"),
            (std::map<std::size_t, int>{{62, 14}, {98, 5}, {100, 3}, {102, 2}, {122, 1}, {170, 1}}));
  // In centimetres: 25 long, at most 12 wide.
  EXPECT_NEAR(bounds(soup).extent().x(), 25, 1);
  EXPECT_LT(bounds(soup).extent().y(), 12);
}

TEST(FootBones, DetailScalesRingsAndTheirVertices) {
  // 14 * (12 * 20 + 2) + 5 * (16 * 24 + 2) + 3 * (28 * 14 + 2) + 2 * (20 * 20 + 2) + 24 * 20 + 2 + 24 * 28 + 2.
  EXPECT_EQ(make_procedural("foot-bones?detail=2").positions.size(), 3'388U + 1'930 + 1'182 + 804 + 482 + 674);
}

// --- torso and sconce --------------------------------------------------------------------------------------------

void expect_one_surface(const TriangleSoup& soup, std::int64_t genus, const std::string& name) {
  expect_closed(soup, name);
  EXPECT_TRUE(has_single_fans(soup));
  ASSERT_EQ(parts_of(soup).size(), 1U);
  EXPECT_EQ(genus_of(soup), genus);
  EXPECT_GT(signed_volume(soup), 0);
}

TEST(Torso, IsOneSurfaceOfGenusNineteen) {
  // 14 true ribs and 6 that reach the one above are bridges between or on 2 bodies: 20 - 2 + 1.
  for (const std::string spec : {"torso-ribs", "torso-ribs?rib_segments=30&vertebra_rings=8&sternum_rings=40",
                                 "torso-ribs?rib_segments=100&vertebra_rings=13&sternum_rings=77"}) {
    expect_one_surface(make_procedural(spec), 19, spec);
  }
}

TEST(Torso, HasThePapersSize) {
  const TriangleSoup soup = make_procedural("torso-ribs");
  expect_near_paper(soup.positions.size(), 12'479);  // [HE10, Fig. 13]
  // Spine 17 * 10 rings of 24 and sternum 48 of 16; 14 ribs of 43 rings of 8, 6 of 32; 4 free ones of 21 rings and a
  // pole; 27 processes of 3 rings and a pole; and an opening takes a vertex: 24 + 27 on the spine, 14 on the sternum, 6
  // on ribs.
  EXPECT_EQ(soup.positions.size(),
            17U * 10 * 24 + 48 * 16 + 14 * 43 * 8 + 6 * 32 * 8 + 4 * (21 * 8 + 1) + 27 * 25 - (51 + 14 + 6));
  // Closed and of genus 19: F = 2 V - 4 + 4 * 19.
  EXPECT_EQ(soup.triangles.size(), 2 * soup.positions.size() + 72);
}

TEST(Sconce, IsOneSurfaceOfGenusFifteen) {
  // 18 bridges on 4 bodies: 18 - 4 + 1; see sconce.cpp.
  for (const std::string spec :
       {"sconce", "sconce?arm_segments=32&plate_rings=40", "sconce?arm_segments=90&plate_rings=100"}) {
    expect_one_surface(make_procedural(spec), 15, spec);
  }
}

TEST(Sconce, HasThePapersSize) {
  const TriangleSoup soup = make_procedural("sconce");
  expect_near_paper(soup.positions.size(), 4'752);                   // [HE10, Fig. 12]
  EXPECT_EQ(soup.triangles.size(), 2 * soup.positions.size() + 56);  // 2 V - 4 + 4 * 15
}

TEST(Bodies, AreMirrorImagesOfThemselves) {
  // Left and right ribs, arms and ears agree. A rib's section starts at the same reference on both sides, but is walked
  // the other way round: the same ellipse, up to rounding.
  for (const std::string name : {"torso-ribs", "sconce"}) {
    const Box box = bounds(make_procedural(name));
    EXPECT_NEAR(box.lower.x(), -box.upper.x(), 1e-12) << name;
  }
}

TEST(Bodies, AbsurdSizesAreRefused) {
  // 1000 mushrooms of 23 rings of 10,000.
  EXPECT_THAT(parameter_error("mushrooms?mushrooms=1000&slices=10000"), HasSubstr("limit of 20 million"));
  EXPECT_THAT(parameter_error("foot-bones?detail=61"), HasSubstr("at most 60"));
  EXPECT_THAT(parameter_error("geospheres?subdivision=9"), HasSubstr("at most 8"));
}

}  // namespace
}  // namespace voxcarve
