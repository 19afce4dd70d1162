#include "metrics/symmetric_difference.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "metrics/inside_intervals.h"
#include "tests/unit/metric_shapes.h"

namespace voxcarve {
namespace {

using namespace test;

SymmetricDifference difference(const TriangleSoup& a, const TriangleSoup& b, std::uint64_t seed = 0) {
  RunContext context;
  context.seed = seed;
  return std::get<SymmetricDifference>(symmetric_difference(a, b, {}, context));
}

TEST(SymmetricDifference, IdenticalShapesDifferByNothing) {
  const SymmetricDifference d = difference(torus(2, 0.5, 24, 12), torus(2, 0.5, 24, 12));
  EXPECT_EQ(d.volume, 0);
  EXPECT_EQ(d.standard_error, 0);
  EXPECT_EQ(d.a_minus_b, 0);
}

TEST(SymmetricDifference, ShiftedUnitCubes) {
  // Each cube sticks out of the other by a slab of volume shift, which is no whole number of strata.
  const double shift = 0.3;
  const SymmetricDifference d = difference(unit_cube(), translated(unit_cube(), {shift, 0, 0}));
  EXPECT_GT(d.standard_error, 0);
  EXPECT_LT(d.standard_error, 0.01);
  EXPECT_NEAR(d.volume, 2 * shift, 4 * d.standard_error);
  EXPECT_NEAR(d.a_minus_b, shift, 4 * d.standard_error);
  EXPECT_NEAR(d.b_minus_a, shift, 4 * d.standard_error);
  EXPECT_NEAR(d.volume_a, 1, 4 * d.standard_error);
}

TEST(SymmetricDifference, IsUnbiasedOverSeeds) {
  // The mean over 64 seeds against 2 * shift, and the spread against the standard errors that were stated.
  double sum = 0;
  double squares = 0;
  double stated = 0;
  RunContext context;
  for (context.seed = 0; context.seed < 64; ++context.seed) {
    const auto d = std::get<SymmetricDifference>(
        symmetric_difference(unit_cube(), translated(unit_cube(), {0.3, 0, 0}), {.rays = 512}, context));
    sum += d.volume;
    squares += (d.volume - 0.6) * (d.volume - 0.6);
    stated += d.standard_error * d.standard_error;
  }
  const double mean_error = std::sqrt(stated / 64 / 64);
  EXPECT_NEAR(sum / 64, 0.6, 4 * mean_error);
  // A ratio of variances over 64 runs of 8 replicates each stays within a factor of two (4 standard deviations or so:
  // the relative standard deviations are sqrt(2 / 64) and sqrt(2 / (64 * 7))).
  EXPECT_GT(squares, stated / 2);
  EXPECT_LT(squares, stated * 2);
}

TEST(SymmetricDifference, ExactAlongTheRays) {
  // A cube against the same cube cut at x = 1 / 2: lines along x see exactly one half each. The replicates along the
  // other axes have 1 / 2 for each line in x > 1 / 2, which an even number of strata divides exactly.
  RunContext context;
  const auto d = std::get<SymmetricDifference>(
      symmetric_difference(unit_cube(), make_box({0, 0, 0}, {0.5, 1, 1}), {.rays = 8 * 16}, context));
  EXPECT_NEAR(d.volume, 0.5, 1e-14);
  EXPECT_NEAR(d.standard_error, 0, 1e-14);
  EXPECT_EQ(d.rays, 128);
  EXPECT_EQ(d.b_minus_a, 0);
}

TEST(SymmetricDifference, EmptyShapeIsTheEmptySolid) {
  const SymmetricDifference d = difference(unit_cube(), TriangleSoup());
  EXPECT_NEAR(d.volume, 1, 1e-12);  // every line has length 1
  EXPECT_NEAR(d.a_minus_b, 1, 1e-12);
  EXPECT_EQ(d.volume_b, 0);
  EXPECT_EQ(difference(TriangleSoup(), TriangleSoup()).volume, 0);
}

TEST(SymmetricDifference, InsideIsNonzeroWinding) {
  // Overlaps count once, the inside of an inward surface counts, and a void in a shell does not.
  const TriangleSoup twice = joined(unit_cube(), unit_cube());
  EXPECT_EQ(difference(unit_cube(), twice).volume, 0);
  EXPECT_EQ(difference(unit_cube(), flipped(unit_cube())).volume, 0);
  const TriangleSoup shell = joined(unit_cube(), flipped(make_box({0.25, 0.25, 0.25}, {0.75, 0.75, 0.75})));
  const SymmetricDifference d = difference(unit_cube(), shell);
  EXPECT_NEAR(d.volume, 0.125, 4 * d.standard_error + 1e-12);
}

TEST(SymmetricDifference, SpheresOfDifferentRadius) {
  const TriangleSoup small = sphere(1, 4);
  const TriangleSoup big = sphere(1.5, 4);
  const SymmetricDifference d = difference(big, small);
  const double expected = signed_volume(big) - signed_volume(small);
  EXPECT_NEAR(d.volume, expected, 4 * d.standard_error);
  EXPECT_LT(d.standard_error, 0.002 * expected);
  EXPECT_EQ(d.b_minus_a, 0);
}

TEST(SymmetricDifference, RepeatedVerticesAreClosed) {
  TriangleSoup split;
  for (const Triangle& t : unit_cube().triangles) {
    const auto base = static_cast<std::uint32_t>(split.positions.size());
    for (const std::uint32_t v : t) split.positions.push_back(unit_cube().positions[v]);
    split.triangles.push_back({base, base + 1, base + 2});
  }
  EXPECT_EQ(InsideIntervals(split).boundary_edges(), 0);
  EXPECT_EQ(difference(unit_cube(), split).volume, 0);
}

/// The unit cube without its top.
TriangleSoup open_cube() {
  TriangleSoup soup = unit_cube();
  soup.triangles.erase(soup.triangles.begin() + 2, soup.triangles.begin() + 4);
  return soup;
}

/// Sum of solid angles over all triangles: the definition of the generalised winding number.
double winding_number(const TriangleSoup& soup, const Point& p) {
  double sum = 0;
  for (const Triangle& t : soup.triangles) {
    const Point a = soup.positions[t[0]] - p;
    const Point b = soup.positions[t[1]] - p;
    const Point c = soup.positions[t[2]] - p;
    sum += 2 * std::atan2(a.dot(b.cross(c)), a.norm() * b.norm() * c.norm() + a.dot(b) * c.norm() +
                                                 b.dot(c) * a.norm() + c.dot(a) * b.norm());
  }
  return sum / (4 * std::numbers::pi);
}

TEST(InsideIntervals, OpenShapesFollowTheGeneralisedWindingNumber) {
  // At random points of random lines, membership agrees with |w| > 1 / 2 by definition, away from its ends.
  TriangleSoup half_torus = torus(2, 0.7, 24, 12);
  half_torus.triangles.resize(half_torus.triangles.size() / 2);
  TriangleSoup torn = sphere(1, 2);
  for (std::size_t t = torn.triangles.size(); t-- > 0;) {
    if (t % 5 == 0) torn.triangles.erase(torn.triangles.begin() + static_cast<std::ptrdiff_t>(t));
  }
  Sequence random(29);
  std::int64_t inside_points = 0;
  for (const TriangleSoup& soup : {open_cube(), half_torus, torn}) {
    InsideIntervals solid(soup);
    EXPECT_GT(solid.boundary_edges(), 0);
    const Box box = bounds(soup);
    std::vector<Crossing> crossings;
    std::vector<Interval> intervals;
    for (int axis = 0; axis < 3; ++axis) {
      solid.prepare(axis);
      for (int i = 0; i < 100; ++i) {
        const Point p = box.lower + random.point().cwiseProduct(box.extent());
        const double w = std::abs(winding_number(soup, p));
        if (std::abs(w - 0.5) < 0.05) continue;  // near a change, which is found to a step of the samples
        solid.along_line(axis, p[(axis + 1) % 3], p[(axis + 2) % 3], crossings, intervals);
        bool inside = false;
        for (const Interval& part : intervals) inside = inside || (part.begin <= p[axis] && p[axis] <= part.end);
        EXPECT_EQ(inside, w > 0.5) << p.transpose() << ", winding number " << w;
        inside_points += inside ? 1 : 0;
      }
    }
  }
  EXPECT_GT(inside_points, 200);
}

TEST(SymmetricDifference, OpenCube) {
  // At the centre of the missing face the other five subtend half of the sphere exactly (its mirror image closes them),
  // and the same holds all over that face, so {w > 1 / 2} ends at it: above, less is seen. Below it, inside, w = 1
  // minus the missing face's solid angle / 4 pi > 1 / 2. So the open cube is the cube.
  const SymmetricDifference d = difference(unit_cube(), open_cube());
  EXPECT_NEAR(d.volume, 0, 1e-5);
  EXPECT_NEAR(d.volume_b, 1, 1e-5);
}

TEST(SymmetricDifference, SingleTriangleIsNoSolid) {
  // A flat sheet has |w| < 1 / 2 everywhere.
  TriangleSoup sheet;
  sheet.positions = {{0, 0, 0}, {1, 0, 0.2}, {0, 1, 0.4}};
  sheet.triangles = {{0, 1, 2}};
  EXPECT_EQ(difference(sheet, sheet).volume_a, 0);
}

TEST(SymmetricDifference, LongBoundariesAreRefusedByName) {
  TriangleSoup leaves;
  for (std::uint32_t i = 0; i < 700; ++i) {
    for (const Point& corner : {Point(0, 0, 0), Point(1, 0, 0), Point(0, 1, 0)}) {
      leaves.positions.push_back(corner + Point(0, 0, i));
    }
    leaves.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  RunContext context;
  EXPECT_EQ(std::get<Undefined>(symmetric_difference(unit_cube(), leaves, {}, context)).reason,
            "the second shape is open with 2100 boundary edges; at most 2000 are treated");
}

TEST(SymmetricDifference, AtLeastEightReplicates) {
  RunContext context;
  const auto d = std::get<SymmetricDifference>(
      symmetric_difference(unit_cube(), sphere(1, 2), {.rays = 1, .replicates = 1}, context));
  EXPECT_EQ(d.rays, 8 * 16);
}

}  // namespace
}  // namespace voxcarve
