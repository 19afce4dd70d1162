// NT Table 1, measured: which degeneracy parity count, ray stabbing, and stitching before stabbing repair.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>

#include "common/mesh/models/cracked.h"
#include "common/mesh/models/procedural.h"
#include "common/mesh/topology.h"
#include "methods/registry.h"

namespace voxcarve {
namespace {

struct Outcome {
  bool repaired = false;    ///< volume within 1 %, and the genus and components of the sound solid
  double volume_ratio = 0;  ///< over the sound solid's
};

Outcome outcome_of(const CrackedSolid& solid, std::vector<std::string> settings) {
  const Method& method = find_method("nooruddin-turk");
  settings.insert(settings.end(), {"resolution=128", "directions=13"});
  RunContext context;
  context.threads = 2;
  const MethodResult result = method.run({solid.name, make_procedural(solid.name)},
                                         Parameters::parse(method.info().parameters, settings, ""), context);
  const TriangleSoup surface = result.levels->extract(0);
  const SurfaceTopology topology = analyze_topology(surface);
  const double ratio = signed_volume(surface) / solid.volume;
  const bool sound = topology.genus == solid.genus && topology.components == solid.components;
  return {std::abs(ratio - 1) < 0.01 && sound, ratio};
}

struct Expected {
  Outcome parity, stabbing, stitched;
};

/// The method's README shows this table. Whether a degeneracy is repaired is what the paper's guidelines (3.3) say:
/// parity repairs everything but what overlaps, stabbing everything but openings. "Neither ... can deal with models
/// that have small cracks and interpenetrating parts." The ratios of the volumes are measured.
const std::map<std::string, Expected> kExpected = {
    {"cracked-holes", {{true, 0.997}, {false, 0.533}, {true, 0.998}}},
    {"cracked-cracks", {{true, 0.998}, {false, 0.917}, {true, 0.998}}},
    {"cracked-t-joints", {{true, 0.998}, {true, 0.998}, {true, 0.998}}},
    {"cracked-zero-area", {{true, 0.998}, {true, 0.998}, {true, 0.998}}},
    // Measured, against the guideline: by parity a void stays where an inner wall ends.
    {"cracked-nonmanifold-edges", {{false, 0.997}, {true, 0.998}, {true, 0.998}}},
    {"cracked-nonmanifold-vertices", {{true, 0.997}, {true, 0.997}, {true, 0.997}}},
    {"cracked-redundant-polygons", {{true, 0.995}, {true, 0.998}, {true, 0.998}}},
    {"cracked-shared-walls", {{true, 0.998}, {true, 0.998}, {true, 0.998}}},
    {"cracked-double-walls", {{false, 0.023}, {true, 0.998}, {true, 0.998}}},
    {"cracked-interpenetrating", {{false, 0.826}, {true, 0.998}, {true, 0.998}}},
    {"cracked-holes-interpenetrating", {{false, 0.825}, {false, 0.672}, {true, 0.998}}},
    {"cracked-cracks-interpenetrating", {{false, 0.826}, {false, 0.940}, {true, 0.998}}},
};

/// Of the ratios, which are rounded to three digits.
constexpr double kTolerance = 0.001;

class CrackedSolids : public testing::TestWithParam<CrackedSolid> {};

TEST_P(CrackedSolids, AreRepairedByWhatTheGuidelinesSay) {
  const CrackedSolid& solid = GetParam();
  ASSERT_TRUE(kExpected.contains(solid.name)) << solid.name;
  const Expected& expected = kExpected.at(solid.name);
  const auto expect = [&](const Outcome& wanted, const std::vector<std::string>& settings) {
    const Outcome outcome = outcome_of(solid, settings);
    EXPECT_EQ(outcome.repaired, wanted.repaired) << settings.back();
    EXPECT_NEAR(outcome.volume_ratio, wanted.volume_ratio, kTolerance) << settings.back();
  };
  expect(expected.parity, {"classifier=parity"});
  expect(expected.stabbing, {"classifier=stabbing"});
  expect(expected.stitched, {"classifier=stabbing", "stitch=on"});
}

INSTANTIATE_TEST_SUITE_P(Table1, CrackedSolids, testing::ValuesIn(cracked_solids()),
                         [](const testing::TestParamInfo<CrackedSolid>& solid) {
                           std::string name = solid.param.name;
                           std::ranges::replace(name, '-', '_');
                           return name;
                         });

}  // namespace
}  // namespace voxcarve
