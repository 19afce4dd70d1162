// Hierarchies as files: `voxcarve run --levels`, and `voxcarve render` of their index.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "common/volume/io/png.h"
#include "experiments/render/render.h"
#include "tests/cli/program.h"

namespace voxcarve::test {
namespace {

using Json = nlohmann::json;

class LevelsProgram : public Program {
 protected:
  Json index_of(const std::string& folder) const { return Json::parse(read_text(folder_ / folder / "index.json")); }
  std::vector<std::string> files_in(const std::string& folder) const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder_ / folder))
      names.push_back(entry.path().filename().string());
    std::ranges::sort(names);
    return names;
  }
  void write(const std::string& name, const std::string& text) const { std::ofstream(folder_ / name) << text; }

  /// Three levels of a torus of genus 1, the middle one interpolated, with two layers each.
  static constexpr const char* kTorus =
      "run he-lowpass model:torus --set resolution=12,24 between=1 layers=2 --levels out ";
};

TEST_F(LevelsProgram, WritesAMeshALevelAndALayerAndAnIndex) {
  const Json report = run_json(std::string(kTorus) + "-o coarse.ply --level 0");
  EXPECT_EQ(report["levels_folder"], "out");
  EXPECT_EQ(report["levels"], 3);
  const Json index = index_of("out");
  EXPECT_EQ(index["program"], report["program"]);
  EXPECT_EQ(index["method"], "he-lowpass");
  EXPECT_EQ(index["model"], "torus");
  EXPECT_EQ(index["parameters"], report["parameters"]);
  EXPECT_EQ(index["seed"], 0);
  ASSERT_EQ(index["levels"].size(), 3U);
  std::vector<std::string> expected = {"index.json"};
  const auto shows = [&](const Json& entry) {
    const std::string file = entry["file"];
    expected.push_back(file);
    const Json measured = run_json("measure out/" + file)["a"];
    EXPECT_EQ(entry["triangles"], measured["triangles"]) << file;
    return measured;
  };
  for (int level = 0; level < 3; ++level) {
    const Json& entry = index["levels"][static_cast<std::size_t>(level)];
    EXPECT_EQ(entry["level"], level);
    EXPECT_EQ(entry["file"], "level_" + std::to_string(level) + ".ply");
    const Json measured = shows(entry);
    for (const char* key : {"vertices", "components", "genus"}) EXPECT_EQ(entry[key], measured[key]) << level << key;
    EXPECT_EQ(entry["genus"], 1);
    ASSERT_EQ(entry["layers"].size(), 2U);
    EXPECT_EQ(entry["layers"][0]["opacity"], 1.0);  // by eq. 4 with m the density of the innermost layer
    EXPECT_EQ(entry["layers"][1]["opacity"].get<double>(),
              entry["layers"][1]["iso_density"].get<double>() / entry["layers"][0]["iso_density"].get<double>());
    EXPECT_LT(entry["layers"][1]["opacity"], 1);
    for (const Json& layer : entry["layers"]) shows(layer);
    EXPECT_EQ(entry["layers"][1]["file"], "level_" + std::to_string(level) + "_layer_1.ply");
  }
  std::ranges::sort(expected);
  EXPECT_EQ(files_in("out"), expected);
  EXPECT_EQ(read_text(folder_ / "out/level_0.ply"), read_text(folder_ / "coarse.ply"));
  // A support is a voxel of its level unless something else is asked for, so of the coarser level twice the finer
  // one's; the level between is half way.
  const auto property = [&](std::size_t level, const char* name) {
    return index["levels"][level]["properties"][name].get<double>();
  };
  const double support = property(2, "support");
  EXPECT_NEAR(support, property(2, "voxel_size"), 1e-12);
  EXPECT_NEAR(property(0, "support"), 2 * support, 1e-12);
  EXPECT_NEAR(property(1, "support"), 1.5 * support, 1e-12);
  EXPECT_NEAR(property(0, "voxel_size"), 2 * support, 1e-12);
  EXPECT_NEAR(property(1, "support_voxels"), 1.5, 1e-12);
  EXPECT_EQ(property(0, "resolution"), 12);
  EXPECT_EQ(property(1, "share"), 0.5);
  EXPECT_FALSE(index["levels"][2]["properties"].contains("share"));
}

TEST_F(LevelsProgram, WritesTheSameBytesOnManyThreads) {
  ASSERT_EQ(run(std::string(kTorus) + "-j 1").code, 0);
  std::vector<std::string> before;
  for (const std::string& name : files_in("out")) before.push_back(read_text(folder_ / "out" / name));
  ASSERT_EQ(run(std::string(kTorus) + "-j 3").code, 0);
  std::vector<std::string> after;
  for (const std::string& name : files_in("out")) after.push_back(read_text(folder_ / "out" / name));
  EXPECT_EQ(before, after);
}

TEST_F(LevelsProgram, RemovesTheFilesOfAnEarlierExportAndNoOthers) {
  ASSERT_EQ(run(kTorus).code, 0);
  write("out/level_9.ply", "somebody's");
  write("out/notes.txt", "somebody's");
  ASSERT_EQ(run("run mason model:torus --set resolution=16 radius=1,2 --levels out --levels-format stl").code, 0);
  EXPECT_EQ(files_in("out"),
            (std::vector<std::string>{"index.json", "level_0.stl", "level_1.stl", "level_9.ply", "notes.txt"}));
  const Json index = index_of("out");
  EXPECT_EQ(index["levels"][0]["properties"]["radius"], 2.0);  // coarse to fine
  EXPECT_EQ(index["levels"][1]["properties"]["radius"], 1.0);
  EXPECT_EQ(index["levels"][0]["layers"], Json::array());
  // An index that names what no export writes removes none of it.
  write("out/index.json", R"({"levels": [{"file": "notes.txt"}, {"file": "../coarse.ply"}, {"file": 3}, 4]})");
  write("coarse.ply", "somebody's");
  ASSERT_EQ(run("run identity model:torus --levels out").code, 0);
  EXPECT_EQ(read_text(folder_ / "out/notes.txt"), "somebody's");
  EXPECT_EQ(read_text(folder_ / "coarse.ply"), "somebody's");
  EXPECT_EQ(index_of("out")["levels"][0]["properties"], Json::object());  // the method has nothing to say
}

TEST_F(LevelsProgram, ALevelWithoutTrianglesHasNoFile) {
  // Of a tube 0.8 thick nothing is 0.9 dense under a filter 0.93 wide to every side.
  ASSERT_EQ(run("run he-lowpass model:torus --set resolution=12,3 iso_value=0.9 --levels out").code, 0);
  const Json levels = index_of("out")["levels"];
  EXPECT_EQ(levels[0]["file"], nullptr);
  EXPECT_EQ(levels[0]["triangles"], 0);
  EXPECT_EQ(levels[0]["genus"], nullptr);
  EXPECT_EQ(levels[0]["undefined"]["genus"], "the level is empty");
  EXPECT_EQ(levels[1]["genus"], 1);
  EXPECT_FALSE(levels[1].contains("undefined"));
  EXPECT_EQ(files_in("out"), (std::vector<std::string>{"index.json", "level_1.ply"}));
}

TEST_F(LevelsProgram, SaysWhyAGenusIsUndefined) {
  write("square.off", "OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n");
  ASSERT_EQ(run("run identity square.off --levels out --levels-format off").code, 0);
  const Json level = index_of("out")["levels"][0];
  EXPECT_EQ(level["genus"], nullptr);
  EXPECT_EQ(level["undefined"]["genus"], run_json("measure square.off")["a"]["undefined"]["genus"]);
  EXPECT_EQ(level["components"], 1);
}

TEST_F(LevelsProgram, TakesAThousandLevelsAtMost) {
  const std::string many = "run he-lowpass model:torus --set resolution=6,8 between=";
  expect_refusal(many + "999 --levels out", 2, "at most 1000 levels, and there are 1,001");
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out"));
  // The stream, asked for too, is not lost.
  expect_refusal("run hagbi-elsana model:sphereflake?depth=1 --json --levels out -o s.vcs", 2, "voxcarve extract");
  EXPECT_EQ(files(), std::vector<std::string>{"s.vcs"});
}

TEST_F(LevelsProgram, RefusesWhatItWouldWriteOver) {
  ASSERT_EQ(run(kTorus).code, 0);
  expect_refusal("run he-lowpass out/level_1.ply --levels out", 2, "write over the input");
  expect_refusal("run identity out/../out/level_1.ply --levels ./out", 2, "write over the input");
  write("out/level_77.ply", read_text(folder_ / "out/level_0.ply"));
  expect_refusal("run identity out/level_77.ply --levels out", 2, "write over the input");
  EXPECT_EQ(run("run identity out/level_77.ply --levels out --levels-format off").code, 0);
  EXPECT_TRUE(std::filesystem::exists(folder_ / "out/level_77.ply"));
  write("file", "");
  expect_refusal("run identity model:torus --levels file", 4, "file");
  expect_refusal("run identity model:torus --levels missing/out", 4, "there is no folder");
  expect_refusal("run identity model:torus --levels-format obj", 2, "--levels");
  expect_refusal("run identity model:torus --levels out --levels-format vtk", 2, "vtk");
}

TEST_F(LevelsProgram, SaysWhatIsWrongWithAnIndex) {
  ASSERT_EQ(run("run identity model:torus --levels out").code, 0);
  const std::string index = read_text(folder_ / "out/index.json");
  expect_refusal("render out/index.json --level 1 -o x.png", 2, "has no level 1: it has 1, numbered from 0");
  expect_refusal("render out/index.json --layered -o x.png", 2, "has no layers");
  expect_refusal("render out/index.json --assembly 3 -o x.png", 2, "does not say how fine its levels are");
  expect_refusal("render out/index.json --assembly 3 --level 0 -o x.png", 2, "by their distance");
  expect_refusal("render out/index.json model:torus --assembly 3 -o x.png", 2, "by itself");
  expect_refusal("render out/index.json --assembly-pixels 3 -o x.png", 2, "with --assembly only");
  expect_refusal("render out/index.json --layered --wireframe -o x.png", 2, "draws no edges");
  expect_refusal("render out/index.json --slice z -o x.png", 2, "no voxels to slice");
  for (const char* option : {"--level 0", "--layered", "--assembly 3"})
    expect_refusal(std::string("render model:torus -o x.png ") + option, 2, "needs the index.json");
  for (const char* size : {"0", "101", "3x", "x3", "3x4x5", "-1", "a", "3.5"})
    expect_refusal(std::string("render out/index.json -o x.png --assembly=") + size, 2, "is none: give N");
  expect_refusal("render none.json -o x.png", 3, "none.json");
  const auto broken = [&](const std::string& text, const std::string& part) {
    write("out/b.json", text);
    expect_refusal("render out/b.json -o x.png", 3, part);
  };
  broken("", "no list \"levels\"");
  broken(index.substr(0, index.size() / 2), "no list \"levels\"");
  broken(R"({"levels": []})", "no list \"levels\"");
  broken(R"({"levels": [3]})", "neither null nor a mesh file");
  broken(R"({"levels": [{"file": "../level_0.ply"}]})", "neither null nor a mesh file");
  broken(R"({"levels": [{"file": "level_0.ply", "properties": {"support": "x"}}]})", "support is no number");
  broken(R"({"levels": [{"file": "level_0.ply", "layers": [{"file": null}]}]})", "no opacity");
  broken(R"({"levels": [{"file": "level_0.ply", "layers": [{"file": null, "opacity": 2}]}]})", "from 0 to 1");
  broken(R"({"levels": [{"file": "level_5.ply"}]})", "level_5.ply");
}

class HierarchyPictures : public LevelsProgram {
 protected:
  void SetUp() override {
    if (!rendering_available()) GTEST_SKIP() << "this build or this machine cannot render";
    LevelsProgram::SetUp();
  }
  GreyImage picture(const std::string& name) const { return decode_png(read_text(folder_ / name), name); }
};

TEST_F(HierarchyPictures, FartherInstancesAreNeverFiner) {
  ASSERT_EQ(run("run he-lowpass model:torus --set resolution=40 levels=4 --levels out").code, 0);
  const Json index = index_of("out");
  const Json panel =
      run_json("render out/index.json --assembly 3x12 --assembly-pixels 5 --size 200 -o a.png")["panels"][0];
  EXPECT_EQ(panel["kind"], "assembly");
  EXPECT_EQ(panel["columns"], 3);
  EXPECT_EQ(panel["rows"], 12);
  EXPECT_EQ(panel["pixels"], 5.0);
  ASSERT_EQ(panel["instances"].size(), 36U);
  std::vector<int> used(4);
  int triangles = 0;
  for (const Json& near : panel["instances"]) {
    for (const Json& far : panel["instances"]) {
      if (far["depth"] >= near["depth"]) {
        EXPECT_LE(far["level"], near["level"]);
      }
    }
    const auto level = near["level"].get<std::size_t>();
    ++used[level];
    triangles += index["levels"][level]["triangles"].get<int>();
    // A coarser one would take twice as much, or nothing is as fine as asked for.
    if (level > 0) {
      EXPECT_GT(2 * near["detail_pixels"].get<double>(), 5);
    }
    if (level < 3) {
      EXPECT_LE(near["detail_pixels"], 5);
    }
  }
  for (std::size_t level = 0; level < 4; ++level) {
    EXPECT_EQ(panel["levels"][level]["instances"], used[level]);
    EXPECT_EQ(panel["levels"][level]["triangles"], index["levels"][level]["triangles"]);
  }
  EXPECT_GE(std::ranges::count_if(used, [](int count) { return count > 0; }), 2);
  EXPECT_EQ(panel["triangles"], triangles);
  EXPECT_EQ(panel["finest_triangles"], 36 * index["levels"][3]["triangles"].get<int>());
  EXPECT_EQ(picture("a.png").width, 200);
  const Outcome text = run("render out/index.json --assembly 2 --size 100 -o b.png");
  EXPECT_EQ(text.code, 0) << text.err;
  EXPECT_NE(text.out.find("of 4 instances at the finest level"), std::string::npos) << text.out;
}

TEST_F(HierarchyPictures, LayersSmoothWhatIsAliased) {
  ASSERT_EQ(run("run he-lowpass 'model:bolt?form=implicit' --set resolution=32 layers=5 --levels out").code, 0);
  const std::string how = " --up z --size 100 --caption '' --aliased ";
  const auto grey_levels = [&](const std::string& name) {
    const GreyImage image = picture(name);
    return std::set<float>(image.values.begin(), image.values.end()).size();
  };
  const Json single = run_json("render out/index.json" + how + "-o single.png")["panels"][0];
  EXPECT_EQ(single["kind"], "mesh");
  EXPECT_EQ(single["level"], 0);
  const Json layered = run_json("render out/index.json --layered --level 0" + how + "-o layered.png")["panels"][0];
  EXPECT_EQ(layered["kind"], "layers");
  ASSERT_EQ(layered["opacities"].size(), 5U);
  int triangles = 0;
  const Json index = index_of("out");
  for (const Json& layer : index["levels"][0]["layers"]) triangles += layer["triangles"].get<int>();
  EXPECT_EQ(layered["triangles"], triangles);
  EXPECT_GT(grey_levels("layered.png"), grey_levels("single.png"));
  // The shades on the way to the white around the bolt: of the single surface hardly a pixel has one.
  const auto light = [&](const std::string& name) {
    const GreyImage image = picture(name);
    return std::ranges::count_if(image.values, [](float value) { return value > 235 && value < 255; });
  };
  EXPECT_GT(light("layered.png"), 50 + 4 * light("single.png"));
  ASSERT_EQ(run("render out/index.json --layered" + how + "-o again.png").code, 0);
  EXPECT_EQ(read_text(folder_ / "again.png"), read_text(folder_ / "layered.png"));
}

TEST_F(HierarchyPictures, DrawsLevelsBesideOtherShapesMagnified) {
  ASSERT_EQ(run(kTorus).code, 0);
  const Json panels = run_json("render model:torus out/index.json --level 1 --magnify 4 --size 128 -o a.png")["panels"];
  EXPECT_EQ(panels[1]["level"], 1);
  EXPECT_EQ(panels[1]["triangles"], index_of("out")["levels"][1]["triangles"]);
  const GreyImage image = picture("a.png");
  for (std::int64_t y = 0; y < 64; ++y) {   // above the captions
    for (std::int64_t x = 0; x < 120; ++x)  // left of the line between the panels
      ASSERT_EQ(image.values[static_cast<std::size_t>(y * image.width + x)],
                image.values[static_cast<std::size_t>((y - y % 4) * image.width + x - x % 4)]);
  }
}

}  // namespace
}  // namespace voxcarve::test
