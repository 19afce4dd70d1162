#include "metrics/visibility.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/mesh/aabb_tree.h"
#include "common/run/errors.h"
#include "metrics/metric.h"
#include "metrics/occlusion_tree.h"
#include "tests/unit/metric_shapes.h"

namespace voxcarve {
namespace {

using namespace test;

SurfacePart visible(const TriangleSoup& soup, const VisibilityOptions& options = {}) {
  RunContext context;
  return visible_part(soup, options, context);
}

TriangleSoup turned(TriangleSoup soup, const Eigen::Matrix3d& rotation) {
  for (Point& p : soup.positions) p = rotation * p;
  return soup;
}

TriangleSoup scaled(TriangleSoup soup, double factor) {
  for (Point& p : soup.positions) p *= factor;
  return soup;
}

void add_quad(TriangleSoup& soup, const Point& a, const Point& b, const Point& c, const Point& d) {
  const auto first = static_cast<std::uint32_t>(soup.positions.size());
  soup.positions.insert(soup.positions.end(), {a, b, c, d});
  soup.triangles.push_back({first, first + 1, first + 2});
  soup.triangles.push_back({first, first + 2, first + 3});
}

/// The square |x|, |y| <= half at height z.
TriangleSoup square(double half, double z) {
  TriangleSoup soup;
  add_quad(soup, {-half, -half, z}, {half, -half, z}, {half, half, z}, {-half, half, z});
  return soup;
}

/// The sides |x|, |y| = half of a box between two heights.
TriangleSoup walls(double half, double low, double high) {
  TriangleSoup soup;
  const std::array<Point, 4> corner = {Point(-half, -half, 0), {half, -half, 0}, {half, half, 0}, {-half, half, 0}};
  for (std::size_t i = 0; i < 4; ++i) {
    const Point& p = corner[i];
    const Point& q = corner[(i + 1) % 4];
    add_quad(soup, p + low * Point::UnitZ(), q + low * Point::UnitZ(), q + high * Point::UnitZ(),
             p + high * Point::UnitZ());
  }
  return soup;
}

/// The square |x|, |y| <= half at height z without the square |x|, |y| <= hole.
TriangleSoup frame(double half, double hole, double z) {
  TriangleSoup soup;
  add_quad(soup, {-half, -half, z}, {half, -half, z}, {half, -hole, z}, {-half, -hole, z});
  add_quad(soup, {-half, hole, z}, {half, hole, z}, {half, half, z}, {-half, half, z});
  add_quad(soup, {-half, -hole, z}, {-hole, -hole, z}, {-hole, hole, z}, {-half, hole, z});
  add_quad(soup, {hole, -hole, z}, {half, -hole, z}, {half, hole, z}, {hole, hole, z});
  return soup;
}

/// A block with a square well of side 1 and depth 10 in its top; the last two triangles are the bottom of the well.
TriangleSoup block_with_well() {
  TriangleSoup soup = joined(joined(square(1, -1), walls(1, -1, 10)), frame(1, 0.5, 10));
  return joined(joined(soup, walls(0.5, 0, 10)), square(0.5, 0));
}

/// The visible area of the triangles of the whole from `first` on.
double visible_area(const SurfacePart& part, std::uint32_t first) {
  double area = 0;
  for (std::size_t i = 0; i < part.source.size(); ++i) {
    if (part.source[i] >= first) area += area_vector(part.surface, part.surface.triangles[i]).norm() / 2;
  }
  return area;
}

TEST(ViewDirections, CoverTheSphere) {
  const std::vector<Point> directions = view_directions(128);
  ASSERT_EQ(directions.size(), 128U);
  Point sum = Point::Zero();
  for (const Point& d : directions) {
    EXPECT_NEAR(d.norm(), 1, 1e-15);
    sum += d;
  }
  EXPECT_LT(sum.norm() / 128, 0.01);
  // Sides of this sphere's triangles are below 1 degree (90 / 2^7 times sqrt 2), so no point is further than 0.6
  // degrees from a vertex; from a vertex the next direction is at most 13.6 degrees away: 14.2 in all.
  for (const Point& p : sphere(1, 7).positions) {
    double nearest = -1;
    for (const Point& d : directions) nearest = std::max(nearest, d.dot(p));
    ASSERT_GT(nearest, std::cos(13.6 * std::numbers::pi / 180));
  }
  EXPECT_EQ(view_directions(1).size(), 1U);
}

TEST(VisiblePart, ConvexShapesAndTheTorusAreVisibleAsTheyAre) {
  // The hole of this torus is as wide as 3 of its tubes' radii: every point of the tube sees out of it steeply.
  for (const TriangleSoup& soup : {unit_cube(), sphere(3, 3), tetrahedron(), torus(2, 0.5, 24, 12)}) {
    const SurfacePart part = visible(soup);
    EXPECT_EQ(part.surface.positions, soup.positions);
    EXPECT_EQ(part.surface.triangles, soup.triangles);
    EXPECT_NEAR(part.share, 1, 1e-12);
    for (std::uint32_t i = 0; i < part.source.size(); ++i) EXPECT_EQ(part.source[i], i);
    EXPECT_EQ(visible(part.surface).surface, part.surface);
    EXPECT_EQ(visible(flipped(soup)).source, part.source);
  }
}

TEST(VisiblePart, ACubeInsideOfACubeIsHidden) {
  const TriangleSoup outer = make_box({0, 0, 0}, {4, 4, 4});
  for (const TriangleSoup& inner : {make_box({1, 1, 1}, {3, 3, 3}), flipped(make_box({1, 1, 1}, {3, 3, 3}))}) {
    const SurfacePart part = visible(joined(inner, outer));
    EXPECT_EQ(part.surface, outer);
    EXPECT_EQ(part.source.front(), 12U);
    EXPECT_NEAR(part.share, 96.0 / (96 + 24), 1e-12);  // 6 * 16 and 6 * 4
  }
}

TEST(VisiblePart, CoincidentTrianglesDoNotHideEachOther) {
  const TriangleSoup cube = make_box({-1, -1, -1}, {1, 1, 1});
  EXPECT_EQ(visible(joined(cube, cube)).surface.triangles.size(), 24U);
  EXPECT_EQ(visible(joined(cube, flipped(cube))).surface.triangles.size(), 24U);
  // The tolerance is 1e-6 * 2 sqrt 3: a shell at a tenth of it hides nothing, one at ten times as much does.
  EXPECT_EQ(visible(joined(cube, scaled(cube, 1 + 3.5e-7))).surface.triangles.size(), 24U);
  const SurfacePart part = visible(joined(cube, scaled(cube, 1 + 3.5e-5)));
  EXPECT_EQ(part.surface.triangles.size(), 12U);
  EXPECT_EQ(part.source.front(), 12U);
}

TEST(VisiblePart, AFloorUnderAWindowIsSeenWhereRaysPassThroughTheWindow) {
  // A box with a window |x|, |y| <= 1 / 4 in its roof at z = 4; the floor at z = 0 lies above the bottom at z = -1, so
  // it is seen from above only. The ray from (x, y, 0) along d passes the roof at (x + 4 dx / dz, y + 4 dy / dz).
  constexpr double kHole = 0.25;
  TriangleSoup soup = joined(joined(square(2, -1), walls(2, -1, 4)), frame(2, kHole, 4));
  const auto floor_begin = static_cast<std::uint32_t>(soup.triangles.size());
  soup = joined(soup, square(2, 0));
  const VisibilityOptions options{.coarse = 1.0 / 256, .fine = 1.0 / 1024};
  const SurfacePart part = visible(soup, options);
  const double coarse = options.coarse * std::sqrt(16.0 + 16 + 25);
  TriangleSoup floor;
  floor.positions = part.surface.positions;
  for (std::size_t i = 0; i < part.source.size(); ++i) {
    if (part.source[i] >= floor_begin) floor.triangles.push_back(part.surface.triangles[i]);
  }
  ASSERT_FALSE(floor.empty());
  const AabbTree tree(floor);
  int seen = 0;
  int hidden = 0;
  for (double x = -1.95; x < 2; x += 0.1) {
    for (double y = -1.95; y < 2; y += 0.1) {
      bool expected = false;
      bool near_border = false;
      for (const Point& d : view_directions(128)) {
        if (d[2] <= 0) continue;
        const double reach = std::max(std::abs(x + 4 * d[0] / d[2]), std::abs(y + 4 * d[1] / d[2]));
        expected = expected || reach < kHole - coarse;  // and so are all points of its piece
        near_border = near_border || std::abs(reach - kHole) <= coarse;
      }
      if (!expected && near_border) continue;
      const bool found = tree.nearest({x, y, 0}).squared_distance < 1e-18;
      ASSERT_EQ(found, expected) << x << " " << y;
      ++(expected ? seen : hidden);
    }
  }
  EXPECT_GT(seen, 100);  // of 1600, or the comparison says little
  EXPECT_GT(hidden, 50);
  // With a lid nothing of the floor is left.
  EXPECT_EQ(visible_area(visible(joined(square(kHole, 4), soup)), floor_begin + 2), 0);
}

TEST(VisiblePart, TheBottomOfADeepWellIsSeenAlongItsAxisOnly) {
  // Whatever leaves the well of side 1 and depth 10 from its bottom has |dx / dz|, |dy / dz| <= 1 / 10. The direction
  // nearest to the axis has z = 1 - 1 / 128: sqrt(1 - z^2) / z = 0.126 at azimuth 69 degrees (half the golden angle),
  // so |dy / dz| = 0.118.
  const TriangleSoup soup = block_with_well();
  const auto bottom = static_cast<std::uint32_t>(soup.triangles.size() - 2);
  EXPECT_EQ(visible_area(visible(soup), bottom), 0);
  // Turned so that its axis is one of the directions, the well shows all of its bottom.
  for (const std::size_t i : {std::size_t{0}, std::size_t{40}, std::size_t{127}}) {
    const auto rotation = Eigen::Quaterniond::FromTwoVectors(Point::UnitZ(), view_directions(128)[i]);
    EXPECT_NEAR(visible_area(visible(turned(soup, rotation.toRotationMatrix())), bottom), 1, 1e-12);
  }
}

TEST(VisiblePart, InterpenetratingSpheresInAnyPose) {
  // Unit spheres whose centres are 1 apart: each loses a cap of height 1 / 2, area pi of 4 pi, so 3 / 4 are visible.
  // The two borders have length 2 pi sqrt(3 / 4) each and are known to a fine length on both sides, which together are
  // below that share of the area 8 pi; the polyhedra's own error is below 0.005.
  const TriangleSoup both = joined(sphere(1, 4), translated(sphere(1, 4), {1, 0, 0}));
  const double border = 4 * std::numbers::pi * std::sqrt(0.75) * std::sqrt(17.0) / 128 / (8 * std::numbers::pi);
  for (const Point& axis : {Point(1, 0, 0), Point(0, 1, 0), Point(1, 2, 3)}) {
    const Eigen::AngleAxisd rotation(std::numbers::pi / 2, axis.normalized());
    const SurfacePart part = visible(turned(both, rotation.toRotationMatrix()));
    EXPECT_NEAR(part.share, 0.75, border + 0.005);
    EXPECT_NEAR(part.share, surface_area(part.surface) / surface_area(both), 1e-12);
  }
}

TEST(VisiblePart, ALongTriangleThatIsMostlyBuriedIsCut) {
  // A blade, 40 long and 0.01 wide, of which the box hides x in (-10, 10). Of its area |x| > 10 shows, 20 of 40.
  TriangleSoup soup = make_box({-10, -1, -1}, {10, 1, 1});
  add_quad(soup, {-20, 0, 0}, {20, 0, 0}, {20, 0.01, 0}, {-20, 0.01, 0});
  const SurfacePart part = visible(soup);
  const double fine = VisibilityOptions().fine * 40.1;
  EXPECT_NEAR(visible_area(part, 12), 0.2, 2 * 0.01 * fine);  // two borders
  for (std::size_t i = 0; i < part.source.size(); ++i) {
    if (part.source[i] < 12) continue;
    for (const std::uint32_t v : part.surface.triangles[i]) {
      EXPECT_GT(std::abs(part.surface.positions[v][0]), 10 - fine);
    }
  }
}

TEST(VisiblePart, SmallTrianglesCountAsMuchAsLargeOnes) {
  // A ball of a thousandth of the box's size before the box is no smaller than a pixel: all of it is visible; inside
  // of the box none of it is.
  const TriangleSoup box = make_box({-1, -1, -1}, {1, 1, 1});
  const TriangleSoup ball = sphere(1e-3, 3);
  EXPECT_EQ(visible(joined(translated(ball, {0, 0, 1.5}), box)).surface.triangles.size(), ball.triangles.size() + 12);
  EXPECT_EQ(visible(joined(translated(ball, {0, 0, 0.9}), box)).surface.triangles.size(), 12U);
}

TEST(VisiblePart, NothingAndShapesWithoutArea) {
  EXPECT_TRUE(visible(TriangleSoup()).surface.empty());
  TriangleSoup line;
  line.positions = {{0, 0, 0}, {1, 1, 1}, {2, 2, 2}};
  line.triangles = {{0, 1, 2}, {0, 0, 1}};
  EXPECT_TRUE(visible(line).surface.empty());
  EXPECT_EQ(visible(line).share, 0);
  TriangleSoup point = line;
  point.triangles = {{1, 1, 1}};
  EXPECT_TRUE(visible(point).surface.empty());
  EXPECT_EQ(visible(joined(line, translated(unit_cube(), {3, 0, 0}))).surface.triangles.size(), 12U);
  EXPECT_EQ(visible(unit_cube(), {.directions = 0}).surface.triangles.size(), 4U);  // one direction sees two sides
}

TEST(VisiblePart, ScaleAndPlaceDoNotMatter) {
  const TriangleSoup soup = joined(sphere(1, 2), translated(sphere(1, 2), {1, 0, 0}));
  const SurfacePart part = visible(soup);
  for (const double factor : {0x1p-900, 0x1p40, 0x1p1000}) {
    const SurfacePart other = visible(scaled(soup, factor));
    EXPECT_EQ(other.source, part.source);
    EXPECT_EQ(other.share, part.share);
  }
  EXPECT_NEAR(visible(translated(soup, {1e6, -1e6, 1e6})).share, part.share, 1e-3);
  const double huge = std::numeric_limits<double>::max();
  EXPECT_NEAR(visible(make_box({-huge, -huge, -huge}, {huge, huge, huge})).share, 1, 1e-12);
}

TEST(VisiblePart, TheSameOnAnyNumberOfThreads) {
  const TriangleSoup soup = joined(joined(sphere(1, 4), translated(sphere(1, 4), {1, 0, 0})), block_with_well());
  RunContext one;
  RunContext four;
  four.threads = 4;
  const SurfacePart first = visible_part(soup, {}, one);
  const SurfacePart second = visible_part(soup, {}, four);
  EXPECT_EQ(first.surface, second.surface);
  EXPECT_EQ(first.source, second.source);
  EXPECT_EQ(first.share, second.share);
}

TEST(VisiblePart, ManyLongTrianglesAreCutLess) {
  // Triangles across the whole box: at these lengths they would be some millions of pieces.
  Sequence random(3);
  TriangleSoup soup;
  for (std::uint32_t i = 0; i < 900; ++i) {
    soup.positions.push_back(random.point());
    if (i % 3 == 2) soup.triangles.push_back({i - 2, i - 1, i});
  }
  const SurfacePart part = visible(soup, {.directions = 4, .coarse = 1.0 / 512, .fine = 1.0 / 512});
  EXPECT_GT(part.share, 0);
  EXPECT_LT(part.share, 0.5);
  EXPECT_LT(part.surface.triangles.size(), 2'000'000U);
}

TEST(VisiblePart, DeclaresThePiecesThatItFinds) {
  // 200 blades through a box: each is cut at its two borders. A piece is at least nine coordinates and its triangle.
  TriangleSoup soup = make_box({-10, -1, -1}, {10, 1, 1});
  for (int i = 0; i < 200; ++i) {
    const double y = -0.9 + 0.009 * i;
    add_quad(soup, {-20, y, 0}, {20, y, 0}, {20, y + 0.001, 0}, {-20, y + 0.001, 0});
  }
  RunContext context;
  const SurfacePart part = visible_part(soup, {}, context);
  const auto pieces = std::ranges::count_if(part.source, [](std::uint32_t t) { return t >= 12; });
  ASSERT_GT(pieces, 1000);
  const std::uint64_t least = OcclusionTree::memory_estimate(soup.triangles.size()) +
                              static_cast<std::uint64_t>(pieces) * (9 * sizeof(double) + sizeof(std::uint32_t));
  ASSERT_EQ(context.timings().size(), 1U);
  EXPECT_GE(context.timings()[0].bytes, least);
  RunContext tight;
  tight.memory_budget = least;
  EXPECT_THROW(visible_part(soup, {}, tight), ResourceError);
}

TEST(VisiblePart, StopsWhenCancelledAndKeepsToTheBudget) {
  RunContext context;
  context.memory_budget = 100;
  EXPECT_THROW(visible_part(unit_cube(), {}, context), ResourceError);
  std::stop_source source;
  context.cancellation = source.get_token();
  source.request_stop();
  EXPECT_THROW(visible_part(unit_cube(), {}, context), Cancelled);
}

double real(const std::vector<Measurement>& values, std::string_view key) {
  return std::get<double>(value_of(values, key));
}

TEST(VisibleHausdorff, InteriorsDoNotCount) {
  // The inner cube's faces are 1 from the outer cube; nobody sees them, and all that is seen is common to both.
  const TriangleSoup outer = make_box({0, 0, 0}, {4, 4, 4});
  const TriangleSoup both = joined(outer, make_box({1, 1, 1}, {3, 3, 3}));
  RunContext context;
  const auto values = measure_pair(both, outer, {}, context);
  EXPECT_NEAR(real(values, "hausdorff.a_to_b.lower"), 1, 0.01);
  EXPECT_EQ(real(values, "visible_hausdorff.upper"), 0);
  EXPECT_EQ(real(values, "visible_hausdorff.mean"), 0);
  EXPECT_NEAR(real(values, "visible_share.a"), 0.8, 1e-12);
  EXPECT_NEAR(real(values, "visible_share.b"), 1, 1e-12);
  EXPECT_EQ(real(values, "visible_normal_deviation.mean"), 0);
  // The other way round the output has the hidden part.
  EXPECT_EQ(real(measure_pair(outer, both, {}, context), "visible_hausdorff.upper"), 0);
}

TEST(VisibleHausdorff, WhatIsSeenCountsInBothDirections) {
  // A lid on the box of the floor's window: the lid's middle is 1 from the window's rim. The input's floor is there in
  // the output too, though hidden.
  const TriangleSoup open = joined(joined(joined(square(2, -1), walls(2, -1, 4)), frame(2, 1, 4)), square(2, 0));
  const TriangleSoup closed = joined(open, square(1, 4));
  RunContext context;
  auto values = measure_pair(open, closed, {}, context);
  EXPECT_EQ(real(values, "visible_hausdorff.a_to_b.upper"), 0);
  EXPECT_NEAR(real(values, "visible_hausdorff.b_to_a.lower"), 1, 0.01);
  // Without its floor, the box with the window lacks what was seen of it: the floor's middle is 1 above the bottom.
  const TriangleSoup hollow = joined(joined(square(2, -1), walls(2, -1, 4)), frame(2, 1, 4));
  values = measure_pair(open, hollow, {}, context);
  EXPECT_NEAR(real(values, "visible_hausdorff.a_to_b.lower"), 1, 0.01);
}

TEST(VisibleHausdorff, NeverExceedsTheWholeOne) {
  // Parts of the same points to the same targets: no distance grows, up to the width of the intervals.
  const TriangleSoup a = joined(sphere(1, 3), translated(sphere(1, 3), {1, 0, 0}));
  const TriangleSoup b = joined(torus(1, 0.3, 24, 12), unit_cube());
  RunContext context;
  const auto values = measure_pair(a, b, {}, context);
  for (const std::string side : {"", "a_to_b.", "b_to_a."}) {
    EXPECT_LE(real(values, "visible_hausdorff." + side + "lower"), real(values, "hausdorff." + side + "upper"));
    EXPECT_GT(real(values, "visible_hausdorff." + side + "lower"), 0.1);
  }
}

TEST(VisibleHausdorff, ReasonsWhyThereIsNone) {
  RunContext context;
  const auto reason = [](const std::vector<Measurement>& values, std::string_view key) {
    return std::get<Undefined>(value_of(values, key)).reason;
  };
  MetricOptions options;
  options.visible = false;
  const auto off = measure_pair(unit_cube(), sphere(1, 1), options, context);
  for (const char* key : {"visible_hausdorff.upper", "visible_share.a", "visible_normal_deviation.b_to_a.rms"}) {
    EXPECT_EQ(reason(off, key), "not asked for");
  }
  EXPECT_GT(real(off, "normal_deviation.mean"), 0);
  TriangleSoup line = unit_cube();
  line.triangles = {{0, 1, 1}};
  const auto values = measure_pair(unit_cube(), line, {}, context);
  EXPECT_EQ(reason(values, "visible_hausdorff.upper"), "no part of the second shape is visible");
  EXPECT_EQ(real(values, "visible_share.b"), 0);
  EXPECT_EQ(reason(measure_pair(unit_cube(), TriangleSoup(), {}, context), "visible_share.a"),
            "the second shape has no triangles");
}

}  // namespace
}  // namespace voxcarve
