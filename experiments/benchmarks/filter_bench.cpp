// The Gaussian low-pass filter: against ITK's, whose cost does not depend on sigma, and by itself by grid and by sigma.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/volume/gaussian_filter.h"
#include "experiments/benchmarks/contests.h"
#include "experiments/benchmarks/peers.h"
#include "experiments/benchmarks/processor_time.h"
#include "experiments/benchmarks/shapes.h"

namespace voxcarve::bench {

namespace {

constexpr const char* kStage = "gaussian filter";
constexpr double kCutOff = 4;  ///< sigma; beyond lie 6e-5 of a Gaussian
constexpr double kSigma = 2;

Lazy<DensityVolume> bumpy_density(std::int64_t side) {
  return Lazy<DensityVolume>([=] { return bumpy_ball_density(side); });
}

auto gaussian(double sigma) {
  return [=](const DensityVolume& field, RunContext& context) {
    return gaussian_filtered(field, {.sigma = Point::Constant(sigma), .support = Point::Constant(kCutOff * sigma)},
                             context);
  };
}

double greatest_difference(const Grid<float>& a, const Grid<float>& b) {
  float greatest = 0;
  for (std::size_t v = 0; v < a.values.size(); ++v) greatest = std::max(greatest, std::abs(a.values[v] - b.values[v]));
  return static_cast<double>(greatest);
}

/// One and two threads. ITK takes long enough for a run without warm-up.
Contest against_itk(std::int64_t side, double sigma, std::optional<double> goal) {
  const Lazy<DensityVolume> input = bumpy_density(side);
  const Lazy<Grid<float>> expected([=] {
    RunContext context;
    context.threads = 2;
    return gaussian(sigma)(input.get(), context);
  });
  const auto finding = std::make_shared<std::string>();
  Contest contest{kStage, fmt::format("{}^3 sigma {:g}", side, sigma), {}, {}, {}};
  for (const int threads : {1, 2})
    contest.contestants.push_back({"voxcarve", threads, prepared_call(input, threads, gaussian(sigma))});
  for (const int threads : {1, 2}) {
    Contestant peer{"itk::RecursiveGaussian", threads, {}};
    peer.warm_up = false;
    if (peers_at_hand().itk) {
      peer.prepare = [=] {
        return [=, run = itk_gaussian(input.get(), sigma, threads)] {
          const auto made = run();
          if (finding->empty()) {
            *finding = fmt::format("densities differ by {:.2g} at most; the peer's kernel is infinite and approximate",
                                   greatest_difference(made.result, expected.get()));
          }
          return made.seconds;
        };
      };
    }
    contest.contestants.push_back(peer);
  }
  const auto note = [=] { return *finding; };
  contest.rows = {{0, 2, goal, note}, {1, 3, goal, note}};
  return contest;
}

/// What the runs of one contest cost the processors: what our own code takes, where others use them too and fresh
/// memory costs the system more than the filter.
struct Spent {
  ProcessorTime time;
  int runs = 0;

  std::string each(double voxels) const {
    const double nanoseconds = 1e9 / voxels / std::max(runs, 1);
    return fmt::format("{:.3g} in our code and {:.3g} in the system", nanoseconds * time.user,
                       nanoseconds * time.system);
  }
};

/// A contestant's `prepare`.
std::function<TimedRun()> watched(const Lazy<DensityVolume>& input, int threads, double sigma,
                                  const std::shared_ptr<Spent>& spent) {
  return [=] {
    return [=, &field = input.get()] {
      RunContext context;
      context.threads = threads;
      const ProcessorTime before = processor_time();
      const auto made = timed([&] { return gaussian(sigma)(field, context); });
      spent->time += processor_time() - before;
      ++spent->runs;
      return made.seconds;
    };
  };
}

Contest by_sigma(const Lazy<DensityVolume>& input, std::int64_t side, double sigma) {
  const auto spent = std::make_shared<Spent>();
  Contest contest{kStage, fmt::format("by sigma: {}^3 sigma {:g}", side, sigma), {}, {{}}, {}};
  contest.contestants = {{"voxcarve", 1, watched(input, 1, sigma, spent)}};
  contest.rows.front().note = [=] { return "ns a voxel: " + spent->each(std::pow(static_cast<double>(side), 3)); };
  return contest;
}

std::vector<Contest> by_grid(const Scope& scope) {
  constexpr int kThreads = 2;
  const std::vector<std::int64_t> sides =
      scope.quick ? std::vector<std::int64_t>{64, 128} : std::vector<std::int64_t>{128, 256, 512, 1024};
  std::vector<GrowthPoint> points;
  std::vector<std::shared_ptr<Spent>> spent;
  for (const std::int64_t side : sides) {
    spent.push_back(std::make_shared<Spent>());
    points.push_back({fmt::format("by grid: {}^3 sigma {:g}", side, kSigma), std::pow(static_cast<double>(side), 3),
                      watched(bumpy_density(side), kThreads, kSigma, spent.back()),
                      side <= 128   ? 20
                      : side <= 256 ? 5
                                    : 1});
  }
  const auto remark = [=](std::span<const double>, Tables& tables) {
    std::string text = fmt::format("gaussian filter, T{}, sigma {:g}, ns a voxel on all processors:", kThreads, kSigma);
    for (std::size_t s = 0; s < sides.size(); ++s) {
      text += fmt::format("{} {}^3 {}", s == 0 ? "" : ";", sides[s],
                          spent[s]->each(std::pow(static_cast<double>(sides[s]), 3)));
    }
    tables.remarks.push_back(text);
  };
  return growth_contests(kStage, "voxel", kThreads, std::move(points), remark);
}

}  // namespace

std::vector<Contest> filter_contests(const Scope& scope) {
  const std::int64_t side = scope.size(512, 64);
  std::vector<Contest> contests{against_itk(side, kSigma, scope.goal(8))};
  const Lazy<DensityVolume> input = bumpy_density(side);
  for (const double sigma : {1.0, 4.0, 8.0}) contests.push_back(by_sigma(input, side, sigma));
  std::ranges::move(by_grid(scope), std::back_inserter(contests));
  return contests;
}

}  // namespace voxcarve::bench
