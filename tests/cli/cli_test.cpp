// The program as a user runs it: exit codes, one line on errors, no partial files, JSON.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "experiments/render/render.h"
#include "tests/cli/program.h"

namespace voxcarve {
namespace {

using nlohmann::json;
using test::Outcome;
using test::Program;
using test::read_text;
namespace fs = std::filesystem;

TEST_F(Program, ListsMethodsAndTheirParameters) {
  const json methods = run_json("methods");
  ASSERT_GE(methods.size(), 4U);
  EXPECT_EQ(methods[0]["name"], "nooruddin-turk");
  const json method = run_json("methods nooruddin-turk");
  EXPECT_EQ(method["citation"], "NT03");
  bool found = false;
  for (const json& parameter : method["parameters"])
    found = found || (parameter["name"] == "resolution" && parameter["unit"] == "voxels");
  EXPECT_TRUE(found);
  EXPECT_NE(run("methods nooruddin-turk").out.find("resolution"), std::string::npos);
}

TEST_F(Program, WritesModelsAndMeasuresThem) {
  EXPECT_EQ(run("models 'torus?segments=32&tube_segments=16' -o torus.obj").code, 0);
  const json a = run_json("measure torus.obj")["a"];
  EXPECT_EQ(a["vertices"], 512);    // 32 * 16
  EXPECT_EQ(a["triangles"], 1024);  // two a quadrilateral
  EXPECT_EQ(a["genus"], 1);
  EXPECT_EQ(a["components"], 1);
  EXPECT_EQ(a["closed"], true);
  EXPECT_EQ(a["boundary_loops"], 0);
  EXPECT_EQ(a["self_intersections"], 0);
  EXPECT_EQ(a["solid"]["b1"], 1);
  for (const char* key : {"nonmanifold_edges", "nonmanifold_vertices", "area", "volume", "bbox_diagonal"})
    EXPECT_TRUE(a.contains(key)) << key;
}

TEST_F(Program, MeasuresPairs) {
  const json pair = run_json("measure model:torus model:torus");
  EXPECT_EQ(pair["hausdorff"]["upper"], 0.0);
  EXPECT_EQ(pair["symmetric_difference"]["volume"], 0.0);
  for (const char* key : {"lower", "upper", "mean", "rms", "relative_upper"})
    EXPECT_TRUE(pair["hausdorff"].contains(key)) << key;
  for (const char* side : {"a_to_b", "b_to_a"}) {
    EXPECT_TRUE(pair["hausdorff"][side].contains("lower"));
    EXPECT_TRUE(pair["hausdorff"][side].contains("upper"));
  }
  for (const char* key : {"volume", "standard_error", "relative", "a_minus_b", "b_minus_a"})
    EXPECT_TRUE(pair["symmetric_difference"].contains(key)) << key;
}

TEST_F(Program, RunsAMethodWithAReport) {
  const json report = run_json(
      "run nooruddin-turk model:torus --set resolution=40 directions=13 --triangles 300 --check-invariants --report "
      "r.json -o t.ply");
  EXPECT_LE(report["triangles"], 300);
  EXPECT_EQ(report["parameters"]["directions"], "13");
  EXPECT_EQ(report["invariants"][0]["holds"], true);
  EXPECT_EQ(json::parse(read_text(folder_ / "r.json")), report);
  EXPECT_EQ(run_json("measure t.ply")["a"]["genus"], 1);
}

TEST_F(Program, WritesVolumesOnTheInputsGridAndReadsThemBack) {
  EXPECT_EQ(run("run nooruddin-turk model:torus --set resolution=30 -o t.nrrd").code, 0);
  EXPECT_EQ(run("run nooruddin-turk t.nrrd --set morphology=open distance=1 -o opened.nrrd").code, 0);
  EXPECT_EQ(run("run nooruddin-turk t.nrrd --set morphology=dilate distance=2 -o dilated.nrrd").code, 0);
  const auto size_of = [&](const std::string& name) {
    const std::string text = read_text(folder_ / name);
    const std::size_t at = text.find("sizes:");
    return text.substr(at, text.find('\n', at) - at);
  };
  EXPECT_EQ(size_of("opened.nrrd"), size_of("t.nrrd"));
  EXPECT_NE(size_of("dilated.nrrd"), size_of("t.nrrd"));
  EXPECT_EQ(run_json("measure t.nrrd")["a"]["voxels"]["b1"], 1);
}

TEST_F(Program, ComparesAllMethods) {
  const json comparison = run_json("compare model:two-spheres --triangles 200 --set resolution=24 alpha=0.1 -o result");
  ASSERT_GE(comparison["rows"].size(), 4U);
  for (const json& row : comparison["rows"]) {
    EXPECT_EQ(row["status"], "done") << row;
    EXPECT_TRUE(fs::exists(folder_ / "result" / (row["method"].get<std::string>() + ".ply")));
    EXPECT_TRUE(row["metrics"]["hausdorff"]["upper"].is_number());
  }
  const std::string csv = read_text(folder_ / "result" / "comparison.csv");
  EXPECT_EQ(static_cast<std::size_t>(std::ranges::count(csv, '\n')), comparison["rows"].size() + 1);
  EXPECT_EQ(fs::exists(folder_ / "result" / "comparison.png"), rendering_available());
  EXPECT_EQ(comparison.contains("no_picture"), !rendering_available());
}

TEST_F(Program, ComparesWithASkippedAndAFailedRowAndSaysWhy) {
  // A slab of one triangle's thickness that no voxel centre of a coarse grid lies in.
  std::ofstream(folder_ / "sheet.off") << "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
  const Outcome outcome = run("compare sheet.off --triangles 100 --set alpha=0.1 -o result");
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("nooruddin-turk failed: no voxel centre lies inside sheet"), std::string::npos)
      << outcome.out;
}

TEST_F(Program, ComparisonsRemoveTheirOwnFilesAlone) {
  // The input lies in the folder of the results, under the name of a method that is not compared; so does another file.
  EXPECT_EQ(run("models 'torus?segments=8&tube_segments=6' -o result/qslim.ply").code, 4);  // no such folder yet
  fs::create_directory(folder_ / "result");
  EXPECT_EQ(run("models 'torus?segments=8&tube_segments=6' -o result/alpha-wrap.ply").code, 0);
  const std::string input = read_text(folder_ / "result" / "alpha-wrap.ply");
  std::ofstream(folder_ / "result" / "nooruddin-turk.ply") << "not ours";
  EXPECT_EQ(run("compare result/alpha-wrap.ply --methods identity,qslim --triangles 50 -o result").code, 0);
  EXPECT_EQ(read_text(folder_ / "result" / "alpha-wrap.ply"), input);
  EXPECT_EQ(read_text(folder_ / "result" / "nooruddin-turk.ply"), "not ours");
  EXPECT_TRUE(fs::exists(folder_ / "result" / "qslim.ply"));
  // The next comparison removes what this one wrote, and it alone.
  EXPECT_EQ(run("compare result/alpha-wrap.ply --methods identity --triangles 50 -o result").code, 0);
  EXPECT_FALSE(fs::exists(folder_ / "result" / "qslim.ply"));
  EXPECT_TRUE(fs::exists(folder_ / "result" / "identity.ply"));
  EXPECT_EQ(read_text(folder_ / "result" / "alpha-wrap.ply"), input);
  // What would be written over or removed is no input.
  const std::string message = "the comparison would write over its input";
  expect_refusal("compare result/alpha-wrap.ply --methods alpha-wrap -o result", 2, message);
  expect_refusal("compare result/identity.ply --methods qslim -o result", 2, message);
  fs::create_hard_link(folder_ / "result" / "alpha-wrap.ply", folder_ / "same.ply");
  expect_refusal("compare same.ply --methods alpha-wrap -o result", 2, message);
  EXPECT_EQ(read_text(folder_ / "result" / "alpha-wrap.ply"), input);
}

TEST_F(Program, ComparisonsRemoveNothingThatABadRecordNames) {
  fs::create_directory(folder_ / "result");
  std::ofstream(folder_ / "kept.ply") << "kept";
  for (const char* record :
       {"", "[1]", R"({"rows": 3})", R"({"rows": [{"method": 7, "status": "done"}, 5]})",
        R"({"rows": [{"method": "../kept", "status": "done"}, {"method": "..", "status": "done"}]})"}) {
    std::ofstream(folder_ / "result" / "comparison.json") << record;
    EXPECT_EQ(run("compare 'model:torus?segments=8&tube_segments=6' --methods identity -o result").code, 0) << record;
    EXPECT_EQ(read_text(folder_ / "kept.ply"), "kept") << record;
  }
}

TEST_F(Program, SaysWhenABudgetIsMissed) {
  const json report = run_json("run identity model:torus --triangles 10");
  ASSERT_EQ(report["notices"].size(), 1U);
  EXPECT_NE(report["notices"][0].get<std::string>().find("more than the budget of 10"), std::string::npos);
}

TEST_F(Program, MeasuresImagesByTheirVoxels) {
  std::ofstream(folder_ / "ring.pbm") << "P1\n3 3\n1 1 1\n1 0 1\n1 1 1\n";
  const json a = run_json("measure ring.pbm")["a"];
  EXPECT_EQ(a["voxels"]["interior"], 8);
  EXPECT_EQ(a["voxels"]["b1"], 1);
  expect_refusal("run qslim ring.pbm", 3, "not an image");
}

TEST_F(Program, TakesNamesThatAreNoUtf8) {
  const std::string name = "odd-\xff.off";
  std::ofstream(folder_ / name) << "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n";
  EXPECT_EQ(run("run identity '" + name + "' --json").code, 0);
}

TEST_F(Program, SaysWhenItsOutputCannotBeWritten) {
  const std::string command = "'" VOXCARVE_PROGRAM "' methods >/dev/full 2>'" + (folder_ / "err.txt").string() + "'";
  const int status = std::system(command.c_str());
  EXPECT_EQ(WEXITSTATUS(status), 4);
  EXPECT_NE(read_text(folder_ / "err.txt").find("standard output"), std::string::npos);
}

TEST_F(Program, RendersOrSaysWhyNot) {
  if (rendering_available()) {
    EXPECT_EQ(run("render model:torus model:chair -o two.png --size 200").code, 0);
    EXPECT_TRUE(read_text(folder_ / "two.png").starts_with("\x89PNG"));
  } else {
    expect_refusal("render model:torus -o one.png", 4, "render");
  }
}

TEST_F(Program, RefusesUsageErrorsWithCode2) {
  expect_refusal("", 2, "subcommand");
  expect_refusal("run qslin model:torus", 2, "did you mean 'qslim'?");
  expect_refusal("run nooruddin-turk model:torus --set resolutoin=8", 2, "did you mean 'resolution'?");
  expect_refusal("run nooruddin-turk model:torus --set resolution=0", 2, "must be an integer");
  expect_refusal("run qslim model:toruss", 2, "did you mean 'torus'?");
  expect_refusal("run qslim model:torus -o out.xyz", 2, "extension");
  expect_refusal("run qslim model:torus --level 5", 2, "there is no level 5");
  expect_refusal("compare model:torus --set nothing=1 -o r", 2, "fits none of the methods");
  expect_refusal("compare model:torus --methods qslim,qslim -o r", 2, "twice");
  expect_refusal("run qslim model:torus -o out.nrrd", 2, "makes no volume");
  expect_refusal("run qslim model:torus --triangles -3", 2, "is not a number from 0");
  expect_refusal("run qslim model:torus --memory nan", 2, "is not a number from");
  expect_refusal("measure model:torus --error nan", 2, "is not a number from");
  EXPECT_TRUE(files().empty());
}

TEST_F(Program, RefusesBadInputWithCode3) {
  expect_refusal("measure missing.ply", 3, "missing.ply");
  expect_refusal("measure noextension", 3, "names no format");
  std::ofstream(folder_ / "nan.off") << "OFF\n3 1 0\nnan 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
  expect_refusal("run qslim nan.off -o out.ply", 3, "nan.off, line 3");
  std::ofstream(folder_ / "range.obj") << "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n";
  expect_refusal("run qslim range.obj -o out.ply", 3, "range.obj, line 4");
  EXPECT_EQ(files(), (std::vector<std::string>{"nan.off", "range.obj"}));
}

TEST_F(Program, RefusesWhatDoesNotFitWithCode4) {
  expect_refusal("run nooruddin-turk model:torus --memory 0.001 --set resolution=512 -o out.ply", 4, "memory budget");
  expect_refusal("run qslim model:torus -o no/such/folder/out.ply", 4, "out.ply");
  EXPECT_TRUE(files().empty());
}

TEST_F(Program, FailsWithCode5AndLeavesTheOldFile) {
  std::ofstream(folder_ / "sheet.off") << "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
  std::ofstream(folder_ / "out.ply") << "old";
  expect_refusal("run nooruddin-turk sheet.off -o out.ply", 5, "no voxel centre lies inside");
  EXPECT_EQ(read_text(folder_ / "out.ply"), "old");
}

TEST_F(Program, StopsCleanlyOnInterrupt) {
  // The run itself would take minutes.
  const std::string command =
      "cd '" + folder_.string() +
      "' && timeout --preserve-status -s INT 1 '" VOXCARVE_PROGRAM
      "' run nooruddin-turk model:sphereflake --set resolution=600 directions=13 -o out.ply 2>err.txt";
  const int status = std::system(command.c_str());
  const std::string message = read_text(folder_ / "err.txt");
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 130);
  EXPECT_EQ(message, "voxcarve: cancelled\n");
  EXPECT_FALSE(fs::exists(folder_ / "out.ply"));
}

TEST_F(Program, PrintsNothingButJsonOnAPipe) {
  const Outcome outcome = run("run nooruddin-turk model:torus --set resolution=64 -o t.ply --json");
  EXPECT_EQ(outcome.err, "");
  EXPECT_FALSE(json::parse(outcome.out, nullptr, false).is_discarded());
}

TEST_F(Program, HelpNamesEveryCommand) {
  const Outcome outcome = run("--help");
  EXPECT_EQ(outcome.code, 0);
  for (const char* command : {"methods", "models", "run", "measure", "compare", "render"})
    EXPECT_NE(outcome.out.find(command), std::string::npos);
}

}  // namespace
}  // namespace voxcarve
