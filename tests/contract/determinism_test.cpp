// The same bytes on one thread and on two: all methods, ten models, shapes and metrics.
#include <gtest/gtest.h>

#include "common/mesh/io/mesh_io.h"
#include "common/model_source.h"
#include "common/run/errors.h"
#include "experiments/runner/comparison.h"
#include "methods/registry.h"
#include "metrics/metric.h"
#include "tests/support/shapes.h"

namespace voxcarve {
namespace {

/// Ten models: closed, open, nested, overlapping, many parts, thin parts.
const std::vector<std::string> kModels = {"model:chair",
                                          "model:perforated-box",
                                          "model:interpenetrating-figure",
                                          "model:torus?segments=40&tube_segments=20",
                                          "model:genus-n?genus=5",
                                          "model:two-spheres",
                                          "model:sphereflake?depth=1",
                                          "open box",
                                          "nested boxes",
                                          "triangle soup"};

Model model_named(const std::string& name) {
  if (name.starts_with("model:")) {
    std::vector<std::string> notices;
    return open_model(name, {}, notices);
  }
  TriangleSoup soup;
  if (name == "triangle soup") {
    // Triangles in a ball that no surface joins, from a fixed linear congruential sequence.
    std::uint32_t state = 1;
    const auto next = [&] { return static_cast<double>((state = state * 1664525U + 1013904223U) >> 8) / (1 << 24); };
    for (std::uint32_t t = 0; t < 200; ++t) {
      const Point center(next(), next(), next());
      for (int corner = 0; corner < 3; ++corner)
        soup.positions.emplace_back(center + 0.2 * Point(next(), next(), next()));
      soup.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
    }
    return {name, soup};
  }
  soup.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  soup.triangles = {{0, 2, 1}, {0, 3, 2}, {0, 1, 5}, {0, 5, 4}, {1, 2, 6},
                    {1, 6, 5}, {2, 3, 7}, {2, 7, 6}, {3, 0, 4}, {3, 4, 7}};
  if (name == "nested boxes") {
    soup.triangles.push_back({4, 5, 6});
    soup.triangles.push_back({4, 6, 7});
    TriangleSoup inner = test::inside_out(soup);
    for (Point& p : inner.positions) p = 0.25 * p + Point::Constant(0.3);
    append(soup, inner);
  }
  return {name, soup};
}

struct Outcome {
  std::string bytes;  ///< of the result as PLY, or the refusal
  std::vector<std::string> metrics;
  bool operator==(const Outcome&) const = default;
};

/// Metrics are the same code whoever made the shape, and sanitizers make them slow: the published methods' results and
/// those of one baseline, which keeps open and broken inputs as they are, are measured.
bool is_measured(const Method& method) {
  return !method.info().baseline || method.info().name == "qslim";
}

Outcome outcome_of(const Model& model, const TriangleSoup& reference, const Method& method, int threads) {
  RunContext context;
  context.threads = threads;
  context.seed = 7;
  std::vector<std::string> settings;
  if (method.info().parameters.find("resolution") != nullptr)
    settings.emplace_back(kAddressSanitizer ? "resolution=16" : "resolution=40");
  if (method.info().parameters.find("directions") != nullptr) settings.emplace_back("directions=13");
  if (method.info().name == "nooruddin-turk") settings.insert(settings.end(), {"morphology=close", "distance=2"});
  Outcome outcome;
  TriangleSoup surface;
  try {
    const Parameters parameters = parameters_for_budget(method, 500, settings);
    surface = level_for_budget(method.run(model, parameters, context), 500).surface;
    outcome.bytes = serialize_mesh(surface, MeshFormat::kPly);
  } catch (const Error& error) {
    outcome.bytes = error.what();
    return outcome;
  }
  if (!is_measured(method)) return outcome;
  MetricOptions options;
  options.rays = 512;
  options.distance_samples = 500;
  options.view_directions = 6;  // the number of directions is no matter here
  for (const auto& measurements :
       {measure_shape(surface, options, context), measure_pair(reference, surface, options, context)}) {
    for (const Measurement& measurement : measurements)
      outcome.metrics.push_back(measurement.key + "=" + exact_text(measurement.value));
  }
  return outcome;
}

class Determinism : public testing::TestWithParam<std::string> {};

TEST_P(Determinism, OneThreadAndTwoGiveTheSameBytes) {
  const Model model = model_named(GetParam());
  RunContext context;
  const TriangleSoup reference = reference_surface(model, context);
  for (const Method* method : all_methods()) {
    const Outcome one = outcome_of(model, reference, *method, 1);
    const Outcome two = outcome_of(model, reference, *method, 2);
    EXPECT_EQ(one.bytes, two.bytes) << method->info().name;
    EXPECT_EQ(one.metrics, two.metrics) << method->info().name;
    EXPECT_FALSE(one.bytes.empty());
  }
}

INSTANTIATE_TEST_SUITE_P(TenModels, Determinism, testing::ValuesIn(kModels),
                         [](const testing::TestParamInfo<std::string>& parameter) {
                           std::string name = parameter.param.substr(0, parameter.param.find('?'));
                           std::ranges::replace_if(
                               name, [](char c) { return std::isalnum(static_cast<unsigned char>(c)) == 0; }, '_');
                           return name;
                         });

}  // namespace
}  // namespace voxcarve
