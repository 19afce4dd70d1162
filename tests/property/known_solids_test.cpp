// Solids of known volume, components and genus through the voxel pipeline and back.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "common/mesh/models/primitives.h"
#include "common/mesh/models/procedural.h"
#include "common/mesh/topology.h"
#include "methods/registry.h"
#include "tests/support/shapes.h"

namespace voxcarve {
namespace {

using test::inside_out;
using test::joined;

/// Repaired from one sample a voxel: the volumes below are those of whole voxels.
TriangleSoup repaired(const TriangleSoup& soup, std::vector<std::string> settings) {
  const Method& method = find_method("nooruddin-turk");
  settings.insert(settings.end(), {"supersampling=1", "kernel=box", "smoothing=0"});
  RunContext context;
  const MethodResult result =
      method.run({"solid", soup}, Parameters::parse(method.info().parameters, settings, ""), context);
  const TriangleSoup surface = result.levels->extract(0);
  const auto topology = analyze_topology(surface);
  EXPECT_TRUE(topology.closed && topology.oriented && topology.nonmanifold_vertices == 0);
  return surface;
}

struct Expected {
  std::int64_t components;
  std::int64_t genus;
  double volume;
  double bound;  ///< largest difference of the volume
};

void expect_solid(const TriangleSoup& surface, const Expected& expected) {
  const SurfaceTopology topology = analyze_topology(surface);
  EXPECT_EQ(topology.components, expected.components);
  EXPECT_EQ(topology.genus.value_or(-1), expected.genus);
  EXPECT_NEAR(signed_volume(surface), expected.volume, expected.bound);
}

/// Six standard deviations of the volume of the voxels whose centres lie in a smooth solid. A centre near the surface
/// is in or out as if by chance, so each of the A / h^2 surface voxels adds a rounding error of h^3 / sqrt(12): sigma
/// is h^2 sqrt(A / 12). The midway isosurface bevels as many outer as inner stairs of a smooth surface.
double volume_bound(const TriangleSoup& soup, double voxel_size) {
  return 6 * voxel_size * voxel_size * std::sqrt(surface_area(soup) / 12);
}

constexpr const char* kDirections[] = {"directions=1", "directions=3", "directions=13"};

TEST(KnownSolids, CubeAlignedToTheGrid) {
  // 20 voxels a side of edge 1/20: exactly n^3 voxels. The isosurface bevels edges and corners: see
  // Isosurface.ACubeLosesOnlyItsEdgesAndCorners, (8000 - 12 * 19 / 8 - 5/6) / 8000.
  for (const char* directions : kDirections) {
    expect_solid(repaired(box(Point::Zero(), Point::Ones()), {"resolution=20", directions}),
                 {1, 0, (8000 - 28.5 - 5.0 / 6) / 8000, 1e-12});
  }
}

TEST(KnownSolids, Sphere) {
  const TriangleSoup sphere = icosphere(Point(1, 2, 3), 2, 4);
  for (const char* directions : kDirections) {
    expect_solid(repaired(sphere, {"resolution=48", directions}),
                 {1, 0, signed_volume(sphere), volume_bound(sphere, 4.0 / 48)});
  }
}

TEST(KnownSolids, Torus) {
  const TriangleSoup shape = torus(3, 1, 96, 48);
  for (const char* directions : kDirections) {
    expect_solid(repaired(shape, {"resolution=64", directions}),
                 {1, 1, signed_volume(shape), volume_bound(shape, 8.0 / 64)});
  }
}

TEST(KnownSolids, GenusThree) {
  // A plate of 7 x 3 x 1 unit cubes without three of them, on voxels of 1/9: exactly 18 * 9^3. The isosurface bevels
  // edges by h^2 / 8 a length: 44 outer and 24 rim edges lose, 12 inner edges (3 holes of 4) gain: 7 h^2 in all, and
  // each of the 32 corners is within one voxel.
  const TriangleSoup shape = make_procedural("genus-n?genus=3");
  const double h = 1.0 / 9;
  for (const char* directions : kDirections) {
    expect_solid(repaired(shape, {"resolution=63", directions}), {1, 3, 18 - 7 * h * h, 32 * h * h * h});
  }
}

TEST(KnownSolids, NestedShellsKeepTheVoidByParity) {
  // A ball of radius 2 with a void of radius 1: two surfaces, one solid. Stabbing cannot see the void.
  const TriangleSoup outer = icosphere(Point::Zero(), 2, 4);
  const TriangleSoup inner = icosphere(Point::Zero(), 1, 4);
  const TriangleSoup shells = joined({outer, inside_out(inner)});
  const double bound = volume_bound(shells, 4.0 / 48);
  for (const char* directions : kDirections) {
    expect_solid(repaired(shells, {"resolution=48", directions}),
                 {2, 0, signed_volume(outer) - signed_volume(inner), bound});
  }
  expect_solid(repaired(shells, {"resolution=48", "directions=13", "classifier=stabbing"}),
               {1, 0, signed_volume(outer), bound});
}

TEST(KnownSolids, TwoCubesThatTouchInAFaceAreOne) {
  // Equal faces with opposite normals: a ray crosses both, so parity sees none. 2 x 1 x 1 at 20 voxels: 20 x 10 x 10.
  const TriangleSoup cubes = joined({box(Point::Zero(), Point::Ones()), box(Point(1, 0, 0), Point(2, 1, 1))});
  // Lost on the edges: 4 of 20 and 8 of 10 voxels, (4 * 19 + 8 * 9) / 8, and 5/6 at the corners.
  const double voxels = 2000 - (4 * 19 + 8 * 9) / 8.0 - 5.0 / 6;
  for (const char* directions : kDirections) {
    expect_solid(repaired(cubes, {"resolution=20", directions}), {1, 0, voxels / 1000, 1e-12});
  }
}

TEST(KnownSolids, TwoCubesThatTouchInAnEdgeAreTwo) {
  // Interiors are 6-connected, so a shared edge does not join them: two components, each an n^3 cube of 10 voxels.
  const TriangleSoup cubes = joined({box(Point::Zero(), Point::Ones()), box(Point(1, 1, 0), Point(2, 2, 1))});
  // Each loses 12 * 9 / 8 on its edges and 5/6 at its corners: along the shared edge they are bevelled as elsewhere.
  const double voxels = 2 * (1000 - 13.5 - 5.0 / 6);
  for (const char* directions : kDirections) {
    expect_solid(repaired(cubes, {"resolution=20", directions}), {2, 0, voxels / 1000, 1e-12});
  }
}

TEST(KnownSolids, APerforatedBoxKeepsItsHundredTunnelsUntilTheyAreClosed) {
  const TriangleSoup shape = make_procedural("perforated-box");
  EXPECT_EQ(analyze_topology(repaired(shape, {"resolution=160"})).genus.value_or(-1), 100);
  EXPECT_EQ(analyze_topology(repaired(shape, {"resolution=160", "morphology=close", "distance=8"})).genus.value_or(-1),
            0);
}

}  // namespace
}  // namespace voxcarve
