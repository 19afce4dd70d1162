#include "methods/hagbi_elsana/walls.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>
#include <string>

#include "common/mesh/models/primitives.h"
#include "common/run/errors.h"
#include "methods/hagbi_elsana/complement.h"
#include "methods/hagbi_elsana/facet_table.h"
#include "methods/hagbi_elsana/valid_complex.h"
#include "tests/support/shapes.h"

namespace voxcarve {
namespace {

Triangle face(const Tetrahedralization& input, std::uint32_t t, int i) {
  const auto& order = Complement::kFace[static_cast<std::size_t>(i)];
  Triangle result{};
  for (std::size_t c = 0; c < 3; ++c) result[c] = input.tetrahedra[t][static_cast<std::size_t>(order[c])];
  return result;
}

/// Is one triangle the other, turned but not turned over?
bool turns_into(Triangle one, const Triangle& other) {
  for (int turn = 0; turn < 3; ++turn) {
    if (one == other) return true;
    std::ranges::rotate(one, one.begin() + 1);
  }
  return false;
}

Tetrahedralization of(const TriangleSoup& soup) {
  RunContext context;
  return make_valid_complex(soup, {}, context).tetrahedralization;
}

/// Around a point on the axis that all triangles of two discs share: more facets with one smallest corner than are
/// looked through one by one.
TriangleSoup spinning_top() {
  constexpr std::uint32_t kSlices = 30;
  TriangleSoup soup;
  soup.positions.emplace_back(0, 0, 0.1);
  for (std::uint32_t i = 0; i < kSlices; ++i) {
    const double angle = 2 * 3.14159265358979 * i / kSlices;
    soup.positions.emplace_back(std::cos(angle), std::sin(angle), 0.01 * i);
    soup.positions.emplace_back(1.5 * std::cos(angle), 1.5 * std::sin(angle), 1 + 0.02 * i);
  }
  for (std::uint32_t i = 0; i < kSlices; ++i) {
    for (std::uint32_t disc = 1; disc <= 2; ++disc) {
      soup.triangles.push_back({0, 2 * i + disc, 2 * ((i + 1) % kSlices) + disc});
    }
  }
  return soup;
}

std::map<std::string, TriangleSoup> models() {
  const TriangleSoup cube = box(Point(0, 0, 0), Point(1, 1, 1));
  TriangleSoup open = torus(2, 0.7, 12, 6);
  open.triangles.resize(open.triangles.size() / 2);
  return {{"cube", cube},
          {"torus", torus(2, 0.7, 12, 6)},
          {"half a torus", open},
          {"cubes that share a face", test::joined({cube, box(Point(1, 0, 0), Point(2, 1, 1))})},
          {"shells", test::joined({uv_sphere(Point(0, 0, 0), 3, 8, 6), as_cavity(uv_sphere(Point(0, 0, 0), 2, 7, 5)),
                                   uv_sphere(Point(0, 0, 0), 1, 6, 4)})},
          {"spinning top", spinning_top()}};
}

TEST(FacetTable, FindsWhatASearchThroughAllFinds) {
  std::mt19937 generator(5);
  // Few points and many facets: long lists at the small corners, short and empty ones at the large; some facets twice.
  std::vector<Triangle> facets;
  for (int f = 0; f < 400; ++f) {
    Triangle t{};
    for (auto& corner : t) corner = generator() % 16;
    if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) facets.push_back(t);
  }
  const FacetTable table(facets, 16);
  for (std::uint32_t a = 0; a < 16; ++a) {
    for (std::uint32_t b = a + 1; b < 16; ++b) {
      for (std::uint32_t c = b + 1; c < 16; ++c) {
        const auto found = table.find<1>(a, {{{b, c}}})[0];
        const auto slow = std::ranges::find_if(facets, [&](const Triangle& t) {
          return std::ranges::is_permutation(t, Triangle{a, b, c});
        });
        ASSERT_EQ(found.exists(), slow != facets.end());
        if (!found.exists()) continue;
        EXPECT_EQ(found.facet(), static_cast<std::uint32_t>(slow - facets.begin()));
        EXPECT_EQ(found.odd(), !turns_into(*slow, {a, b, c}));
      }
    }
  }
}

TEST(FindWalls, FindsWhatASearchThroughAllFacetsFinds) {
  for (const auto& [name, model] : models()) {
    SCOPED_TRACE(name);
    const Tetrahedralization input = of(model);
    std::map<std::set<std::uint32_t>, std::uint32_t> facet_of;
    for (std::uint32_t f = 0; f < input.facets.size(); ++f) {
      facet_of[{input.facets[f].begin(), input.facets[f].end()}] = f;
    }
    std::vector<std::array<std::uint32_t, 3>> expected;
    for (std::uint32_t t = 0; t < input.tetrahedra.size(); ++t) {
      for (int i = 0; i < 4; ++i) {
        const Triangle corners = face(input, t, i);
        const auto found = facet_of.find({corners.begin(), corners.end()});
        if (found != facet_of.end()) expected.push_back({t, static_cast<std::uint32_t>(i), found->second});
      }
    }
    const RunContext context;
    const Walls walls = find_walls(input, context);
    std::vector<std::array<std::uint32_t, 3>> listed;
    std::vector<std::uint8_t> bits(input.tetrahedra.size(), 0);
    walls.for_each([&](const Wall& wall) {
      listed.push_back({wall.tetrahedron, wall.face, wall.facet});
      bits[wall.tetrahedron] |= static_cast<std::uint8_t>(1 << wall.face);
      // kFace is counterclockwise seen from within.
      EXPECT_EQ(wall.in_front, turns_into(face(input, wall.tetrahedron, wall.face), input.facets[wall.facet]));
    });
    EXPECT_EQ(listed, expected);
    EXPECT_EQ(walls.faces, bits);
  }
}

TEST(FindWalls, RefusesFacetsThatAreNoFacesOrThereTwice) {
  const RunContext context;
  Tetrahedralization input = of(torus(2, 0.7, 12, 6));
  Tetrahedralization twice = input;
  twice.facets.push_back(twice.facets.front());
  twice.facet_source.push_back(0);
  EXPECT_THROW(find_walls(twice, context), MethodFailure);
  input.facets.push_back({0, 1, 40});  // corners on the torus's opposite sides
  input.facet_source.push_back(0);
  EXPECT_THROW(find_walls(input, context), MethodFailure);
}

TEST(FindHull, IsWhatHasNoNeighbour) {
  const Tetrahedralization input = of(torus(2, 0.7, 12, 6));
  std::vector<std::pair<std::uint32_t, int>> expected;
  for (std::uint32_t t = 0; t < input.tetrahedra.size(); ++t) {
    for (int i = 0; i < 4; ++i) {
      if (input.neighbors[t][static_cast<std::size_t>(i)] == -1) expected.emplace_back(t, i);
    }
  }
  std::vector<std::pair<std::uint32_t, int>> found;
  for (const HullFace& at : find_hull(input)) found.emplace_back(at.tetrahedron, at.face);
  EXPECT_EQ(found, expected);
}

/// Every tetrahedron takes the smallest mark around it until nothing changes; 0 is beyond the hull.
std::vector<std::uint32_t> slow_regions(const Tetrahedralization& input, const std::vector<std::uint8_t>& barriers) {
  std::vector<std::uint32_t> mark(input.tetrahedra.size());
  for (std::uint32_t t = 0; t < mark.size(); ++t) mark[t] = t + 1;
  for (bool changed = true; changed;) {
    changed = false;
    for (std::uint32_t t = 0; t < mark.size(); ++t) {
      for (std::size_t i = 0; i < 4; ++i) {
        if ((barriers[t] >> i & 1) != 0) continue;
        const std::int32_t beyond = input.neighbors[t][i];
        const std::uint32_t other = beyond < 0 ? 0 : mark[static_cast<std::size_t>(beyond)];
        changed = changed || other < mark[t];
        mark[t] = std::min(mark[t], other);
      }
    }
  }
  std::map<std::uint32_t, std::uint32_t> number{{0, 0}};  // in the order of first tetrahedra
  for (std::uint32_t& m : mark) m = number.try_emplace(m, static_cast<std::uint32_t>(number.size())).first->second;
  return mark;
}

TEST(FindRegions, FindsWhatSmallestMarksFind) {
  const RunContext context;
  std::mt19937 generator(3);
  for (const auto& [name, model] : models()) {
    SCOPED_TRACE(name);
    const Tetrahedralization input = of(model);
    const std::vector<HullFace> hull = find_hull(input);
    std::vector<std::uint8_t> barriers = find_walls(input, context).faces;
    for (int closed = 0; closed < 4; ++closed) {  // the model's walls, then more and more at random, on both sides
      const std::vector<std::uint32_t> expected = slow_regions(input, barriers);
      const Regions regions = find_regions(input, hull, barriers, context);
      EXPECT_EQ(regions.of, expected);
      EXPECT_EQ(regions.count, 1 + *std::ranges::max_element(expected));
      for (std::uint32_t t = 0; t < barriers.size(); ++t) {
        for (std::size_t i = 0; i < 4; ++i) {
          if (generator() % 4 != 0) continue;
          barriers[t] |= static_cast<std::uint8_t>(1 << i);
          const std::int32_t beyond = input.neighbors[t][i];
          if (beyond < 0) continue;
          const auto& back = input.neighbors[static_cast<std::size_t>(beyond)];
          const auto j = std::ranges::find(back, static_cast<std::int32_t>(t)) - back.begin();
          barriers[static_cast<std::size_t>(beyond)] |= static_cast<std::uint8_t>(1 << j);
        }
      }
    }
  }
}

}  // namespace
}  // namespace voxcarve
