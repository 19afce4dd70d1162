// yucca, pine and elm: open leaves and needles on closed wood, of the papers' sizes, that do not cross each other.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "common/mesh/models/growth.h"
#include "tests/unit/model_checks.h"

namespace voxcarve {
namespace {

using namespace test;

/// Within a tenth of the paper's figure.
void expect_near_paper(std::size_t actual, double paper) {
  EXPECT_NEAR(static_cast<double>(actual), paper, 0.1 * paper);
}

/// Edges that only one triangle has.
std::size_t boundary_edges(const TriangleSoup& soup) {
  const std::vector<Edge> edges = sorted_directed_edges(soup);
  EXPECT_EQ(std::ranges::adjacent_find(edges), edges.end()) << "a directed edge stands in two triangles";
  return static_cast<std::size_t>(std::ranges::count_if(edges, [&](const Edge& edge) {
    return !std::ranges::binary_search(edges, Edge{edge[1], edge[0]});
  }));
}

/// How many parts there are of each (vertices, triangles, boundary edges).
std::map<std::array<std::size_t, 3>, int> kinds_of_parts(const std::vector<TriangleSoup>& parts) {
  std::map<std::array<std::size_t, 3>, int> kinds;
  for (const TriangleSoup& part : parts) {
    ++kinds[{part.positions.size(), part.triangles.size(), boundary_edges(part)}];
  }
  return kinds;
}

void expect_sound(const TriangleSoup& soup, const std::string& name) {
  validate(soup, name);
  EXPECT_TRUE(
      std::ranges::none_of(soup.triangles, [&](const Triangle& triangle) { return is_degenerate(soup, triangle); }));
  TriangleSoup used = soup;
  remove_unused_vertices(used);
  EXPECT_EQ(used.positions.size(), soup.positions.size());
  // Separate parts are apart: no vertex of one lies on a vertex of another.
  EXPECT_EQ(merge_equal_positions(soup).positions.size(), soup.positions.size());
}

using Corners = std::array<Point, 3>;

/// True when the segment passes through the triangle; computed by its parameters.
bool passes_through(const Point& from, const Point& to, const Corners& t) {
  const Point normal = (t[1] - t[0]).cross(t[2] - t[0]);
  const double start = normal.dot(from - t[0]);
  const double end = normal.dot(to - t[0]);
  if ((start > 0) == (end > 0)) return false;
  const Point at = from + start / (start - end) * (to - from);
  for (std::size_t k = 0; k < 3; ++k) {
    if ((t[(k + 1) % 3] - t[k]).cross(at - t[k]).dot(normal) < 0) return false;
  }
  return true;
}

/// The slow twin of FreeSpace::crosses, over all pairs of parts.
std::size_t crossing_parts(const std::vector<TriangleSoup>& parts) {
  const auto corners = [](const TriangleSoup& part, const Triangle& t) {
    return Corners{part.positions[t[0]], part.positions[t[1]], part.positions[t[2]]};
  };
  const auto cross = [&](const TriangleSoup& a, const TriangleSoup& b) {
    for (const Triangle& s : a.triangles) {
      for (const Triangle& t : b.triangles) {
        const Corners first = corners(a, s);
        const Corners second = corners(b, t);
        for (std::size_t k = 0; k < 3; ++k) {
          if (passes_through(first[k], first[(k + 1) % 3], second)) return true;
          if (passes_through(second[k], second[(k + 1) % 3], first)) return true;
        }
      }
    }
    return false;
  };
  std::vector<Box> boxes;
  for (const TriangleSoup& part : parts) boxes.push_back(bounds(part));
  std::size_t count = 0;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const bool apart = (boxes[i].lower.array() > boxes[j].upper.array()).any() ||
                         (boxes[j].lower.array() > boxes[i].upper.array()).any();
      if (!apart && cross(parts[i], parts[j])) ++count;
    }
  }
  return count;
}

// --- growth ------------------------------------------------------------------------------------------------------

TEST(SeededSequence, IsSplitmix64) {
  // The first output of splitmix64 for the seed 0 is 0xe220a8397b1dcdaf [SLF14]; its upper 53 bits make the share.
  SeededSequence sequence(0);
  EXPECT_EQ(sequence.uniform(0, 1), static_cast<double>(0xe220a8397b1dcdafU >> 11U) * 0x1p-53);
  // The second is 0x6e789e6aa1b965f4.
  EXPECT_EQ(sequence.uniform(-1, 3), -1 + 4 * (static_cast<double>(0x6e789e6aa1b965f4U >> 11U) * 0x1p-53));
}

TriangleSoup triangle_at(const Point& a, const Point& b, const Point& c) {
  return {.positions = {a, b, c}, .triangles = {{0, 1, 2}}, .vertex_colors = {}, .triangle_colors = {}};
}

TEST(FreeSpace, KnowsWhatCrosses) {
  for (const double cell_size : {0.1, 1.0, 50.0}) {
    FreeSpace space(cell_size);
    space.occupy(triangle_at({0, 0, 0}, {4, 0, 0}, {0, 4, 0}));
    // Its edge passes through (1, 1, 0).
    EXPECT_TRUE(space.crosses(triangle_at({1, 1, -1}, {1, 1, 1}, {9, 9, 0.5})));
    // An edge of the first, from (0, 0, 0) to (4, 0, 0), passes through it at x = 2.
    EXPECT_TRUE(space.crosses(triangle_at({2, -3, -3}, {2, -3, 3}, {2, 2, 0.1})));
    // Above it, and beside it in its plane's neighbourhood.
    EXPECT_FALSE(space.crosses(triangle_at({1, 1, 0.01}, {2, 1, 0.01}, {1, 2, 0.5})));
    EXPECT_FALSE(space.crosses(triangle_at({3, 3, -1}, {3, 3, 1}, {5, 5, 0.1})));
  }
}

TEST(FreeSpace, PlacesTheFirstPieceThatFitsOrTheLast) {
  FreeSpace space(1);
  space.occupy(triangle_at({-9, -9, 0}, {9, -9, 0}, {0, 9, 0}));
  std::vector<double> crowdings;
  const auto falling = [&](double crowding) {
    crowdings.push_back(crowding);
    const double z = 2.5 - static_cast<double>(crowdings.size());  // its lower end: 1.5, 0.5, -0.5, ...
    return triangle_at({0, 0, -z}, {1, 0, 3 - z}, {0, 1, 3 - z});
  };
  // Lower ends at -1.5 and -0.5 reach through the plane; the third stands at 0.5, above it.
  EXPECT_EQ(space.place(falling, 10).positions[0].z(), 0.5);
  EXPECT_EQ(crowdings, (std::vector<double>{0, 0.1, 0.2}));
  crowdings.clear();
  EXPECT_EQ(space.place(falling, 2).positions[0].z(), -0.5);
  EXPECT_EQ(crowdings, (std::vector<double>{0, 0.5}));
}

// --- yucca -------------------------------------------------------------------------------------------------------

TEST(Yucca, HasThePapersSizeInPointedOpenLeaves) {
  const TriangleSoup soup = make_procedural("yucca");
  expect_sound(soup, "yucca");
  expect_near_paper(soup.positions.size(), 801);  // [HE10, Table 1]
  expect_near_paper(soup.triangles.size(), 1'200);
  // A leaf: 5 rows of 5 and 2 points; 4 belts of 8 triangles and 4 at either point; an outline of 2 * 6 edges.
  const std::vector<TriangleSoup> leaves = parts_of(soup);
  EXPECT_EQ(kinds_of_parts(leaves), (std::map<std::array<std::size_t, 3>, int>{{{27, 40, 12}, 30}}));
  EXPECT_EQ(crossing_parts(leaves), 0U);
}

TEST(Yucca, LeavesAreLongNarrowAndRadiate) {
  const double width = 0.09;  // the parameters' defaults
  for (const TriangleSoup& leaf : parts_of(make_procedural("yucca"))) {
    const Point base = leaf.positions.front();
    const Point tip = leaf.positions.back();
    // Lengths are 0.64 (0.8 of 0.8) to 1 along the midrib; the chord of an arc that turns by at most 100 degrees is at
    // least sin(50) / (50 pi / 180) = 0.87 of it.
    EXPECT_GT((tip - base).norm(), 0.64 * 0.87);
    EXPECT_LT((tip - base).norm(), 1.0);
    // Tips lie further from the stem than bases, all of which start within 0.06 of it.
    EXPECT_LE(base.head<2>().norm(), 0.06 + 1e-12);
    EXPECT_GT(tip.head<2>().norm(), base.head<2>().norm());
    // Across a leaf, from edge to edge, is at most its width (a little more for the curve through the rows' shares).
    for (std::size_t row = 0; row < 5; ++row) {
      EXPECT_LT((leaf.positions[1 + 5 * row] - leaf.positions[5 + 5 * row]).norm(), 1.05 * width);
    }
  }
}

// --- pine and elm ------------------------------------------------------------------------------------------------

TEST(Pine, HasThePapersSizeInNeedlesAndWood) {
  const TriangleSoup soup = make_procedural("pine");
  expect_sound(soup, "pine");
  expect_near_paper(soup.positions.size(), 90'125);  // [HE10, Table 1]
  expect_near_paper(soup.triangles.size(), 61'700);
  // 1 + 9 (1 + 6) branches of 5 sides, 4 rings and 2 poles, closed; 2 * 7,393 needles of two quads.
  const std::vector<TriangleSoup> parts = parts_of(soup);
  EXPECT_EQ(kinds_of_parts(parts), (std::map<std::array<std::size_t, 3>, int>{{{22, 40, 0}, 64}, {{6, 4, 6}, 14'786}}));
  for (const TriangleSoup& part : parts) {
    if (part.positions.size() != 22) continue;
    expect_closed(part, "wood");
    EXPECT_GT(signed_volume(part), 0);
  }
}

TEST(Pine, NeedlesDoNotCross) {
  // Fewer, so that comparing all pairs stays quick; as dense, because there are fewer branches.
  EXPECT_EQ(crossing_parts(parts_of(make_procedural("pine?boughs=2&twigs=3&pairs=900"))), 0U);
}

TEST(Elm, HasThePapersSizeInLeavesAndWood) {
  const TriangleSoup soup = make_procedural("elm");
  expect_sound(soup, "elm");
  expect_near_paper(soup.positions.size(), 7'401);  // [HE10, Table 1]
  expect_near_paper(soup.triangles.size(), 8'500);
  // A leaf: 2 rows of 3 and 2 points, one belt of 4 triangles and 2 at either point, an outline of 6 edges.
  const std::vector<TriangleSoup> parts = parts_of(soup);
  EXPECT_EQ(kinds_of_parts(parts), (std::map<std::array<std::size_t, 3>, int>{{{22, 40, 0}, 64}, {{8, 8, 6}, 749}}));
  EXPECT_EQ(crossing_parts(parts), 0U);
}

TEST(Foliage, CountsFollowTheParameters) {
  EXPECT_EQ(make_procedural("yucca?leaves=7&rows=3&columns=2").triangles.size(), 7U * 2 * 3);  // 2 belts, 2 points
  // 1 + 3 (1 + 2) = 10 branches of 40 triangles.
  EXPECT_EQ(make_procedural("pine?boughs=3&twigs=2&pairs=11").triangles.size(), 10U * 40 + 11 * 8);
  EXPECT_EQ(make_procedural("elm?boughs=3&twigs=2&leaves=0").triangles.size(), 10U * 40);
  EXPECT_EQ(make_procedural("elm?boughs=1&twigs=1&leaves=5").triangles.size(), 3U * 40 + 5 * 8);
}

TEST(Foliage, AnotherSeedIsAnotherPlantOfTheSameSize) {
  for (const std::string name : {"yucca", "elm"}) {
    const TriangleSoup first = make_procedural(name);
    const TriangleSoup second = make_procedural(name + "?seed=2");
    EXPECT_EQ(first.triangles, second.triangles);
    EXPECT_NE(first.positions, second.positions);
  }
}

TEST(Foliage, AbsurdSizesAreRefused) {
  // 100,000 leaves of 1000 rows; 1 + 1000 * 1001 branches of 40 triangles.
  EXPECT_THAT(parameter_error("yucca?leaves=100000&rows=1000"), HasSubstr("limit of 20 million"));
  EXPECT_THAT(parameter_error("pine?boughs=1000&twigs=1000"), HasSubstr("limit of 20 million"));
  EXPECT_THAT(parameter_error("elm?boughs=1000&twigs=1000"), HasSubstr("limit of 20 million"));
}

}  // namespace
}  // namespace voxcarve
