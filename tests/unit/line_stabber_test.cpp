#include "common/mesh/line_stabber.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <stop_token>

#include "common/run/errors.h"
#include "tests/unit/metric_shapes.h"

namespace voxcarve {
namespace {

using namespace test;

TEST(StabFrame, IsRightHandedAndOrthonormal) {
  Sequence random(1);
  for (int i = 0; i < 100; ++i) {
    const StabFrame f = StabFrame::along(random.point() - Point::Constant(0.5));
    EXPECT_NEAR(f.u.cross(f.v).dot(f.w), 1, 1e-14);
    EXPECT_NEAR(f.u.dot(f.v), 0, 1e-15);
  }
  for (int axis = 0; axis < 3; ++axis) {
    const StabFrame f = StabFrame::along_axis(axis);
    EXPECT_EQ(f.u.cross(f.v), f.w);
    EXPECT_EQ(f.w, Point::Unit(axis));
  }
}

TEST(LineStabber, CubeIsEnteredAndLeftAtItsFaces) {
  const TriangleSoup cube = make_box({0, 0, 0.1}, {1, 1, 0.7});
  const LineStabber stabber(cube);
  std::vector<Crossing> hits;
  stabber.crossings(0.3, 0.6, hits);
  ASSERT_EQ(hits.size(), 2U);
  EXPECT_EQ(hits[0].depth, 0.1);  // a face of constant depth gives that depth to the last bit
  EXPECT_EQ(hits[0].sign, 1);
  EXPECT_EQ(hits[1].depth, 0.7);
  EXPECT_EQ(hits[1].sign, -1);
  EXPECT_LT(hits[0].triangle, 2U);  // make_box starts with the bottom
}

TEST(LineStabber, LinesThroughDiagonalsEdgesAndVerticesCountOnce) {
  // On the lattice points of an aligned cube every line meets an edge or a vertex. Moved by (eps, eps^2), lines on the
  // lower sides enter and lines on the upper sides miss, whatever the direction.
  const TriangleSoup cube = unit_cube();
  for (int axis = 0; axis < 3; ++axis) {
    const LineStabber stabber(cube, StabFrame::along_axis(axis), 0.25);
    std::vector<Crossing> hits;
    for (const double u : {0.0, 0.25, 0.5, 0.75, 1.0}) {
      for (const double v : {0.0, 0.25, 0.5, 0.75, 1.0}) {
        stabber.crossings(u, v, hits);
        ASSERT_EQ(hits.size(), u < 1 && v < 1 ? 2U : 0U) << u << " " << v;
        if (!hits.empty()) {
          EXPECT_EQ(hits[0].depth, 0);
          EXPECT_EQ(hits[0].sign, 1);
          EXPECT_EQ(hits[1].depth, 1);
          EXPECT_EQ(hits[1].sign, -1);
        }
      }
    }
  }
}

/// Every line that a closed surface's own vertices and edge middles name: the worst ones.
void expect_watertight(const TriangleSoup& soup, const StabFrame& frame, double cell_size) {
  const LineStabber stabber(soup, frame, cell_size);
  std::vector<Crossing> hits;
  const auto check = [&](const Point& p) {
    stabber.crossings(frame.u.dot(p), frame.v.dot(p), hits);
    int sum = 0;
    for (const Crossing& hit : hits) sum += hit.sign;
    ASSERT_EQ(sum, 0);
    ASSERT_EQ(hits.size() % 2, 0U);
  };
  for (const Point& p : soup.positions) check(p);
  for (const Triangle& t : soup.triangles) {
    for (std::size_t c = 0; c < 3; ++c) check((soup.positions[t[c]] + soup.positions[t[(c + 1) % 3]]) / 2);
  }
}

TEST(LineStabber, ClosedSurfacesAreWatertight) {
  Sequence random(11);
  const TriangleSoup far_away = translated(sphere(1, 3), {1e6, -3e5, 17});
  for (const TriangleSoup& soup : {unit_cube(), torus(2, 0.5, 24, 16), sphere(1, 3), far_away}) {
    for (int axis = 0; axis < 3; ++axis) expect_watertight(soup, StabFrame::along_axis(axis), 0);
    for (int i = 0; i < 5; ++i) {
      expect_watertight(soup, StabFrame::along(random.point() - Point::Constant(0.5)), i * 0.05);
    }
  }
}

TEST(LineStabber, RepeatedVerticesStayWatertight) {
  // A soup without shared indices, as an STL file gives it.
  const TriangleSoup shared = sphere(1, 2);
  TriangleSoup split;
  for (const Triangle& t : shared.triangles) {
    const auto base = static_cast<std::uint32_t>(split.positions.size());
    for (const std::uint32_t v : t) split.positions.push_back(shared.positions[v]);
    split.triangles.push_back({base, base + 1, base + 2});
  }
  expect_watertight(split, StabFrame::along({1, 2, 3}), 0);
}

/// The slow, obvious twin: doubles, no cells, lines in general position.
std::vector<Crossing> brute_force(const TriangleSoup& soup, const StabFrame& f, double u, double v) {
  std::vector<Crossing> hits;
  for (std::uint32_t i = 0; i < soup.triangles.size(); ++i) {
    const Triangle& t = soup.triangles[i];
    const Point p = f.at(u, v, 0);
    const Point a = soup.positions[t[0]] - p;
    const Point b = soup.positions[t[1]] - p;
    const Point c = soup.positions[t[2]] - p;
    const double e0 = f.w.dot(b.cross(c));
    const double e1 = f.w.dot(c.cross(a));
    const double e2 = f.w.dot(a.cross(b));
    const bool positive = e0 > 0 && e1 > 0 && e2 > 0;
    if (!positive && !(e0 < 0 && e1 < 0 && e2 < 0)) continue;
    const double depth = (e0 * a.dot(f.w) + e1 * b.dot(f.w) + e2 * c.dot(f.w)) / (e0 + e1 + e2);
    hits.push_back({depth, i, static_cast<std::int8_t>(positive ? -1 : 1)});
  }
  sort_crossings(hits);
  return hits;
}

TEST(LineStabber, AgreesWithBruteForce) {
  Sequence random(13);
  TriangleSoup soup;  // no surface at all
  for (std::uint32_t i = 0; i < 300; ++i) {
    soup.positions.push_back(random.point());
    if (i % 3 == 2) soup.triangles.push_back({i - 2, i - 1, i});
  }
  for (int i = 0; i < 10; ++i) {
    const StabFrame frame = StabFrame::along(random.point() - Point::Constant(0.5));
    const LineStabber stabber(soup, frame, i * 0.03);
    std::vector<Crossing> hits;
    for (int k = 0; k < 100; ++k) {
      const Point p = random.point();
      const double u = frame.u.dot(p);
      const double v = frame.v.dot(p);
      stabber.crossings(u, v, hits);
      const std::vector<Crossing> expected = brute_force(soup, frame, u, v);
      ASSERT_EQ(hits.size(), expected.size());
      for (std::size_t h = 0; h < hits.size(); ++h) {
        EXPECT_EQ(hits[h].triangle, expected[h].triangle);
        EXPECT_EQ(hits[h].sign, expected[h].sign);
        // The line moves by at most a lattice step, 2^-27; the steepest of these triangles turns that into this.
        EXPECT_NEAR(hits[h].depth, expected[h].depth, 1e-5);
      }
    }
  }
}

TEST(LineStabber, EdgeOnTrianglesAndLinesOutsideNeverCount) {
  TriangleSoup wall;
  wall.positions = {{0, 0, 0}, {1, 0, 0}, {1, 0, 1}, {2, 3, 0}, {2, 3, 5}, {2, 3, 2}};
  wall.triangles = {{0, 1, 2}, {3, 4, 5}};
  const LineStabber stabber(wall);
  std::vector<Crossing> hits;
  stabber.crossings(0.5, 0, hits);
  EXPECT_TRUE(hits.empty());
  stabber.crossings(2, 3, hits);
  EXPECT_TRUE(hits.empty());
  for (const double u : {-1e300, -1.0, 5.0, 1e300, std::nan("")}) {
    stabber.crossings(u, 0.5, hits);
    EXPECT_TRUE(hits.empty());
  }
}

TEST(LineStabber, EmptySoupHasNoCrossings) {
  std::vector<Crossing> hits;
  LineStabber(TriangleSoup()).crossings(0, 0, hits);
  EXPECT_TRUE(hits.empty());
}

TEST(LineStabber, TinyAndHugeShapes) {
  for (const double scale : {1e-12, 1e12, 1e-200, 1e150}) {
    TriangleSoup cube = unit_cube();
    for (Point& p : cube.positions) p *= scale;
    std::vector<Crossing> hits;
    LineStabber(cube).crossings(0.3 * scale, 0.2 * scale, hits);
    ASSERT_EQ(hits.size(), 2U);
    EXPECT_EQ(hits[1].depth, scale);
  }
}

TEST(LineStabber, CellSizeDoesNotChangeTheAnswer) {
  const TriangleSoup soup = torus(2, 0.5, 24, 16);
  const StabFrame frame = StabFrame::along({1, 1, 1});
  const LineStabber coarse(soup, frame, 100);
  const LineStabber fine(soup, frame, 0.01);
  std::vector<Crossing> first;
  std::vector<Crossing> second;
  for (const Point& p : soup.positions) {
    coarse.crossings(frame.u.dot(p), frame.v.dot(p), first);
    fine.crossings(frame.u.dot(p), frame.v.dot(p), second);
    ASSERT_EQ(first.size(), second.size());
    for (std::size_t i = 0; i < first.size(); ++i) {
      EXPECT_EQ(first[i].depth, second[i].depth);
      EXPECT_EQ(first[i].triangle, second[i].triangle);
    }
  }
}

TEST(LineStabber, TrianglesOfAllSizesAgreeWithBruteForceAndWithOneSizeOfCells) {
  // From a cell to a hundred thousand cells; every line goes through a triangle, by the size of its cells.
  Sequence random(17);
  TriangleSoup soup;
  for (std::uint32_t i = 0; i < 400; ++i) {
    const Point middle = random.point();
    const double size = std::pow(10.0, -5 * static_cast<double>(i) / 400);
    for (int corner = 0; corner < 3; ++corner) {
      soup.positions.push_back(middle + size * (random.point() - Point::Constant(0.5)));
    }
    soup.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  const StabFrame frame = StabFrame::along({1, -2, 3});
  const LineStabber stabber(soup, frame, 1e-5);
  const LineStabber twin(soup, frame, 100);
  std::vector<Crossing> hits;
  std::vector<Crossing> expected;
  for (const Triangle& t : soup.triangles) {
    const Point p = (soup.positions[t[0]] + soup.positions[t[1]] + soup.positions[t[2]]) / 3;
    const double u = frame.u.dot(p);
    const double v = frame.v.dot(p);
    stabber.crossings(u, v, hits);
    twin.crossings(u, v, expected);
    ASSERT_EQ(hits.size(), expected.size());
    const std::vector<Crossing> slow = brute_force(soup, frame, u, v);
    ASSERT_EQ(hits.size(), slow.size());
    ASSERT_FALSE(hits.empty());
    for (std::size_t i = 0; i < hits.size(); ++i) {
      EXPECT_EQ(hits[i].depth, expected[i].depth);
      EXPECT_EQ(hits[i].triangle, expected[i].triangle);
      EXPECT_EQ(hits[i].sign, expected[i].sign);
      EXPECT_EQ(hits[i].triangle, slow[i].triangle);
    }
  }
}

TEST(LineStabber, MemoryGrowsWithFinerCellsUpToABudget) {
  const TriangleSoup soup = sphere(1, 3);
  const std::uint64_t coarse = LineStabber::memory_estimate(soup, {}, 0.5);
  const std::uint64_t fine = LineStabber::memory_estimate(soup, {}, 0.02);
  EXPECT_GT(coarse, soup.triangles.size() * 64);  // the records alone
  EXPECT_GT(fine, coarse + 4 * 100 * 100);        // 2 / 0.02 cells a side, four bytes each
  // A cube with a million cells a side and more: there are at most 2^18 + 128 * 12 cells of a size, and as many entries
  // of triangles. The twelve are of two sizes: four sets of four bytes.
  for (const double cell_size : {1e-3, 1e-6, 1e-9}) {
    EXPECT_LT(LineStabber::memory_estimate(unit_cube(), StabFrame::along({1, 2, 3}), cell_size), 4 * 4 << 18);
  }
}

TEST(LineStabber, CanBeCancelled) {
  const TriangleSoup cube = unit_cube();
  RunContext run;
  EXPECT_NO_THROW(LineStabber(cube, {}, 0, &run));
  std::stop_source stop;
  stop.request_stop();
  run.cancellation = stop.get_token();
  EXPECT_THROW(LineStabber(cube, {}, 0, &run), Cancelled);
  EXPECT_THROW(LineStabber::memory_estimate(cube, {}, 0, &run), Cancelled);
}

}  // namespace
}  // namespace voxcarve
