#include "common/volume/voxelize.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/mesh/models/primitives.h"
#include "common/run/errors.h"
#include "tests/support/shapes.h"

namespace voxcarve {
namespace {

using test::frame_of;
using test::inside_out;
using test::joined;

BinaryVolume voxelize_with(const TriangleSoup& soup, const GridFrame& frame, Classifier classifier, int directions) {
  RunContext context;
  return voxelize(soup, frame, {.classifier = classifier, .directions = directions}, context);
}

constexpr Classifier kClassifiers[] = {Classifier::kParity, Classifier::kStabbing};
constexpr int kDirectionCounts[] = {1, 3, 13};

TEST(Voxelize, CubeOnVoxelFacesFillsExactlyItsVoxels) {
  // Every voxel of [2, 6]^3 in a grid of 8^3 unit voxels has its centre inside: 4^3 of them.
  const TriangleSoup cube = box(Point::Constant(2), Point::Constant(6));
  for (const Classifier classifier : kClassifiers) {
    for (const int directions : kDirectionCounts) {
      const BinaryVolume volume = voxelize_with(cube, frame_of({8, 8, 8}), classifier, directions);
      EXPECT_EQ(count_interior(volume), 64) << directions;
      EXPECT_EQ(volume(2, 2, 2), 1);
      EXPECT_EQ(volume(1, 2, 2), 0);
    }
  }
}

TEST(Voxelize, CubeThroughVoxelCentresIsHalfOpenWithEveryClassifierAndDirection) {
  // All faces, edges and corners of [1.5, 5.5]^3 pass through voxel centres 1 and 5. Moved by (e, e^2, e^3), centres
  // 1 ... 4 lie inside in every coordinate: 4^3 again, the same ones for every way of counting.
  const TriangleSoup cube = box(Point::Constant(1.5), Point::Constant(5.5));
  for (const TriangleSoup& soup : {cube, inside_out(cube)}) {
    for (const Classifier classifier : kClassifiers) {
      for (const int directions : kDirectionCounts) {
        const BinaryVolume volume = voxelize_with(soup, frame_of({8, 8, 8}), classifier, directions);
        EXPECT_EQ(count_interior(volume), 64) << directions;
        for (std::int64_t k = 0; k < 8; ++k) {
          for (std::int64_t j = 0; j < 8; ++j) {
            for (std::int64_t i = 0; i < 8; ++i) {
              const bool inside = std::min({i, j, k}) >= 1 && std::max({i, j, k}) <= 4;
              ASSERT_EQ(volume(i, j, k) != 0, inside) << i << " " << j << " " << k << " directions " << directions;
            }
          }
        }
      }
    }
  }
}

TEST(Voxelize, SlantedFacesThroughVoxelCentresAgreeAlongAllAxes) {
  // The octahedron |x| + |y| + |z| <= 3 about voxel (4, 4, 4): its faces, edges and corners pass through centres. With
  // an infinitesimal move the closed side keeps those centres from which the move leads inside: per octant, faces whose
  // leading outward component is negative. All axes must agree, so one direction gives the same as three.
  TriangleSoup octahedron;
  const Point center = Point::Constant(4.5);
  octahedron.positions = {center + Point(3, 0, 0), center - Point(3, 0, 0), center + Point(0, 3, 0),
                          center - Point(0, 3, 0), center + Point(0, 0, 3), center - Point(0, 0, 3)};
  octahedron.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  RunContext context;
  std::vector<BinaryVolume> volumes;
  for (int axis = 0; axis < 3; ++axis) {
    volumes.push_back(voxelize(octahedron, frame_of({9, 9, 9}), {.directions = 1, .axis = axis}, context));
  }
  EXPECT_EQ(volumes[0], volumes[1]);
  EXPECT_EQ(volumes[0], volumes[2]);
  EXPECT_EQ(volumes[0], voxelize_with(octahedron, frame_of({9, 9, 9}), Classifier::kParity, 13));
  // A centre at integer offset (x, y, z) stays inside iff |x| + |y| + |z| < 3, or it is 3 and the outward normal there
  // has a leading component against the move: x < 0, or x = 0 is on an edge between x > 0 and x < 0 faces, where moving
  // along +x leads outside.
  for (int x = -4; x <= 4; ++x) {
    for (int y = -4; y <= 4; ++y) {
      for (int z = -4; z <= 4; ++z) {
        const int norm = std::abs(x) + std::abs(y) + std::abs(z);
        const bool inside = norm < 3 || (norm == 3 && x < 0);
        ASSERT_EQ(volumes[0](x + 4, y + 4, z + 4) != 0, inside) << x << " " << y << " " << z;
      }
    }
  }
}

/// The slow twin: a voxel's centre by even-odd counting of all triangles in doubles, for shapes in general position.
bool brute_force_inside(const TriangleSoup& soup, const Point& p, const Point& direction) {
  int crossings = 0;
  for (const Triangle& t : soup.triangles) {
    const Point& a = soup.positions[t[0]];
    const Point ab = soup.positions[t[1]] - a;
    const Point ac = soup.positions[t[2]] - a;
    const Point q = direction.cross(ac);
    const double determinant = ab.dot(q);
    if (determinant == 0) continue;
    const double u = (p - a).dot(q) / determinant;
    const Point r = (p - a).cross(ab);
    const double v = direction.dot(r) / determinant;
    crossings += u >= 0 && v >= 0 && u + v <= 1 && ac.dot(r) / determinant > 0;
  }
  return crossings % 2 != 0;
}

TEST(Voxelize, AgreesWithBruteForceInGeneralPosition) {
  const Point tilt = Point(0.3, 1.1, -0.7).normalized();
  Eigen::Affine3d turn(Eigen::AngleAxisd(0.7, tilt));
  const TriangleSoup shape = transformed(torus(6, 2.3, 17, 9), Eigen::Translation3d(10.13, 9.77, 9.31) * turn);
  const GridFrame frame = frame_of({20, 20, 20});
  for (const int directions : kDirectionCounts) {
    const BinaryVolume volume = voxelize_with(shape, frame, Classifier::kParity, directions);
    for (std::int64_t k = 0; k < 20; ++k) {
      for (std::int64_t j = 0; j < 20; ++j) {
        for (std::int64_t i = 0; i < 20; ++i) {
          const Point center = frame.center({i, j, k});
          ASSERT_EQ(volume(i, j, k) != 0, brute_force_inside(shape, center, Point(0.137, 0.731, 0.519)))
              << center.transpose();
        }
      }
    }
  }
}

TEST(Voxelize, ParityHollowsOverlapsAndStabbingDoesNot) {
  // Two 4-cubes overlapping in a 2 x 4 x 4 slab: 64 + 64 voxels, 32 of them in both. Their union is a 6 x 4 x 4 box,
  // which is its own line hull in every direction.
  const TriangleSoup overlapping = joined({box(Point(1, 1, 1), Point(5, 5, 5)), box(Point(3, 1, 1), Point(7, 5, 5))});
  for (const int directions : {3, 13}) {
    EXPECT_EQ(count_interior(voxelize_with(overlapping, frame_of({8, 8, 8}), Classifier::kParity, directions)), 64);
    EXPECT_EQ(count_interior(voxelize_with(overlapping, frame_of({8, 8, 8}), Classifier::kStabbing, directions)), 96);
  }
}

TEST(Voxelize, NestedShellsKeepTheirCavityByParityAndLoseItByStabbing) {
  const TriangleSoup shells =
      joined({box(Point::Constant(1), Point::Constant(9)), inside_out(box(Point::Constant(3), Point::Constant(6)))});
  EXPECT_EQ(count_interior(voxelize_with(shells, frame_of({10, 10, 10}), Classifier::kParity, 3)), 512 - 27);
  EXPECT_EQ(count_interior(voxelize_with(shells, frame_of({10, 10, 10}), Classifier::kStabbing, 3)), 512);
}

/// The box without the triangles whose corners all have coordinate `value` along `axis`.
TriangleSoup without_face(TriangleSoup soup, int axis, double value) {
  std::erase_if(soup.triangles, [&](const Triangle& t) {
    return std::ranges::all_of(t, [&](std::uint32_t vertex) { return soup.positions[vertex][axis] == value; });
  });
  return soup;
}

TEST(Voxelize, InvalidColumnsDoNotVote) {
  // A cube without its top (y = 6): along y all 4 x 4 columns through it cross once and do not vote; x and z are whole.
  const TriangleSoup open_cube = without_face(box(Point::Constant(2), Point::Constant(6)), 1, 6);
  ASSERT_EQ(open_cube.triangles.size(), 10U);
  RunContext context;
  VoxelizeReport report;
  const BinaryVolume one = voxelize(open_cube, frame_of({8, 8, 8}), {.directions = 1, .axis = 1}, context, &report);
  EXPECT_EQ(count_interior(one), 0);
  ASSERT_EQ(report.axes.size(), 1U);
  EXPECT_EQ(report.axes[0].columns, 16);
  EXPECT_EQ(report.axes[0].invalid_columns, 16);
  EXPECT_EQ(count_interior(voxelize(open_cube, frame_of({8, 8, 8}), {.directions = 3}, context)), 64);
}

TEST(Voxelize, StabbingWithValidityLetsOddRaysAbstain) {
  // The same open cube. Along y each ray through it meets the bottom alone: first and last crossing are one, nothing
  // lies between them, and the solid is lost. With the validity test these rays do not vote, and those along x and z
  // keep all 64 voxels; with y alone nobody votes, and all is exterior.
  const TriangleSoup open_cube = without_face(box(Point::Constant(2), Point::Constant(6)), 1, 6);
  RunContext context;
  VoxelizeReport report;
  VoxelizeOptions options{.classifier = Classifier::kStabbing, .directions = 3};
  EXPECT_EQ(count_interior(voxelize(open_cube, frame_of({8, 8, 8}), options, context, &report)), 0);
  EXPECT_EQ(report.axes[1].invalid_columns, 0);
  options.stab_validity = true;
  report = {};
  EXPECT_EQ(count_interior(voxelize(open_cube, frame_of({8, 8, 8}), options, context, &report)), 64);
  EXPECT_EQ(report.axes[1].columns, 16);
  EXPECT_EQ(report.axes[1].invalid_columns, 16);
  EXPECT_EQ(report.axes[0].invalid_columns, 0);
  options.directions = 1;
  EXPECT_EQ(count_interior(voxelize(open_cube, frame_of({8, 8, 8}), options, context)), 0);
}

TEST(Voxelize, ASolidWithOneValidVoteSurvives) {
  // Without its +x and +y faces only the columns along z are valid: one vote of three, and nothing against it.
  const TriangleSoup soup = without_face(without_face(box(Point::Constant(2), Point::Constant(6)), 0, 6), 1, 6);
  ASSERT_EQ(soup.triangles.size(), 8U);
  EXPECT_EQ(count_interior(voxelize_with(soup, frame_of({8, 8, 8}), Classifier::kParity, 3)), 64);
}

TEST(Voxelize, DisputedVoxelsTakeTheClassOfTheirNeighbours) {
  // A solid cube of 10^3 voxels, and in its middle a pair of faces of one voxel's size each: one that only rays along x
  // meet, one that only rays along y meet. Behind both, in the column's crossing, x and y are invalid and z alone
  // votes: unanimous. In the columns of x alone: z and y say interior, so they have it. To get a dispute a ray must be
  // valid and wrong: two faces behind each other along x make a pocket whose x vote says exterior, y is invalid by one
  // more face, z votes interior: 1 : 1, a tie, exterior by the paper's rule, interior by its 26 interior neighbours.
  TriangleSoup soup = box(Point::Constant(0), Point::Constant(10));
  const auto add_face = [&](int axis, const Point& lower) {
    Point u = Point::Zero();
    Point v = Point::Zero();
    u[(axis + 1) % 3] = 1;
    v[(axis + 2) % 3] = 1;
    const auto first = static_cast<std::uint32_t>(soup.positions.size());
    soup.positions.insert(soup.positions.end(), {lower, lower + u, lower + u + v, lower + v});
    soup.triangles.push_back({first, first + 1, first + 2});
    soup.triangles.push_back({first, first + 2, first + 3});
  };
  add_face(0, Point(5, 5, 5));
  add_face(0, Point(6, 5, 5));
  add_face(1, Point(5, 6, 5));
  RunContext context;
  VoxelizeReport report;
  const BinaryVolume bare = voxelize(soup, frame_of({10, 10, 10}), {.directions = 3, .settle_sweeps = 0}, context);
  EXPECT_EQ(count_interior(bare), 999);
  EXPECT_EQ(bare(5, 5, 5), 0);
  const BinaryVolume settled = voxelize(soup, frame_of({10, 10, 10}), {.directions = 3}, context, &report);
  EXPECT_EQ(count_interior(settled), 1000);
  EXPECT_EQ(report.settled_voxels, 1);
}

TEST(Voxelize, AWatertightModelHasNothingToSettle) {
  const TriangleSoup shape = joined({torus(3, 1, 24, 12), icosphere(Point(6, 1, 0.5), 1.3, 3)});
  RunContext context;
  const GridFrame frame = voxel_frame(bounds(shape), 40);
  for (const int directions : {3, 13}) {
    VoxelizeReport report;
    const BinaryVolume volume = voxelize(shape, frame, {.directions = directions}, context, &report);
    EXPECT_EQ(report.settled_voxels, 0);
    EXPECT_EQ(volume, voxelize(shape, frame, {.directions = directions, .settle_sweeps = 0}, context));
  }
}

TEST(Voxelize, APartOfAGridGetsThePartOfTheVolume) {
  const TriangleSoup shape =
      transformed(torus(6, 2.3, 17, 9), Eigen::Affine3d(Eigen::Translation3d(10.13, 9.77, 3.31)));
  const BinaryVolume whole = voxelize_with(shape, frame_of({20, 20, 8}), Classifier::kParity, 3);
  const GridFrame part = frame_of({7, 9, 5}, Point(4, 6, 1));
  EXPECT_EQ(voxelize_with(shape, part, Classifier::kParity, 3), resized(whole, part));
}

TEST(Voxelize, ThinSlabsAreTreatedAlikeAlongEveryAxis) {
  // A slab of 1 x 1 x 0.008 at 100 voxels is 0.8 voxel thick: one layer of 100 x 100, whichever way it lies, and never
  // an image.
  for (int axis = 0; axis < 3; ++axis) {
    Point upper = Point::Ones();
    upper[axis] = 0.008;
    const TriangleSoup slab = box(Point::Zero(), upper);
    const GridFrame frame = voxel_frame(bounds(slab), 100);
    EXPECT_FALSE(frame.is_image());
    EXPECT_EQ(count_interior(voxelize_with(slab, frame, Classifier::kParity, 3)), 10000) << axis;
  }
}

TEST(Voxelize, DirectionsAreUnitAndDistinctAxes) {
  const std::vector<Point> directions = voxelization_directions(13);
  ASSERT_EQ(directions.size(), 13U);
  for (std::size_t a = 0; a < directions.size(); ++a) {
    EXPECT_NEAR(directions[a].norm(), 1, 1e-15);
    for (std::size_t b = a + 1; b < directions.size(); ++b) EXPECT_LT(std::abs(directions[a].dot(directions[b])), 0.95);
  }
  // Neighbouring face normals of the icosahedron enclose acos(sqrt(5) / 3): each of the ten has three such neighbours
  // among the twenty, so the ten axes have 15 such pairs.
  int neighbours = 0;
  for (std::size_t a = 3; a < 13; ++a) {
    for (std::size_t b = a + 1; b < 13; ++b) {
      neighbours += std::abs(std::abs(directions[a].dot(directions[b])) - std::sqrt(5.0) / 3) < 1e-12;
    }
  }
  EXPECT_EQ(neighbours, 15);
  EXPECT_EQ(voxelization_directions(1, 2)[0], Point(0, 0, 1));
  EXPECT_THROW(voxelization_directions(7), ParameterError);
}

TEST(VoxelFrame, PutsTheResolutionAlongTheLongestSide) {
  Box box;
  box.extend(Point(1, 2, 3));
  box.extend(Point(5, 10, 3.5));  // 4 x 8 x 0.5
  const GridFrame frame = voxel_frame(box, 16);
  EXPECT_EQ(frame.voxel_size, 0.5);
  EXPECT_EQ(frame.dims, Index3(8, 16, 2));  // a single slice would be an image
  EXPECT_EQ(frame.origin, Point(1, 2, 3));
}

TEST(VoxelFrame, RefusesVoxelsBelowTheDigitsOfTheCoordinates) {
  Box far_away;
  far_away.extend(Point::Constant(1e16));
  far_away.extend(Point::Constant(1e16 + 4));
  EXPECT_THROW(voxel_frame(far_away, 64), InputError);
  Box point;
  point.extend(Point::Zero());
  EXPECT_THROW(voxel_frame(point, 64), InputError);
}

TEST(Voxelize, TinyHugeAndFarModelsGiveTheSameVolume) {
  const TriangleSoup shape = torus(3, 1, 24, 12);
  const auto volume_of = [](const TriangleSoup& soup) {
    return voxelize_with(soup, voxel_frame(bounds(soup), 32), Classifier::kParity, 13).values;
  };
  const GridValues<std::uint8_t> expected = volume_of(shape);
  for (const double scale : {0x1p-40, 0x1p40}) {  // powers of two: not a digit changes
    EXPECT_EQ(volume_of(transformed(shape, Eigen::Affine3d(Eigen::UniformScaling<double>(scale)))), expected);
  }
  const GridValues<std::uint8_t> far_away =
      volume_of(transformed(shape, Eigen::Affine3d(Eigen::Translation3d(1e9, -1e9, 1e9))));
  ASSERT_EQ(far_away.size(), expected.size());
  // Coordinates of 1e9 keep digits down to 1e-7: only a voxel centre so close to the surface may change.
  int changed = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) changed += far_away[i] != expected[i];
  EXPECT_LE(changed, 2);
}

TEST(Voxelize, SphereHasItsVolumeWithinTheSurfaceVoxels) {
  // Error at most half a voxel diagonal across the surface: |V - V0| <= 4 pi r^2 sqrt(3) / 2, here 4.5 % of V0 with
  // r = 57.6 voxels; centres average out far below that, so a tenth of the bound is asked for.
  const TriangleSoup sphere = icosphere(Point::Zero(), 1, 5);
  RunContext context;
  const GridFrame frame = voxel_frame(bounds(sphere), 115);
  const BinaryVolume volume = voxelize(sphere, frame, {.directions = 3}, context);
  const double measured = static_cast<double>(count_interior(volume)) * std::pow(frame.voxel_size, 3);
  EXPECT_NEAR(measured / signed_volume(sphere), 1, 0.0045);
}

TEST(Voxelize, GivesTheSameVolumeOnOneThreadAndOnTwo) {
  const TriangleSoup shape = joined({torus(3, 1, 24, 12), icosphere(Point(2, 1, 0.5), 1.3, 3)});
  for (const Classifier classifier : kClassifiers) {
    RunContext one;
    RunContext two;
    two.threads = 2;
    const GridFrame frame = voxel_frame(bounds(shape), 40);
    EXPECT_EQ(voxelize(shape, frame, {.classifier = classifier, .directions = 13}, one),
              voxelize(shape, frame, {.classifier = classifier, .directions = 13}, two));
  }
}

TEST(Voxelize, CanBeCancelled) {
  RunContext context;
  std::stop_source source;
  context.cancellation = source.get_token();
  std::int64_t last = 0;
  context.progress = [&](const ProgressEvent& event) {
    EXPECT_GE(event.done, last);
    last = event.done;
    if (event.done > 0) source.request_stop();
  };
  const TriangleSoup shape = torus(3, 1, 60, 40);
  EXPECT_THROW(voxelize(shape, voxel_frame(bounds(shape), 64), {}, context), Cancelled);
  EXPECT_LT(last, 3 * 2 * 60 * 40);
}

TEST(Voxelize, HoldsAnEighthOfTheResultBesideIt) {
  // A byte a voxel, a bit a voxel, and for two slabs at work what is left of a fifth.
  const TriangleSoup shape = torus(3, 1, 60, 40);
  const GridFrame frame = voxel_frame(bounds(shape), 300);
  RunContext context;
  voxelize(shape, frame, {}, context);
  ASSERT_EQ(context.timings().size(), 1U);
  const double per_voxel = static_cast<double>(context.timings()[0].bytes) / static_cast<double>(frame.voxels());
  EXPECT_GT(per_voxel, 1.125);
  EXPECT_LT(per_voxel, 1.325);
}

TEST(Voxelize, RefusesAGridWithoutVoxels) {
  RunContext context;
  for (const Index3& dims : {Index3(0, 0, 0), Index3(0, 4, 4), Index3(4, 0, 4), Index3(4, 4, 0), Index3(4, 4, -1)}) {
    for (const int directions : {1, 3, 13}) {
      EXPECT_THROW(voxelize(box(Point::Zero(), Point::Ones()), frame_of(dims), {.directions = directions}, context),
                   InputError);
    }
  }
}

TEST(Voxelize, AsksForItsMemoryBeforeItAllocates) {
  RunContext context;
  context.memory_budget = 1 << 20;
  EXPECT_THROW(voxelize(box(Point::Zero(), Point::Ones()), frame_of({4096, 4096, 4096}), {}, context), ResourceError);
}

}  // namespace
}  // namespace voxcarve
