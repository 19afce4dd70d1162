#include "common/mesh/reduction.h"

#include <gtest/gtest.h>

#include "common/mesh/models/primitives.h"
#include "common/mesh/topology.h"
#include "common/run/errors.h"
#include "tests/support/shapes.h"

namespace voxcarve {
namespace {

using test::joined;

void expect_closed_genus(const TriangleSoup& soup, std::int64_t components, std::int64_t genus) {
  const SurfaceTopology topology = analyze_topology(soup);
  EXPECT_TRUE(topology.closed);
  EXPECT_TRUE(topology.oriented);
  EXPECT_EQ(topology.nonmanifold_vertices, 0);
  EXPECT_EQ(topology.components, components);
  EXPECT_EQ(topology.genus.value_or(-1), genus);
}

TEST(ReduceOpenmesh, KeepsTheTopologyAndMeetsTheCount) {
  RunContext context;
  for (const std::int64_t triangles : {1000, 200, 60}) {
    const TriangleSoup reduced = reduce_openmesh(torus(3, 1, 48, 24), triangles, context);
    EXPECT_LE(static_cast<std::int64_t>(reduced.triangles.size()), triangles);
    expect_closed_genus(reduced, 1, 1);
  }
  EXPECT_TRUE(context.notices().empty());
}

TEST(ReduceOpenmesh, KeepsTheShape) {
  // Faces of a finely divided box are flat: collapses that cost nothing leave its volume.
  RunContext context;
  const TriangleSoup fine = block_surface(
      {1, 2, 3}, [](int, int, int) { return true; }, 1.0, 8);
  const TriangleSoup reduced = reduce_openmesh(fine, 100, context);
  EXPECT_NEAR(signed_volume(reduced), 6, 1e-9);
  EXPECT_NEAR(surface_area(reduced), 22, 1e-9);
}

TEST(ReduceOpenmesh, SaysWhenItStopsEarly) {
  // Five tetrahedra-like components cannot go below 4 triangles each.
  RunContext context;
  std::vector<TriangleSoup> spheres;
  for (int i = 0; i < 5; ++i) spheres.push_back(icosphere(Point(3 * i, 0, 0), 1, 2));
  const TriangleSoup reduced = reduce_openmesh(joined(spheres), 8, context);
  EXPECT_GE(reduced.triangles.size(), 20U);
  expect_closed_genus(reduced, 5, 0);
  ASSERT_FALSE(context.notices().empty());
  EXPECT_NE(context.notices().back().find("the reduction stopped at"), std::string::npos);
}

TEST(ReduceOpenmesh, LeavesWhatIsWithinTheCount) {
  RunContext context;
  const TriangleSoup cube = box(Point::Zero(), Point::Ones());
  EXPECT_EQ(reduce_openmesh(cube, 12, context), cube);
}

TEST(ReduceOpenmesh, CutsNonManifoldInputAndSaysSo) {
  // Two boxes that share an edge by index.
  TriangleSoup soup =
      merge_equal_positions(joined({block_surface(
                                        {1, 1, 1}, [](int, int, int) { return true; }, 1.0, 6),
                                    transformed(block_surface(
                                                    {1, 1, 1}, [](int, int, int) { return true; }, 1.0, 6),
                                                Eigen::Affine3d(Eigen::Translation3d(1, 1, 0)))}));
  ASSERT_GT(analyze_topology(soup).nonmanifold_edges, 0);
  RunContext context;
  const TriangleSoup reduced = reduce_openmesh(soup, 100, context);
  EXPECT_LE(reduced.triangles.size(), 100U);
  EXPECT_EQ(analyze_topology(reduced).nonmanifold_edges, 0);
  ASSERT_FALSE(context.notices().empty());
  EXPECT_NE(context.notices().front().find("was cut at singular edges"), std::string::npos);
}

TEST(ReduceOpenmesh, WorksFarFromTheOriginAndAtAnyScale) {
  RunContext context;
  for (const double scale : {1e-12, 1e12}) {
    const TriangleSoup sphere =
        transformed(icosphere(Point::Zero(), 1, 3), Eigen::Affine3d(Eigen::UniformScaling<double>(scale)));
    const TriangleSoup reduced = reduce_openmesh(sphere, 200, context);
    EXPECT_LE(reduced.triangles.size(), 200U);
    // 200 equal triangles have edges with a^2 = 16 pi / (200 sqrt 3) = 0.145; inscribed, their planes lie a^2 / 8 below
    // the sphere on average, so the best polyhedron loses 3 a^2 / 8 = 5.4 %. Half as much again is allowed.
    EXPECT_NEAR(signed_volume(reduced) / signed_volume(sphere), 1, 0.081) << scale;
  }
}

TEST(ReduceOpenmesh, CanBeCancelled) {
  RunContext context;
  std::stop_source source;
  context.cancellation = source.get_token();
  context.progress = [&](const ProgressEvent& event) {
    if (event.done > event.total / 4) source.request_stop();
  };
  EXPECT_THROW(reduce_openmesh(icosphere(Point::Zero(), 1, 5), 100, context), Cancelled);
}

}  // namespace
}  // namespace voxcarve
