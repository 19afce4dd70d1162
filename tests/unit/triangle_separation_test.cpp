#include "common/mesh/triangle_separation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cfenv>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "tests/support/shapes.h"
#include "tests/unit/arrangement_checks.h"
#include "tests/unit/metric_shapes.h"

namespace voxcarve {
namespace {

/// How many pairs of a kind were looked at, did not cross, and were said to be apart.
struct Tally {
  int pairs = 0;
  int apart = 0;
  int settled = 0;
};

/// Two triangles of some of six vertices with `common` common ones, turned at random.
TriangleSoup pair_of(std::vector<Point> positions, std::uint32_t common, std::mt19937_64& random) {
  TriangleSoup soup;
  soup.positions = std::move(positions);
  soup.triangles = {{0, 1, 2}, {3, 4, 5}};
  for (std::uint32_t i = 0; i < common; ++i) soup.triangles[1][i] = i;
  for (Triangle& t : soup.triangles) std::shuffle(t.begin(), t.end(), random);
  return soup;
}

/// Whether the claim that the pair is apart, if made, is true by exact integers.
void check(const TriangleSoup& soup, Tally& tally) {
  if (test::exactly_collinear(test::corners_of(soup, 0)) || test::exactly_collinear(test::corners_of(soup, 1))) return;
  // Vertices at one position have one name in the soups that this is for.
  for (const std::uint32_t i : soup.triangles[0])
    for (const std::uint32_t j : soup.triangles[1])
      if (i != j && soup.positions[i] == soup.positions[j]) return;
  const CorneredTriangle first(soup, soup.triangles[0]);
  const CorneredTriangle second(soup, soup.triangles[1]);
  const bool claimed = certainly_apart(first, second);
  ++tally.pairs;
  tally.settled += claimed ? 1 : 0;
  const bool forbidden = test::forbidden_pair(soup, 0, 1);
  tally.apart += forbidden ? 0 : 1;
  ASSERT_FALSE(claimed && forbidden);
  ASSERT_FALSE(certainly_apart(second, first) && forbidden);
}

/// Makes the last vertex nearly, or exactly, touch the plane, an edge's line or a corner of the first triangle.
void bring_near(std::vector<Point>& p, double offset, std::mt19937_64& random) {
  std::uniform_real_distribution<double> share(-0.5, 1.5);
  const double s = random() % 3 == 0 ? 0 : share(random);
  const double t = random() % 3 == 0 ? 0 : share(random);
  const Point step(share(random) - 0.5, share(random) - 0.5, share(random) - 0.5);
  p[5] = p[0] + s * (p[1] - p[0]) + t * (p[2] - p[0]) + offset * step;
}

TEST(CertainlyApart, IsNeverSaidOfTrianglesThatCross) {
  // Lattices of few points, where most things touch; random points; points nearly in the plane of the other triangle,
  // down to the last place of the coordinates; slivers; all of it far from the origin, tiny, and huge.
  const std::array<double, 9> scales{1, 1e-20, 1e20, 0x1p-200, 0x1p200, 0x1p-340, 0x1p340, 0x1p-1060, 0x1p1020};
  std::array<Tally, 3> tallies{};
  for (std::uint64_t seed = 0; seed < test::case_count(std::uint64_t{200000}); ++seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> share(-1, 1);
    std::vector<Point> p(6);
    const bool lattice = seed % 3 == 0;
    const std::uint64_t side = 2 + random() % 4;
    for (Point& q : p) {
      for (const int axis : {0, 1, 2}) q[axis] = lattice ? static_cast<double>(random() % side) : share(random);
    }
    const std::uint32_t common = static_cast<std::uint32_t>(seed / 3 % 3);
    if (seed % 3 == 1) {
      const double offset = std::ldexp(1.0, -static_cast<int>(random() % 60));
      bring_near(p, offset, random);
      if (random() % 2 == 0 && common < 2) {
        std::swap(p[4], p[5]);
        bring_near(p, offset, random);
      }
    }
    if (random() % 4 == 0) p[random() % 2 == 0 ? 1 : 4] *= 1e-9;
    if (random() % 4 == 0) {
      const double away = std::ldexp(1.0, static_cast<int>(random() % 30));
      for (Point& q : p) q += Point::Constant(away);
    }
    const double scale = random() % 2 == 0 ? 1 : scales[random() % scales.size()];
    for (Point& q : p) q *= scale;
    if (!std::all_of(p.begin(), p.end(), [](const Point& q) { return q.allFinite(); })) continue;
    SCOPED_TRACE(seed);
    ASSERT_NO_FATAL_FAILURE(check(pair_of(p, common, random), tallies[common]));
  }
  for (const Tally& tally : tallies) {
    EXPECT_GT(tally.pairs, test::case_count(40000));
    EXPECT_GT(tally.pairs - tally.apart, test::case_count(400));  // there was something to be wrong about
    EXPECT_GT(tally.settled, test::case_count(10000));
  }
}

TEST(CertainlyApart, MixedMagnitudes) {
  // Coordinates of which each has a magnitude of its own: underflow and overflow in some products and not in others.
  std::array<Tally, 3> tallies{};
  for (std::uint64_t seed = 0; seed < test::case_count(std::uint64_t{30000}); ++seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> share(-1, 1);
    const int span = seed % 2 == 0 ? 1000 : 260;
    std::vector<Point> p(6);
    for (Point& q : p) {
      for (const int axis : {0, 1, 2}) {
        q[axis] = random() % 4 == 0 ? 0 : std::ldexp(share(random), static_cast<int>(span * share(random)));
      }
    }
    const std::uint32_t common = static_cast<std::uint32_t>(seed / 2 % 3);
    SCOPED_TRACE(seed);
    ASSERT_NO_FATAL_FAILURE(check(pair_of(p, common, random), tallies[common]));
  }
  for (const Tally& tally : tallies) EXPECT_GT(tally.pairs, test::case_count(5000));
}

TEST(CertainlyApart, InAnyRoundingMode) {
  std::array<Tally, 3> tallies{};
  for (const int mode : {FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO}) {
    for (std::uint64_t seed = 0; seed < test::case_count(std::uint64_t{20000}); ++seed) {
      std::mt19937_64 random(seed);
      std::uniform_real_distribution<double> share(-1, 1);
      std::vector<Point> p(6);
      for (Point& q : p) q = Point(share(random), share(random), share(random));
      bring_near(p, std::ldexp(1.0, -static_cast<int>(random() % 60)), random);
      // Where products overflow, to infinity or to the largest number.
      if (seed % 2 == 1) {
        for (Point& q : p) q *= std::ldexp(1.0, 200 + static_cast<int>(random() % 800));
      }
      const TriangleSoup soup = pair_of(p, static_cast<std::uint32_t>(seed % 3), random);
      std::fesetround(mode);
      const bool claimed =
          certainly_apart(CorneredTriangle(soup, soup.triangles[0]), CorneredTriangle(soup, soup.triangles[1]));
      std::fesetround(FE_TONEAREST);
      ASSERT_FALSE(claimed && test::forbidden_pair(soup, 0, 1)) << seed;
      tallies[seed % 3].settled += claimed ? 1 : 0;
    }
  }
  for (const Tally& tally : tallies) EXPECT_GT(tally.settled, test::case_count(1000));
}

TEST(CertainlyApart, SaysSoOfNeighboursOnASmoothSurface) {
  // Fans of triangles that go round a vertex are apart in plain sight: of the pairs with common vertices none may be
  // left open here, or a search through a mesh is slow. A flat grid has nothing but pairs in one plane.
  TriangleSoup grid;
  for (int y = 0; y < 8; ++y)
    for (int x = 0; x < 8; ++x) grid.positions.emplace_back(0.1 * x, 0.1 * y, 0.03 * x + 0.07 * y);
  for (std::uint32_t y = 0; y < 7; ++y) {
    for (std::uint32_t x = 0; x < 7; ++x) {
      const std::uint32_t v = 8 * y + x;
      grid.triangles.push_back({v, v + 1, v + 9});
      grid.triangles.push_back({v, v + 9, v + 8});
    }
  }
  for (const TriangleSoup& soup : {test::torus(1, 0.4, 24, 16), grid}) {
    int neighbours = 0;
    for (std::size_t i = 0; i < soup.triangles.size(); ++i) {
      for (std::size_t j = i + 1; j < soup.triangles.size(); ++j) {
        const Triangle& t = soup.triangles[i];
        const Triangle& u = soup.triangles[j];
        if (std::find_first_of(t.begin(), t.end(), u.begin(), u.end()) == t.end()) continue;
        ++neighbours;
        EXPECT_TRUE(certainly_apart(CorneredTriangle(soup, t), CorneredTriangle(soup, u))) << i << " and " << j;
      }
    }
    EXPECT_GT(neighbours, 400);
  }
}

}  // namespace
}  // namespace voxcarve
