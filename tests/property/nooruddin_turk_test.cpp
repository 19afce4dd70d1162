// What the paper shows of the method, on procedural models and, where they are at hand, on the real ones.
#include <gtest/gtest.h>

#include <cmath>

#include "common/mesh/aabb_tree.h"
#include "common/mesh/io/mesh_io.h"
#include "common/mesh/line_stabber.h"
#include "common/mesh/models/procedural.h"
#include "common/mesh/topology.h"
#include "common/run/errors.h"
#include "common/volume/betti.h"
#include "common/volume/morphology.h"
#include "common/volume/voxelize.h"
#include "methods/registry.h"
#include "tests/support/shapes.h"

namespace voxcarve {
namespace {

/// From one sample a voxel, unless `settings` say otherwise.
MethodResult run(const TriangleSoup& soup, std::vector<std::string> settings) {
  const Method& method = find_method("nooruddin-turk");
  settings.insert(settings.begin(), {"supersampling=1", "kernel=box"});
  RunContext context;
  context.threads = 2;
  return method.run({"input", soup}, Parameters::parse(method.info().parameters, settings, ""), context);
}

void expect_one_closed_component(const TriangleSoup& surface) {
  const SurfaceTopology topology = analyze_topology(surface);
  EXPECT_TRUE(topology.closed && topology.oriented);
  EXPECT_EQ(topology.nonmanifold_edges, 0);
  EXPECT_EQ(topology.nonmanifold_vertices, 0);
  EXPECT_EQ(topology.components, 1);
}

/// Volume of the intersection of the soup's line hulls along `directions`: a stratified sample of n^3 points, each in
/// the hull of a direction iff its line crosses the soup both in front of it and behind it. The slow twin of stabbing.
double line_hull_volume(const TriangleSoup& soup, const std::vector<Point>& directions, int n) {
  std::vector<LineStabber> stabbers;
  for (const Point& direction : directions) stabbers.emplace_back(soup, StabFrame::along(direction));
  const Box box = bounds(soup);
  const Point cell = box.extent() / n;
  std::uint64_t state = 12345;
  const auto jitter = [&state] {
    state = state * 6364136223846793005ULL + 1442695040888963407ULL;
    return static_cast<double>(state >> 11) * 0x1p-53;
  };
  std::vector<Crossing> crossings;
  std::int64_t inside = 0;
  for (int k = 0; k < n; ++k) {
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) {
        const Point point =
            box.lower + Point((i + jitter()) * cell[0], (j + jitter()) * cell[1], (k + jitter()) * cell[2]);
        inside += std::ranges::all_of(stabbers, [&](const LineStabber& stabber) {
          crossings.clear();
          stabber.append_crossings(point.dot(stabber.frame().u), point.dot(stabber.frame().v), crossings);
          const double depth = point.dot(stabber.frame().w);
          const auto in_front =
              std::ranges::count_if(crossings, [depth](const Crossing& c) { return c.depth <= depth; });
          return in_front > 0 && in_front < static_cast<std::ptrdiff_t>(crossings.size());
        });
      }
    }
  }
  return static_cast<double>(inside) * cell.prod();
}

void expect_stabbing_converges(const TriangleSoup& soup, const std::string& resolution) {
  const TriangleSoup stabbed =
      run(soup, {"classifier=stabbing", "directions=13", "resolution=" + resolution}).levels->extract(0);
  expect_one_closed_component(stabbed);
  // The sample's standard error is below sqrt(points near the surface) / points inside, about 0.1 % here.
  const double hull = line_hull_volume(soup, voxelization_directions(13), 110);
  EXPECT_NEAR(signed_volume(stabbed) / hull, 1, 0.01);
}

TEST(RayStabbing, OverlappingPartsBecomeOneSolidThatIsTheIntersectionOfTheLineHulls) {
  expect_stabbing_converges(make_procedural("interpenetrating-figure"), "200");
}

TEST(ParityCount, HollowsTheOverlapsOfParts) {
  // Where two parts overlap a ray crosses two surfaces on its way in: even, so exterior [NT03, 3.2].
  const TriangleSoup figure = make_procedural("interpenetrating-figure");
  RunContext context;
  const GridFrame frame = voxel_frame(bounds(figure), 200);
  const BinaryVolume parity = voxelize(figure, frame, {.classifier = Classifier::kParity, .directions = 13}, context);
  const BinaryVolume stabbing =
      voxelize(figure, frame, {.classifier = Classifier::kStabbing, .directions = 13}, context);
  // Parity is within stabbing: what lies inside a part lies between a first and a last crossing in every direction.
  // Only centres closer to the surface than oblique rays are moved, 2^-10 voxel, may tell otherwise.
  const AabbTree tree(figure);
  std::int64_t hollowed = 0;
  for (std::int64_t k = 0; k < parity.nz(); ++k) {
    for (std::int64_t j = 0; j < parity.ny(); ++j) {
      for (std::int64_t i = 0; i < parity.nx(); ++i) {
        hollowed += stabbing(i, j, k) > parity(i, j, k);
        if (stabbing(i, j, k) >= parity(i, j, k)) continue;
        EXPECT_LT(std::sqrt(tree.nearest(frame.center({i, j, k})).squared_distance), 0x1.1p-10 * frame.voxel_size);
      }
    }
  }
  EXPECT_GT(hollowed, count_interior(stabbing) / 100);
  EXPECT_NE(betti_numbers(parity, context), betti_numbers(stabbing, context));
}

TEST(Closing, JoinsTheSlatsOfTheChairIntoOneSolidOfGenusZero) {
  // [NT03, Fig. 9]: closing distance 10, 170 faces. At 256 voxels the gaps between slats have 0.045 * 256 / 0.985,
  // about 11.7 voxels, fewer than the 20 that a ball of radius 10 bridges.
  const TriangleSoup chair = make_procedural("chair");
  EXPECT_NEAR(static_cast<double>(chair.triangles.size()), 3261, 0.02 * 3261);
  const MethodResult result = run(chair, {"resolution=256", "morphology=close", "distance=10", "triangles=170"});
  const TriangleSoup reduced = result.levels->extract(0);
  expect_one_closed_component(reduced);
  EXPECT_EQ(analyze_topology(reduced).genus.value_or(-1), 0);
  EXPECT_LE(reduced.triangles.size(), 170U);
  RunContext context;
  EXPECT_EQ(betti_numbers(std::get<BinaryVolume>(result.volumes.back().volume), context), (BettiNumbers{1, 0, 0}));
}

TEST(Closing, CanBeCancelledWhileItRuns) {
  const Method& method = find_method("nooruddin-turk");
  const std::vector<std::string> settings = {"resolution=128", "morphology=close", "distance=10"};
  RunContext context;
  std::stop_source source;
  context.cancellation = source.get_token();
  bool closing_began = false;
  context.progress = [&](const ProgressEvent& event) {
    if (event.stage != "close") return;
    closing_began = true;
    source.request_stop();
  };
  EXPECT_THROW(method.run({"chair", make_procedural("chair")},
                          Parameters::parse(method.info().parameters, settings, ""), context),
               Cancelled);
  EXPECT_TRUE(closing_began);
}

TEST(Closing, LeavesTheChairInPiecesWhenTheBallFitsBetweenItsSlats) {
  const TriangleSoup chair = make_procedural("chair");
  const MethodResult result = run(chair, {"resolution=256", "morphology=close", "distance=2"});
  EXPECT_GT(analyze_topology(result.levels->extract(0)).components, 1);
}

TEST(RealModels, BunnyWithHolesIsRepairedByThirteenDirections) {
  VOXCARVE_REQUIRE_DATA(path, "bunny_base_holes.ply");
  const TriangleSoup bunny = read_mesh(path);
  const TriangleSoup repaired = run(bunny, {"resolution=256", "classifier=parity", "directions=13"}).levels->extract(0);
  expect_one_closed_component(repaired);
  EXPECT_EQ(analyze_topology(repaired).genus.value_or(-1), 0);
  // One direction, through the holes of the base: whole columns are lost [NT03, Fig. 4].
  const MethodResult damaged = run(bunny, {"resolution=256", "classifier=parity", "directions=1"});
  ASSERT_EQ(damaged.notices.size(), 1U);
  EXPECT_NE(damaged.notices[0].find("voxel columns"), std::string::npos);
  EXPECT_LT(signed_volume(damaged.levels->extract(0)), signed_volume(repaired));
}

TEST(RealModels, AlCaponeBecomesOneClosedComponentByStabbing) {
  VOXCARVE_REQUIRE_DATA(path, "al_capone.obj");
  expect_stabbing_converges(read_mesh(path), "256");
}

}  // namespace
}  // namespace voxcarve
