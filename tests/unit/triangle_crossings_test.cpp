#include "common/mesh/triangle_crossings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <random>
#include <vector>

#include "common/mesh/aabb_tree.h"
#include "common/run/errors.h"
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

/// A soup of triangles that are neither collinear nor the same, with one vertex a position.
TriangleSoup clean_lattice_soup(int count, int side, std::uint64_t seed) {
  TriangleSoup soup = merge_equal_positions(lattice_soup(count, side, seed));
  std::map<Triangle, int> seen;
  std::erase_if(soup.triangles, [&](const Triangle& t) {
    Triangle sorted = t;
    std::sort(sorted.begin(), sorted.end());
    return test::exactly_collinear({soup.positions[t[0]], soup.positions[t[1]], soup.positions[t[2]]}) ||
           seen[sorted]++ > 0;
  });
  return soup;
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
    const TriangleSoup soup = clean_lattice_soup(40, 2 + static_cast<int>(seed % 4), seed);
    const auto pairs = crossings_of(soup);
    ASSERT_EQ(pairs, slow_crossings(soup));
    found += static_cast<int>(pairs.size());
  }
  EXPECT_GT(found, test::case_count(10000));
}

TEST(FindCrossings, OfSuspectsOnly) {
  for (std::uint64_t seed = 0; seed < test::case_count(std::uint64_t{60}); ++seed) {
    SCOPED_TRACE(seed);
    const TriangleSoup soup = clean_lattice_soup(60, 3 + static_cast<int>(seed % 20), seed);
    RunContext context;
    context.threads = 1 + static_cast<int>(seed % 2);
    const std::vector<Crossing> all = find_crossings(soup, context);
    std::mt19937_64 random(seed);
    for (const std::uint64_t one_in : {1, 2, 10, 1000}) {
      std::vector<bool> suspects(soup.triangles.size());
      for (std::size_t i = 0; i < suspects.size(); ++i) suspects[i] = random() % one_in == 0;
      std::vector<Crossing> expected = all;
      std::erase_if(expected, [&](const Crossing& c) { return !suspects[c.first] && !suspects[c.second]; });
      const std::vector<Crossing> found = find_crossings(soup, suspects, context);
      ASSERT_EQ(found.size(), expected.size());
      for (std::size_t i = 0; i < found.size(); ++i) {
        EXPECT_EQ(found[i].first, expected[i].first);
        EXPECT_EQ(found[i].second, expected[i].second);
        EXPECT_EQ(found[i].coplanar, expected[i].coplanar);
        EXPECT_EQ(found[i].ends, expected[i].ends);
      }
    }
  }
}

TEST(FindCrossings, AtAnyScaleAndAmongClusters) {
  // The same soup at three scales, far apart, the smallest within a rounding error of nothing beside the largest: in
  // each of them the pairs that it has alone, and no others.
  const TriangleSoup soup = clean_lattice_soup(60, 5, 7);
  const auto alone = crossings_of(soup);
  ASSERT_GT(alone.size(), 100U);
  TriangleSoup joined;
  std::vector<std::array<std::uint32_t, 2>> expected;
  for (const double scale : {0x1p-300, 1.0, 0x1p300}) {
    TriangleSoup part = soup;
    for (Point& p : part.positions) p = scale * (p + Point::Constant(scale == 0x1p300 ? 1.0 : 8.0));
    const auto shift = static_cast<std::uint32_t>(joined.triangles.size());
    for (const auto& [first, second] : alone) expected.push_back({first + shift, second + shift});
    append(joined, part);
  }
  EXPECT_EQ(crossings_of(joined), expected);
}

TEST(FindCrossings, RefusesAListLargerThanTheBudget) {
  // Triangles through one line, every two of which cross: 300 * 299 / 2 pairs of 40 bytes, twice.
  TriangleSoup soup;
  for (std::uint32_t i = 0; i < 300; ++i) {
    soup.positions.emplace_back(-1, -1 - 0.001 * i, -1.0 * i);
    soup.positions.emplace_back(1, 1 + 0.001 * i, 1.0 * i);
    soup.positions.emplace_back(2 + i, 2, 0);
    soup.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  RunContext context;
  context.memory_budget = 1'000'000;
  EXPECT_THROW(find_crossings(soup, context), ResourceError);
  context.memory_budget = 100'000'000;
  EXPECT_EQ(find_crossings(soup, context).size(), 300U * 299U / 2U);
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
