// Marching cubes: against VTK's flying edges, and by itself from small grids to large.
#include "common/volume/isosurface.h"

#include <fmt/format.h>

#include <cmath>

#include "experiments/benchmarks/contests.h"
#include "experiments/benchmarks/peers.h"
#include "experiments/benchmarks/shapes.h"

namespace voxcarve::bench {

namespace {

constexpr const char* kStage = "isosurface";
constexpr float kIsoValue = 0.5F;
constexpr double kPeriods = 6;

Lazy<DensityVolume> gyroid(std::int64_t resolution) {
  return Lazy<DensityVolume>([=] { return gyroid_density(resolution, kPeriods); });
}

std::function<TimedRun()> run_of_ours(const Lazy<DensityVolume>& volume, int threads,
                                      const std::shared_ptr<std::int64_t>& triangles) {
  return prepared_call(
      volume, threads,
      [](const DensityVolume& density, RunContext& context) { return isosurface(density, kIsoValue, context); },
      [=](const TriangleSoup& surface) { *triangles = static_cast<std::int64_t>(surface.triangles.size()); });
}

Contest against_flying_edges(std::int64_t resolution, std::optional<double> goal) {
  const Lazy<DensityVolume> volume = gyroid(resolution);
  const auto ours = std::make_shared<std::int64_t>(0);
  const auto theirs = std::make_shared<std::int64_t>(0);
  Contest contest{kStage, fmt::format("{}^3 float gyroid {:g} periods", resolution, kPeriods), {}, {}, {}};
  for (const int threads : {1, 2})
    contest.contestants.push_back({"voxcarve", threads, run_of_ours(volume, threads, ours)});
  for (const int threads : {1, 2}) {
    Contestant vtk{"vtkFlyingEdges3D", threads, {}};
    if (peers_at_hand().vtk) {
      vtk.prepare = [=] {
        return [=, run = vtk_isosurface(volume.get(), kIsoValue, threads)] {
          const auto made = run();
          *theirs = made.result;
          return made.seconds;
        };
      };
    }
    contest.contestants.push_back(vtk);
  }
  const auto note = [=]() -> std::string {
    return fmt::format("{} triangles, the peer's {}, on {}", with_thousands(*ours), with_thousands(*theirs),
                       peers_at_hand().vtk ? vtk_smp_backend() : "nothing");
  };
  contest.rows = {{0, 2, goal, note}, {1, 3, goal, note}};
  return contest;
}

}  // namespace

std::vector<Contest> isosurface_contests(const Scope& scope) {
  std::vector<Contest> contests{against_flying_edges(scope.size(512, 256), scope.goal(1.5))};
  const std::vector<std::int64_t> resolutions =
      scope.quick ? std::vector<std::int64_t>{64, 128, 192} : std::vector<std::int64_t>{128, 192, 256, 384, 512};
  std::vector<GrowthPoint> points;
  std::vector<std::shared_ptr<std::int64_t>> triangles;
  for (const std::int64_t side : resolutions) {
    triangles.push_back(std::make_shared<std::int64_t>(0));
    points.push_back({fmt::format("by grid: {}^3 float gyroid {:g} periods", side, kPeriods),
                      std::pow(static_cast<double>(side), 3), run_of_ours(gyroid(side), 1, triangles.back()),
                      side <= 256 ? 3 : 1});
  }
  const auto remark = [=](std::span<const double> seconds, Tables& tables) {
    std::string text = "isosurface, T1, ns a triangle:";
    for (std::size_t i = 0; i < seconds.size(); ++i) {
      text += fmt::format("{} {}^3 {:.3g} ({} triangles)", i == 0 ? "" : ",", resolutions[i],
                          1e9 * seconds[i] / static_cast<double>(*triangles[i]),
                          short_count(static_cast<double>(*triangles[i])));
    }
    tables.remarks.push_back(text);
  };
  std::ranges::move(growth_contests(kStage, "voxel", 1, std::move(points), remark), std::back_inserter(contests));
  return contests;
}

}  // namespace voxcarve::bench
