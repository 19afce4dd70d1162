// Stages and metrics that have no peer here: what they cost, by size.
#include <fmt/format.h>

#include "common/mesh/models/primitives.h"
#include "common/volume/distance_transform.h"
#include "common/volume/labelling.h"
#include "common/volume/morphology.h"
#include "common/volume/voxelize.h"
#include "experiments/benchmarks/contests.h"
#include "experiments/benchmarks/shapes.h"
#include "metrics/metric.h"

namespace voxcarve::bench {

namespace {

constexpr int kThreads = 2;

Lazy<BinaryVolume> binary_ball(std::int64_t resolution) {
  return Lazy<BinaryVolume>([=] { return thresholded(bumpy_ball_density(resolution), 0.5F); });
}

/// A series over grids of the sides `resolutions`.
template <class Call>
void add_volume_series(std::vector<Contest>& contests, const std::string& stage, const std::string& setting,
                       const std::vector<std::int64_t>& resolutions, const Call& call) {
  std::vector<GrowthPoint> points;
  for (const std::int64_t side : resolutions) {
    const auto voxels = static_cast<double>(side * side * side);
    points.push_back(
        {fmt::format("by grid: {}^3{}", side, setting), voxels, prepared_call(binary_ball(side), kThreads, call)});
  }
  std::ranges::move(growth_contests(stage, "voxel", kThreads, std::move(points)), std::back_inserter(contests));
}

}  // namespace

std::vector<Contest> other_contests(const Scope& scope) {
  const std::vector<std::int64_t> resolutions =
      scope.quick ? std::vector<std::int64_t>{64, 128} : std::vector<std::int64_t>{128, 256};
  std::vector<Contest> contests;
  add_volume_series(
      contests, "distance transform", "", resolutions,
      [](const BinaryVolume& volume, RunContext& context) { return squared_distance(volume, 1, context); });
  for (const double distance : {3.0, 10.0}) {
    add_volume_series(
        contests, "closing", fmt::format(" distance {}", distance), resolutions,
        [=](const BinaryVolume& volume, RunContext& context) { return close(volume, distance, context); });
  }
  add_volume_series(contests, "labelling", "", resolutions, [](const BinaryVolume& volume, RunContext& context) {
    return label_components(volume, 1, Connectivity::kFace, context);
  });
  std::vector<GrowthPoint> points;
  for (const std::int64_t triangles : {20000, 100000}) {
    const Lazy<std::array<TriangleSoup, 2>> pair([=] {
      return std::array{bumpy_ball(triangles), bumpy_ball(triangles / 4)};
    });
    points.push_back(
        {fmt::format("by triangles: {} and a quarter of the triangles", short_count(static_cast<double>(triangles))),
         static_cast<double>(triangles),
         prepared_call(pair, kThreads, [](const std::array<TriangleSoup, 2>& shapes, RunContext& context) {
           return measure_pair(shapes[0], shapes[1], {}, context);
         })});
  }
  std::ranges::move(growth_contests("pair metrics", "triangle", kThreads, std::move(points)),
                    std::back_inserter(contests));
  return contests;
}

}  // namespace voxcarve::bench
