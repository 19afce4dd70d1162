// Metrics, which have no peer here: what they cost, by size.
#include <fmt/format.h>

#include "experiments/benchmarks/contests.h"
#include "experiments/benchmarks/shapes.h"
#include "metrics/metric.h"

namespace voxcarve::bench {

namespace {

constexpr int kThreads = 2;

}  // namespace

std::vector<Contest> other_contests(const Scope&) {
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
  return growth_contests("pair metrics", "triangle", kThreads, std::move(points));
}

}  // namespace voxcarve::bench
