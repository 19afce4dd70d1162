// Which level of detail an instance is drawn at, and where it stands.
#include "experiments/render/assembly.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "common/run/errors.h"
#include "tests/unit/rendered_image.h"

namespace voxcarve {
namespace {

using test::cube;
using test::front_view;

/// The cube [-1, 1]^3 `copies` times over, so that levels differ in triangles and not in size.
TriangleSoup cubes(int copies) {
  TriangleSoup soup;
  for (int i = 0; i < copies; ++i) append(soup, cube());
  return soup;
}

std::vector<AssemblyLevel> three_levels() {
  return {{cubes(1), 0.4}, {cubes(2), 0.2}, {cubes(4), 0.1}};
}

constexpr SceneSize kScene = {200, 160};

TEST(Assembly, StandsInRowsAwayFromTheView) {
  AssemblyOptions options;
  options.columns = 3;
  options.rows = 2;
  // From the front, -z is away. Sides are 2, and gaps a quarter of that.
  const Assembly assembly = plan_assembly(three_levels(), options, front_view(), kScene);
  ASSERT_EQ(assembly.instances.size(), 6U);
  for (std::size_t i = 0; i < 6; ++i) {
    const AssemblyInstance& instance = assembly.instances[i];
    EXPECT_EQ(instance.column, static_cast<int>(i % 3));
    EXPECT_EQ(instance.row, static_cast<int>(i / 3));
    EXPECT_LT((instance.offset - Point(2.5 * instance.column, 0, -2.5 * instance.row)).norm(), 1e-12);
    EXPECT_NEAR(instance.depth, assembly.instances[0].depth + 2.5 * instance.row, 1e-9);
  }
  EXPECT_EQ(assembly.framed.size(), 48U);
  // From the +x side, -x is away and -z to the right, however high the camera stands; with z up y goes away from -y.
  RenderOptions side = front_view();
  side.azimuth = 90;
  side.elevation = 60;
  EXPECT_LT((plan_assembly(three_levels(), options, side, kScene).instances[4].offset - Point(-2.5, 0, -2.5)).norm(),
            1e-12);
  RenderOptions z_up = front_view();
  z_up.up_axis = "z";
  EXPECT_LT((plan_assembly(three_levels(), options, z_up, kScene).instances[4].offset - Point(2.5, 2.5, 0)).norm(),
            1e-12);
}

TEST(Assembly, TakesTheCoarsestLevelWhoseDetailIsSmallEnough) {
  AssemblyOptions options;
  options.columns = 2;
  options.rows = 30;
  options.pixels = 3;
  RenderOptions render = front_view();
  render.view_angle = 50;
  const std::vector<AssemblyLevel> levels = three_levels();
  const Assembly assembly = plan_assembly(levels, options, render, kScene);
  // A length s facing the camera at depth d is seen under s / d, of 2 tan 25 for 160 pixels.
  const double pixels = 160 / (2 * std::tan(25 * std::numbers::pi / 180));
  std::int64_t triangles = 0;
  std::vector<int> used(3);
  for (const AssemblyInstance& instance : assembly.instances) {
    std::int64_t expected = 2;
    for (std::int64_t level = 2; level >= 0; --level) {
      if (levels[static_cast<std::size_t>(level)].detail / instance.depth * pixels <= 3) expected = level;
    }
    EXPECT_EQ(instance.level, expected) << instance.row;
    const AssemblyLevel& level = levels[static_cast<std::size_t>(instance.level)];
    EXPECT_NEAR(instance.detail_pixels, level.detail / instance.depth * pixels, 1e-9);
    triangles += 12 << instance.level;  // 12, 24 or 48
    ++used[static_cast<std::size_t>(instance.level)];
  }
  for (const int count : used) EXPECT_GT(count, 0);
  EXPECT_EQ(assembly.triangles, triangles);
  EXPECT_EQ(assembly.finest_triangles, 60 * 48);
}

TEST(Assembly, FartherInstancesAreNeverFiner) {
  std::mt19937_64 random(5);
  const auto uniform = [&random](double low, double high) {
    return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
  };
  for (int i = 0; i < 200; ++i) {
    RenderOptions render = front_view();
    render.azimuth = uniform(-180, 180);
    render.elevation = uniform(-90, 90);
    render.view_angle = uniform(5, 110);
    AssemblyOptions options;
    options.rows = 9;
    options.pixels = uniform(0.2, 20);
    const Assembly assembly = plan_assembly(three_levels(), options, render, kScene);
    for (const AssemblyInstance& near : assembly.instances) {
      EXPECT_GT(near.depth, 0);
      for (const AssemblyInstance& far : assembly.instances) {
        if (far.depth < near.depth) continue;
        EXPECT_LE(far.level, near.level) << i;
      }
    }
  }
}

TEST(Assembly, PassesOverEmptyLevelsAndKnowsItsEnds) {
  std::vector<AssemblyLevel> levels = three_levels();
  levels[0].surface = {};
  AssemblyOptions options;
  const auto all_at = [&](double pixels, std::int64_t level) {
    options.pixels = pixels;
    for (const AssemblyInstance& instance : plan_assembly(levels, options, front_view(), kScene).instances)
      EXPECT_EQ(instance.level, level) << pixels;
  };
  all_at(1e6, 1);
  all_at(1e-6, 2);
  for (AssemblyLevel& level : levels) level.surface = {};
  EXPECT_THROW(plan_assembly(levels, options, front_view(), kScene), ParameterError);
}

TEST(Assembly, MovesTheLevelsToTheirPlaces) {
  const std::vector<AssemblyLevel> levels = three_levels();
  AssemblyOptions options;
  options.columns = 1;
  options.rows = 2;
  Assembly assembly = plan_assembly(levels, options, front_view(), kScene);
  assembly.instances[1].level = 0;
  RunContext context;
  const TriangleSoup surface = assembly_surface(levels, assembly, context);
  const Box box = bounds(surface);
  EXPECT_LT((box.upper - Point(1, 1, 1)).norm(), 1e-12);
  EXPECT_LT((box.lower - Point(-1, -1, -3.5)).norm(), 1e-12);  // 2.5 away
  EXPECT_EQ(surface.triangles.size(), 12U * (1 << assembly.instances[0].level) + 12U);
  context.memory_budget = 100;
  EXPECT_THROW(assembly_surface(levels, assembly, context), ResourceError);
}

TEST(Assembly, IsPlannedForThePictureThatIsDrawn) {
  VOXCARVE_REQUIRE_RENDERING();
  AssemblyOptions options;
  options.columns = options.rows = 1;
  RenderOptions render = front_view();
  render.view_angle = 50;
  // The cube's front is its nearest part: 2 wide where a level's detail of 2 would be measured.
  const std::vector<AssemblyLevel> levels = {{cube(), 2}};
  const Assembly assembly = plan_assembly(levels, options, render, scene_size({""}, render));
  RunContext context;
  render.framed = assembly.framed;
  const test::Extent shape = test::drawn(render_image({{assembly_surface(levels, assembly, context), ""}}, render));
  EXPECT_NEAR(shape.right - shape.left + 1, assembly.instances[0].detail_pixels, 1.01);
  EXPECT_NEAR(assembly.instances[0].detail_pixels, 0.92 * 160, 1e-6);  // it fills the frame
}

}  // namespace
}  // namespace voxcarve
