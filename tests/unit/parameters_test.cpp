#include "common/run/parameters.h"

#include <gtest/gtest.h>

#include "common/run/errors.h"
#include "common/run/text.h"

namespace voxcarve {
namespace {

ParameterSchema example_schema() {
  ParameterSchema schema;
  schema.specs = {ParameterSpec::toggle("exposed", true, "a switch"),
                  ParameterSpec::integer("resolution", "voxels", 2, 64, 16, "an integer"),
                  ParameterSpec::real("distance", "voxels", 0, 10, 2.5, "a real"),
                  ParameterSpec::choice("kernel", {"box", "gaussian"}, "box", "a choice")};
  return schema;
}

Parameters parse(std::vector<std::string> assignments) {
  return Parameters::parse(example_schema(), assignments, "example");
}

std::string refusal(std::vector<std::string> assignments) {
  try {
    parse(std::move(assignments));
  } catch (const ParameterError& error) {
    return error.what();
  }
  return "";
}

TEST(Parameters, TakesDefaultsForWhatIsNotSet) {
  const Parameters parameters = parse({});
  EXPECT_TRUE(parameters.toggle("exposed"));
  EXPECT_EQ(parameters.integer("resolution"), 16);
  EXPECT_EQ(parameters.real("distance"), 2.5);
  EXPECT_EQ(parameters.choice("kernel"), "box");
}

TEST(Parameters, ReadsEveryTypeAndLetsTheLaterAssignmentWin) {
  const Parameters parameters =
      parse({"exposed=off", "resolution=8", "distance=1e-3", "kernel=gaussian", "resolution=9"});
  EXPECT_FALSE(parameters.toggle("exposed"));
  EXPECT_EQ(parameters.integer("resolution"), 9);
  EXPECT_EQ(parameters.real("distance"), 1e-3);
  EXPECT_EQ(parameters.choice("kernel"), "gaussian");
}

TEST(Parameters, CanonicalTextIsSortedAndComplete) {
  EXPECT_EQ(parse({"distance=0.1"}).canonical(), "distance=0.1 exposed=on kernel=box resolution=16");
  EXPECT_EQ(parse({"kernel=box", "distance=0.10"}).canonical(), parse({"distance=1e-1"}).canonical());
}

TEST(Parameters, SuggestsTheNearestNameForAnUnknownOne) {
  EXPECT_EQ(refusal({"resolutoin=8"}), "example has no parameter 'resolutoin'; did you mean 'resolution'?");
  EXPECT_EQ(refusal({"zebra=8"}), "example has no parameter 'zebra'");
}

TEST(Parameters, RefusesWhatDoesNotFitAndSaysWhatWould) {
  EXPECT_EQ(refusal({"resolution=1"}),
            "example: resolution=1 must be an integer of at least 2 and at most 64 (voxels)");
  EXPECT_EQ(refusal({"resolution=8.5"}),
            "example: resolution=8.5 must be an integer of at least 2 and at most 64 (voxels)");
  EXPECT_EQ(refusal({"distance=nan"}),
            "example: distance=nan must be a real number of at least 0 and at most 10 (voxels)");
  EXPECT_EQ(refusal({"kernel=hat"}), "example: kernel=hat must be one of box, gaussian");
  EXPECT_EQ(refusal({"exposed=maybe"}), "example: exposed=maybe must be on or off");
  EXPECT_EQ(refusal({"exposed"}), "'exposed' is not of the form name=value");
}

TEST(Parameters, ChecksCombinations) {
  ParameterSchema schema = example_schema();
  schema.check = [](const Parameters& p) {
    if (p.real("distance") > static_cast<double>(p.integer("resolution")))
      throw ParameterError("distance exceeds resolution");
  };
  EXPECT_THROW(Parameters::parse(schema, std::vector<std::string>{"resolution=2", "distance=3"}, "example"),
               ParameterError);
  EXPECT_NO_THROW(Parameters::parse(schema, std::vector<std::string>{"resolution=3", "distance=3"}, "example"));
}

TEST(Text, FormatsBytesAndReals) {
  EXPECT_EQ(format_bytes(7), "7 B");
  EXPECT_EQ(format_bytes(1536), "1.5 KiB");
  EXPECT_EQ(format_bytes(std::uint64_t{3} << 30), "3.0 GiB");
  EXPECT_EQ(format_real(0.1), "0.1");
  EXPECT_EQ(format_real(1e-12), "1e-12");
}

TEST(Text, SplitsAndJoins) {
  EXPECT_EQ(split("a,b,,c", ','), (std::vector<std::string>{"a", "b", "", "c"}));
  EXPECT_TRUE(split("", ',').empty());
  EXPECT_EQ(join(std::vector<std::string>{"a", "b"}), "a, b");
}

TEST(Parameters, ReadsListsOfReals) {
  ParameterSchema schema;
  schema.specs = {ParameterSpec::reals("radius", "voxels", 0, 10, {1, 2.5}, "radii")};
  const auto parsed = [&](const std::string& text) {
    return Parameters::parse(schema, std::vector<std::string>{"radius=" + text}, "owner");
  };
  EXPECT_EQ(Parameters::defaults(schema).reals("radius"), (std::vector<double>{1, 2.5}));
  EXPECT_EQ(parsed("3").reals("radius"), std::vector<double>{3});
  EXPECT_EQ(parsed("10,0,0.5").reals("radius"), (std::vector<double>{10, 0, 0.5}));
  EXPECT_EQ(parsed("10,0,0.5").canonical(), "radius=10,0,0.5");
  for (const char* wrong : {"", ",", "1,", ",1", "1,,2", "1,11", "-1", "nan", "1;2", "1, 2"})
    EXPECT_THROW(parsed(wrong), ParameterError) << wrong;
}

}  // namespace
}  // namespace voxcarve
