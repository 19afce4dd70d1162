#include "methods/hagbi_elsana/complement.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "common/mesh/models/primitives.h"
#include "methods/hagbi_elsana/tetrahedron.h"
#include "tests/support/carving.h"
#include "tests/support/shapes.h"

namespace voxcarve {
namespace {

double carvable_volume(const Complement& mesh) {
  double sum = 0;
  for (std::uint32_t t = 0; t < mesh.first_ghost; ++t) sum += volume(mesh.points, mesh.corners[t]);
  return sum;
}

double hull_volume(const Complement& mesh) {
  TriangleSoup hull;
  hull.positions = mesh.points;
  for (std::uint32_t ghost = mesh.first_ghost; ghost < mesh.size(); ++ghost)
    hull.triangles.push_back(mesh.face(ghost, 3));
  return signed_volume(hull);
}

/// What cannot be carved.
double solid_volume(const Classification& made) {
  return hull_volume(made.complement) - carvable_volume(made.complement);
}

Classification classify_soup(const TriangleSoup& soup, InsideRule rule = InsideRule::kWinding) {
  RunContext context;
  return test::classified(soup, context, false, rule);
}

const TriangleSoup kCube = box(Point(0, 0, 0), Point(1, 1, 1));

TEST(Classify, ConvexModelsLeaveNothingToCarve) {
  const Classification made = classify_soup(kCube);
  EXPECT_EQ(made.complement.first_ghost, 0U);
  EXPECT_EQ(made.hull_faces, 12U);
  EXPECT_EQ(made.hull_points, 8U);
  EXPECT_NEAR(hull_volume(made.complement), 1, 1e-12);
}

TEST(Classify, TellsTheInsideOfSolidsByTheirVolume) {
  for (const TriangleSoup& solid : {torus(2, 0.7, 16, 8), test::joined({kCube, box(Point(3, 0, 0), Point(4, 2, 1))}),
                                    test::inside_out(torus(2, 0.7, 16, 8))}) {
    const Classification made = classify_soup(solid);
    EXPECT_NEAR(solid_volume(made), std::abs(signed_volume(solid)), 1e-9);
    EXPECT_TRUE(made.voids.empty());
    EXPECT_EQ(made.folds, 0);
  }
}

TEST(Classify, AVoidInAVoid) {
  // Shell 3 to 2, in it a shell 1 to 0.5: two solids; voids between them and inside the inner one.
  const auto sphere = [](double radius) { return uv_sphere(Point(0, 0, 0), radius, 8, 6); };
  const Classification made =
      classify_soup(test::joined({sphere(3), as_cavity(sphere(2)), sphere(1), as_cavity(sphere(0.5))}));
  ASSERT_EQ(made.voids.size(), 2U);
  const double between = signed_volume(sphere(2)) - signed_volume(sphere(1));
  const double inside = signed_volume(sphere(0.5));
  EXPECT_NEAR(std::max(made.voids[0].volume, made.voids[1].volume), between, 1e-9);
  EXPECT_NEAR(std::min(made.voids[0].volume, made.voids[1].volume), inside, 1e-9);
  std::set<std::uint32_t> solids;
  for (const std::uint32_t solid : made.complement.solid_of_point) {
    if (solid != Complement::kNone) solids.insert(solid);
  }
  EXPECT_EQ(solids.size(), 2U);
}

TEST(Classify, BoxesThatShareAFaceAreOneSolid) {
  // The common square stands there once in each direction: multiplicity 0, a wall within the solid.
  const Classification made = classify_soup(test::joined({kCube, box(Point(1, 0, 0), Point(2, 1, 1))}));
  EXPECT_NEAR(solid_volume(made), 2, 1e-12);
  EXPECT_EQ(made.nested_regions, 0);
  EXPECT_EQ(made.contradictory_regions, 0);
}

TEST(Classify, SolidsWithinSolidsStayInside) {
  const Classification made = classify_soup(test::joined({kCube, box(Point(.25, .25, .25), Point(.75, .75, .75))}));
  EXPECT_NEAR(solid_volume(made), 1, 1e-12);
  EXPECT_EQ(made.nested_regions, 1);
}

TEST(Classify, OpenMeshesAreFoldsOrSolidified) {
  TriangleSoup open = torus(2, 0.7, 24, 12);
  open.triangles.erase(open.triangles.begin());  // a hole of one triangle
  const Classification folded = classify_soup(open);
  EXPECT_NEAR(solid_volume(folded), 0, 1e-9);
  EXPECT_EQ(folded.folds, static_cast<std::int64_t>(open.triangles.size()));
  const Classification solid = classify_soup(open, InsideRule::kWindingNumber);
  // All but the tetrahedra at the missing triangle are told right.
  EXPECT_NEAR(solid_volume(solid), signed_volume(torus(2, 0.7, 24, 12)), 0.01);
  EXPECT_LT(solid.folds, 20);
}

TEST(Classify, ContradictingOrientationsAreDecidedByParity) {
  // One cube of two has a triangle turned round: winding numbers behind it depend on the way.
  TriangleSoup turned = test::joined({kCube, box(Point(2, 0, 0), Point(3, 1, 1))});
  std::swap(turned.triangles[3][0], turned.triangles[3][1]);
  const Classification made = classify_soup(turned);
  EXPECT_GT(made.contradictory_regions, 0);
  EXPECT_NEAR(solid_volume(made), 2, 1e-12);
}

TEST(Classify, NeighboursAreMutualAndSeeTheSameFace) {
  RunContext context;
  const Complement mesh = test::classified(torus(2, 0.7, 12, 6), context).complement;
  for (std::uint32_t t = 0; t < mesh.size(); ++t) {
    for (int i = 0; i < 4; ++i) {
      const std::uint32_t other = mesh.neighbors[t][static_cast<std::size_t>(i)];
      if (other == Complement::kSolid) {
        EXPECT_TRUE(mesh.is_wall(t, i));
        continue;
      }
      const auto back = std::ranges::find(mesh.neighbors[other], t) - mesh.neighbors[other].begin();
      ASSERT_LT(back, 4);
      Triangle here = mesh.face(t, i);
      Triangle there = mesh.face(other, static_cast<int>(back));
      std::ranges::sort(here);
      std::ranges::sort(there);
      EXPECT_EQ(here, there);
      EXPECT_EQ(mesh.is_wall(t, i), mesh.is_wall(other, static_cast<int>(back)));
    }
  }
}

TEST(Classify, TheBoxHasItsCorners) {
  RunContext context;
  const Classification made = test::classified(icosphere(Point(0, 0, 0), 1, 1), context, true);
  EXPECT_EQ(made.complement.model_points, 42U);
  // The icosphere reaches its box at the ends of axes only if it has vertices there: bounds are its vertices' own.
  EXPECT_NEAR(hull_volume(made.complement), bounds(icosphere(Point(0, 0, 0), 1, 1)).extent().prod(), 1e-9);
}

}  // namespace
}  // namespace voxcarve
