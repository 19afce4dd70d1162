// Names of models as users type them, and the catalogue of external ones.
#include <gmock/gmock-matchers.h>
#include <gtest/gtest.h>

#include "tests/unit/model_checks.h"

namespace voxcarve {
namespace {

using namespace test;

TEST(Specs, ParseNamesAndParameters) {
  EXPECT_EQ(make_procedural("torus"), make_procedural("torus?major=1&minor=0.4"));
  EXPECT_EQ(make_procedural("torus?"), make_procedural("torus"));
  EXPECT_EQ(make_procedural("genus-n?genus=2&subdivision=1").triangles.size(), 100U);  // 2 * (18 * 2 + 14)
}

TEST(Specs, UnknownNamesAreRefusedWithTheNearest) {
  EXPECT_THAT(parameter_error("tors"), HasSubstr("'tors'; did you mean 'torus'?"));
  EXPECT_THAT(parameter_error("turbin_blade"), HasSubstr("did you mean 'turbine_blade'?"));  // an external one
  EXPECT_THAT(parameter_error("motor?x=1"), HasSubstr("'motor' is an external model"));
  EXPECT_THAT(parameter_error("xyzzyxyzzy"), testing::EndsWith("no model is called 'xyzzyxyzzy'"));
  EXPECT_THAT(parameter_error(""), HasSubstr("no model is called ''"));
  EXPECT_THAT(parameter_error("torus?majr=2"), HasSubstr("torus has no parameter 'majr'; did you mean 'major'?"));
}

TEST(Specs, BadValuesAreRefused) {
  EXPECT_THAT(parameter_error("torus?major"), HasSubstr("not of the form name=value"));
  EXPECT_THAT(parameter_error("torus?major=2&&minor=1"), HasSubstr("not of the form name=value"));
  EXPECT_THAT(parameter_error("torus?major=big"), HasSubstr("must be a real number"));
  EXPECT_THAT(parameter_error("torus?major=nan"), HasSubstr("must be a real number"));
  EXPECT_THAT(parameter_error("torus?segments=2"), HasSubstr("at least 3"));
  EXPECT_THAT(parameter_error("torus?major=1&minor=1"), HasSubstr("minor must be less than major"));
  EXPECT_THAT(parameter_error("genus-n?genus=-1"), HasSubstr("at least 0"));
  EXPECT_THAT(parameter_error("perforated-box?hole_width=0.9"), HasSubstr("at most 0.8"));
  EXPECT_THAT(parameter_error("chair?back_slats=40"), HasSubstr("slats narrower than"));
}

TEST(Specs, AbsurdSizesAreRefusedBeforeAnythingIsBuilt) {
  for (const char* spec :
       {"torus?segments=100000&tube_segments=100000", "genus-n?genus=500000&subdivision=1000",
        "perforated-box?holes=2000&sides=10000", "two-spheres?subdivision=9", "sphereflake?depth=6&subdivision=8",
        "interpenetrating-figure?slices=10000&stacks=10000", "chair?slat_segments=10000&corner_segments=1000"}) {
    const std::string message = parameter_error(spec);
    EXPECT_TRUE(message.find("limit of 20 million") != std::string::npos ||
                message.find("at most 8") != std::string::npos)
        << spec << ": " << message;
  }
}

TEST(Specs, RefusalsOfSizeStateTheCount) {
  // One more belt than 20 million allow: 2 * 5000 * 2001.
  EXPECT_THAT(parameter_error("torus?segments=5000&tube_segments=2001"),
              HasSubstr("20010000 triangles, more than the limit of 20 million"));
  // A cuboid of 14 squares: 28 * 846^2.
  EXPECT_THAT(parameter_error("genus-n?genus=0&subdivision=846"), HasSubstr("20040048 triangles"));
}

// --- catalogue ---------------------------------------------------------------------------------------------------

TEST(Catalogue, EntriesAreCompleteAndUnique) {
  std::set<std::string> names;
  for (const ExternalModel& model : external_models()) {
    SCOPED_TRACE(model.name);
    EXPECT_TRUE(names.insert(model.name).second);
    EXPECT_FALSE(model.file.empty());
    EXPECT_FALSE(model.stands_for.empty());
    EXPECT_TRUE(model.source.starts_with("github.com/"));
    EXPECT_FALSE(model.licence.empty());
    EXPECT_EQ(model.sha256.size(), 64U);
    EXPECT_EQ(model.sha256.find_first_not_of("0123456789abcdef"), std::string::npos);
    EXPECT_EQ(model.file.ends_with(".nrrd"), model.kind == ExternalKind::kVolume);
    EXPECT_EQ(to_string(model.kind), model.kind == ExternalKind::kVolume ? "volume" : "mesh");
    // A name means one model.
    EXPECT_EQ(std::ranges::count(model_names(), model.name), 0);
  }
  EXPECT_TRUE(names.contains("motor"));
}

TEST(Catalogue, FindsFilesAndSaysWhereToGetThem) {
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "voxcarve_catalogue_test";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  const auto message = [&](const std::filesystem::path& where) -> std::string {
    try {
      find_external("motor", where);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no InputError";
  };
  EXPECT_THAT(message(""), testing::AllOf(HasSubstr("VOXCARVE_DATA"), HasSubstr("motor.obj"), HasSubstr("vtk-data")));
  EXPECT_THAT(message(folder / "nowhere"), testing::AllOf(HasSubstr("is not a folder"), HasSubstr("vtk-data")));
  EXPECT_THAT(message(folder), testing::AllOf(HasSubstr("there is no"), HasSubstr("motor.obj"), HasSubstr("vtk-data")));
  std::ofstream(folder / "motor.obj") << "v 0 0 0\n";
  EXPECT_EQ(find_external("motor", folder), folder / "motor.obj");
  EXPECT_THROW(find_external("moter", folder), ParameterError);
  std::filesystem::remove_all(folder);
}

TEST(Catalogue, AgreesWithTheDataFolder) {
  const char* data = std::getenv("VOXCARVE_DATA");
  if (data == nullptr) GTEST_SKIP() << "VOXCARVE_DATA is unset: no data folder to compare the catalogue with";
  std::ifstream manifest(std::filesystem::path(data) / "MANIFEST.csv");
  if (!manifest) GTEST_SKIP() << data << " has no MANIFEST.csv";
  std::stringstream text;
  text << manifest.rdbuf();
  std::map<std::string, std::string> row_of_file;
  for (std::string line; std::getline(text, line);) {
    const std::size_t first = line.find(',');
    row_of_file[line.substr(first + 1, line.find(',', first + 1) - first - 1)] = line;
  }
  for (const ExternalModel& model : external_models()) {
    EXPECT_NO_THROW(find_external(model.name, data)) << model.name;
    ASSERT_TRUE(row_of_file.contains(model.file)) << model.file;
    EXPECT_THAT(row_of_file[model.file], HasSubstr("," + model.sha256 + ","));
    EXPECT_TRUE(row_of_file[model.file].starts_with(model.name + ",")) << model.name;
  }
}

}  // namespace
}  // namespace voxcarve
