// The isosurface against its slow, obvious twin, bit for bit: positions, their order, and triangles.
#include "common/volume/isosurface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <random>
#include <stop_token>
#include <vector>

#include "common/run/errors.h"
#include "common/volume/isosurface_table.h"
#include "tests/support/shapes.h"

namespace voxcarve {
namespace {

using test::frame_of;
using test::random_volume;

/// Marching cubes as one would write it down: a vertex for every crossed grid edge, in the order that the header
/// promises, found again through a map. Samples outside the grid are exterior; share(a, b) is where the surface
/// crosses on the way from sample a to sample b.
TriangleSoup slow_isosurface(const GridFrame& frame, const std::function<bool(const Index3&)>& inside,
                             const std::function<double(const Index3&, const Index3&)>& share) {
  TriangleSoup surface;
  const auto is_inside = [&](const Index3& sample) { return frame.contains(sample) && inside(sample); };
  std::map<std::array<std::int64_t, 4>, std::uint32_t> vertex_on_edge;  // by lower end and axis
  for (std::int64_t k = -1; k < frame.dims[2]; ++k) {
    for (std::int64_t j = -1; j < frame.dims[1]; ++j) {
      for (int axis = 0; axis < 3; ++axis) {
        for (std::int64_t i = -1; i < frame.dims[0]; ++i) {
          const Index3 sample(i, j, k);
          const Index3 other = sample + Index3::Unit(axis);
          if (is_inside(sample) == is_inside(other)) continue;
          vertex_on_edge[{i, j, k, axis}] = static_cast<std::uint32_t>(surface.positions.size());
          Point position = sample.cast<double>() + Point::Constant(0.5);
          position[axis] += share(sample, other);
          surface.positions.emplace_back(frame.origin + frame.voxel_size * position);
        }
      }
    }
  }
  for (std::int64_t k = -1; k < frame.dims[2]; ++k) {
    for (std::int64_t j = -1; j < frame.dims[1]; ++j) {
      for (std::int64_t i = -1; i < frame.dims[0]; ++i) {
        const auto corner = [&](unsigned c) { return Index3(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2 & 1)); };
        unsigned mask = 0;
        for (unsigned c = 0; c < 8; ++c) mask |= unsigned{is_inside(corner(c))} << c;
        const CubeCase& cube = cube_cases()[mask];
        for (std::size_t t = 0; t < cube.triangle_count; ++t) {
          Triangle triangle;
          for (std::size_t c = 0; c < 3; ++c) {
            const std::uint8_t edge = cube.triangles[t][c];
            const Index3 start = corner(kEdgeCorners[edge][0]);
            triangle[c] = vertex_on_edge.at({start[0], start[1], start[2], edge / 4});
          }
          surface.triangles.push_back(triangle);
        }
      }
    }
  }
  return surface;
}

TriangleSoup slow_isosurface(const BinaryVolume& volume) {
  return slow_isosurface(
      volume.frame, [&](const Index3& v) { return volume(v[0], v[1], v[2]) != 0; },
      [](const Index3&, const Index3&) { return 0.5; });
}

double between(double value_a, double value_b, double iso_value) {
  return std::clamp((iso_value - value_a) / (value_b - value_a), 1.0 / 1024, 1 - 1.0 / 1024);
}

TriangleSoup slow_isosurface(const DensityVolume& volume, float iso_value) {
  return slow_isosurface(
      volume.frame, [&](const Index3& v) { return volume(v[0], v[1], v[2]) >= iso_value; },
      [&](const Index3& a, const Index3& b) {
        return between(volume.get(a[0], a[1], a[2], 0), volume.get(b[0], b[1], b[2], 0), iso_value);
      });
}

TriangleSoup slow_scalar_isosurface(const Grid<float>& field, float iso_value) {
  return slow_isosurface(
      field.frame, [&](const Index3& v) { return field(v[0], v[1], v[2]) >= iso_value; },
      [&](const Index3& a, const Index3& b) {
        if (!field.frame.contains(a) || !field.frame.contains(b)) return 0.5;
        return between(field(a[0], a[1], a[2]), field(b[0], b[1], b[2]), iso_value);
      });
}

/// Rows shorter than a word of 64 samples, as long, and longer; lines along every axis, images, single voxels.
std::vector<Index3> awkward_dims() {
  return {{1, 1, 1},  {2, 1, 1},   {1, 7, 1},   {1, 1, 9},   {5, 4, 3},   {31, 6, 5},  {62, 3, 4}, {63, 5, 3},
          {64, 4, 3}, {65, 3, 4},  {66, 2, 2},  {127, 3, 2}, {128, 2, 3}, {129, 3, 3}, {64, 1, 1}, {65, 1, 1},
          {1, 64, 5}, {3, 65, 64}, {64, 64, 1}, {65, 40, 1}, {192, 1, 3}, {200, 3, 1}, {9, 8, 30}};
}

TEST(Isosurface, EqualsItsSlowTwinOnRandomBinaryVolumes) {
  RunContext context;
  std::uint64_t seed = 0;
  for (const Index3& dims : awkward_dims()) {
    for (const double fill : {0.02, 0.3, 0.5, 0.98}) {
      BinaryVolume volume = random_volume(dims, fill, ++seed);
      volume.frame.origin = Point(0.1, -20.3, 7);
      volume.frame.voxel_size = 0.3;
      for (std::uint8_t& value : volume.values) value = value != 0 ? static_cast<std::uint8_t>(seed) : value;
      ASSERT_EQ(isosurface(volume, context), slow_isosurface(volume)) << dims.transpose() << " fill " << fill;
    }
  }
}

TEST(Isosurface, EqualsItsSlowTwinOnFullVolumesAndOnEmptyOnes) {
  RunContext context;
  for (const Index3& dims : awkward_dims()) {
    const BinaryVolume full(frame_of(dims), 1);
    ASSERT_EQ(isosurface(full, context), slow_isosurface(full)) << dims.transpose();
    ASSERT_EQ(isosurface(BinaryVolume(frame_of(dims)), context), TriangleSoup()) << dims.transpose();
  }
  EXPECT_EQ(isosurface(BinaryVolume(frame_of({0, 0, 0})), context), TriangleSoup());
  EXPECT_EQ(isosurface(BinaryVolume(frame_of({64, 0, 2})), context), TriangleSoup());
}

TEST(Isosurface, EqualsItsSlowTwinOnRandomFields) {
  RunContext context;
  std::mt19937_64 generator(1);
  for (const Index3& dims : awkward_dims()) {
    // A quarter each: the iso-value itself, a neighbour of it, 0, and anything.
    DensityVolume density(frame_of(dims, Point(1, 2, 3), 0.7));
    for (float& value : density.values) {
      const float any = static_cast<float>(generator() >> 40) * 0x1p-24F;
      const float choices[4] = {0.375F, generator() % 2 == 0 ? 0.37500003F : 0.37499997F, 0.0F, any};
      value = choices[generator() % 4];
    }
    ASSERT_EQ(isosurface(density, 0.375F, context), slow_isosurface(density, 0.375F)) << dims.transpose();
    ASSERT_EQ(scalar_isosurface(density, 0.375F, context), slow_scalar_isosurface(density, 0.375F)) << dims.transpose();
    // Values and iso-values of any size and sign; 0, with which short rows are filled up, may be interior.
    Grid<float> field = density;
    for (float& value : field.values) value = 1e6F * value - 8e5F;
    ASSERT_EQ(scalar_isosurface(field, -4e5F, context), slow_scalar_isosurface(field, -4e5F)) << dims.transpose();
  }
}

/// A gyroid cut off by a ball: smooth, with rows, words and cells of every kind.
Grid<float> gyroid(const Index3& dims) {
  Grid<float> field(frame_of(dims));
  const Point center = 0.5 * dims.cast<double>();
  for (std::int64_t k = 0; k < dims[2]; ++k)
    for (std::int64_t j = 0; j < dims[1]; ++j)
      for (std::int64_t i = 0; i < dims[0]; ++i) {
        const Point p = field.frame.center({i, j, k});
        const Point q = p * 0.3;
        const double wave =
            std::sin(q[0]) * std::cos(q[1]) + std::sin(q[1]) * std::cos(q[2]) + std::sin(q[2]) * std::cos(q[0]);
        const double ball = 0.4 * static_cast<double>(dims.minCoeff()) - (p - center).norm();
        field(i, j, k) = static_cast<float>(std::min(wave, ball));
      }
  return field;
}

TEST(Isosurface, EqualsItsSlowTwinOnASmoothFieldOnAnyNumberOfThreads) {
  RunContext one;
  RunContext two;
  two.threads = 2;
  // 130 samples make rows of 3 words, so that the 51 * 41 rows of cells are four chunks of at most 682.
  const Grid<float> field = gyroid({130, 50, 40});
  const TriangleSoup expected = slow_scalar_isosurface(field, 0.25F);
  ASSERT_GT(expected.triangles.size(), 5000U);
  EXPECT_EQ(scalar_isosurface(field, 0.25F, one), expected);
  EXPECT_EQ(scalar_isosurface(field, 0.25F, two), expected);
  const BinaryVolume noise = random_volume({130, 50, 40}, 0.1, 3);
  const TriangleSoup expected_noise = slow_isosurface(noise);
  EXPECT_EQ(isosurface(noise, one), expected_noise);
  EXPECT_EQ(isosurface(noise, two), expected_noise);
}

TEST(Isosurface, KeepsCrossingsAwayFromSamples) {
  // Interior 1 beside exterior 0: at an iso-value of 1 the crossing would lie on the interior sample, at 2^-20 almost
  // on the exterior one; both keep a distance of 2^-10 voxel.
  RunContext context;
  const DensityVolume voxel(frame_of({1, 1, 1}), 1.0F);
  EXPECT_EQ(bounds(isosurface(voxel, 1.0F, context)).lower, Point::Constant(0.5 - 1.0 / 1024));
  EXPECT_EQ(bounds(isosurface(voxel, 0x1p-20F, context)).lower, Point::Constant(-0.5 + 1.0 / 1024));
}

TEST(Isosurface, HasNoZeroAreaTriangleFarFromTheOrigin) {
  // Up to the coarsest coordinates that `voxel_frame` lets pass: a voxel of eight last digits. Iso-values next to the
  // samples' own put crossings as near to samples as they come.
  RunContext context;
  std::mt19937_64 random(7);
  Grid<float> field(frame_of({20, 9, 8}));
  for (float& value : field.values) value = random() % 2 == 0 ? 0.5F : 0.25F;
  for (const double offset : {0.0, 1e10, 1e11, 1e12, -1e12}) {
    for (const double voxel_size : {1.0 / 128, 8 * std::abs(offset) * std::numeric_limits<double>::epsilon()}) {
      if (voxel_size == 0) continue;
      field.frame.origin = Point(offset, 0.3 * offset, -offset);
      field.frame.voxel_size = voxel_size;
      for (const float iso_value : {0.25000003F, 0.375F, 0.5F}) {
        for (const TriangleSoup& surface :
             {isosurface(field, iso_value, context), scalar_isosurface(field, iso_value, context)}) {
          ASSERT_GT(surface.triangles.size(), 1000U);
          EXPECT_EQ(
              std::ranges::count_if(surface.triangles, [&](const Triangle& t) { return is_degenerate(surface, t); }), 0)
              << offset << " voxel " << voxel_size << " iso " << iso_value;
          EXPECT_EQ(merge_equal_positions(surface).positions.size(), surface.positions.size());
        }
      }
    }
  }
}

TEST(Isosurface, ReportsProgressToTheEndAndCanBeCancelled) {
  const Grid<float> field = gyroid({130, 130, 130});
  RunContext context;
  std::int64_t last = -1;
  std::int64_t total = 0;
  std::stop_source stop;
  context.cancellation = stop.get_token();
  context.progress = [&](const ProgressEvent& event) {
    EXPECT_GE(event.done, last);
    last = event.done;
    total = event.total;
  };
  EXPECT_FALSE(scalar_isosurface(field, 0.25F, context).empty());
  EXPECT_EQ(last, total);
  EXPECT_GT(total, 0);
  // Stopped half-way.
  context.progress = [&](const ProgressEvent& event) {
    if (event.done > event.total / 2) stop.request_stop();
  };
  EXPECT_THROW(scalar_isosurface(field, 0.25F, context), Cancelled);
}

TEST(Isosurface, AsksForItsTablesBeforeItMakesThem) {
  // 100 rows of 1000 samples and one layer around them: 101 * 3 + 1 rows with 16 words of 8 bytes and 24 bytes of
  // counts.
  RunContext context;
  context.memory_budget = (101 * 3 + 1) * (16 * 8 + 24) - 1;
  const BinaryVolume volume(frame_of({1000, 100, 1}));
  EXPECT_THROW(isosurface(volume, context), ResourceError);
  ++context.memory_budget;
  EXPECT_TRUE(isosurface(volume, context).empty());
  EXPECT_EQ(context.timings().back().bytes, context.memory_budget);
}

}  // namespace
}  // namespace voxcarve
