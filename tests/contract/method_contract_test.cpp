// What every registered method keeps to. A new method is tested here without a line of its own.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>

#include "common/mesh/models/primitives.h"
#include "common/mesh/topology.h"
#include "common/run/errors.h"
#include "methods/registry.h"
#include "tests/support/shapes.h"

namespace voxcarve {
namespace {

using test::frame_of;
using test::joined;

std::string test_name(const Method& method) {
  std::string name = method.info().name;
  std::ranges::replace(name, '-', '_');
  return name;
}

/// One small model of every kind.
std::vector<Model> small_models() {
  std::vector<Model> models;
  models.push_back({"tori", joined({torus(3, 1, 48, 24), torus(1, 0.3, 12, 8)})});
  BinaryVolume volume = BinaryVolume(frame_of({8, 7, 6}), 1);
  volume(3, 3, 3) = 0;
  models.push_back({"block", volume});
  models.push_back({"image", BinaryVolume(frame_of({8, 7, 1}), 1)});
  Grid<float> field(frame_of({8, 8, 8}));
  for (std::size_t i = 0; i < field.values.size(); ++i) field.values[i] = static_cast<float>(i % 8);
  models.push_back({"field", ScalarVolume{field, 3.5F}});
  ImplicitSolid ball{[](const Point& p) { return p.norm() < 1; }, {Point::Constant(-1), Point::Constant(1)}};
  ball.clearance = [](const Point& p) { return (1 - 1e-12) * std::abs(p.norm() - 1); };
  models.push_back({"ball", ball});
  return models;
}

Parameters defaults_of(const Method& method) {
  return Parameters::defaults(method.info().parameters);
}

/// The same on coarse grids, and `settings`: what most tests below ask for does not depend on the resolution, and runs
/// many times.
Parameters coarse_defaults_of(const Method& method, std::vector<std::string> settings = {}) {
  if (method.info().parameters.find("resolution") != nullptr) settings.emplace_back("resolution=40");
  return Parameters::parse(method.info().parameters, settings, method.info().name);
}

class EveryMethod : public testing::TestWithParam<const Method*> {
 protected:
  const Method& method() const { return *GetParam(); }
  MethodResult run(const Model& model, int threads = 1) const {
    RunContext context;
    context.threads = threads;
    return method().run(model, coarse_defaults_of(method()), context);
  }
  std::vector<Model> supported() const {
    std::vector<Model> models;
    for (Model& model : small_models()) {
      if (!method().unsupported(model, defaults_of(method()))) models.push_back(std::move(model));
    }
    return models;
  }
};

std::vector<TriangleSoup> all_levels(const MethodResult& result) {
  std::vector<TriangleSoup> levels;
  for (std::int64_t level = 0; level < result.levels->size(); ++level) levels.push_back(result.levels->extract(level));
  return levels;
}

bool same_volumes(const MethodResult& a, const MethodResult& b) {
  if (a.volumes.size() != b.volumes.size()) return false;
  for (std::size_t i = 0; i < a.volumes.size(); ++i) {
    if (a.volumes[i].name != b.volumes[i].name || a.volumes[i].volume != b.volumes[i].volume) return false;
  }
  return true;
}

TEST_P(EveryMethod, DescribesItself) {
  const MethodInfo& info = method().info();
  EXPECT_EQ(info.name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-"), std::string::npos) << info.name;
  EXPECT_FALSE(info.summary.empty());
  EXPECT_FALSE(info.accepts.empty());
  EXPECT_EQ(std::ranges::count_if(all_methods(), [&](const Method* other) { return other->info().name == info.name; }),
            1);
}

TEST_P(EveryMethod, HasAValidSchema) {
  std::set<std::string> names;
  for (const ParameterSpec& spec : method().info().parameters.specs) {
    EXPECT_TRUE(names.insert(spec.name).second) << spec.name << " stands twice";
    EXPECT_EQ(spec.name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_"), std::string::npos) << spec.name;
    EXPECT_FALSE(spec.help.empty()) << spec.name;
    // The default reads back as itself, so it is in range and one of the choices.
    const std::string assignment = spec.name + "=" + to_string(spec.default_value);
    EXPECT_NO_THROW(Parameters::parse(method().info().parameters, std::vector<std::string>{assignment}, ""))
        << assignment;
  }
  EXPECT_EQ(Parameters::parse(method().info().parameters, {}, "").canonical(), defaults_of(method()).canonical());
}

TEST_P(EveryMethod, RefusesUnknownParameters) {
  EXPECT_THROW(Parameters::parse(method().info().parameters, std::vector<std::string>{"no_such_parameter=1"}, ""),
               ParameterError);
}

TEST_P(EveryMethod, SupportsSomethingAndGivesReasonsForTheRest) {
  EXPECT_FALSE(supported().empty());
  for (const Model& model : small_models()) {
    if (const auto reason = method().unsupported(model, defaults_of(method()))) {
      EXPECT_FALSE(reason->text.empty());
      RunContext context;
      EXPECT_THROW(method().run(model, coarse_defaults_of(method()), context), InputError) << model.name;
    }
  }
}

TEST_P(EveryMethod, GivesAtLeastOneLevelWithTriangles) {
  for (const Model& model : supported()) {
    RunContext context;
    context.threads = 2;
    const MethodResult result = method().run(model, defaults_of(method()), context);
    ASSERT_GE(result.levels->size(), 1) << model.name;
    EXPECT_FALSE(result.levels->extract(result.levels->size() - 1).empty()) << model.name;
  }
}

TEST_P(EveryMethod, IsDeterministicAndIndependentOfThreads) {
  for (const Model& model : supported()) {
    const MethodResult first = run(model);
    const MethodResult again = run(model);
    const MethodResult threaded = run(model, 2);
    EXPECT_EQ(all_levels(first), all_levels(again)) << model.name;
    EXPECT_EQ(all_levels(first), all_levels(threaded)) << model.name;
    EXPECT_TRUE(same_volumes(first, threaded)) << model.name;
    EXPECT_EQ(first.notices, threaded.notices) << model.name;
  }
}

TEST_P(EveryMethod, LeavesTheInputAlone) {
  for (const Model& model : supported()) {
    const Model before = model;
    run(model);
    EXPECT_EQ(before.shape.index(), model.shape.index());
    if (model.soup() != nullptr) {
      EXPECT_EQ(*model.soup(), *before.soup());
    }
    if (const auto* volume = std::get_if<BinaryVolume>(&model.shape)) {
      EXPECT_EQ(*volume, std::get<BinaryVolume>(before.shape));
    }
    if (const auto* scalar = std::get_if<ScalarVolume>(&model.shape)) {
      EXPECT_EQ(scalar->grid, std::get<ScalarVolume>(before.shape).grid);
    }
  }
}

TEST_P(EveryMethod, StopsWhenItIsCancelledBeforeTheRun) {
  for (const Model& model : supported()) {
    RunContext context;
    std::stop_source source;
    context.cancellation = source.get_token();
    source.request_stop();
    EXPECT_THROW(method().run(model, coarse_defaults_of(method()), context), Cancelled) << model.name;
  }
}

TEST_P(EveryMethod, StopsWhenItIsCancelledDuringTheRun) {
  for (const Model& model : supported()) {
    // As many runs as there are reports: each is cancelled at its next report.
    int reports = 0;
    {
      RunContext context;
      context.progress = [&](const ProgressEvent&) { ++reports; };
      method().run(model, coarse_defaults_of(method()), context);
    }
    for (int stop_at = 1; stop_at < reports; stop_at += 1 + reports / 8) {
      RunContext context;
      std::stop_source source;
      context.cancellation = source.get_token();
      int seen = 0;
      bool last_stage_was_over = false;
      context.progress = [&](const ProgressEvent& event) {
        if (++seen == stop_at) {
          source.request_stop();
          last_stage_was_over = event.done == event.total;
        }
      };
      try {
        method().run(model, coarse_defaults_of(method()), context);
        // Between the last stage's end and the return there is nothing left to stop.
        EXPECT_TRUE(last_stage_was_over) << method().info().name << " went on after report " << stop_at << " of "
                                         << reports;
      } catch (const Cancelled&) {
      }
    }
  }
}

TEST_P(EveryMethod, ReportsMonotoneProgress) {
  for (const Model& model : supported()) {
    RunContext context;
    context.threads = 2;
    std::string stage;
    std::int64_t done = 0;
    std::set<std::string> over;
    std::map<std::string, std::int64_t> last;
    context.progress = [&](const ProgressEvent& event) {
      if (event.stage != stage) {
        stage = event.stage;
        done = 0;
      }
      EXPECT_GE(event.done, done) << stage;
      EXPECT_LE(event.done, event.total) << stage;
      done = event.done;
      last[stage] = event.total - event.done;
    };
    method().run(model, coarse_defaults_of(method()), context);
    for (const auto& [name, left] : last) EXPECT_EQ(left, 0) << name << " did not end at its total";
  }
}

TEST_P(EveryMethod, FailsBeforeItExceedsItsMemoryBudget) {
  for (const Model& model : supported()) {
    RunContext context;
    context.memory_budget = 16;  // bytes: less than any model here
    EXPECT_THROW(method().run(model, coarse_defaults_of(method()), context), ResourceError) << model.name;
  }
}

TEST_P(EveryMethod, KeepsItsPromiseOfAClosedManifold) {
  const ParameterSchema& schema = method().info().parameters;
  std::vector<Parameters> settings = {coarse_defaults_of(method())};
  if (schema.find("triangles") != nullptr) settings.push_back(coarse_defaults_of(method(), {"triangles=100"}));
  for (const Model& model : supported()) {
    for (const Parameters& parameters : settings) {
      RunContext context;
      const MethodResult result = method().run(model, parameters, context);
      const auto checks = method().check_invariants(model, parameters, result, context);
      if (method().info().closed_manifold) {
        EXPECT_FALSE(checks.empty());
      }
      for (const InvariantCheck& check : checks) {
        EXPECT_TRUE(check.holds) << model.name << ", " << parameters.canonical() << ": " << check.name << ", "
                                 << check.detail;
      }
    }
  }
}

TEST_P(EveryMethod, GivesAVolumeWhereItSaysSo) {
  for (const Model& model : supported())
    EXPECT_EQ(!run(model).volumes.empty(), method().info().gives_volume) << model.name;
}

TEST_P(EveryMethod, MeetsATriangleBudgetThatItTakes) {
  const ParameterSchema& schema = method().info().parameters;
  if (schema.find("triangles") == nullptr) GTEST_SKIP() << method().info().name << " takes no triangle budget";
  RunContext context;
  const MethodResult result = method().run(
      small_models()[0], Parameters::parse(schema, std::vector<std::string>{"triangles=300"}, ""), context);
  EXPECT_LE(result.levels->extract(result.levels->size() - 1).triangles.size(), 300U);
}

TEST_P(EveryMethod, RefusesModelsThatMakeNoSense) {
  TriangleSoup not_finite = box(Point::Zero(), Point::Ones());
  not_finite.positions[0][0] = std::numeric_limits<double>::quiet_NaN();
  TriangleSoup out_of_range = box(Point::Zero(), Point::Ones());
  out_of_range.triangles[0][0] = 99;
  TriangleSoup point;
  point.positions.assign(3, Point::Ones());
  point.triangles = {{0, 1, 2}};
  for (const TriangleSoup& soup : {TriangleSoup{}, not_finite, out_of_range, point}) {
    RunContext context;
    EXPECT_THROW(method().run({"nonsense", soup}, defaults_of(method()), context), InputError);
  }
}

INSTANTIATE_TEST_SUITE_P(Registered, EveryMethod, testing::ValuesIn(all_methods()),
                         [](const testing::TestParamInfo<const Method*>& parameter) {
                           return test_name(*parameter.param);
                         });

TEST(Registry, SuggestsTheNearestMethod) {
  try {
    find_method("qslin");
    FAIL();
  } catch (const ParameterError& error) {
    EXPECT_NE(std::string(error.what()).find("did you mean 'qslim'?"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace voxcarve
