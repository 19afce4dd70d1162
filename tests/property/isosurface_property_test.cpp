// Volume and surface agree: the isosurface of any binary volume is a closed oriented 2-manifold whose components and
// genus are those of the digital topology.
#include <gtest/gtest.h>

#include <stop_token>
#include <vector>

#include "common/mesh/topology.h"
#include "common/run/errors.h"
#include "common/volume/betti.h"
#include "common/volume/isosurface.h"
#include "common/volume/isosurface_table.h"
#include "tests/support/shapes.h"

namespace voxcarve {
namespace {

using test::frame_of;
using test::random_volume;

void expect_closed_manifold(const SurfaceTopology& topology) {
  ASSERT_TRUE(topology.closed);
  ASSERT_TRUE(topology.oriented);
  ASSERT_EQ(topology.nonmanifold_edges, 0);
  ASSERT_EQ(topology.nonmanifold_vertices, 0);
  ASSERT_EQ(topology.collapsed_triangles, 0);
}

TEST(IsosurfaceProperty, RandomVolumesGiveManifoldsOfTheirDigitalTopology) {
  RunContext context;
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    const Index3 dims(1 + static_cast<std::int64_t>(seed % 6), 1 + static_cast<std::int64_t>(seed / 6 % 6),
                      2 + static_cast<std::int64_t>(seed / 36 % 5));
    const BinaryVolume volume = random_volume(dims, 0.1 + 0.1 * static_cast<double>(seed % 9), seed);
    const TriangleSoup surface = isosurface(volume, context);
    const SurfaceTopology topology = analyze_topology(surface);
    ASSERT_NO_FATAL_FAILURE(expect_closed_manifold(topology)) << "seed " << seed;
    const BettiNumbers betti = betti_numbers(volume, context);
    ASSERT_GE(betti.b1, 0);
    // Every solid component has one outer surface and every void one surface of its own.
    ASSERT_EQ(topology.components, betti.b0 + betti.b2) << "seed " << seed;
    // The boundary of a solid has twice its Euler characteristic.
    ASSERT_EQ(topology.euler_characteristic, 2 * (betti.b0 - betti.b1 + betti.b2)) << "seed " << seed;
    // So the genera add up to the tunnels.
    if (!surface.empty()) {
      ASSERT_EQ(topology.genus.value_or(-1), betti.b1) << "seed " << seed;
    }
  }
}

TEST(IsosurfaceProperty, RandomDensitiesGiveManifoldsWithoutZeroAreaTriangles) {
  RunContext context;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    const BinaryVolume pattern = random_volume({6, 5, 4}, 0.5, seed);
    const BinaryVolume second = random_volume({6, 5, 4}, 0.5, seed + 1000);
    DensityVolume density(pattern.frame);
    // Values 0, 0.25, 0.5 (the iso-value itself) and 1.
    for (std::size_t i = 0; i < density.values.size(); ++i) {
      density.values[i] =
          pattern.values[i] != 0 ? (second.values[i] != 0 ? 1.0F : 0.5F) : (second.values[i] != 0 ? 0.25F : 0.0F);
    }
    const TriangleSoup surface = isosurface(density, 0.5F, context);
    ASSERT_NO_FATAL_FAILURE(expect_closed_manifold(analyze_topology(surface)));
    for (const Triangle& triangle : surface.triangles) ASSERT_FALSE(is_degenerate(surface, triangle));
  }
}

TEST(Isosurface, OneVoxelIsAnOctahedronOfASixthOfItsVolume) {
  // Six vertices half a voxel from the centre: an octahedron, volume 4/3 (1/2)^3 = 1/6.
  RunContext context;
  const TriangleSoup surface = isosurface(BinaryVolume(frame_of({1, 1, 1}, Point(3, 4, 5), 2), 1), context);
  EXPECT_EQ(surface.positions.size(), 6U);
  EXPECT_EQ(surface.triangles.size(), 8U);
  EXPECT_DOUBLE_EQ(signed_volume(surface), 8.0 / 6);
  EXPECT_EQ(bounds(surface).lower, Point(3, 4, 5));
  EXPECT_EQ(bounds(surface).upper, Point(5, 6, 7));
}

TEST(Isosurface, ACubeLosesOnlyItsEdgesAndCorners) {
  // n^3 voxels: the surface passes midway, so faces lie on the cube's; each of the 12 edges is bevelled between
  // half-voxel crossings: a triangular prism of cross-section (1/2)^2 / 2 = 1/8 along n - 1 voxels, and at each corner
  // the corner voxel's eighth [0, 1/2]^3 keeps the octahedron's 1/48: 8 (1/8 - 1/48) = 5/6 are lost.
  RunContext context;
  for (const std::int64_t n : {2, 5, 9}) {
    const TriangleSoup surface = isosurface(BinaryVolume(frame_of({n, n, n}), 1), context);
    const auto side = static_cast<double>(n);
    EXPECT_NEAR(signed_volume(surface), side * side * side - 12 * (side - 1) / 8 - 5.0 / 6, 1e-9);
  }
}

TEST(Isosurface, FollowsALinearDensityExactly) {
  // density 1 - |z - 5| / 4 is 0.5 at z = 3 and 7, between samples at half-integers.
  RunContext context;
  DensityVolume density(frame_of({4, 4, 10}));
  for (std::int64_t k = 0; k < 10; ++k)
    for (std::int64_t j = 0; j < 4; ++j)
      for (std::int64_t i = 0; i < 4; ++i)
        density(i, j, k) = static_cast<float>(std::max(0.0, 1 - std::abs(static_cast<double>(k) + 0.5 - 5) / 4));
  const Box box = bounds(isosurface(density, 0.5F, context));
  EXPECT_DOUBLE_EQ(box.lower[2], 3);
  EXPECT_DOUBLE_EQ(box.upper[2], 7);
}

TEST(Isosurface, AScalarFieldClosesOnTheFacesOfItsGrid) {
  RunContext context;
  const TriangleSoup surface = scalar_isosurface(Grid<float>(frame_of({3, 3, 3}), 1000.0F), 500.0F, context);
  EXPECT_TRUE(analyze_topology(surface).closed);
  EXPECT_EQ(bounds(surface).lower, Point::Zero());
  EXPECT_EQ(bounds(surface).upper, Point::Constant(3));
}

TEST(Isosurface, IsEmptyWithoutInteriorAndRefusesAnIsoValueOfZero) {
  RunContext context;
  EXPECT_TRUE(isosurface(BinaryVolume(frame_of({3, 3, 3})), context).empty());
  EXPECT_THROW(isosurface(DensityVolume(frame_of({3, 3, 3})), 0.0F, context), ParameterError);
}

TEST(CubeCases, UseExactlyTheCrossedEdges) {
  for (unsigned mask = 0; mask < 256; ++mask) {
    std::array<bool, 12> used{};
    for (std::size_t t = 0; t < cube_cases()[mask].triangle_count; ++t) {
      for (const std::uint8_t edge : cube_cases()[mask].triangles[t]) used.at(edge) = true;
    }
    for (std::size_t edge = 0; edge < 12; ++edge) {
      const bool crossed = (mask >> kEdgeCorners[edge][0] & 1U) != (mask >> kEdgeCorners[edge][1] & 1U);
      EXPECT_EQ(used[edge], crossed) << mask;
      EXPECT_EQ((cube_cases()[mask].crossed_edges >> edge & 1U) != 0, crossed) << mask;
    }
  }
}

TEST(Isosurface, AsksForItsMemoryBeforeItMakesTheSurface) {
  // 30^3 alternating voxels: each an octahedron of 8 triangles and 6 vertices, 13,500 * (8 * 12 + 6 * 24) bytes.
  BinaryVolume checkerboard(frame_of({30, 30, 30}));
  for (std::int64_t k = 0; k < 30; ++k)
    for (std::int64_t j = 0; j < 30; ++j)
      for (std::int64_t i = 0; i < 30; ++i) checkerboard(i, j, k) = (i + j + k) % 2 == 0;
  RunContext context;
  context.memory_budget = 13500 * 240;
  EXPECT_THROW(isosurface(checkerboard, context), ResourceError);
  // The rows of samples, with one layer around the grid shared by the slices along y: 64 samples a word of 8 bytes, and
  // 24 bytes of counts.
  context.memory_budget += (31 * 32 + 1) * (8 + 24);
  EXPECT_EQ(isosurface(checkerboard, context).triangles.size(), 13500U * 8);
  EXPECT_EQ(context.timings().back().bytes, context.memory_budget);
}

/// By counting every cell and every block whose two exterior voxels are opposite.
std::int64_t slow_euler_characteristic(const BinaryVolume& volume) {
  std::int64_t sum = 0;
  const auto interior = [&](const Index3& v) { return volume.get(v[0], v[1], v[2], 0) != 0; };
  for (std::int64_t k = -1; k < volume.nz(); ++k) {
    for (std::int64_t j = -1; j < volume.ny(); ++j) {
      for (std::int64_t i = -1; i < volume.nx(); ++i) {
        // A cell extends along the axes whose bits are set, and has all its voxels interior.
        std::vector<Index3> exterior;
        for (int cell = 0; cell < 8; ++cell) {
          bool whole = true;
          for (int corner = 0; corner < 8; ++corner) {
            const Index3 voxel = Index3(i, j, k) + Index3(corner & 1, corner >> 1 & 1, corner >> 2);
            if ((corner & ~cell) == 0) whole = whole && interior(voxel);
            if (cell == 0 && !interior(voxel)) exterior.push_back(voxel);
          }
          const int dimension = (cell & 1) + (cell >> 1 & 1) + (cell >> 2);
          if (whole) sum += dimension % 2 == 0 ? 1 : -1;
        }
        const bool opposite = exterior.size() == 2 && ((exterior[0] - exterior[1]).cwiseAbs().array() == 1).all();
        sum += opposite ? 1 : 0;
      }
    }
  }
  return sum;
}

TEST(Betti, TheEulerCharacteristicIsThatOfTheCellsOnAnyNumberOfThreads) {
  RunContext one;
  RunContext three;
  three.threads = 3;
  std::uint64_t seed = 0;
  for (const Index3& dims : {Index3(1, 1, 1), Index3(9, 1, 1), Index3(1, 7, 5), Index3(6, 5, 1), Index3(17, 9, 8),
                             Index3(3000, 10, 11), Index3(0, 3, 3)}) {
    for (const double fill : {0.2, 0.5, 0.8, 1.0}) {
      BinaryVolume volume = random_volume(dims, fill, ++seed);
      for (std::uint8_t& value : volume.values) value = value != 0 ? static_cast<std::uint8_t>(1 + seed) : value;
      const std::int64_t expected = slow_euler_characteristic(volume);
      EXPECT_EQ(euler_characteristic(volume, one), expected) << dims.transpose();
      EXPECT_EQ(euler_characteristic(volume, three), expected) << dims.transpose();
    }
  }
}

TEST(Betti, TheEulerCharacteristicCanBeCancelled) {
  RunContext context;
  std::stop_source stop;
  stop.request_stop();
  context.cancellation = stop.get_token();
  EXPECT_THROW(euler_characteristic(random_volume({9, 9, 9}, 0.5, 1), context), Cancelled);
}

TEST(Betti, KnownVolumes) {
  RunContext context;
  BinaryVolume shell(frame_of({3, 3, 3}), 1);
  shell(1, 1, 1) = 0;
  EXPECT_EQ(betti_numbers(shell, context), (BettiNumbers{1, 0, 1}));
  BinaryVolume ring(frame_of({3, 3, 2}), 1);
  ring(1, 1, 0) = ring(1, 1, 1) = 0;
  EXPECT_EQ(betti_numbers(ring, context), (BettiNumbers{1, 1, 0}));
  BinaryVolume diagonal(frame_of({2, 2, 2}));
  diagonal(0, 0, 0) = diagonal(1, 1, 0) = 1;  // touch in an edge: not 6-connected
  EXPECT_EQ(betti_numbers(diagonal, context), (BettiNumbers{2, 0, 0}));
  BinaryVolume image(frame_of({3, 3, 1}), 1);
  image(1, 1, 0) = 0;
  EXPECT_EQ(betti_numbers(image, context), (BettiNumbers{1, 1, 0}));
}

}  // namespace
}  // namespace voxcarve
