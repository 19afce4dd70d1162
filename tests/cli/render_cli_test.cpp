// `voxcarve render` of slices and volumes as a user runs it.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "common/volume/io/png.h"
#include "experiments/render/render.h"
#include "tests/cli/program.h"

namespace voxcarve {
namespace {

using nlohmann::json;
using test::Outcome;
using test::Program;
using test::read_text;

class RenderProgram : public Program {
 protected:
  void SetUp() override {
    Program::SetUp();
    // 3 x 2 x 2 values: 0 to 5 in the lower slice, 10 to 15 in the upper one.
    write("ramp.nrrd", "float", "3 2 2", "0 1 2 3 4 5 10 11 12 13 14 15");
    write("solid.nrrd", "uint8", "3 3 3", "0 0 0 0 0 0 0 0 0  0 0 0 0 1 0 0 0 0  0 0 0 0 0 0 0 0 0");
    write("hollow.nrrd", "uint8", "2 2 2", "0 0 0 0 0 0 0 0");
  }
  void write(const std::string& name, const std::string& type, const std::string& sizes,
             const std::string& values) const {
    std::ofstream(folder_ / name) << "NRRD0004\ntype: " << type << "\ndimension: 3\nsizes: " << sizes
                                  << "\nencoding: ascii\n\n"
                                  << values << "\n";
  }
  GreyImage picture(const std::string& name) const { return decode_png(read_text(folder_ / name), name); }
};

float at(const GreyImage& image, std::int64_t x, std::int64_t y) {
  return image.values[static_cast<std::size_t>(y * image.width + x)];
}

TEST_F(RenderProgram, DrawsSlices) {
  // An empty caption leaves the whole panel to the slice: 32 pixels with a margin of 1 give 3 x 2 voxels of 10 pixels,
  // from x = 1 and y = 6.
  const json report = run_json("render ramp.nrrd --slice z=0 --window 0,5 --caption '' --size 32 -o a.png");
  const GreyImage image = picture("a.png");
  ASSERT_EQ(image.width, 32);
  ASSERT_EQ(image.height, 32);
  for (int row = 0; row < 2; ++row) {
    for (int column = 0; column < 3; ++column) {
      const int value = column + 3 * row;  // a fifth of white each
      const int middle_y = 6 + 10 * (1 - row) + 5;
      EXPECT_NEAR(at(image, 1 + 10 * column + 5, middle_y), 51 * value, 0.01) << column << ", " << row;
    }
  }
  for (const auto& [x, y] : {std::pair(0, 15), std::pair(31, 15), std::pair(15, 5), std::pair(15, 26)})
    EXPECT_NEAR(at(image, x, y), 128, 0.01);  // the line around the slice
  EXPECT_EQ(at(image, 15, 4), 255);
  EXPECT_EQ(at(image, 15, 27), 255);
  EXPECT_EQ(report["output"], "a.png");
  EXPECT_EQ(report["shapes"], json({"ramp.nrrd"}));
  EXPECT_EQ(report["panels"], json::parse(R"([{"input": "ramp.nrrd", "kind": "slice", "shows": "values", "axis": "z",
      "index": 0, "slices": 2, "voxels": [3, 2, 2], "map": "grey", "window": [0.0, 5.0]}])"));
}

TEST_F(RenderProgram, DescribesEverySlice) {
  const json panels = run_json("render ramp.nrrd solid.nrrd --slice y --size 64 -o b.png")["panels"];
  ASSERT_EQ(panels.size(), 2U);
  EXPECT_EQ(panels[0]["index"], 1);                   // of two, floor(2 / 2)
  EXPECT_EQ(panels[0]["window"], json({0.0, 15.0}));  // of the whole volume
  EXPECT_EQ(panels[1]["index"], 1);
  EXPECT_EQ(panels[1]["window"], json({0.0, 1.0}));
  EXPECT_EQ(picture("b.png").width, 128);
  const json distance = run_json("render solid.nrrd --slice z=100% --distance --size 64 -o d.png")["panels"][0];
  EXPECT_EQ(distance["shows"], "distance");
  EXPECT_EQ(distance["index"], 2);
  EXPECT_EQ(distance["map"], "cyclic");
  EXPECT_EQ(distance["period"], 16.0);
  EXPECT_FALSE(distance.contains("window"));
  const json grey = run_json("render solid.nrrd --slice z --distance --map grey --size 64 -o g.png")["panels"][0];
  // The farthest of the middle slice is its corner, the square root of two away.
  EXPECT_NEAR(grey["window"][1].get<double>(), 1.41421356, 1e-6);
}

TEST_F(RenderProgram, SlicesLieInOnePlaneUnlessSeparate) {
  // Samples of both files lie at whole numbers, so slice 0 of `ramp` is slice 0 of `solid`, and 100 % of two slices is
  // slice 1; by itself `solid` has slice 2 there.
  EXPECT_EQ(run_json("render ramp.nrrd solid.nrrd --slice z=100% --size 64 -o p.png")["panels"][1]["index"], 1);
  EXPECT_EQ(run_json("render ramp.nrrd solid.nrrd --slice z=100% --separate --size 64 -o p.png")["panels"][1]["index"],
            2);
  // The third slice of `solid` is beyond `ramp`.
  expect_refusal("render --iso 1 solid.nrrd ramp.nrrd --slice z=2 -o q.png", 2,
                 "no slice in the first volume's plane z = 2");
}

TEST_F(RenderProgram, SaysWhatIsWrongWithASlice) {
  const auto refused = [&](const std::string& arguments, int code, const std::string& part) {
    expect_refusal("render --iso 1 " + arguments + " -o x.png", code, part);
  };
  refused("ramp.nrrd --slice z=2", 2, "ramp has no slice z=2: along z it has 2, numbered from 0");
  refused("ramp.nrrd --slice z=-1", 2, "no slice z=-1");
  refused("ramp.nrrd --slice w", 2, "slice 'w' is none");
  refused("ramp.nrrd --slice z=101%", 2, "share from 0 to 100 %");
  refused("ramp.nrrd --slice z --volume", 2, "exclude each other");
  refused("ramp.nrrd --slice z --window 3,3", 2, "first value must be less");
  refused("ramp.nrrd --slice z --window 3", 2, "--window");
  refused("ramp.nrrd --slice z --window 0,nan", 2, "not a number");
  refused("ramp.nrrd --slice z --window 0,1 --map cyclic", 2, "--map grey only");
  refused("ramp.nrrd --slice z --period 4", 2, "--map cyclic only");
  refused("ramp.nrrd --slice z --map cyclic --period -1", 2, "not a number from");
  refused("ramp.nrrd --slice z --map cyclic --period 0", 2, "not a number from");
  refused("ramp.nrrd --slice z --map rainbow", 2, "rainbow");
  for (const char* option : {"--distance", "--map grey", "--window 0,1", "--contour", "--period 2"})
    refused(std::string("ramp.nrrd ") + option, 2, "with --slice only");
  refused("model:torus --slice z", 2, "which has no voxels to slice; make a volume of it first: voxcarve run");
  refused("'model:bolt?form=implicit' --slice z", 2,
          "bolt is an implicit solid, which has no voxels to slice; make a volume of it first: voxcarve run he-lowpass "
          "'model:bolt?form=implicit' -o VOLUME.nrrd");
  refused("hollow.nrrd --slice z --distance", 3, "no interior voxel");
  EXPECT_EQ(files(), (std::vector<std::string>{"hollow.nrrd", "ramp.nrrd", "solid.nrrd"}));
}

TEST_F(RenderProgram, TheAdviceForAnImplicitSolidWorks) {
  const Outcome made = run("run he-lowpass 'model:bolt?form=implicit' --set resolution=16 -o b.nrrd");
  EXPECT_EQ(made.code, 0) << made.err;
  EXPECT_NE(made.out.find(" voxels in "), std::string::npos) << made.out;
  EXPECT_EQ(run("render b.nrrd --slice z --size 64 -o b.png").code, 0);
  expect_refusal("models 'bolt?form=implicit' -o b.ply", 3, "is an implicit solid; only meshes");
}

TEST_F(RenderProgram, SaysWhatIsWrongWithAVolume) {
  std::ofstream(folder_ / "ring.pbm") << "P1\n3 3\n1 1 1\n1 0 1\n1 1 1\n";
  expect_refusal("render model:torus --volume -o x.png", 2, "none of the shapes is a volume");
  expect_refusal("render ring.pbm --volume -o x.png", 2, "is an image");
  // A millionth of a GiB is 1,073 bytes, too little for 512 voxels of 6 bytes.
  std::string zeros;
  for (int i = 0; i < 512; ++i) zeros += "0 ";
  write("large.nrrd", "uint8", "8 8 8", zeros);
  expect_refusal("render large.nrrd --volume --memory 1e-6 -o x.png", 4, "memory budget");
  EXPECT_EQ(run("render ring.pbm --slice z --size 64 -o ring.png").code, 0);
}

TEST_F(RenderProgram, DrawsVolumesBesideMeshesOrSaysWhyNot) {
  const std::string arguments = "render model:torus solid.nrrd --volume --size 64 -o v.png";
  if (!rendering_available()) {
    expect_refusal(arguments, 4, "render");
    return;
  }
  const json panels = run_json(arguments)["panels"];
  EXPECT_EQ(panels[0]["kind"], "mesh");
  EXPECT_GT(panels[0]["triangles"], 0);
  EXPECT_EQ(panels[1]["kind"], "volume");
  EXPECT_EQ(panels[1]["voxels"], json({3, 3, 3}));
  EXPECT_EQ(panels[1]["iso_value"], 0.5);
  EXPECT_EQ(picture("v.png").width, 128);
}

TEST_F(RenderProgram, SlicesWorkWithoutRendering) {
  const Outcome outcome = run("render solid.nrrd --slice z --size 64 -o s.png");
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(outcome.err.find("captions") != std::string::npos, !captions_available());
}

}  // namespace
}  // namespace voxcarve
