// Carving streams from the command line: written by `run`, read by `extract`.
#include "tests/cli/program.h"

namespace voxcarve::test {
namespace {

using Json = nlohmann::json;

/// Eight balls of 42 vertices and 80 triangles each.
const std::string kRun = "run hagbi-elsana 'model:geospheres?subdivision=1' ";

class CarvingProgram : public Program {
 protected:
  void SetUp() override {
    Program::SetUp();
    ASSERT_EQ(run(kRun + "-o balls.vcs").code, 0);
  }
  Json extract(const std::string& arguments) const { return run_json("extract balls.vcs " + arguments); }
  /// The bytes of the level that these arguments give.
  std::string extracted(const std::string& arguments) const {
    const Outcome outcome = run("extract balls.vcs " + arguments + " -o extracted.ply");
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return read_text(folder_ / "extracted.ply");
  }
};

TEST_F(CarvingProgram, SaysWhatAStreamHolds) {
  const Json report = extract("");
  EXPECT_EQ(report["stream"], "balls.vcs");
  EXPECT_EQ(report["model"]["vertices"], 8 * 42);
  EXPECT_EQ(report["model"]["triangles"], 8 * 80);
  // Without a choice, the finest level: the model.
  EXPECT_EQ(report["step"], report["steps"]);
  EXPECT_EQ(report["vertices"], 8 * 42);
  EXPECT_EQ(report["triangles"], 8 * 80);
  EXPECT_EQ(report["components"], 8);
  EXPECT_EQ(report["closed_components"], 8);
  EXPECT_EQ(report["genus"], 0);
  EXPECT_FALSE(report.contains("output"));
  // The same object as the run's, of names and typed values.
  EXPECT_EQ(report["parameters"], run_json(kRun)["parameters"]);
  EXPECT_EQ(report["parameters"]["priority"], "longest-edge");
  EXPECT_EQ(report["parameters"]["exposed"], true);
  EXPECT_EQ(report["parameters"]["tetgen_seconds"], 600);
  EXPECT_EQ(report["notices"], Json::array());
  // The hull: a closed surface of genus 0, F = 2 V - 4.
  const Json hull = extract("--step 0");
  EXPECT_EQ(hull["step"], 0);
  EXPECT_EQ(hull["vertices"], hull["hull"]["vertices"]);
  EXPECT_EQ(hull["triangles"].get<int>(), 2 * hull["vertices"].get<int>() - 4);
  EXPECT_EQ(hull["components"], 1);
  // Every number of vertices between the two has a level, and the hull is one.
  EXPECT_EQ(report["levels"].get<int>(), 8 * 42 - hull["vertices"].get<int>() + 1);
  const Outcome text = run("extract balls.vcs --step 0");
  EXPECT_EQ(text.code, 0);
  EXPECT_TRUE(text.out.starts_with("step 0 of ")) << text.out;
  EXPECT_EQ(files(), std::vector<std::string>{"balls.vcs"});
}

TEST_F(CarvingProgram, GivesWhatARunGives) {
  for (const std::string budget : {"--vertices 200", "--triangles 301", "--level 7", "--level 0", ""}) {
    ASSERT_EQ(run(kRun + budget + " -o fresh.ply").code, 0);
    EXPECT_EQ(extracted(budget), read_text(folder_ / "fresh.ply")) << budget;
  }
  // Bytes do not depend on the number of threads.
  ASSERT_EQ(run(kRun + "-o two.vcs --threads 2").code, 0);
  EXPECT_EQ(read_text(folder_ / "two.vcs"), read_text(folder_ / "balls.vcs"));
  EXPECT_EQ(extracted("--vertices 200 --threads 2"), extracted("--vertices 200"));
}

TEST_F(CarvingProgram, FindsTheFinestLevelWithinBounds) {
  for (int vertices = extract("--step 0")["vertices"]; vertices <= 8 * 42; vertices += 37) {
    EXPECT_EQ(extract("--vertices " + std::to_string(vertices))["vertices"], vertices);
  }
  const Json by_triangles = extract("--triangles 300");
  EXPECT_LE(by_triangles["triangles"], 300);
  const Json one = extract("--components 1");
  EXPECT_EQ(one["closed_components"], 1);
  const Json simple = extract("--genus 0 --components 1");
  EXPECT_EQ(simple["closed_components"], 1);
  EXPECT_EQ(simple["genus"], 0);
  EXPECT_LE(simple["step"], one["step"]);
  const Json small = extract("--genus 0 --components 3 --vertices 150 --triangles 280");
  EXPECT_LE(small["vertices"], 150);
  EXPECT_LE(small["triangles"], 280);
  EXPECT_EQ(small["genus"], 0);
  // What was chosen is the finest: no level after it fits, by the program's own word.
  const int levels = extract("")["levels"];
  const int chosen = one["step"];
  for (int level = levels - 1; level >= 0; level -= 4) {
    const Json other = extract("--level " + std::to_string(level));
    if (other["step"] <= chosen) break;
    EXPECT_GT(other["closed_components"], 1) << level;
  }
}

TEST_F(CarvingProgram, TakesStepsLevelsAndDistances) {
  const Json level = extract("--level 3");
  EXPECT_EQ(extracted("--step " + std::to_string(level["step"].get<int>())), extracted("--level 3"));
  // Nearer takes no fewer steps; no point of the hull is a whole diagonal away.
  const int near = extract("--distance 0.05")["step"];
  const int far = extract("--distance 0.15")["step"];
  EXPECT_GE(near, far);
  EXPECT_EQ(extract("--distance 1")["step"], 0);
  const Json all = extract("--distance 0 -o model.obj");
  EXPECT_EQ(all["vertices"], 8 * 42);
  EXPECT_EQ(all["output"], "model.obj");
  const Json measured = run_json("measure model.obj")["a"];
  EXPECT_EQ(measured["closed"], true);
  EXPECT_EQ(measured["components"], 8);
}

TEST_F(CarvingProgram, RefusesWhatItCannotGive) {
  expect_refusal("extract balls.vcs --step 1000000", 2, "there is no step 1000000");
  expect_refusal("extract balls.vcs --level 1000000", 2, "there is no level 1000000");
  expect_refusal("extract balls.vcs --step -1", 2, "--step");
  expect_refusal("extract balls.vcs --vertices 0", 2, "--vertices");
  expect_refusal("extract balls.vcs --genus -1", 2, "--genus");
  expect_refusal("extract balls.vcs --distance nan", 2, "--distance");
  for (const std::string bound : {"--vertices 9", "--triangles 9", "--genus 0", "--components 1"}) {
    for (const std::string choice : {"--step 1", "--level 1", "--distance 0.1"}) {
      expect_refusal("extract balls.vcs " + bound + " " + choice, 2, "excludes");
    }
  }
  expect_refusal("extract balls.vcs --step 1 --level 1", 2, "excludes");
  expect_refusal("extract balls.vcs --step 1 --distance 0.1", 2, "excludes");
  expect_refusal("extract balls.vcs --level 1 --distance 0.1", 2, "excludes");
  expect_refusal("extract balls.vcs -o x.nrrd", 2, "no mesh format");
  expect_refusal("extract balls.vcs -o x.vcs", 2, "no mesh format");
  expect_refusal("extract balls.vcs -o missing/x.ply", 4, "missing/x.ply");
  expect_refusal("extract", 2, "STREAM");
  EXPECT_EQ(files(), std::vector<std::string>{"balls.vcs"});
}

TEST_F(CarvingProgram, GivesTheHullWithANoticeWhereABudgetIsBelowItAsARunDoes) {
  const Json hull = extract("--step 0");
  const int vertices = hull["vertices"];
  EXPECT_EQ(extract("--vertices " + std::to_string(vertices))["notices"], Json::array());
  for (const std::string budget : {"--vertices 20", "--triangles 20"}) {
    const Json report = extract(budget);
    EXPECT_EQ(report["step"], 0);
    ASSERT_EQ(report["notices"].size(), 1U);
    EXPECT_EQ(report["notices"].back(), run_json(kRun + budget)["notices"].back());
  }
  EXPECT_EQ(extract("--vertices 20")["notices"][0], "even the coarsest level has " + std::to_string(vertices) +
                                                        " distinct vertices, more than the 20 asked for");
  const Outcome text = run("extract balls.vcs --vertices 20");
  EXPECT_EQ(text.code, 0);
  EXPECT_TRUE(text.err.starts_with("note: even the coarsest level")) << text.err;
}

TEST_F(CarvingProgram, GivesTheGenusThatIsAskedFor) {
  // From the hull, of genus 0, to a ring of genus 1. The hull always has the least genus there is, so a bound of the
  // genus cannot be met only together with one of the counts: no closed surface has three vertices.
  ASSERT_EQ(run("run hagbi-elsana 'model:genus-n?genus=1&subdivision=1' -o ring.vcs").code, 0);
  EXPECT_EQ(run_json("extract ring.vcs")["genus"], 1);
  EXPECT_EQ(run_json("extract ring.vcs --genus 0")["genus"], 0);
  const Json hull = run_json("extract ring.vcs --genus 0 --vertices 3");
  EXPECT_EQ(hull["step"], 0);
  EXPECT_EQ(hull["genus"], 0);
  EXPECT_EQ(hull["notices"].size(), 1U);
}

TEST_F(CarvingProgram, RefusesFilesThatAreNoStreams) {
  expect_refusal("extract none.vcs", 3, "none.vcs");
  expect_refusal("extract .", 3, ".");
  const std::string bytes = read_text(folder_ / "balls.vcs");
  const auto write = [&](const std::string& content) {
    std::ofstream(folder_ / "altered.vcs", std::ios::binary) << content;
  };
  std::string altered = bytes;
  altered[altered.size() / 2] = static_cast<char>(altered[altered.size() / 2] ^ 4);
  write(altered);
  expect_refusal("extract altered.vcs", 3, "altered.vcs: was altered");
  write(bytes.substr(0, bytes.size() - 1));
  expect_refusal("extract altered.vcs", 3, "altered.vcs: holds");
  write("ply\n");
  expect_refusal("extract altered.vcs --vertices 10 -o x.ply", 3, "altered.vcs: is no carving stream");
  write("");
  expect_refusal("extract altered.vcs", 3, "altered.vcs: is no carving stream");
  EXPECT_FALSE(std::filesystem::exists(folder_ / "x.ply"));
}

TEST_F(CarvingProgram, OnlyCarvingMakesStreams) {
  expect_refusal("run mason model:cells -o x.vcs", 2, "mason makes no carving stream");
  expect_refusal("run nooruddin-turk model:torus -o x.vcs", 2, "hagbi-elsana does");
  expect_refusal(kRun + "-o missing/x.vcs", 4, "missing");
  EXPECT_EQ(files(), std::vector<std::string>{"balls.vcs"});
}

TEST_F(CarvingProgram, HoldsItsInvariants) {
  const Json report = run_json(kRun + "--set initial=box breadth=0.02 exposed=off --check-invariants -o box.vcs");
  EXPECT_GE(report["invariants"].size(), 7U);  // six of its own, and that every level is a closed manifold
  for (const Json& check : report["invariants"]) EXPECT_EQ(check["holds"], true) << check;
  // The box's corners, and where each ball touches three of its sides.
  EXPECT_EQ(run_json("extract box.vcs --step 0")["vertices"], 8 + 8 * 3);
  expect_refusal(kRun + "--set breadth=0.1 breadth_model=0.1", 2, "breadth");
}

TEST_F(CarvingProgram, TimesTheAttemptsThatFailed) {
  // Two tetrahedra whose tips are 1e-11 apart: TetGen takes them for one point until it is told to look closer.
  std::ofstream(folder_ / "tips.off") << "OFF\n8 8 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n-1e-11 0 0\n-1 0 0\n0 -1 0\n"
                                         "0 0 -1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n3 4 5 6\n3 4 7 5\n3 5 7 6\n"
                                         "3 4 6 7\n";
  const Json report = run_json("run hagbi-elsana tips.off --report r.json");
  std::vector<std::string> stages;
  for (const Json& timing : report["timings"]) stages.push_back(timing["stage"]);
  const auto failed = std::ranges::find(stages, "tetrahedralization (failed)");
  ASSERT_NE(failed, stages.end());
  ASSERT_NE(failed + 1, stages.end());
  EXPECT_EQ(*(failed + 1), "tetrahedralization");
  EXPECT_EQ(Json::parse(read_text(folder_ / "r.json"))["timings"], report["timings"]);
  const Outcome text = run("run hagbi-elsana tips.off -v");
  EXPECT_NE(text.err.find("tetrahedralization (failed)  "), std::string::npos) << text.err;
}

TEST_F(CarvingProgram, VoidsThatAreLeftShutBoundTheDistance) {
  std::ofstream(folder_ / "shell.off")  // a tetrahedron of edge about 4.6, and in it a void, turned inside out
      << "OFF\n8 8 0\n0 0 0\n4 0 0\n0 4 0\n0 0 4\n.5 .5 .5\n1.5 .5 .5\n.5 1.5 .5\n.5 .5 1.5\n"
         "3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n3 4 5 6\n3 4 7 5\n3 5 7 6\n3 4 6 7\n";
  ASSERT_EQ(run("run hagbi-elsana shell.off --set smallest_void=1 -o shut.vcs").code, 0);
  EXPECT_EQ(run_json("extract shut.vcs")["components"], 1);
  expect_refusal("extract shut.vcs --distance 0.001", 5, "voids that were left shut");
  ASSERT_EQ(run("run hagbi-elsana shell.off -o open.vcs").code, 0);
  EXPECT_EQ(run_json("extract open.vcs")["components"], 2);
  EXPECT_EQ(run_json("extract open.vcs --distance 0")["components"], 2);
}

}  // namespace
}  // namespace voxcarve::test
