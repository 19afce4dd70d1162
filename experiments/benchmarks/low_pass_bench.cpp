// Low-pass filtering of solids: how its cost goes with the support and with the resolution, and the hierarchy of the
// paper's sphereflake. No peer has radially symmetric filters.
#include <fmt/format.h>

#include <cmath>

#include "common/mesh/models/procedural.h"
#include "experiments/benchmarks/contests.h"
#include "methods/he_lowpass/hierarchy.h"
#include "methods/he_lowpass/low_pass.h"
#include "methods/registry.h"

namespace voxcarve::bench {

namespace {

constexpr const char* kStage = "low-pass";

Lazy<Model> implicit_model(const std::string& name) {
  return Lazy<Model>([=] { return Model{name, *make_implicit(name + "?form=implicit")}; });
}

/// The mechanical part at a resolution, by the hyper-cone of a support in voxels; the note tells what was summed.
Contest filtered_part(const std::string& work, const Lazy<Model>& part, std::int64_t resolution, double support) {
  const auto report = std::make_shared<LowPassReport>();
  const auto seconds = std::make_shared<double>(0);
  const auto voxels = std::make_shared<std::int64_t>(0);
  Contest contest{kStage, fmt::format("{}: {} voxels, R = {:g}", work, resolution, support), {}, {{}}, {}};
  Contestant ours{"voxcarve", 1, {}};
  ours.prepare = [=] {
    return [=, &model = part.get()] {
      RunContext context;
      const auto solid = make_sampler(model, {});
      const GridFrame frame = padded(level_frame(solid->box(), resolution), 1);
      const auto run = timed([&] {
        return low_pass(*solid, frame, {{RadialShape::kHyperCone, 0}, support, 11, TapRule::kPoint}, context,
                        report.get());
      });
      *seconds = run.seconds;
      *voxels = frame.voxels();
      return run.seconds;
    };
  };
  contest.contestants = {ours};
  contest.rows.front().note = [=] {
    return fmt::format("{:.1f} % of the grid points summed, {} taps; {:.0f} ns a summed point, {:.1f} ns a grid point",
                       100 * static_cast<double>(report->evaluated) / static_cast<double>(*voxels), report->taps,
                       1e9 * *seconds / static_cast<double>(report->evaluated),
                       1e9 * *seconds / static_cast<double>(*voxels));
  };
  return contest;
}

/// [He95, Table 1], all six levels with their surfaces; `taps` across the support.
Contest sphereflake(int taps) {
  const Lazy<Model> flake = implicit_model("sphereflake");
  Contest contest{kStage, fmt::format("sphereflake hierarchy, {} taps", taps), {}, {}, {}};
  for (const int threads : {1, 2}) {
    contest.rows.push_back({contest.contestants.size(), {}, {}, {}});
    contest.contestants.push_back(
        {"voxcarve", threads, prepared_call(flake, threads, [=](const Model& model, RunContext& context) {
           const Method& method = find_method("he-lowpass");
           const std::vector<std::string> settings = {"resolution=200,100,50,30,15,5", fmt::format("taps={}", taps)};
           return method.run(model, Parameters::parse(method.info().parameters, settings, "he-lowpass"), context);
         })});
    contest.contestants.back().warm_up = false;
  }
  return contest;
}

}  // namespace

std::vector<Contest> low_pass_contests(const Scope& scope) {
  const Lazy<Model> part = implicit_model("mechanical-part");
  std::vector<Contest> contests;
  const std::int64_t side = scope.size(200, 30);
  for (const double support : {0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0})
    contests.push_back(filtered_part("by support", part, side, support));
  for (const std::int64_t resolution :
       scope.quick ? std::vector<std::int64_t>{20, 40} : std::vector<std::int64_t>{50, 100, 200, 400})
    contests.push_back(filtered_part("by resolution", part, resolution, 1));
  if (!scope.quick) {
    contests.push_back(sphereflake(11));
    contests.push_back(sphereflake(24));
  }
  return contests;
}

}  // namespace voxcarve::bench
