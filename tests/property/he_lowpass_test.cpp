// What He et al. say of their hierarchies, on small solids.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "common/mesh/models/procedural.h"
#include "common/mesh/topology.h"
#include "common/run/errors.h"
#include "methods/he_lowpass/hierarchy.h"
#include "methods/he_lowpass/low_pass.h"
#include "methods/he_lowpass/surface_layers.h"
#include "methods/registry.h"
#include "tests/support/shapes.h"

namespace voxcarve {
namespace {

const Method& method() {
  return find_method("he-lowpass");
}

MethodResult run(const Model& model, const std::vector<std::string>& assignments, int threads = 1) {
  RunContext context;
  context.threads = threads;
  return method().run(model, Parameters::parse(method().info().parameters, assignments, "he-lowpass"), context);
}

Model genus_three() {
  return {"genus-n", make_procedural("genus-n?genus=3")};
}

const DensityVolume& volume_of(const MethodResult& result, std::int64_t level) {
  const auto found = std::ranges::find(result.volumes, level, &NamedVolume::level);
  return std::get<DensityVolume>(found->volume);
}

TEST(HeLowpass, LevelsComeFromCoarseToFineAndEachIsThatOfTheOriginalAlone) {
  const MethodResult all = run(genus_three(), {"resolution=40,20,10"});
  ASSERT_EQ(all.levels->size(), 3);
  const std::vector<std::pair<std::string, std::string>> alone = {
      {"resolution=10", "support=1"}, {"resolution=20", "support=1"}, {"resolution=40", "support=1"}};
  for (std::size_t i = 0; i < alone.size(); ++i) {
    // A voxel of its own is the support of each: resolution times support is the same.
    const MethodResult one = run(genus_three(), {alone[i].first, alone[i].second});
    EXPECT_EQ(volume_of(one, 0), volume_of(all, static_cast<std::int64_t>(i)));
    EXPECT_EQ(one.levels->extract(0), all.levels->extract(static_cast<std::int64_t>(i)));
  }
}

TEST(HeLowpass, DetailsVanishFromLevelToLevel) {
  // The tunnels are a good tenth of the length wide: voxels of a fortieth keep them, those of a quarter cannot.
  const MethodResult all = run(genus_three(), {"resolution=40,4"});
  EXPECT_EQ(analyze_topology(all.levels->extract(1)).genus, 3);
  EXPECT_EQ(analyze_topology(all.levels->extract(0)).genus, 0);
}

TEST(HeLowpass, EveryInvariantHoldsOfEveryLevel) {
  const Model model = genus_three();
  const Parameters parameters = Parameters::parse(
      method().info().parameters, std::vector<std::string>{"resolution=24,12", "between=2", "layers=2"}, "he-lowpass");
  RunContext context;
  const MethodResult result = method().run(model, parameters, context);
  EXPECT_EQ(result.levels->size(), 4);
  EXPECT_EQ(result.layers.size(), 8U);
  const std::vector<InvariantCheck> checks = method().check_invariants(model, parameters, result, context);
  EXPECT_EQ(checks.size(), 3U);
  for (const InvariantCheck& check : checks) EXPECT_TRUE(check.holds) << check.name << ": " << check.detail;
}

TEST(HeLowpass, AWrongLevelIsNoticed) {
  const Model model = genus_three();
  const Parameters parameters =
      Parameters::parse(method().info().parameters, std::vector<std::string>{"resolution=12"}, "he-lowpass");
  RunContext context;
  MethodResult result = method().run(model, parameters, context);
  std::get<DensityVolume>(result.volumes[0].volume).values.front() = 1.5F;
  const std::vector<InvariantCheck> checks = method().check_invariants(model, parameters, result, context);
  EXPECT_EQ(std::ranges::count(checks, false, &InvariantCheck::holds), 2);
}

TEST(HeLowpass, NothingIsSaidOfDensitiesWhereThereAreNone) {
  ScalarVolume field{Grid<float>(test::frame_of({6, 6, 6})), 5};
  for (std::size_t i = 0; i < field.grid.values.size(); ++i) field.grid.values[i] = static_cast<float>(i % 11);
  const Model model{"field", field};
  const Parameters parameters = Parameters::parse(
      method().info().parameters, std::vector<std::string>{"resolution=6", "source=values"}, "he-lowpass");
  RunContext context;
  const MethodResult result = method().run(model, parameters, context);
  for (const InvariantCheck& check : method().check_invariants(model, parameters, result, context)) {
    EXPECT_TRUE(check.holds) << check.name;
    EXPECT_EQ(check.name.find("densities"), std::string::npos);
  }
}

TEST(HeLowpass, TurningTheInputTurnsTheOutput) {
  // A quarter turn about z takes (x, y) to (-y, x). The solid is implicit and asymmetric, in a box of whole voxels, and
  // no sample lies on its surface.
  const auto inside = [](const Point& p) {
    return (p - Point(0.31, 0.07, -0.2)).norm() < 0.83 || (p - Point(-0.5, 0.33, 0.4)).norm() < 0.51;
  };
  ImplicitSolid solid;
  solid.inside = inside;
  solid.box.extend(Point::Constant(-1.5));
  solid.box.extend(Point::Constant(1.5));
  ImplicitSolid turned = solid;
  turned.inside = [inside](const Point& p) { return inside(Point(p[1], -p[0], p[2])); };
  const MethodResult before = run({"solid", solid}, {"resolution=12"});
  const MethodResult after = run({"turned", turned}, {"resolution=12"});
  const DensityVolume& a = volume_of(before, 0);
  const DensityVolume& b = volume_of(after, 0);
  ASSERT_EQ(a.frame.dims, b.frame.dims);
  const std::int64_t last = a.nx() - 1;
  std::int64_t partial = 0;
  for (std::int64_t k = 0; k < a.nz(); ++k) {
    for (std::int64_t j = 0; j < a.ny(); ++j) {
      for (std::int64_t i = 0; i < a.nx(); ++i) {
        EXPECT_EQ(a(i, j, k), b(last - j, i, k));
        partial += a(i, j, k) > 0 && a(i, j, k) < 1 ? 1 : 0;
      }
    }
  }
  EXPECT_GT(partial, 100);
}

TEST(HeLowpass, LayersNestAndBelongToTheChosenDensities) {
  const MethodResult result = run(genus_three(), {"resolution=16", "layers=5"});
  const std::vector<SurfaceLayer> expected = best_layers({RadialShape::kGaussian, 0.4}, 5).layers;
  ASSERT_EQ(result.layers.size(), 5U);
  double volume = 0;
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(result.layers[i].iso_density, expected[i].iso_density);
    EXPECT_EQ(result.layers[i].opacity, expected[i].opacity);
    // Every vertex of a layer lies within the next one out: its solid is {density >= a lower value}. So do the volumes.
    double own = 0;
    for (const Triangle& t : result.layers[i].surface.triangles) {
      const auto& p = result.layers[i].surface.positions;
      own += p[t[0]].dot(p[t[1]].cross(p[t[2]])) / 6;
    }
    EXPECT_GT(own, volume);
    volume = own;
    EXPECT_TRUE(analyze_topology(result.layers[i].surface).closed);
  }
}

TEST(HeLowpass, ThreadsChangeNothing) {
  for (const char* filter : {"gaussian", "hyper-cone"}) {
    const std::vector<std::string> assignments = {"resolution=30,11", "between=1", "layer_error=0.05",
                                                  std::string("filter=") + filter};
    const MethodResult one = run(genus_three(), assignments, 1);
    const MethodResult two = run(genus_three(), assignments, 2);
    ASSERT_EQ(one.levels->size(), two.levels->size());
    for (std::int64_t i = 0; i < one.levels->size(); ++i) {
      EXPECT_EQ(one.levels->extract(i), two.levels->extract(i));
      EXPECT_EQ(volume_of(one, i), volume_of(two, i));
    }
  }
}

ScalarVolume ramp() {
  ScalarVolume volume{Grid<float>(test::frame_of({20, 20, 20}, Point::Zero(), 0.5)), 950};
  for (std::int64_t k = 0; k < 20; ++k) {
    for (std::int64_t j = 0; j < 20; ++j) {
      for (std::int64_t i = 0; i < 20; ++i) volume.grid(i, j, k) = static_cast<float>(100 * i);
    }
  }
  return volume;
}

TEST(HeLowpass, ValuesAreFilteredWithoutAnInsideTest) {
  // A symmetric filter leaves a linear field as it is, away from the border: the surface {x-index = 9.5} stays at
  // x = (9.5 + 1/2) / 2, midway between two centres of the level, from which both sides look alike. So it does of the
  // solid, whose samples are 1/11 apart: ceil(12 / 1.1) in a voxel. A plane may be off by half of that.
  for (const char* filter : {"gaussian", "hyper-cone", "box"}) {
    for (const char* source : {"values", "solid"}) {
      const MethodResult result =
          run({"ramp", ramp()},
              {"resolution=10", "support_model=1.1", std::string("filter=") + filter, std::string("source=") + source});
      const TriangleSoup surface = result.levels->extract(0);
      int inner = 0;
      for (const Point& p : surface.positions) {
        if (std::abs(p[1] - 5) > 2 || std::abs(p[2] - 5) > 2 || p[0] > 8) continue;
        EXPECT_NEAR(p[0], 5, source[0] == 'v' ? 1e-3 : 0.5 / 11 + 1e-3) << filter << ' ' << source;
        ++inner;
      }
      EXPECT_GT(inner, 5);
    }
  }
  EXPECT_THROW(run(genus_three(), {"source=values"}), InputError);
}

/// A plate |z| <= thickness / 2 of 2 x 2, with a cylindrical hole of a radius at its centre (0: none), and room about
/// it.
Model plate(double thickness, double hole) {
  ImplicitSolid solid;
  solid.inside = [=](const Point& p) {
    return std::abs(p[2]) <= thickness / 2 && std::abs(p[0]) <= 1 && std::abs(p[1]) <= 1 &&
           std::hypot(p[0], p[1]) >= hole;
  };
  solid.box.extend(Point::Constant(-1));
  solid.box.extend(Point::Constant(1));
  return {"plate", solid};
}

TEST(HeLowpass, LargeThinSheetsVanish) {
  // NT's criticism [NT03, 2.1]. In the middle of a wide sheet of thickness t the density is 1 - 2 d(t / 2), which is a
  // half where d = 1 / 4: all thinner ones vanish, whatever their extent. Sheets 10 % on either side of that.
  const RadialFilter filter{RadialShape::kGaussian, 0.4};
  constexpr double kSupport = 0.4;
  const double least = 2 * kSupport * filter.plane_distance(0.25);
  EXPECT_NEAR(1 - 2 * filter.plane_profile(least / 2 / kSupport), 0.5, 1e-9);
  const std::vector<std::string> assignments = {"resolution=21", "support_model=0.4"};  // a layer of samples at z = 0
  EXPECT_FALSE(run(plate(1.1 * least, 0), assignments).levels->extract(0).empty());
  EXPECT_THROW(run(plate(0.9 * least, 0), assignments), MethodFailure);
}

TEST(HeLowpass, WhetherAHoleClosesDependsOnItsSurroundings) {
  // NT's other criticism: one hole, one filter; in a thick plate its walls are within the support, in a thin one they
  // are not. On the axis the density is the filter's weight beyond the hole's radius and within the plate: of a
  // Gaussian of 0.2 about exp(-0.19^2 / 2 / 0.2^2) = 0.64 in the thick one, times the 0.68 within one sigma in the thin
  // one 0.43.
  const std::vector<std::string> assignments = {"resolution=41", "support_model=0.5"};
  const auto genus_of = [&](double thickness) {
    return analyze_topology(run(plate(thickness, 0.19), assignments).levels->extract(0)).genus;
  };
  EXPECT_EQ(genus_of(1.2), 0);
  EXPECT_EQ(genus_of(0.4), 1);
}

TEST(HeLowpass, NothingLeftIsAFailureByName) {
  // A torus in a support a hundred times its size has no density of a half anywhere.
  try {
    run({"torus", make_procedural("torus")}, {"resolution=4", "support_model=100"});
    FAIL();
  } catch (const MethodFailure& failure) {
    EXPECT_NE(std::string(failure.what()).find("nothing of torus is left"), std::string::npos);
  }
}

}  // namespace
}  // namespace voxcarve
