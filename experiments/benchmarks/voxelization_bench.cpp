// Solid voxelization: against VTK's image stencils and OpenVDB's level sets, and by itself from few triangles to many.
#include <fmt/format.h>

#include <cmath>

#include "common/volume/voxelize.h"
#include "experiments/benchmarks/contests.h"
#include "experiments/benchmarks/growth.h"
#include "experiments/benchmarks/peers.h"
#include "experiments/benchmarks/shapes.h"

namespace voxcarve::bench {

namespace {

constexpr const char* kStage = "voxelization";
constexpr int kDirections = 3;

struct Input {
  TriangleSoup soup;
  GridFrame frame;
};

Lazy<Input> ball(std::int64_t triangles, std::int64_t resolution) {
  return Lazy<Input>([=] {
    Input input{bumpy_ball(triangles), {}};
    input.frame = voxel_frame(bounds(input.soup), resolution);
    return input;
  });
}

std::string work_name(std::int64_t resolution, std::int64_t triangles) {
  return fmt::format("{}^3 parity {} directions {} triangles", resolution, kDirections,
                     short_count(static_cast<double>(triangles)));
}

/// Interior voxels by contestant, to see that all solved one problem.
using Counts = std::shared_ptr<std::vector<std::int64_t>>;

BinaryVolume voxelized(const Input& input, RunContext& context) {
  return voxelize(input.soup, input.frame, {.directions = kDirections}, context);
}

Contestant ours(const Lazy<Input>& input, int threads, const Counts& counts, std::size_t slot) {
  const auto count = [=](const BinaryVolume& volume) { (*counts)[slot] = count_interior(volume); };
  return {"voxcarve", threads, prepared_call(input, threads, voxelized, count)};
}

TimedRun remembering(CountingPeer run, const Counts& counts, std::size_t slot) {
  return [=] {
    const auto made = run();
    (*counts)[slot] = made.result;
    return made.seconds;
  };
}

Contest against_peers(std::int64_t resolution, std::int64_t triangles, std::optional<double> goal) {
  const Lazy<Input> input = ball(triangles, resolution);
  const auto counts = std::make_shared<std::vector<std::int64_t>>(5);
  Contest contest{kStage, work_name(resolution, triangles), {}, {}, {}};
  contest.contestants = {ours(input, 1, counts, 0), ours(input, 2, counts, 1)};
  Contestant vtk{"vtkPolyDataToImageStencil", 1, {}};
  if (peers_at_hand().vtk)
    vtk.prepare = [=] { return remembering(vtk_voxelization(input.get().soup, input.get().frame), counts, 2); };
  contest.contestants.push_back(vtk);
  for (const int threads : {1, 2}) {
    Contestant openvdb{"OpenVDB meshToVolume", threads, {}};
    const auto slot = static_cast<std::size_t>(2 + threads);
    if (peers_at_hand().openvdb) {
      openvdb.prepare = [=] {
        return remembering(openvdb_voxelization(input.get().soup, input.get().frame, threads), counts, slot);
      };
    }
    contest.contestants.push_back(openvdb);
  }
  const auto agreement = [=](std::size_t ours_at, std::size_t peer_at, const char* remark) {
    return [=]() -> std::string {
      const auto mine = static_cast<double>((*counts)[ours_at]);
      const auto theirs = static_cast<double>((*counts)[peer_at]);
      if (mine == 0 || theirs == 0) return remark;
      return fmt::format("{}interior {:+.4f} %", remark, 100 * (theirs - mine) / mine);
    };
  };
  contest.rows = {{0, 2, goal, agreement(0, 2, "to a mask; ")},
                  {0, 3, goal, agreement(0, 3, "to a mask; ")},
                  {1, 2, goal, agreement(1, 2, "peer on 1 thread, it has no more; ")},
                  {1, 4, goal, agreement(1, 4, "to a mask; ")}};
  return contest;
}

/// What the paper's other settings cost.
std::vector<Contest> other_settings(std::int64_t resolution, std::int64_t triangles) {
  std::vector<Contest> contests;
  const auto add = [&](const std::string& setting, const auto& call) {
    Contest& contest = contests.emplace_back();
    contest.stage = kStage;
    contest.work =
        fmt::format("{}^3 {} {} triangles", resolution, setting, short_count(static_cast<double>(triangles)));
    const Lazy<Input> input = ball(triangles, resolution);
    for (const int threads : {1, 2}) {
      contest.rows.push_back({contest.contestants.size(), {}, {}, {}});
      contest.contestants.push_back({"voxcarve", threads, prepared_call(input, threads, call)});
    }
  };
  add("parity 13 directions", [](const Input& input, RunContext& context) {
    return voxelize(input.soup, input.frame, {.directions = 13}, context);
  });
  add("stabbing 3 directions", [](const Input& input, RunContext& context) {
    return voxelize(input.soup, input.frame, {.classifier = Classifier::kStabbing}, context);
  });
  for (const auto& [kernel, name] :
       {std::pair(FilterKernel::kBox, "box"), std::pair(FilterKernel::kGaussian, "gaussian")}) {
    for (const int samples : {2, 3}) {
      add(fmt::format("supersampling {} {}", samples, name), [=](const Input& input, RunContext& context) {
        return voxelize_density(input.soup, input.frame, {}, {.samples = samples, .kernel = kernel}, context);
      });
    }
  }
  return contests;
}

GrowthPoint growth_point(const char* series, std::int64_t resolution, std::int64_t triangles, double size) {
  const Lazy<Input> input = ball(triangles, resolution);
  return {std::string(series) + ": " + work_name(resolution, triangles), size, prepared_call(input, 1, voxelized),
          resolution <= 256 ? 3 : 1};
}

void report_costs(std::span<const VoxelizationSample> samples, Tables& tables) {
  const VoxelizationCosts costs = fit_costs(samples);
  tables.remarks.push_back(fmt::format(
      "voxelization, T1, {} directions: {:.3g} ns a triangle + {:.3g} ns a voxel column + {:.3g} ns a voxel "
      "(least squares over {} sizes, none off by more than {:.0f} %)",
      kDirections, costs.per_triangle, costs.per_column, costs.per_voxel, samples.size(), 100 * costs.worst));
}

/// Triangles at a fixed grid, then grids at fixed triangles; from both, what each costs.
std::vector<Contest> growth(const Scope& scope) {
  const std::vector<std::int64_t> triangle_counts =
      scope.quick ? std::vector<std::int64_t>{10000, 30000, 100000}
                  : std::vector<std::int64_t>{10000, 30000, 100000, 300000, 1000000};
  const std::vector<std::int64_t> resolutions =
      scope.quick ? std::vector<std::int64_t>{64, 128, 192} : std::vector<std::int64_t>{128, 192, 256, 384, 512};
  const std::int64_t resolution = scope.size(256, 128);
  const std::int64_t triangles = scope.size(100000, 30000);
  auto samples = std::make_shared<std::vector<VoxelizationSample>>();
  const auto sample = [=](std::int64_t side, std::int64_t count, double seconds) {
    // The ball's box is a cube but for its bumps.
    const auto n = static_cast<double>(side);
    samples->push_back({static_cast<double>(count), kDirections * n * n, n * n * n, seconds});
  };
  std::vector<GrowthPoint> by_triangles;
  for (const std::int64_t count : triangle_counts)
    by_triangles.push_back(growth_point("by triangles", resolution, count, static_cast<double>(count)));
  std::vector<GrowthPoint> by_grid;
  for (const std::int64_t side : resolutions)
    by_grid.push_back(growth_point("by grid", side, triangles, std::pow(static_cast<double>(side), 3)));
  std::vector<Contest> contests =
      growth_contests(kStage, "triangle", 1, std::move(by_triangles), [=](std::span<const double> seconds, Tables&) {
        for (std::size_t i = 0; i < seconds.size(); ++i) sample(resolution, triangle_counts[i], seconds[i]);
      });
  std::vector<Contest> grids =
      growth_contests(kStage, "voxel", 1, std::move(by_grid), [=](std::span<const double> seconds, Tables& tables) {
        for (std::size_t i = 0; i < seconds.size(); ++i) sample(resolutions[i], triangles, seconds[i]);
        if (samples->size() == triangle_counts.size() + resolutions.size()) report_costs(*samples, tables);
      });
  std::ranges::move(grids, std::back_inserter(contests));
  return contests;
}

}  // namespace

std::vector<Contest> voxelization_contests(const Scope& scope) {
  const std::int64_t resolution = scope.size(512, 256);
  std::vector<Contest> contests;
  contests.push_back(against_peers(resolution, 100000, scope.goal(20)));
  contests.push_back(against_peers(resolution, scope.size(1000000, 300000), scope.goal(30)));
  std::ranges::move(other_settings(scope.size(256, 128), 100000), std::back_inserter(contests));
  std::ranges::move(growth(scope), std::back_inserter(contests));
  return contests;
}

}  // namespace voxcarve::bench
