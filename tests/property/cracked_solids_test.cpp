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

/// Volume within 1 %, and the genus and components of the sound solid.
bool repaired(const CrackedSolid& solid, std::vector<std::string> settings) {
  const Method& method = find_method("nooruddin-turk");
  settings.insert(settings.end(), {"resolution=128", "directions=13"});
  RunContext context;
  context.threads = 2;
  const MethodResult result = method.run({solid.name, make_procedural(solid.name)},
                                         Parameters::parse(method.info().parameters, settings, ""), context);
  const TriangleSoup surface = result.levels->extract(0);
  const SurfaceTopology topology = analyze_topology(surface);
  return std::abs(signed_volume(surface) / solid.volume - 1) < 0.01 && topology.genus == solid.genus &&
         topology.components == solid.components;
}

struct Expected {
  bool parity;
  bool stabbing;
};

/// What the paper's guidelines (3.3) say: parity repairs everything but what overlaps, stabbing everything but
/// openings. "Neither ... can deal with models that have small cracks and interpenetrating parts."
const std::map<std::string, Expected> kExpected = {
    {"cracked-holes", {true, false}},
    {"cracked-cracks", {true, false}},
    {"cracked-t-joints", {true, true}},
    {"cracked-zero-area", {true, true}},
    // Measured, against the guideline: by parity a void stays where an inner wall ends.
    {"cracked-nonmanifold-edges", {false, true}},
    {"cracked-nonmanifold-vertices", {true, true}},
    {"cracked-redundant-polygons", {true, true}},
    {"cracked-shared-walls", {true, true}},
    {"cracked-double-walls", {false, true}},
    {"cracked-interpenetrating", {false, true}},
    {"cracked-holes-interpenetrating", {false, false}},
    {"cracked-cracks-interpenetrating", {false, false}},
};

class CrackedSolids : public testing::TestWithParam<CrackedSolid> {};

TEST_P(CrackedSolids, AreRepairedByWhatTheGuidelinesSay) {
  const CrackedSolid& solid = GetParam();
  ASSERT_TRUE(kExpected.contains(solid.name)) << solid.name;
  const Expected& expected = kExpected.at(solid.name);
  EXPECT_EQ(repaired(solid, {"classifier=parity"}), expected.parity);
  EXPECT_EQ(repaired(solid, {"classifier=stabbing"}), expected.stabbing);
  EXPECT_TRUE(repaired(solid, {"stitch=on", "classifier=stabbing"}));
}

INSTANTIATE_TEST_SUITE_P(Table1, CrackedSolids, testing::ValuesIn(cracked_solids()),
                         [](const testing::TestParamInfo<CrackedSolid>& solid) {
                           std::string name = solid.param.name;
                           std::ranges::replace(name, '-', '_');
                           return name;
                         });

}  // namespace
}  // namespace voxcarve
