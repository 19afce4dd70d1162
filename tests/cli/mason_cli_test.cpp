// Mason and its operators on images, volumes and soups, from the command line.
#include "tests/cli/program.h"

namespace voxcarve::test {
namespace {

using Json = nlohmann::json;

TEST_F(Program, SimplifiesAnImageAndMeasuresTheChange) {
  ASSERT_EQ(run("models landscape -o landscape.png").code, 0);
  const Json report = run_json("run mason landscape.png --set radius=5 -o simple.png --check-invariants");
  for (const Json& check : report["invariants"]) EXPECT_EQ(check["holds"], true) << check;
  EXPECT_GE(report["invariants"].size(), 13U);
  const Json pair = run_json("measure landscape.png simple.png --radius 5");
  // Pinned: the image is the program's own, and the filter is exact in integers.
  EXPECT_EQ(pair["a"]["voxels"]["interior"], 78195);
  EXPECT_EQ(pair["b"]["voxels"]["interior"], 82202);
  EXPECT_EQ(pair["voxels"]["changed"], 12181);
  EXPECT_EQ(pair["voxels"]["b_minus_a"].get<int>() - pair["voxels"]["a_minus_b"].get<int>(), 82202 - 78195);
  EXPECT_EQ(pair["b"]["voxels"]["foreground_components"], 1);
  // Mason never changes more than either of these.
  for (const char* filter : {"rf", "fr"}) {
    const std::string name = filter;
    ASSERT_EQ(run("run " + name + " landscape.png --set radius=5 -o " + name + ".png").code, 0);
    EXPECT_GT(run_json("measure landscape.png " + name + ".png")["voxels"]["changed"], 12181) << name;
  }
}

TEST_F(Program, GivesALevelForEveryRadius) {
  ASSERT_EQ(run("models cells -o cells.pbm").code, 0);
  const Json report = run_json("run round cells.pbm --set radius=2,6 -o coarse.pbm --level 0");
  EXPECT_EQ(report["levels"], 2);
  EXPECT_EQ(report["level"], 0);
  ASSERT_EQ(run("run round cells.pbm --set radius=6 -o six.pbm").code, 0);
  EXPECT_EQ(run_json("measure coarse.pbm six.pbm")["voxels"]["changed"], 0);
  ASSERT_EQ(run("run round cells.pbm --set radius=2,6 -o fine.pbm").code, 0);
  EXPECT_GT(run_json("measure fine.pbm six.pbm")["voxels"]["a_minus_b"], 0);
}

TEST_F(Program, WritesTheMapsOfMason) {
  ASSERT_EQ(run("models cells -o cells.pbm").code, 0);
  const auto interior = [&](const std::string& name) {
    return run_json("measure " + name + ".pbm")["a"]["voxels"]["interior"].get<int>();
  };
  for (const std::string radius : {"4", "4.2"}) {  // of the latter the square is no integer, and no float is 4.2
    const std::string mason = "run mason cells.pbm --set radius=" + radius + " maps=on --volume ";
    for (const std::string name : {"core", "mortar", "anticore"}) {
      ASSERT_EQ(run(mason + name + " -o " + name + ".pbm").code, 0);
    }
    EXPECT_GT(interior("mortar"), 0) << radius;
    EXPECT_EQ(interior("core") + interior("mortar") + interior("anticore"), 300 * 225) << radius;
    ASSERT_EQ(run(mason + "stability -o stability.nrrd").code, 0);
    // What is stable up to the radius is what the mortar leaves.
    run_json("run round stability.nrrd --iso " + radius + " --set radius=0 -o stable.pbm");
    EXPECT_EQ(interior("stable"), interior("core") + interior("anticore")) << radius;
  }
  expect_refusal("run mason cells.pbm --volume mortar -o x.pbm", 2, "no volume 'mortar'");
  expect_refusal("run mason cells.pbm --volume mortar", 2, "--volume needs an output file");
}

TEST_F(Program, AnEmptyResultIsAVolumeButNoMesh) {
  ASSERT_EQ(run("models cells -o cells.pbm").code, 0);
  const Outcome outcome = run("run erode cells.pbm --set radius=100 -o empty.pbm");
  EXPECT_EQ(outcome.code, 0);
  EXPECT_NE(outcome.err.find("the result is empty"), std::string::npos) << outcome.err;
  EXPECT_EQ(run_json("measure empty.pbm")["a"]["voxels"]["interior"], 0);
  expect_refusal("run erode cells.pbm --set radius=100 -o empty.ply", 5, "no mesh to write");
  ASSERT_EQ(run("run nooruddin-turk model:torus --set resolution=20 -o torus.nrrd").code, 0);
  const Json compared = run_json("compare torus.nrrd --methods erode,dilate --set radius=15 -o compared");
  EXPECT_EQ(compared["rows"][0]["status"], "failed");
  EXPECT_EQ(compared["rows"][1]["status"], "done");
  expect_refusal("run erode model:torus --set resolution=20 radius=15 -o empty.ply", 5, "nothing of torus is left");
}

TEST_F(Program, ListsAndWritesVolumeModels) {
  const Json models = run_json("models");
  int volumes = 0;
  for (const Json& model : models["procedural"]) volumes += model["kind"] != "mesh" ? 1 : 0;
  EXPECT_EQ(volumes, 4);
  ASSERT_EQ(run("models 'ball-cube?side=30' -o cube.nrrd").code, 0);
  EXPECT_EQ(run_json("measure cube.nrrd --no-visible")["a"]["voxels"]["interior"], 30 * 30 * 30);
  expect_refusal("models cells -o cells.ply", 2, "cells");
}

TEST_F(Program, RefusesRadiiThatAreNone) {
  expect_refusal("run mason model:cells --set radius=3,-1 -o x.png", 2, "real numbers, separated by commas");
  expect_refusal("run mason model:cells --set radius= -o x.png", 2, "radius=");
  expect_refusal("run mason model:cells --set radius=3, -o x.png", 2, "radius=3,");
}

TEST_F(Program, DrawsIrregularVoxelsInTheirColours) {
  ASSERT_EQ(run("models cells -o cells.pbm").code, 0);
  const Json drawn = run_json("render cells.pbm --irregular 5 --size 300 -o cells.png");
  EXPECT_EQ(drawn["panels"][0]["shows"], "irregularity");
  EXPECT_EQ(drawn["panels"][0]["radius"], 5);
  expect_refusal("render cells.pbm --irregular 5 --map grey -o x.png", 2, "--irregular");
}

}  // namespace
}  // namespace voxcarve::test
