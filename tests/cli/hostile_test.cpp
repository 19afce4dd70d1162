// Hostile files through every method of the program: an output, or one clear line and exit code 3, 4 or 5.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "methods/registry.h"
#include "tests/cli/program.h"
#include "tests/support/shapes.h"

namespace voxcarve {
namespace {

using test::Outcome;
using test::Program;
using test::read_text;
namespace fs = std::filesystem;

class Hostile : public Program {
 protected:
  /// Runs every method on `input`; the exit codes seen.
  std::vector<int> run_every_method(const std::string& input) const {
    std::vector<int> codes;
    for (const Method* method : all_methods()) {
      const std::string& name = method->info().name;
      std::string settings;
      if (method->info().parameters.find("resolution") != nullptr) settings = " --set resolution=24 directions=13";
      if (method->info().parameters.find("alpha") != nullptr) settings = " --set alpha=0.1";
      const Outcome outcome = run("run " + name + " '" + input + "' -o out.ply --triangles 200" + settings);
      codes.push_back(outcome.code);
      const bool done = outcome.code == 0;
      EXPECT_TRUE(done || (outcome.code >= 3 && outcome.code <= 5))
          << name << " " << input << ": " << outcome.code << "\n"
          << outcome.err;
      EXPECT_EQ(fs::exists(folder_ / "out.ply"), done) << name << " " << input;
      if (!done) {
        EXPECT_TRUE(outcome.err.starts_with("voxcarve: ")) << outcome.err;
        EXPECT_EQ(std::ranges::count(outcome.err, '\n'), 1) << outcome.err;
      }
      fs::remove(folder_ / "out.ply");
    }
    return codes;
  }

  void write(const std::string& name, const std::string& bytes) const {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
  }

  void expect_refused(const std::string& name, const std::string& bytes) const {
    write(name, bytes);
    for (const int code : run_every_method(name)) EXPECT_EQ(code, 3) << name;
    fs::remove(folder_ / name);
  }
};

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

/// A tetrahedron in every text format of meshes.
const std::string kPly =
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double y\nproperty double z\nelement face 4\n"
    "property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 "
    "2\n";
const std::string kOff = "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n";
const std::string kObj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
const std::string kStl =
    "solid s\nfacet normal 0 0 -1\nouter loop\nvertex 0 0 0\nvertex 0 1 0\nvertex 1 0 0\nendloop\nendfacet\nendsolid "
    "s\n";

TEST_F(Hostile, EmptyFilesOfEveryFormat) {
  for (const char* name : {"e.ply", "e.obj", "e.off", "e.stl", "e.nrrd", "e.mhd", "e.mha", "e.png", "e.pbm", "e.pgm"})
    expect_refused(name, "");
}

TEST_F(Hostile, TruncatedFilesOfEveryFormat) {
  expect_refused("t.ply", kPly.substr(0, kPly.size() - 12));
  expect_refused("t.off", kOff.substr(0, kOff.size() - 12));
  expect_refused("t.obj", kObj.substr(0, kObj.size() - 35));  // the vertices alone
  expect_refused("t.stl", kStl.substr(0, kStl.size() - 40));
  ASSERT_EQ(run("models torus -o whole.ply").code, 0);
  ASSERT_EQ(run("models torus -o whole.stl").code, 0);
  ASSERT_EQ(run("run nooruddin-turk model:torus --set resolution=20 -o whole.nrrd").code, 0);
  ASSERT_EQ(run("run nooruddin-turk model:torus --set resolution=20 -o whole.mha").code, 0);
  for (const char* extension : {"ply", "stl", "nrrd", "mha"}) {
    const std::string bytes = read_text(folder_ / (std::string("whole.") + extension));
    for (const std::size_t share : {1U, 5U, 9U})
      expect_refused(std::string("t.") + extension, bytes.substr(0, bytes.size() * share / 10));
  }
  expect_refused("t.pbm", "P1\n4 4\n0 1 0 1\n");
  expect_refused("t.png", "\x89PNG\r\n\x1a\n");
}

TEST_F(Hostile, CoordinatesThatAreNotFinite) {
  for (const char* value : {"nan", "-inf", "1e999"}) {
    expect_refused("n.ply", replaced(kPly, "1 0 0", std::string(value) + " 0 0"));
    expect_refused("n.off", replaced(kOff, "1 0 0", std::string(value) + " 0 0"));
    expect_refused("n.obj", replaced(kObj, "1 0 0", std::string(value) + " 0 0"));
    expect_refused("n.stl", replaced(kStl, "vertex 1 0 0", std::string("vertex ") + value + " 0 0"));
  }
}

TEST_F(Hostile, AbsurdCounts) {
  for (const char* count : {"4000000000", "99999999999999999999", "-1"}) {
    expect_refused("c.ply", replaced(kPly, "vertex 4", std::string("vertex ") + count));
    expect_refused("c.ply", replaced(kPly, "face 4", std::string("face ") + count));
    expect_refused("c.off", replaced(kOff, "4 4 0", std::string(count) + " 4 0"));
    expect_refused("c.off", replaced(kOff, "4 4 0", std::string("4 ") + count + " 0"));
    expect_refused("c.nrrd",
                   std::string("NRRD0004\ntype: uint8\ndimension: 3\nsizes: ") + count + " 9 9\nencoding: raw\n\nabc");
    expect_refused("c.pbm", std::string("P1\n") + count + " 4\n0 1\n");
  }
  expect_refused("c.obj", replaced(kObj, "f 1 3 2", "f 1 3 4000000000"));
  std::string stl(84, '\0');
  stl[80] = stl[81] = stl[82] = stl[83] = '\xff';  // 4294967295 triangles
  expect_refused("c.stl", stl);
}

TEST_F(Hostile, TheWholeFilesAreFine) {
  // What the variants above were made from is accepted, so it is the change that is refused.
  write("w.ply", kPly);
  write("w.off", kOff);
  write("w.obj", kObj);
  for (const char* name : {"w.ply", "w.off", "w.obj"}) {
    for (const int code : run_every_method(name)) EXPECT_EQ(code, 0) << name;
  }
  write("w.stl", kStl);  // one triangle: some methods need a solid
  EXPECT_EQ(run("measure w.stl").code, 0);
}

TEST_F(Hostile, EveryNastyFileOfTheExternalModels) {
  VOXCARVE_REQUIRE_DATA(folder, "nasty");
  int files = 0;
  for (const auto& entry : fs::directory_iterator(folder)) {
    run_every_method(entry.path().string());
    ++files;
  }
  EXPECT_GE(files, 10);
}

}  // namespace
}  // namespace voxcarve
