#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "experiments/benchmarks/contests.h"
#include "experiments/benchmarks/growth.h"

namespace voxcarve::bench {

std::vector<Contest> growth_contests(const std::string& stage, const std::string& unit, int threads,
                                     std::vector<GrowthPoint> points,
                                     std::function<void(std::span<const double>, Tables&)> afterwards) {
  struct Series {
    std::vector<GrowthPoint> points;
    std::vector<double> seconds;  ///< 0: not run
    std::function<void(std::span<const double>, Tables&)> afterwards;
  };
  auto series = std::make_shared<Series>();
  series->seconds.resize(points.size());
  series->points = std::move(points);
  series->afterwards = std::move(afterwards);
  std::vector<Contest> contests;
  for (std::size_t p = 0; p < series->points.size(); ++p) {
    Contest& contest = contests.emplace_back();
    contest.stage = stage;
    contest.work = series->points[p].work;
    contest.contestants = {{"voxcarve", threads, series->points[p].prepare, false, series->points[p].iterations}};
    contest.rows = {{}};
    contest.afterwards = [series, p, unit](Tables& tables) {
      const double size = series->points[p].size;
      const double seconds = median(tables.ratios.back().ours_seconds);
      series->seconds[p] = seconds;
      std::string note = fmt::format("{:.3g} ns a {}", 1e9 * seconds / size, unit);
      if (p > 0 && series->seconds[p - 1] > 0) {
        note += fmt::format(", grows as {}s^{:.2f}", unit,
                            growth_exponent(series->points[p - 1].size, series->seconds[p - 1], size, seconds));
      }
      tables.ratios.back().note = note;
      const bool all_ran = std::ranges::all_of(series->seconds, [](double s) { return s > 0; });
      if (p + 1 == series->points.size() && all_ran && series->afterwards) series->afterwards(series->seconds, tables);
    };
  }
  return contests;
}

}  // namespace voxcarve::bench
