// The model `blade`: one closed surface of the stated size, genus and proportions.
#include <gtest/gtest.h>

#include "common/mesh/topology.h"
#include "common/volume/grid.h"
#include "common/volume/voxelize.h"
#include "tests/unit/model_checks.h"

namespace voxcarve {
namespace {

using namespace test;

// Five channels from root to tip; nine rows of 28 film holes, a row of 30 slots, 20 crossovers: each a handle.
constexpr std::int64_t kGenus = 5 + 9 * 28 + 30 + 20;

TEST(Blade, HasThePapersNumberOfFaces) {
  const TriangleSoup soup = make_procedural("blade");
  EXPECT_EQ(soup.triangles.size(), 1'726'892U);  // [NT03, Fig. 6]
  // Of a connected closed surface V - F / 2 = 2 - 2 g.
  EXPECT_EQ(static_cast<std::int64_t>(soup.positions.size()), 1'726'892 / 2 + 2 - 2 * kGenus);
  // The paper's 643 x 300 x 382 voxels, the long side upright.
  const GridFrame frame = voxel_frame(bounds(soup), 643);
  EXPECT_EQ(frame.dims, (Index3{382, 300, 643}));
}

TEST(Blade, IsOneSurfaceOfItsGenusAtAnyDetail) {
  for (const char* spec : {"blade?detail=0.05", "blade?detail=0.1", "blade?detail=0.23&splits=0"}) {
    const TriangleSoup soup = make_procedural(spec);
    const SurfaceTopology topology = analyze_topology(soup);
    EXPECT_EQ(topology.components, 1) << spec;
    EXPECT_TRUE(topology.closed && topology.oriented) << spec;
    EXPECT_EQ(topology.nonmanifold_vertices, 0) << spec;
    EXPECT_EQ(topology.genus, kGenus) << spec << " " << topology.genus_reason;
    EXPECT_EQ(std::ranges::count_if(soup.triangles, [&](const Triangle& t) { return is_degenerate(soup, t); }), 0)
        << spec;
    EXPECT_EQ(merge_equal_positions(soup).positions.size(), soup.positions.size()) << spec;
    // The platform is 382 x 300, root to tip 643.
    EXPECT_NEAR((bounds(soup).extent() - Point(382, 300, 643)).norm(), 0, 1e-9) << spec;
  }
}

TEST(Blade, DetailIsAFactorOnTheCount) {
  EXPECT_NEAR(static_cast<double>(make_procedural("blade?detail=0.1").triangles.size()), 172'689, 0.07 * 172'689);
  // A split turns one triangle into three.
  EXPECT_EQ(make_procedural("blade?detail=0.05&splits=10").triangles.size(),
            make_procedural("blade?detail=0.05&splits=0").triangles.size() + 20);
}

TEST(Blade, EndFacesAreFlatAndDoNotOverlapThemselves) {
  const TriangleSoup soup = make_procedural("blade?detail=0.1");
  for (const double z : {0.0, 643.0}) {
    std::int64_t faces = 0;
    std::int64_t turned = 0;
    for (const Triangle& t : soup.triangles) {
      if (!std::ranges::all_of(t, [&](std::uint32_t v) { return soup.positions[v].z() == z; })) continue;
      ++faces;
      turned += area_vector(soup, t).z() * (z > 0 ? 1 : -1) > 0 ? 0 : 1;
    }
    EXPECT_GT(faces, 0);
    EXPECT_EQ(turned, 0) << z;
  }
}

TEST(Blade, PlatformFacesDoNotOverlapThemselves) {
  // The platform's underside (205) faces down; the fillet above its top (235) rises, so nothing there faces down.
  const TriangleSoup soup = make_procedural("blade?detail=0.1");
  std::int64_t checked = 0;
  for (const Triangle& t : soup.triangles) {
    const auto all_at = [&](double z) {
      return std::ranges::all_of(t, [&](std::uint32_t v) { return std::abs(soup.positions[v].z() - z) < 1e-9; });
    };
    if (!all_at(205) && !all_at(235)) continue;
    ++checked;
    EXPECT_GT(area_vector(soup, t).z() * (all_at(235) ? 1 : -1), 0);
  }
  EXPECT_GT(checked, 1000);
}

TEST(Blade, ChannelsOpenAtRootAndTip) {
  // Upright lines through the middle of every channel's mouth start outside the metal: parity count along z sees the
  // mouths. 2 voxels below the tip and above the root each slice has five holes and one outline, so the metal there has
  // b1 = 5: in the plane, interior components - exterior components = 1 - 6.
  const TriangleSoup soup = make_procedural("blade?detail=0.1");
  RunContext context;
  const GridFrame frame = voxel_frame(bounds(soup), 322);
  const BinaryVolume volume = voxelize(soup, frame, {.directions = 1, .axis = 2}, context);
  for (const std::int64_t k : {std::int64_t{1}, frame.dims.z() - 2}) {
    // Runs of exterior voxels between metal along the line of greatest extent: count the five openings by flood fill.
    std::vector<char> seen(static_cast<std::size_t>(frame.dims.x() * frame.dims.y()), 0);
    int openings = -1;  // the outside
    for (std::int64_t start = 0; start < frame.dims.x() * frame.dims.y(); ++start) {
      if (seen[static_cast<std::size_t>(start)] != 0 || volume(start % frame.dims.x(), start / frame.dims.x(), k) != 0)
        continue;
      ++openings;
      std::vector<std::int64_t> stack = {start};
      seen[static_cast<std::size_t>(start)] = 1;
      while (!stack.empty()) {
        const std::int64_t x = stack.back() % frame.dims.x();
        const std::int64_t y = stack.back() / frame.dims.x();
        stack.pop_back();
        for (const auto& [dx, dy] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
          const std::int64_t i = x + dx;
          const std::int64_t j = y + dy;
          if (i < 0 || j < 0 || i >= frame.dims.x() || j >= frame.dims.y() || volume(i, j, k) != 0) continue;
          char& mark = seen[static_cast<std::size_t>(j * frame.dims.x() + i)];
          if (mark != 0) continue;
          mark = 1;
          stack.push_back(j * frame.dims.x() + i);
        }
      }
    }
    EXPECT_EQ(openings, 5) << k;
  }
}

}  // namespace
}  // namespace voxcarve
