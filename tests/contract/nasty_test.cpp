// Nasty shapes through every method and metric: a result or one typed error, never anything else.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "common/mesh/io/mesh_io.h"
#include "common/mesh/models/primitives.h"
#include "common/model_source.h"
#include "common/run/errors.h"
#include "experiments/runner/comparison.h"
#include "methods/registry.h"
#include "tests/support/shapes.h"

namespace voxcarve {
namespace {

using test::inside_out;
using test::joined;

Parameters quick_parameters(const Method& method) {
  std::vector<std::string> settings;
  if (method.info().parameters.find("resolution") != nullptr)
    settings.emplace_back(kAddressSanitizer ? "resolution=12" : "resolution=24");
  if (method.info().parameters.find("directions") != nullptr) settings.emplace_back("directions=13");
  if (method.info().parameters.find("alpha") != nullptr) settings.emplace_back("alpha=0.1");
  return parameters_for_budget(method, 200, settings);
}

/// Runs and measures; everything but a typed error ends the test.
void survive(const Model& model) {
  MetricOptions options;
  options.rays = 256;
  options.distance_samples = 100;
  options.hausdorff_error = 1e-2;
  for (const Method* method : all_methods()) {
    RunContext context;
    TriangleSoup surface;
    try {
      surface = level_for_budget(method->run(model, quick_parameters(*method), context), 200).surface;
    } catch (const Error& error) {
      const std::string message = error.what();
      EXPECT_FALSE(message.empty());
      EXPECT_EQ(message.find('\n'), std::string::npos) << message;
      const int code = static_cast<int>(error.exit_code());
      EXPECT_TRUE(code >= 3 && code <= 5) << code << " " << message;
      continue;
    }
    EXPECT_NO_THROW(validate(surface, model.name)) << method->info().name;
    for (const auto& measurements :
         {measure_shape(surface, options, context), measure_pair(*model.soup(), surface, options, context)}) {
      for (const Measurement& measurement : measurements) {
        if (const auto* real = std::get_if<double>(&measurement.value)) {
          EXPECT_TRUE(std::isfinite(*real)) << model.name << ", " << method->info().name << ": " << measurement.key;
        }
        if (const auto* undefined = std::get_if<Undefined>(&measurement.value)) {
          EXPECT_FALSE(undefined->reason.empty()) << measurement.key;
        }
      }
    }
  }
}

TEST(Nasty, HandMadeShapes) {
  const TriangleSoup cube = box(Point::Zero(), Point::Ones());
  TriangleSoup one_triangle;
  one_triangle.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  one_triangle.triangles = {{0, 1, 2}};
  TriangleSoup line = one_triangle;
  line.positions[2] = Point(2, 0, 0);
  TriangleSoup repeated = one_triangle;
  repeated.triangles = {{0, 0, 1}, {0, 1, 2}, {0, 1, 2}, {2, 1, 0}};
  TriangleSoup flat = box(Point::Zero(), Point(1, 1, 0));
  TriangleSoup needle = box(Point::Zero(), Point(1, 1e-9, 1e-9));
  const auto scaled = [&](double factor) {
    return transformed(cube, Eigen::Affine3d(Eigen::UniformScaling<double>(factor)));
  };
  const auto moved = [&](double offset) {
    return transformed(cube, Eigen::Affine3d(Eigen::Translation3d(offset, offset, offset)));
  };
  const std::vector<std::pair<std::string, TriangleSoup>> shapes = {
      {"one triangle", one_triangle},
      {"a line", line},
      {"repeated triangles", repeated},
      {"flat box", flat},
      {"needle", needle},
      {"inside out", inside_out(cube)},
      {"doubled", joined({cube, cube})},
      {"inside out and not", joined({cube, inside_out(cube)})},
      {"touching edge", joined({cube, transformed(cube, Eigen::Affine3d(Eigen::Translation3d(1, 1, 0)))})},
      {"1e-12", scaled(1e-12)},
      {"1e12", scaled(1e12)},
      {"1e-300", scaled(1e-300)},
      {"1e300", scaled(1e300)},
      {"at 1e12", moved(1e12)},
      {"at 1e17", moved(1e17)}};
  for (const auto& [name, soup] : shapes) {
    SCOPED_TRACE(name);
    survive({name, soup});
  }
}

TEST(Nasty, EveryNastyFileOfTheExternalModels) {
  VOXCARVE_REQUIRE_DATA(folder, "nasty");
  int opened = 0;
  int refused = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    SCOPED_TRACE(entry.path().filename().string());
    try {
      std::vector<std::string> notices;
      const Model model = open_model(entry.path().string(), {}, notices);
      ++opened;
      survive(model);
    } catch (const Error& error) {
      ++refused;
      EXPECT_EQ(error.exit_code(), ExitCode::kBadInput) << error.what();
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    }
  }
  EXPECT_GE(opened, 10);
  EXPECT_GE(refused, 4);  // empty.off, empty_0byte.stl, inf_nan.obj, bad_index.obj at least
}

}  // namespace
}  // namespace voxcarve
