#include "methods/hagbi_elsana/complement.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <vector>

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

TEST(Classify, OpenMeshesAreFolds) {
  TriangleSoup open = torus(2, 0.7, 24, 12);
  open.triangles.erase(open.triangles.begin());  // a hole of one triangle
  const Classification folded = classify_soup(open);
  EXPECT_NEAR(solid_volume(folded), 0, 1e-9);
  EXPECT_EQ(folded.folds, static_cast<std::int64_t>(open.triangles.size()));
}

/// With the triangle that an open mesh lacks among the faces of its tetrahedra, every tetrahedron lies on one side of
/// the closed one. Seen from a point beside it, the missing triangle covers a solid angle W < 2 pi, so the winding
/// number is 1 - W / 4 pi > 1/2 on the inside, and W / 4 pi < 1/2 at most, in absolute value, on the outside: all
/// centroids are told right, but for those of flat tetrahedra, which have no volume.
TEST(Classify, SolidifiedMeshesAreWhatTheyWereClosed) {
  const auto expect_whole = [](const TriangleSoup& closed, std::size_t missing, std::int64_t most_folds) {
    TriangleSoup open = closed;
    open.triangles.erase(open.triangles.begin() + static_cast<std::ptrdiff_t>(missing));
    RunContext context;
    const ValidComplex valid = make_valid_complex(open, {}, context);
    const Triangle& hole = closed.triangles[missing];
    if (!std::ranges::any_of(valid.tetrahedralization.tetrahedra, [&](const TetrahedronCorners& corners) {
          return std::ranges::all_of(hole, [&](auto v) { return std::ranges::count(corners, v) == 1; });
        })) {
      return false;
    }
    const Classification made =
        classify(valid.tetrahedralization, valid.complex, valid.multiplicity, InsideRule::kWindingNumber, context);
    EXPECT_NEAR(solid_volume(made), signed_volume(closed), 1e-9);
    EXPECT_LE(made.folds, most_folds) << missing;
    return true;
  };
  const TriangleSoup even = torus(2, 0.7, 24, 12);
  TriangleSoup uneven = even;
  for (std::size_t i = 0; i < uneven.positions.size(); ++i) {
    const auto angle = static_cast<double>(i);
    uneven.positions[i] += 1e-3 * Point(std::sin(7 * angle), std::sin(11 * angle + 1), std::sin(13 * angle + 2));
  }
  int tried = 0;
  for (std::size_t missing = 0; missing < 5; ++missing) {
    // Four corners of a quad lie in a plane here. A flat tetrahedron between them has both its triangles as walls, and
    // beyond its other two faces one side of the torus, which it takes; only at the missing triangle's quad its one
    // wall may have that side beyond it, too.
    tried += expect_whole(even, missing, 1);
    // No tetrahedron is flat: a wall has the inside on one side, the outside on the other.
    tried += expect_whole(uneven, missing, 0);
  }
  EXPECT_GE(tried, 6);
}

/// Voids are what no way leads to from the ghosts, and points of one component are those that simplices of M join: by
/// marks handed on until nothing changes.
TEST(Classify, VoidsAndComponentsAreWhatSmallestMarksSay) {
  const auto sphere = [](double radius, int slices) { return uv_sphere(Point(0, 0, 0), radius, slices, slices - 2); };
  TriangleSoup open = torus(2, 0.7, 12, 6);
  open.triangles.erase(open.triangles.begin(), open.triangles.begin() + 3);
  const std::vector<TriangleSoup> models = {
      torus(2, 0.7, 12, 6), open,
      test::joined({sphere(3, 8), as_cavity(sphere(2, 7)), sphere(1, 6), as_cavity(sphere(0.5, 5))}),
      test::joined(
          {sphere(3, 8), sphere(2, 7), box(Point(5, 0, 0), Point(6, 1, 1)), box(Point(6, 1, 1), Point(7, 2, 2))}),
      test::joined({kCube, test::inside_out(box(Point(.25, .25, .25), Point(.75, .75, .75))),
                    box(Point(2, 0, 0), Point(3, 1, 1))})};
  for (std::size_t m = 0; m < models.size(); ++m) {
    for (const InsideRule rule : {InsideRule::kWinding, InsideRule::kWindingNumber}) {
      SCOPED_TRACE("model " + std::to_string(m) + (rule == InsideRule::kWinding ? "" : ", by winding number"));
      RunContext context;
      const ValidComplex valid = make_valid_complex(models[m], {}, context);
      const Classification made = classify(valid.tetrahedralization, valid.complex, valid.multiplicity, rule, context);
      const Complement& mesh = made.complement;

      std::vector<std::uint32_t> mark(mesh.size());
      for (std::uint32_t t = 0; t < mesh.size(); ++t) mark[t] = mesh.is_ghost(t) ? 0 : t + 1;
      for (bool changed = true; changed;) {
        changed = false;
        for (std::uint32_t t = 0; t < mesh.size(); ++t) {
          for (int i = 0; i < 4; ++i) {
            if (mesh.is_barrier(t, i)) continue;
            const std::uint32_t other = mark[mesh.neighbors[t][static_cast<std::size_t>(i)]];
            changed = changed || other < mark[t];
            mark[t] = std::min(mark[t], other);
          }
        }
      }
      std::map<std::uint32_t, Void> void_of;
      std::map<std::uint32_t, double> longest;
      for (std::uint32_t t = 0; t < mesh.first_ghost; ++t) {
        if (mark[t] == 0) continue;
        void_of[mark[t]].volume += volume(mesh.points, mesh.corners[t]);
        const double edge = longest_edge_squared(mesh.points, mesh.corners[t]);
        if (edge <= longest[mark[t]]) continue;
        longest[mark[t]] = edge;
        void_of[mark[t]].seed = t;
      }
      std::map<std::uint32_t, double> expected;  // volumes by seed
      for (const auto& [first, found] : void_of) expected[found.seed] = found.volume;
      std::map<std::uint32_t, double> voids;
      for (const Void& found : made.voids) voids[found.seed] = found.volume;
      EXPECT_EQ(voids, expected);
      EXPECT_TRUE(std::ranges::is_sorted(made.voids, {}, &Void::seed));

      std::set<std::set<std::uint32_t>> carvable;
      for (std::uint32_t t = 0; t < mesh.first_ghost; ++t) {
        carvable.insert({mesh.corners[t].begin(), mesh.corners[t].end()});
      }
      std::vector<std::vector<std::uint32_t>> simplices;
      for (const Triangle& facet : valid.tetrahedralization.facets) simplices.emplace_back(facet.begin(), facet.end());
      for (const TetrahedronCorners& corners : valid.tetrahedralization.tetrahedra) {
        if (!carvable.contains({corners.begin(), corners.end()}))
          simplices.emplace_back(corners.begin(), corners.end());
      }
      std::vector<std::uint32_t> solid(mesh.points.size(), Complement::kNone);
      for (const auto& simplex : simplices) {
        for (const std::uint32_t point : simplex) solid[point] = point;
      }
      for (bool changed = true; changed;) {
        changed = false;
        for (const auto& simplex : simplices) {
          for (const std::uint32_t point : simplex) {
            changed = changed || solid[simplex[0]] != solid[point];
            solid[simplex[0]] = solid[point] = std::min(solid[simplex[0]], solid[point]);
          }
        }
      }
      std::map<std::uint32_t, std::uint32_t> number;  // in the order of their first points
      for (std::uint32_t& component : solid) {
        if (component == Complement::kNone) continue;
        component = number.try_emplace(component, static_cast<std::uint32_t>(number.size())).first->second;
      }
      EXPECT_EQ(mesh.solid_of_point, solid);
    }
  }
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
