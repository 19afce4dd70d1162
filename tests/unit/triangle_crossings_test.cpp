#include "common/mesh/triangle_crossings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <vector>

#include "common/mesh/aabb_tree.h"
#include "tests/support/shapes.h"
#include "tests/unit/arrangement_checks.h"

namespace voxcarve {
namespace {

using test::lattice_soup;
using test::slow_crossings;

std::vector<std::array<std::uint32_t, 2>> crossings_of(const TriangleSoup& soup) {
  RunContext context;
  std::vector<std::array<std::uint32_t, 2>> pairs;
  for (const Crossing& crossing : find_crossings(soup, context)) pairs.push_back({crossing.first, crossing.second});
  return pairs;
}

/// Number of crossings of two triangles, the second given in each of its six orders; they agree.
std::size_t crossings_between(const std::vector<Point>& first, std::vector<Point> second) {
  std::optional<std::size_t> count;
  std::array<std::size_t, 3> order{0, 1, 2};
  do {
    TriangleSoup soup;
    soup.positions = first;
    for (const std::size_t i : order) soup.positions.push_back(second[i]);
    soup.triangles = {{0, 1, 2}, {3, 4, 5}};
    const auto pairs = crossings_of(merge_equal_positions(soup));
    EXPECT_TRUE(!count || *count == pairs.size());
    count = pairs.size();
  } while (std::next_permutation(order.begin(), order.end()));
  return *count;
}

TEST(FindCrossings, PairsByHand) {
  const std::vector<Point> base{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}};
  // Allowed: apart; a common corner; a common edge at an angle or flat on the other side; the same triangle.
  EXPECT_EQ(crossings_between(base, {{0, 0, 1}, {4, 0, 1}, {0, 4, 1}}), 0U);
  EXPECT_EQ(crossings_between(base, {{0, 0, 0}, {-1, 0, 0}, {0, -1, 0}}), 0U);
  EXPECT_EQ(crossings_between(base, {{0, 0, 0}, {1, 1, 1}, {1, 1, 2}}), 0U);
  EXPECT_EQ(crossings_between(base, {{0, 0, 0}, {4, 0, 0}, {1, 1, 1}}), 0U);
  EXPECT_EQ(crossings_between(base, {{0, 0, 0}, {4, 0, 0}, {1, -1, 0}}), 0U);
  EXPECT_EQ(crossings_between(base, base), 0U);
  // Through the inside; a corner on the inside, on an edge; an edge on an edge; an edge across an edge.
  EXPECT_EQ(crossings_between(base, {{1, 1, -1}, {1, 1, 1}, {9, 9, 0}}), 1U);
  EXPECT_EQ(crossings_between(base, {{1, 1, 0}, {1, 1, 1}, {2, 1, 1}}), 1U);
  EXPECT_EQ(crossings_between(base, {{2, 0, 0}, {1, 1, 1}, {2, 1, 1}}), 1U);
  EXPECT_EQ(crossings_between(base, {{1, 0, 0}, {3, 0, 0}, {2, 0, 1}}), 1U);
  EXPECT_EQ(crossings_between(base, {{2, 0, -1}, {2, 0, 1}, {2, -5, 0}}), 1U);
  // From a common corner: through the opposite edge's inside, along a part of an edge, along the inside.
  EXPECT_EQ(crossings_between(base, {{0, 0, 0}, {3, 3, -1}, {3, 3, 1}}), 1U);
  EXPECT_EQ(crossings_between(base, {{0, 0, 0}, {2, 0, 0}, {1, 0, 1}}), 1U);
  EXPECT_EQ(crossings_between(base, {{0, 0, 0}, {1, 1, 0}, {1, 1, 1}}), 1U);
  // In the plane: inside of each other, from a common corner, on one side of a common edge, touching in half an edge.
  EXPECT_EQ(crossings_between(base, {{1, 1, 0}, {2, 1, 0}, {1, 2, 0}}), 1U);
  EXPECT_EQ(crossings_between(base, {{0, 0, 0}, {5, 1, 0}, {1, 5, 0}}), 1U);
  EXPECT_EQ(crossings_between(base, {{0, 0, 0}, {4, 0, 0}, {9, 1, 0}}), 1U);
  EXPECT_EQ(crossings_between(base, {{0, 0, 0}, {2, 0, 0}, {1, -1, 0}}), 1U);
  EXPECT_EQ(crossings_between(base, {{-1, -1, 0}, {9, -1, 0}, {-1, 9, 0}}), 1U);
}

TEST(FindCrossings, OneUnitInTheLastPlaceDecides) {
  // A corner that floats above the inside of the other by the smallest number there is does not touch it.
  const std::vector<Point> base{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}};
  const double least = std::numeric_limits<double>::denorm_min();
  EXPECT_EQ(crossings_between(base, {{1, 1, least}, {1, 1, 1}, {2, 1, 1}}), 0U);
  EXPECT_EQ(crossings_between(base, {{1, 1, -least}, {1, 1, 1}, {2, 1, 1}}), 1U);
  // On the slanted edge x + y = 4, and one unit outside of it.
  EXPECT_EQ(crossings_between(base, {{1, 3, 0}, {9, 9, 1}, {9, 9, 2}}), 1U);
  EXPECT_EQ(crossings_between(base, {{1, std::nextafter(3.0, 4.0), 0}, {9, 9, 1}, {9, 9, 2}}), 0U);
}

TEST(FindCrossings, AgreesWithEveryPairByExactIntegers) {
  // Lattices of 2 to 5 points: most pairs touch in corners, along edges, or overlap in a plane.
  int found = 0;
  for (std::uint64_t seed = 0; seed < test::case_count(std::uint64_t{300}); ++seed) {
    SCOPED_TRACE(seed);
    const TriangleSoup merged = merge_equal_positions(lattice_soup(40, 2 + static_cast<int>(seed % 4), seed));
    TriangleSoup soup = merged;
    soup.triangles.clear();
    std::map<Triangle, int> seen;
    for (const Triangle& t : merged.triangles) {
      Triangle sorted = t;
      std::sort(sorted.begin(), sorted.end());
      const bool flat =
          test::exactly_collinear({merged.positions[t[0]], merged.positions[t[1]], merged.positions[t[2]]});
      if (!flat && seen[sorted]++ == 0) soup.triangles.push_back(t);
    }
    const auto pairs = crossings_of(soup);
    ASSERT_EQ(pairs, slow_crossings(soup));
    found += static_cast<int>(pairs.size());
  }
  EXPECT_GT(found, test::case_count(10000));
}

TEST(FindCrossings, ContactPointsLieInBoth) {
  // On small integers the point of an edge in a plane is computed well enough to say that it is in both triangles.
  int compared = 0;
  for (std::uint64_t seed = 0; seed < test::case_count(std::uint64_t{200}); ++seed) {
    TriangleSoup soup = lattice_soup(1, 7, seed);
    append(soup, lattice_soup(1, 7, seed + 1000));
    soup = merge_equal_positions(soup);
    if (test::exactly_collinear(test::corners_of(soup, 0)) || test::exactly_collinear(test::corners_of(soup, 1)))
      continue;
    RunContext context;
    for (const Crossing& crossing : find_crossings(soup, context)) {
      if (crossing.coplanar) continue;
      for (const ContactPoint& end : crossing.ends) {
        Point p = soup.positions[end.from];
        if (!end.is_vertex()) {
          const auto c = test::corners_of(soup, end.triangle);
          const Point normal = (c[1] - c[0]).cross(c[2] - c[0]);
          const Point along = soup.positions[end.to] - p;
          p += normal.dot(c[0] - p) / normal.dot(along) * along;
        }
        for (std::size_t t = 0; t < 2; ++t) {
          const auto c = test::corners_of(soup, t);
          ++compared;
          EXPECT_LT(squared_distance(p, c[0], c[1], c[2]), 1e-26) << seed;
        }
      }
    }
  }
  EXPECT_GT(compared, test::case_count(100));
}

}  // namespace
}  // namespace voxcarve
