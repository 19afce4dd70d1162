#include "common/volume/surface_voxels.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "common/mesh/aabb_tree.h"
#include "common/mesh/models/primitives.h"
#include "common/run/errors.h"
#include "common/volume/isosurface.h"
#include "tests/support/shapes.h"

namespace voxcarve {
namespace {

using test::frame_of;
using test::joined;

const Color kRed(1, 0, 0);
const Color kGreen(0, 1, 0);
const Color kBlue(0, 0, 1);

/// The square [0, side]^2 of the plane z = height.
TriangleSoup square(double side, double height, const Color& color) {
  TriangleSoup soup;
  soup.positions = {{0, 0, height}, {side, 0, height}, {side, side, height}, {0, side, height}};
  soup.triangles = {{0, 1, 2}, {0, 2, 3}};
  return colored(soup, color);
}

std::vector<std::int64_t> slice_voxels(const GridFrame& frame, std::int64_t k) {
  std::vector<std::int64_t> voxels;
  for (std::int64_t i = 0; i < frame.dims[0] * frame.dims[1]; ++i)
    voxels.push_back(k * frame.dims[0] * frame.dims[1] + i);
  return voxels;
}

TEST(SurfaceColors, OfAPlaneAreOneLayerOrTwoWhenItLiesOnABorder) {
  // A square over the whole width of the grid meets exactly the voxels of the layer that it lies in; on the border of
  // two layers their closed cubes meet it both.
  RunContext context;
  const GridFrame frame = frame_of({8, 8, 6});
  const SurfaceColors inside = record_surface_colors(square(8, 2.25, kRed), frame, context);
  EXPECT_EQ(inside.frame, frame);
  EXPECT_EQ(inside.voxels, slice_voxels(frame, 2));
  EXPECT_EQ(inside.colors, std::vector<Color>(64, kRed));
  std::vector<std::int64_t> both = slice_voxels(frame, 2);
  both.insert(both.end(), 64, 0);
  std::ranges::copy(slice_voxels(frame, 3), both.begin() + 64);
  EXPECT_EQ(record_surface_colors(square(8, 3, kRed), frame, context).voxels, both);
}

TEST(SurfaceColors, TouchingCubesCountAndNearMissesDoNot) {
  // The triangle with corners (1, 0), (0, 1), (0, 0) at height 0.5, times 4 and moved by 0.5: its long side runs along
  // x + y = 5. A voxel (i, j) meets it iff its lowest corner (i, j) is not beyond that side, i + j <= 5, and within the
  // square [0.5, 4.5]: i, j <= 4. Of the 25 voxels of [0, 4]^2, i + j > 5 holds for (2,4) (3,3) (3,4) (4,2) (4,3)
  // (4,4).
  RunContext context;
  TriangleSoup soup;
  soup.positions = {{0.5, 0.5, 0.5}, {4.5, 0.5, 0.5}, {0.5, 4.5, 0.5}};
  soup.triangles = {{0, 1, 2}};
  const GridFrame frame = frame_of({6, 6, 2});
  const SurfaceColors surface = record_surface_colors(colored(soup, kRed), frame, context);
  std::vector<std::int64_t> expected;
  for (std::int64_t j = 0; j < 5; ++j)
    for (std::int64_t i = 0; i < 5; ++i)
      if (i + j <= 5) expected.push_back(6 * j + i);
  EXPECT_EQ(expected.size(), 19U);
  EXPECT_EQ(surface.voxels, expected);
}

/// Whether a triangle meets a closed box, the slow way: by clipping it against the six planes.
bool meets_by_clipping(std::vector<Point> polygon, const Point& low, const Point& high) {
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {1.0, -1.0}) {
      const double limit = sign > 0 ? low[axis] : -high[axis];
      std::vector<Point> kept;
      for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Point& a = polygon[i];
        const Point& b = polygon[(i + 1) % polygon.size()];
        const double da = sign * a[axis] - limit;
        const double db = sign * b[axis] - limit;
        if (da >= 0) kept.push_back(a);
        if ((da < 0) != (db < 0) && da != 0 && db != 0) kept.push_back(a + da / (da - db) * (b - a));
      }
      polygon = kept;
    }
  }
  return !polygon.empty();
}

TriangleSoup random_triangles(std::size_t count, double size, std::uint64_t seed) {
  std::mt19937_64 generator(seed);
  const auto number = [&] { return static_cast<double>(generator() >> 11) * 0x1p-53; };
  TriangleSoup soup;
  for (std::uint32_t t = 0; t < count; ++t) {
    const Point base(12 * number() - 1, 12 * number() - 1, 12 * number() - 1);
    for (int c = 0; c < 3; ++c) {
      soup.positions.push_back(base + size * Point(number() - 0.5, number() - 0.5, number() - 0.5));
      soup.vertex_colors.emplace_back(static_cast<float>(number()), static_cast<float>(number()),
                                      static_cast<float>(number()));
    }
    soup.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
  }
  return soup;
}

TEST(SurfaceColors, AgreeWithClippingEveryTriangleAgainstEveryVoxel) {
  RunContext context;
  context.threads = 2;
  const GridFrame frame = frame_of({10, 10, 10});
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const TriangleSoup soup = random_triangles(3, seed % 2 == 0 ? 8 : 1.5, seed);
    std::vector<std::int64_t> expected;
    for (std::int64_t voxel = 0; voxel < frame.voxels(); ++voxel) {
      const Point low(static_cast<double>(voxel % 10), static_cast<double>(voxel / 10 % 10),
                      static_cast<double>(voxel / 100));
      for (const Triangle& t : soup.triangles) {
        if (!meets_by_clipping({soup.positions[t[0]], soup.positions[t[1]], soup.positions[t[2]]}, low,
                               low + Point::Ones())) {
          continue;
        }
        expected.push_back(voxel);
        break;
      }
    }
    EXPECT_EQ(record_surface_colors(soup, frame, context).voxels, expected) << "seed " << seed;
  }
}

TEST(SurfaceColors, TheNearestTriangleWins) {
  // Two squares in the layer 2 <= z <= 3, whose centres lie at 2.5: 0.2 below them and 0.1 above.
  RunContext context;
  const GridFrame frame = frame_of({4, 4, 6});
  const TriangleSoup far = square(4, 2.3, kRed);
  const TriangleSoup near = square(4, 2.6, kGreen);
  for (const TriangleSoup& soup : {joined({far, near}), joined({near, far})}) {
    EXPECT_EQ(record_surface_colors(soup, frame, context).colors, std::vector<Color>(16, kGreen));
  }
}

TEST(SurfaceColors, OfEquallyNearTrianglesTheFirstWins) {
  RunContext context;
  const GridFrame frame = frame_of({4, 4, 6});
  const TriangleSoup below = square(4, 2.25, kRed);
  const TriangleSoup above = square(4, 2.75, kGreen);
  EXPECT_EQ(record_surface_colors(joined({below, above}), frame, context).colors, std::vector<Color>(16, kRed));
  EXPECT_EQ(record_surface_colors(joined({above, below}), frame, context).colors, std::vector<Color>(16, kGreen));
  // The two halves of a square share a diagonal through the centres of the voxels i = j, which see both at once.
  TriangleSoup halves = square(4, 2.3, kRed);
  halves.triangle_colors[1] = kBlue;
  const SurfaceColors surface = record_surface_colors(halves, frame, context);
  ASSERT_EQ(surface.voxels.size(), 16U);
  for (std::size_t i = 0; i < 16; ++i) {
    const bool in_first = i % 4 >= i / 4;  // x >= y
    EXPECT_EQ(surface.colors[i], in_first ? kRed : kBlue) << i;
  }
}

TEST(SurfaceColors, AreInterpolatedBetweenVerticesAndATrianglesOwnColourWins) {
  // Red grows from 0 at x = 0 to 1 at x = 8: at the centre of voxel i it is (i + 0.5) / 8.
  RunContext context;
  const GridFrame frame = frame_of({8, 8, 3});
  TriangleSoup soup = square(8, 1.4, kBlue);
  soup.triangle_colors.clear();
  for (const Point& p : soup.positions) soup.vertex_colors.emplace_back(static_cast<float>(p[0] / 8), 0.0F, 0.0F);
  const SurfaceColors surface = record_surface_colors(soup, frame, context);
  ASSERT_EQ(surface.voxels.size(), 64U);
  for (std::size_t i = 0; i < 64; ++i) {
    EXPECT_NEAR(surface.colors[i][0], (static_cast<float>(i % 8) + 0.5F) / 8, 1e-6F);
    EXPECT_EQ(surface.colors[i][1], 0.0F);
  }
  soup.triangle_colors = {kGreen, kGreen};
  EXPECT_EQ(record_surface_colors(soup, frame, context).colors, std::vector<Color>(64, kGreen));
  soup.triangle_colors.clear();
  soup.vertex_colors.clear();
  EXPECT_TRUE(record_surface_colors(soup, frame, context).empty());
}

TEST(SurfaceColors, OfACubeAreThoseOfItsFaces) {
  // The faces of [1, 7]^3 + 0.25 lie within layers of voxels. A voxel away from the edges meets one face alone and has
  // its colour; each layer has 7^2 voxels, of which 5^2 are away from the edges.
  RunContext context;
  const GridFrame frame = frame_of({9, 9, 9});
  TriangleSoup cube = box(Point::Constant(1.25), Point::Constant(7.25));
  const std::array<Color, 6> face_color = {kRed, kGreen, kBlue, Color(1, 1, 0), Color(0, 1, 1), Color(1, 0, 1)};
  const auto face_of = [](const Point& outward) {
    Eigen::Index axis = 0;
    outward.cwiseAbs().maxCoeff(&axis);
    return static_cast<std::size_t>(2 * axis + (outward[axis] > 0 ? 1 : 0));
  };
  for (const Triangle& t : cube.triangles) cube.triangle_colors.push_back(face_color.at(face_of(area_vector(cube, t))));
  const SurfaceColors surface = record_surface_colors(cube, frame, context);
  EXPECT_EQ(surface.voxels.size(), 7U * 7 * 7 - 5 * 5 * 5);
  std::array<int, 6> seen{};
  for (std::size_t i = 0; i < surface.voxels.size(); ++i) {
    const std::int64_t index = surface.voxels[i];
    const Index3 voxel(index % 9, index / 9 % 9, index / 81);
    const int on_faces = static_cast<int>(((voxel.array() == 1) || (voxel.array() == 7)).count());
    ASSERT_GE(on_faces, 1);
    if (on_faces > 1) continue;
    const std::size_t face = face_of(voxel.cast<double>() - Point::Constant(4));
    EXPECT_EQ(surface.colors[i], face_color.at(face));
    ++seen.at(face);
  }
  EXPECT_EQ(seen, (std::array<int, 6>{25, 25, 25, 25, 25, 25}));

  // Through the isosurface of the same cube, a vertex in the middle of a face has the face's colour: both voxels of its
  // edge are nearest to that face.
  BinaryVolume solid(frame);
  for (std::int64_t k = 1; k <= 7; ++k)
    for (std::int64_t j = 1; j <= 7; ++j)
      for (std::int64_t i = 1; i <= 7; ++i) solid(i, j, k) = 1;
  TriangleSoup skin = isosurface(solid, context);
  interpolate_colors(skin, NearestColors(surface, frame, context), context);
  ASSERT_EQ(skin.vertex_colors.size(), skin.positions.size());
  int checked = 0;
  for (std::size_t v = 0; v < skin.positions.size(); ++v) {
    const Point from_center = skin.positions[v] - Point::Constant(4.5);
    const Point size = from_center.cwiseAbs();
    if (std::min({size[0] + size[1], size[1] + size[2], size[2] + size[0]}) > 2) continue;
    EXPECT_EQ(skin.vertex_colors[v], face_color.at(face_of(from_center)));
    ++checked;
  }
  EXPECT_GT(checked, 6);
}

TEST(SurfaceColors, AreTheSameFarFromTheOriginAndOnTwoThreads) {
  // 2^20 and 2^-3 are exact, so the same voxels are met.
  RunContext one;
  RunContext two;
  two.threads = 2;
  const TriangleSoup soup = random_triangles(200, 2, 7);
  const SurfaceColors near = record_surface_colors(soup, frame_of({10, 10, 10}), one);
  const Point shift = Point::Constant(0x1p20);
  TriangleSoup moved = soup;
  for (Point& p : moved.positions) {
    p = (p * 0x1p16).array().round() * 0x1p-16;  // keeps the digits that survive so far out
    p = 0.125 * p + shift;
  }
  const SurfaceColors far = record_surface_colors(moved, frame_of({10, 10, 10}, shift, 0.125), two);
  EXPECT_EQ(far.voxels, near.voxels);
  EXPECT_EQ(far.colors, near.colors);
  EXPECT_EQ(record_surface_colors(soup, frame_of({10, 10, 10}), two).colors, near.colors);
}

TEST(SurfaceColors, RefuseATriangleThatIsTooLargeForTheLattice) {
  RunContext context;
  EXPECT_THROW(record_surface_colors(square(1e12, 0, kRed), frame_of({4, 4, 4}), context), InputError);
}

TEST(SurfaceColors, DeclareAsManySlicesAsAreAtWorkAtOnce) {
  // Four slices are one piece of work, whatever the number of threads: 512 * 512 voxels of 16 bytes, 4 MiB.
  TriangleSoup soup = box(Point(1, 1, 1), Point(500, 500, 3));
  soup.vertex_colors.assign(soup.positions.size(), Color(1, 0, 0));
  RunContext context;
  context.threads = 1024;
  context.memory_budget = std::uint64_t{64} << 20;
  EXPECT_FALSE(record_surface_colors(soup, frame_of({512, 512, 4}), context).empty());
  EXPECT_GE(context.timings().back().bytes, std::uint64_t{4} << 20);
}

TEST(SurfaceColors, SurviveTrianglesWithoutArea) {
  RunContext context;
  TriangleSoup soup;
  soup.positions = {{0.5, 0.5, 0.5}, {2.5, 0.5, 0.5}, {1.5, 0.5, 0.5}};
  soup.triangles = {{0, 1, 2}, {0, 0, 0}};
  const SurfaceColors surface = record_surface_colors(colored(soup, kRed), frame_of({4, 4, 4}), context);
  EXPECT_EQ(surface.voxels, (std::vector<std::int64_t>{0, 1, 2}));
}

/// The slow twin: the distance to every surface voxel.
std::int64_t squared_distance_to(const SurfaceColors& surface, const GridFrame& frame, const Index3& voxel,
                                 std::size_t number) {
  const std::int64_t index = surface.voxels[number];
  const Index3& dims = surface.frame.dims;
  const Index3 place(index % dims[0], index / dims[0] % dims[1], index / (dims[0] * dims[1]));
  const Point shift = (surface.frame.origin - frame.origin) / frame.voxel_size;
  return (place + shift.array().round().matrix().cast<std::int64_t>() - voxel).squaredNorm();
}

TEST(NearestColors, AreThoseOfANearestSurfaceVoxelOnLargerAndSmallerGrids) {
  RunContext context;
  SurfaceColors surface;
  surface.frame = frame_of({9, 8, 7}, {1, 2, 3}, 0.5);
  std::mt19937_64 generator(3);
  for (std::int64_t i = 0; i < surface.frame.voxels(); ++i) {
    if (generator() % 40 != 0) continue;
    surface.voxels.push_back(i);
    surface.colors.emplace_back(static_cast<float>(surface.voxels.size()), 0.0F, 0.0F);  // its own number, from 1
  }
  ASSERT_GT(surface.voxels.size(), 5U);
  GridFrame inner = surface.frame;
  inner.dims = {3, 2, 2};
  inner.origin += 0.5 * Point(4, 3, 2);
  for (const GridFrame& frame : {surface.frame, padded(surface.frame, 5), inner}) {
    const NearestColors colors(surface, frame, context);
    EXPECT_EQ(colors.frame(), frame);
    for (std::int64_t k = 0; k < frame.dims[2]; ++k) {
      for (std::int64_t j = 0; j < frame.dims[1]; ++j) {
        for (std::int64_t i = 0; i < frame.dims[0]; ++i) {
          std::int64_t best = std::numeric_limits<std::int64_t>::max();
          for (std::size_t n = 0; n < surface.voxels.size(); ++n)
            best = std::min(best, squared_distance_to(surface, frame, {i, j, k}, n));
          const auto number = static_cast<std::size_t>(colors.at({i, j, k})[0]) - 1;
          ASSERT_EQ(squared_distance_to(surface, frame, {i, j, k}, number), best);
        }
      }
    }
    EXPECT_EQ(colors.at({-3, 1, 100}), colors.at({0, 1, frame.dims[2] - 1}));
  }
  EXPECT_THROW(NearestColors(SurfaceColors(), inner, context), InputError);
}

TEST(InterpolateColors, TakesTheShareAlongTheEdge) {
  // Two coloured voxels: black at i = 0, red at i = 1. A vertex at a quarter of the way between their centres, at x =
  // 0.75, is a quarter red; beyond the grid the border's colour goes on.
  RunContext context;
  SurfaceColors surface;
  surface.frame = frame_of({2, 1, 1}, {10, 20, 30}, 2);
  surface.voxels = {0, 1};
  surface.colors = {Color::Zero(), kRed};
  const NearestColors colors(surface, surface.frame, context);
  TriangleSoup soup;
  const auto at = [](double x, double y) { return Point(10 + 2 * x, 20 + 2 * y, 30 + 2 * 0.5); };
  soup.positions = {at(0.75, 0.5), at(1.25, 0.5), at(-0.25, 0.5), at(1.75, 0.5), at(1.5, 0.75)};
  soup.triangles = {{0, 1, 2}, {2, 3, 4}};
  interpolate_colors(soup, colors, context);
  EXPECT_EQ(soup.vertex_colors, (std::vector<Color>{{0.25F, 0, 0}, {0.75F, 0, 0}, {0, 0, 0}, kRed, kRed}));
}

TEST(ThinShell, FallsLinearlyWithTheDistanceToAPlane) {
  // Centres lie at k + 0.5; the square at 4.25 spans more than the grid, so distances are |k + 0.5 - 4.25|.
  RunContext context;
  TriangleSoup plane = square(40, 4.25, kRed);
  for (Point& p : plane.positions) p -= Point(10, 10, 0);
  const DensityVolume shell = thin_shell(plane, frame_of({20, 20, 12}), 2, context);
  for (std::int64_t k = 0; k < 12; ++k) {
    const double expected = std::max(0.0, 1 - std::abs(static_cast<double>(k) + 0.5 - 4.25) / 2);
    EXPECT_FLOAT_EQ(shell(7, 9, k), static_cast<float>(expected)) << k;
    EXPECT_FLOAT_EQ(shell(19, 0, k), static_cast<float>(expected)) << k;
  }
  EXPECT_THROW(thin_shell(plane, frame_of({2, 2, 2}), 0, context), ParameterError);
  EXPECT_THROW(thin_shell(plane, frame_of({2, 2, 2}), 17, context), ParameterError);
}

TEST(ThinShell, LeavesTheInsideOfASphereEmptyAndAgreesWithEveryTriangleInTurn) {
  RunContext one;
  RunContext two;
  two.threads = 2;
  const TriangleSoup ball = icosphere(Point(1e6 + 10, 10, 10), 7, 2);
  const GridFrame frame = frame_of({21, 20, 19}, Point(1e6, 0, 0));
  const double reach = 1.5;
  const DensityVolume shell = thin_shell(ball, frame, reach, one);
  EXPECT_EQ(thin_shell(ball, frame, reach, two), shell);
  EXPECT_EQ(shell(9, 9, 9), 0.0F);
  EXPECT_GT(shell(16, 9, 9), 0.5F);
  for (std::int64_t k = 0; k < 19; k += 2) {
    for (std::int64_t j = 0; j < 20; j += 3) {
      for (std::int64_t i = 0; i < 21; ++i) {
        double squared = std::numeric_limits<double>::infinity();
        for (const Triangle& t : ball.triangles) {
          squared = std::min(squared, squared_distance(frame.center({i, j, k}), ball.positions[t[0]],
                                                       ball.positions[t[1]], ball.positions[t[2]]));
        }
        EXPECT_NEAR(shell(i, j, k), std::max(0.0, 1 - std::sqrt(squared) / reach), 1e-6);
      }
    }
  }
}

}  // namespace
}  // namespace voxcarve
