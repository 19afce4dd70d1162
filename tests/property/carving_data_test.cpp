// Carving real models.
#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>

#include "common/mesh/io/mesh_io.h"
#include "common/mesh/topology.h"
#include "methods/hagbi_elsana/stream_file.h"
#include "metrics/self_intersections.h"
#include "tests/support/carving.h"
#include "tests/support/shapes.h"

namespace voxcarve {
namespace {

namespace fs = std::filesystem;

/// So many numbers of vertices from the hull's to the model's: levels are closed manifolds that do not pass through
/// themselves, and a file of the stream gives the same.
void expect_sound_levels(const fs::path& path, std::int64_t levels) {
  const CarvingStream stream = test::carved(merge_equal_positions(read_mesh(path)));
  std::string pattern = (fs::temp_directory_path() / "voxcarve-XXXXXX").string();
  ASSERT_NE(mkdtemp(pattern.data()), nullptr);
  RunContext context;
  context.threads = 2;
  write_stream(stream, fs::path(pattern) / "stream.vcs");
  const CarvingStream again = read_stream(fs::path(pattern) / "stream.vcs", context);
  fs::remove_all(pattern);
  EXPECT_EQ(again.levels(), stream.levels());
  EXPECT_EQ(again.steps(), stream.steps());
  const std::int64_t first = stream.vertices(0);
  const std::int64_t last = stream.vertices(stream.last_step());
  ASSERT_LT(first, last);
  for (std::int64_t i = 0; i < levels; ++i) {
    const std::int64_t vertices = first + (last - first) * i / (levels - 1);
    SCOPED_TRACE(std::to_string(vertices) + " vertices");
    const std::uint32_t step = stream.step_for_vertices(vertices);
    EXPECT_EQ(stream.vertices(step), vertices);
    const TriangleSoup surface = stream.extract(step);
    EXPECT_EQ(again.extract(step, &context), surface);
    const SurfaceTopology topology = analyze_topology(surface);
    EXPECT_TRUE(topology.closed);
    EXPECT_TRUE(topology.oriented);
    EXPECT_EQ(topology.nonmanifold_edges, 0);
    EXPECT_EQ(topology.nonmanifold_vertices, 0);
    EXPECT_EQ(merge_equal_positions(surface).positions.size(), static_cast<std::size_t>(vertices));
    EXPECT_EQ(count_self_intersections(surface, context), MetricValue(std::int64_t{0}));
  }
}

TEST(CarvedData, TheHorse) {
  VOXCARVE_REQUIRE_DATA(path, "horse_97k.ply");
  expect_sound_levels(path, 20);
}

TEST(CarvedData, TheBunnyWithItsHoles) {
  VOXCARVE_REQUIRE_DATA(path, "bunny_base_holes.ply");
  expect_sound_levels(path, 5);
}

}  // namespace
}  // namespace voxcarve
