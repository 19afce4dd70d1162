// The stages around the voxels: densities, smoothing, colour, stitching, reduction, and what is said to the user.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

#include "common/mesh/models/primitives.h"
#include "common/mesh/topology.h"
#include "common/run/errors.h"
#include "common/volume/morphology.h"
#include "methods/registry.h"
#include "tests/support/shapes.h"

namespace voxcarve {
namespace {

using test::joined;

MethodResult run(const Model& model, const std::vector<std::string>& settings) {
  const Method& method = find_method("nooruddin-turk");
  RunContext context;
  return method.run(model, Parameters::parse(method.info().parameters, settings, ""), context);
}

TriangleSoup surface_of(const TriangleSoup& soup, const std::vector<std::string>& settings) {
  return run({"input", soup}, settings).levels->extract(0);
}

bool has_notice(const MethodResult& result, const std::string& part) {
  return std::ranges::any_of(result.notices,
                             [&](const std::string& notice) { return notice.find(part) != std::string::npos; });
}

/// Root mean square distance of the vertices from the unit sphere.
double roughness(const TriangleSoup& surface) {
  double sum = 0;
  for (const Point& p : surface.positions) sum += (p.norm() - 1) * (p.norm() - 1);
  return std::sqrt(sum / static_cast<double>(surface.positions.size()));
}

TEST(Supersampling, MakesTheRepairedSphereSmoother) {
  // One sample a voxel puts every vertex midway between two centres, so that its distance along a grid edge is off by
  // up to half a voxel, uniformly; the distance to the surface is that times a cosine c between the edge and the
  // normal. Cut edges lie in proportion to c, so E[c^2] = int c^3 / int c = 1/2: rms h / sqrt(12) / sqrt(2) = 0.204 h.
  const TriangleSoup sphere = icosphere(Point::Zero(), 1, 5);
  const double h = 2.0 / 32;
  const double binary = roughness(surface_of(sphere, {"resolution=32", "supersampling=1", "kernel=box"}));
  EXPECT_NEAR(binary, 0.204 * h, 0.03 * h);
  double rougher = binary;
  for (const char* samples : {"supersampling=2", "supersampling=3"}) {
    const double box = roughness(surface_of(sphere, {"resolution=32", samples, "kernel=box"}));
    EXPECT_LT(box, 0.75 * rougher) << samples;
    rougher = box;
    EXPECT_LT(roughness(surface_of(sphere, {"resolution=32", samples, "kernel=gaussian"})), 0.25 * binary) << samples;
  }
}

TEST(IsoValue, ALowerOneGivesALargerSolid) {
  const TriangleSoup sphere = icosphere(Point::Zero(), 1, 4);
  const double half = signed_volume(surface_of(sphere, {"resolution=32"}));
  EXPECT_LT(signed_volume(surface_of(sphere, {"resolution=32", "iso_value=0.8"})), half);
  EXPECT_GT(signed_volume(surface_of(sphere, {"resolution=32", "iso_value=0.2"})), half);
  // Without densities between 0 and 1 the surface moves along the grid edges: at 0.25, a quarter of a voxel outward.
  const TriangleSoup cube = box(Point::Zero(), Point::Ones());
  const std::vector<std::string> binary = {"resolution=10", "supersampling=1", "kernel=box", "iso_value=0.25"};
  const Box grown = bounds(surface_of(cube, binary));
  EXPECT_NEAR(grown.lower[0], -0.025, 1e-12);
  EXPECT_NEAR(grown.upper[2], 1.025, 1e-12);
}

TEST(Threshold, DecidesWhatTheMorphologySees) {
  const TriangleSoup sphere = icosphere(Point::Zero(), 1, 4);
  const auto voxels = [&](const char* threshold) {
    const MethodResult result = run({"sphere", sphere}, {"resolution=32", "supersampling=3", "kernel=gaussian",
                                                         "morphology=close", "distance=1", threshold});
    return count_interior(std::get<BinaryVolume>(result.volumes.back().volume));
  };
  EXPECT_GT(voxels("threshold=0.1"), voxels("threshold=0.5"));
  EXPECT_GT(voxels("threshold=0.5"), voxels("threshold=0.9"));
}

TEST(ThinShell, HasTwoSurfacesThatAreNearOneAnother) {
  // Density 1/2 lies one voxel from the sphere on either side [NT03, 3, Fig. 2a].
  const TriangleSoup sphere = icosphere(Point::Zero(), 1, 5);
  const double h = 2.0 / 64;
  const TriangleSoup shell = surface_of(sphere, {"resolution=64", "classifier=thin-shell"});
  EXPECT_EQ(analyze_topology(shell).components, 2);
  const double outer = 4.0 / 3 * std::numbers::pi * std::pow(1 + h, 3);
  const double inner = 4.0 / 3 * std::numbers::pi * std::pow(1 - h, 3);
  EXPECT_NEAR(signed_volume(shell) / (outer - inner), 1, 0.05);
}

TEST(Smoothing, IsOnAfterMorphologyAndOffOtherwise) {
  const Model sphere = {"sphere", icosphere(Point::Zero(), 1, 4)};
  const auto surface = [&](std::vector<std::string> settings) {
    settings.emplace_back("resolution=24");
    return run(sphere, settings).levels->extract(0);
  };
  const std::vector<std::string> closing = {"morphology=close", "distance=2"};
  const auto with = [&](std::vector<std::string> settings, const char* extra) {
    settings.emplace_back(extra);
    return settings;
  };
  EXPECT_EQ(surface(closing), surface(with(closing, "smoothing=10")));
  EXPECT_NE(surface(closing), surface(with(closing, "smoothing=0")));
  EXPECT_EQ(surface({}), surface({"smoothing=0"}));
  EXPECT_LT(roughness(surface(closing)), 0.7 * roughness(surface(with(closing, "smoothing=0"))));
  EXPECT_THROW(surface({"smoothing_lambda=0.5", "smoothing_mu=-0.4"}), ParameterError);
  // Steps that would make waves are refused before anything is done; the defaults are legal at any number of
  // iterations.
  EXPECT_THROW(surface({"smoothing=100", "smoothing_mu=-1.5"}), ParameterError);
  EXPECT_THROW(surface(with(closing, "smoothing_mu=-1.5")), ParameterError);
  EXPECT_EQ(surface({"smoothing_mu=-1.5"}), surface({}));
  EXPECT_NO_THROW(surface({"smoothing=1000"}));
}

TEST(DistanceMaps, AgreeWhereDanielssonsIsExact) {
  // The nearest voxel of a single block is reached by straight and diagonal steps through voxels of the same nearest
  // one, so nothing is lost on the way.
  const Model cube = {"cube", box(Point::Zero(), Point::Ones())};
  const std::vector<std::string> settings = {"resolution=12", "morphology=dilate", "distance=3"};
  std::vector<std::string> danielsson = settings;
  danielsson.emplace_back("distance_map=danielsson-4sed");
  EXPECT_EQ(run(cube, settings).levels->extract(0), run(cube, danielsson).levels->extract(0));
}

TEST(Colours, ComeOutWhereTheyWentIn) {
  // Two overlapping boxes, red and blue; stabbing makes one solid of them.
  TriangleSoup boxes = joined({colored(box(Point(0, 0, 0), Point(2, 1, 1)), Color(1, 0, 0)),
                               colored(box(Point(1, -0.5, -0.5), Point(3, 1.5, 1.5)), Color(0, 0, 1))});
  const double h = 3.0 / 48;
  for (const char* triangles : {"triangles=0", "triangles=300"}) {
    const TriangleSoup out = surface_of(boxes, {"resolution=48", "classifier=stabbing", "directions=13", triangles});
    ASSERT_EQ(out.vertex_colors.size(), out.positions.size());
    for (std::size_t v = 0; v < out.positions.size(); ++v) {
      const double x = out.positions[v][0];
      if (x < 1 - 3 * h) {
        EXPECT_GT(out.vertex_colors[v][0], 0.9F) << x;
        EXPECT_LT(out.vertex_colors[v][2], 0.1F) << x;
      } else if (x > 1 + 3 * h) {
        EXPECT_GT(out.vertex_colors[v][2], 0.9F) << x;
        EXPECT_LT(out.vertex_colors[v][0], 0.1F) << x;
      }
    }
  }
  EXPECT_TRUE(surface_of(boxes, {"resolution=24", "color=off"}).vertex_colors.empty());
}

TEST(Colours, OfAClosedGapAreThoseOfTheNearestSurface) {
  // A red and a blue plate 0.2 apart, closed: the filling is red in its lower half and blue in its upper one.
  TriangleSoup plates = joined({colored(box(Point(0, 0, 0), Point(2, 2, 0.4)), Color(1, 0, 0)),
                                colored(box(Point(0, 0, 0.6), Point(2, 2, 1)), Color(0, 0, 1))});
  const TriangleSoup out =
      surface_of(plates, {"resolution=40", "morphology=close", "distance=5", "smoothing=0", "directions=3"});
  EXPECT_EQ(analyze_topology(out).components, 1);
  const double h = 2.0 / 40;
  std::size_t in_the_gap = 0;
  for (std::size_t v = 0; v < out.positions.size(); ++v) {
    const double z = out.positions[v][2];
    if (std::abs(z - 0.5) < h || std::abs(z - 0.5) > 0.1) continue;
    ++in_the_gap;
    EXPECT_GT(out.vertex_colors[v][z < 0.5 ? 0 : 2], 0.99F) << z;
  }
  EXPECT_GT(in_the_gap, 100U);
}

TEST(Stitching, LetsStabbingRepairCracksAndOverlapsTogether) {
  // Two overlapping boxes whose six sides each are moved outward by 0.004: cracks along every edge. Union of
  // [0,2]x[0,1]x[0,1] and [1,3]x[-.5,1.5]x[-.5,1.5]: 2 + 8 - 1.
  TriangleSoup cracked;
  for (const auto& part : {box(Point(0, 0, 0), Point(2, 1, 1)), box(Point(1, -0.5, -0.5), Point(3, 1.5, 1.5))}) {
    for (const Triangle& triangle : part.triangles) {
      const Point normal = area_vector(part, triangle).normalized();
      TriangleSoup side;
      for (const std::uint32_t corner : triangle) side.positions.push_back(part.positions[corner] + 0.004 * normal);
      side.triangles = {{0, 1, 2}};
      append(cracked, side);
    }
  }
  const std::vector<std::string> settings = {"resolution=60", "classifier=stabbing", "directions=13"};
  std::vector<std::string> stitching = settings;
  stitching.insert(stitching.end(), {"stitch=on", "stitch_tolerance=0.01"});
  const TriangleSoup stitched = surface_of(cracked, stitching);
  EXPECT_EQ(analyze_topology(stitched).components, 1);
  EXPECT_EQ(analyze_topology(stitched).genus.value_or(-1), 0);
  EXPECT_NEAR(signed_volume(stitched) / 9, 1, 0.02);
}

TEST(Notices, SayWhenTheResolutionIsBelowTenTimesTheDistance) {
  const Model cube = {"cube", box(Point::Zero(), Point::Ones())};
  EXPECT_TRUE(has_notice(run(cube, {"resolution=40", "morphology=close", "distance=5"}), "below 10 times"));
  EXPECT_FALSE(has_notice(run(cube, {"resolution=50", "morphology=close", "distance=5"}), "below 10 times"));
  EXPECT_FALSE(has_notice(run(cube, {"resolution=40", "distance=5"}), "below 10 times"));
  // The resolution counts, not the grid, which some settings make wider than the model.
  const std::vector<std::vector<std::string>> grids = {
      {}, {"kernel=gaussian", "supersampling=2"}, {"classifier=thin-shell"}, {"supersampling=3"}};
  for (const auto& grid : grids) {
    std::vector<std::string> settings = grid;
    settings.insert(settings.end(), {"resolution=40", "morphology=close", "distance=4.1"});
    EXPECT_TRUE(has_notice(run(cube, settings), "resolution of 40 voxels is below 10 times the distance of 4.1"));
    settings.back() = "distance=4";
    EXPECT_FALSE(has_notice(run(cube, settings), "below 10 times"));
  }
  // Of a volume what its interior fills: 30 of 90 voxels.
  BinaryVolume volume(GridFrame{Index3(90, 50, 50), Point::Zero(), 1});
  for (std::int64_t k = 20; k < 30; ++k)
    for (std::int64_t j = 20; j < 35; ++j)
      for (std::int64_t i = 40; i < 70; ++i) volume(i, j, k) = 1;
  const Model bar = {"bar", volume};
  EXPECT_TRUE(has_notice(run(bar, {"morphology=close", "distance=3.1"}), "resolution of 30 voxels is below 10 times"));
  EXPECT_FALSE(has_notice(run(bar, {"morphology=close", "distance=3"}), "below 10 times"));
}

TEST(Reducers, BothKeepTheTopology) {
  const TriangleSoup shape = torus(3, 1, 64, 32);
  for (const char* reducer : {"reducer=quadric", "reducer=openmesh"}) {
    const TriangleSoup reduced = surface_of(shape, {"resolution=48", "triangles=400", reducer});
    EXPECT_LE(reduced.triangles.size(), 400U) << reducer;
    const SurfaceTopology topology = analyze_topology(reduced);
    EXPECT_TRUE(topology.closed && topology.oriented) << reducer;
    EXPECT_EQ(topology.genus.value_or(-1), 1) << reducer;
  }
}

TEST(Baselines, OpenAndCloseAreTheOperatorsAlone) {
  // A thin ring (0.1) within the hole (radius 2) of a thick one (1), in voxels of 1/8: a ball of 3/8 opens the thin one
  // away. A ball of radius R on the axis touches the tube at height sqrt((1 + R)^2 - 9), so above the middle for R > 4:
  // balls of 5 from above and below do not meet, and the closing is one piece without a tunnel.
  const Model tori = {"tori", joined({torus(3, 1, 48, 24), torus(1, 0.1, 24, 8)})};
  const std::vector<std::tuple<const char*, const char*, std::int64_t>> cases = {{"open", "radius=3", 1},
                                                                                 {"close", "radius=40", 0}};
  for (const auto& [name, radius, genus] : cases) {
    const Method& method = find_method(name);
    const std::vector<std::string> settings = {"resolution=64", radius};
    RunContext context;
    const MethodResult result = method.run(tori, Parameters::parse(method.info().parameters, settings, ""), context);
    const SurfaceTopology topology = analyze_topology(result.levels->extract(0));
    EXPECT_TRUE(topology.closed) << name;
    EXPECT_EQ(topology.components, 1) << name;
    EXPECT_EQ(topology.genus.value_or(-1), genus) << name;
  }
}

}  // namespace
}  // namespace voxcarve
