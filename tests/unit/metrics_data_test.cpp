// Topology and metrics of real models against what their manifest says, which an independent program (trimesh) wrote.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "common/mesh/io/mesh_io.h"
#include "common/mesh/topology.h"
#include "common/run/text.h"
#include "metrics/metric.h"

namespace voxcarve {
namespace {

/// The fields of a line; commas inside of double quotes belong to the field.
std::vector<std::string> csv_fields(const std::string& line) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (const char c : line) {
    if (c == '"') {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      fields.emplace_back();
    } else {
      fields.back() += c;
    }
  }
  return fields;
}

using Row = std::map<std::string, std::string>;

std::vector<Row> read_manifest(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::vector<Row> rows;
  std::vector<std::string> names;
  for (std::string line; std::getline(file, line);) {
    const std::vector<std::string> fields = csv_fields(line);
    if (names.empty()) {
      names = fields;
      continue;
    }
    Row row;
    for (std::size_t i = 0; i < std::min(names.size(), fields.size()); ++i) row[names[i]] = fields[i];
    rows.push_back(row);
  }
  return rows;
}

class DataFolder : public testing::Test {
 protected:
  void SetUp() override {
    const char* folder = std::getenv("VOXCARVE_DATA");
    if (folder == nullptr) GTEST_SKIP() << "VOXCARVE_DATA does not name a folder of models";
    folder_ = folder;
  }
  std::filesystem::path folder_;
};

TEST_F(DataFolder, TopologyAgreesWithTheManifest) {
  int compared = 0;
  for (const Row& row : read_manifest(folder_ / "MANIFEST.csv")) {
    const std::string& name = row.at("file");
    if (row.at("kind") != "mesh" || !mesh_format(name) || std::stoll(row.at("triangles")) == 0) continue;
    if (std::stoll(row.at("bad_index_tris")) + std::stoll(row.at("nonfinite_vertices")) > 0) continue;  // refused
    SCOPED_TRACE(name);
    const TriangleSoup soup = read_mesh(folder_ / name);
    const SurfaceTopology t = analyze_topology(soup);
    // Triangles that name a vertex twice have no edges here; in the manifest they do.
    if (t.collapsed_triangles > 0) continue;
    ++compared;
    const auto number = [&row](const char* key) { return std::stoll(row.at(key)); };
    EXPECT_EQ(t.triangles, number("triangles"));
    EXPECT_LE(t.vertices, number("vertices"));  // which counts unused ones
    EXPECT_EQ(t.components, number("components"));
    EXPECT_EQ(t.boundary_edges, number("boundary_edges"));
    // Its folded polygons have 6, 1 or no edges with too many triangles, depending on how they are triangulated.
    if (name != "lamp.obj") {
      EXPECT_EQ(t.nonmanifold_edges, number("nonmanifold_edges"));
    }
    EXPECT_EQ(t.closed ? "yes" : "no", row.at("watertight"));
    std::int64_t flipped = 0;
    const EdgeTable edges(soup);
    for (std::size_t e = 0; e < edges.size(); ++e) {
      const auto uses = edges.uses(e);
      flipped += uses.size() == 2 && uses[0].forward == uses[1].forward ? 1 : 0;
    }
    EXPECT_EQ(flipped, number("flipped_edges"));
  }
  EXPECT_GE(compared, 30);
}

TEST_F(DataFolder, CutSoupsAreOrientedManifolds) {
  for (const char* name : {"cycloidal_drive_coloured.ply", "office_chair.obj", "lamp.obj", "nasty/complex_edges.off",
                           "nasty/cubes_touching_edge.stl", "nasty/inconsistent_orientation.stl",
                           "nasty/hourglass_vertex.obj", "nasty/moebius.obj"}) {
    SCOPED_TRACE(name);
    const TriangleSoup cut = cut_to_manifold(read_mesh(folder_ / name));
    const SurfaceTopology t = analyze_topology(cut);
    EXPECT_TRUE(t.oriented);
    EXPECT_EQ(t.nonmanifold_edges, 0);
    EXPECT_EQ(t.nonmanifold_vertices, 0);
  }
}

TEST_F(DataFolder, KnownSolids) {
  RunContext context;
  // A plate with five through-holes; a closed scan without a handle.
  const auto plate = measure_shape(read_mesh(folder_ / "csg_plate_holes.stl"), {}, context);
  EXPECT_EQ(value_of(plate, "genus"), MetricValue(std::int64_t{5}));
  EXPECT_EQ(value_of(plate, "solid.b1"), MetricValue(std::int64_t{5}));
  const auto mushroom = measure_shape(read_mesh(folder_ / "mushroom.off"), {}, context);
  EXPECT_EQ(value_of(mushroom, "solid.b0"), MetricValue(std::int64_t{1}));
  EXPECT_EQ(value_of(mushroom, "solid.b1"), MetricValue(std::int64_t{0}));
  const auto crossing = measure_shape(read_mesh(folder_ / "interpenetrating_two_spheres.stl"), {}, context);
  EXPECT_GT(std::get<std::int64_t>(value_of(crossing, "self_intersections")), 0);
}

TEST_F(DataFolder, OpenBunnyHasTheVolumeOfItsClosedShape) {
  // Sinking a tetrahedron into the middle changes nothing; the open scan has an inside all the same.
  RunContext context;
  const TriangleSoup bunny = read_mesh(folder_ / "bunny_base_holes.ply");
  MetricOptions options;
  options.rays = 512;
  TriangleSoup with_inner = bunny;
  const Point middle(-0.02, 0.1, 0.0);
  TriangleSoup inner;
  inner.positions = {middle, middle + Point(0.01, 0, 0), middle + Point(0, 0.01, 0), middle + Point(0, 0, 0.01)};
  inner.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  append(with_inner, inner);
  const auto values = measure_pair(bunny, with_inner, options, context);
  EXPECT_LT(std::get<double>(value_of(values, "symmetric_difference.relative")), 1e-6);
  EXPECT_GT(std::get<double>(value_of(values, "hausdorff.lower")), 0.005);
}

}  // namespace
}  // namespace voxcarve
