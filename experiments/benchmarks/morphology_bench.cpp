// Morphology by balls, distance transforms and labelling: against ITK, by grid size, and Mason on the largest grid of
// its paper. Volumes come and go as one byte a voxel; packing into bits and back is part of every time here.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/volume/bit_morphology.h"
#include "common/volume/distance_transform.h"
#include "common/volume/labelling.h"
#include "common/volume/morphology.h"
#include "common/volume/run_labelling.h"
#include "experiments/benchmarks/contests.h"
#include "experiments/benchmarks/peak_memory.h"
#include "experiments/benchmarks/peers.h"
#include "experiments/benchmarks/processor_time.h"
#include "experiments/benchmarks/shapes.h"
#include "methods/mason/regular_filters.h"

namespace voxcarve::bench {

namespace {

constexpr int kThreads = 2;
constexpr double kGibibyte = 1024.0 * 1024.0 * 1024.0;

Lazy<BinaryVolume> scattered(std::int64_t side) {
  return Lazy<BinaryVolume>([=] { return scattered_balls(side); });
}

auto opening(std::int64_t radius) {
  return [=](const BinaryVolume& volume, RunContext& context) {
    return open(volume, static_cast<double>(radius), context);
  };
}

/// Ours by itself, for checks outside the clock.
template <class Call>
auto on_all_threads(const Lazy<BinaryVolume>& input, Call call) {
  RunContext context;
  context.threads = kThreads;
  return call(input.get(), context);
}

/// What the last run of a peer showed when it was compared with ours; empty before.
using Finding = std::shared_ptr<std::string>;

/// Its maker is given the volume and the threads; `inspect` is shown every result. ITK takes long enough for a run
/// without warm-up, but its goals are judged, so it runs in every round.
template <class MakePeer, class Inspect>
Contestant itk(const char* name, int threads, const Lazy<BinaryVolume>& input, MakePeer make_peer, Inspect inspect) {
  Contestant peer{name, threads, {}};
  peer.warm_up = false;
  if (!peers_at_hand().itk) return peer;
  peer.prepare = [=] {
    return [=, run = make_peer(input.get(), threads)] {
      const auto made = run();
      inspect(made.result);
      return made.seconds;
    };
  };
  return peer;
}

std::string share_of_voxels(std::int64_t count, const GridFrame& frame) {
  if (count == 0) return "no voxel differs";
  return fmt::format("{} of {} voxels differ", with_thousands(count), with_thousands(frame.voxels()));
}

/// Rows of ours and the peer, one and two threads, where the contestants are these four in this order.
std::vector<Pairing> rows_by_threads(std::optional<double> goal, const Finding& finding) {
  const auto note = [=] { return *finding; };
  return {{0, 2, goal, note}, {1, 3, goal, note}};
}

Contest opening_contest(const Lazy<BinaryVolume>& input, std::int64_t side, std::int64_t radius,
                        std::optional<double> goal) {
  const Lazy<BinaryVolume> expected([=] { return on_all_threads(input, opening(radius)); });
  const auto finding = std::make_shared<std::string>();
  const auto compare = [=](const BinaryVolume& theirs) {
    const BinaryVolume& ours = expected.get();
    std::int64_t differing = 0;
    for (std::size_t v = 0; v < ours.values.size(); ++v) differing += ours.values[v] != theirs.values[v];
    *finding =
        share_of_voxels(differing, ours.frame) + fmt::format(", {} remain", with_thousands(count_interior(ours)));
  };
  Contest contest{"opening", fmt::format("{}^3 radius {}", side, radius), {}, {}, {}};
  for (const int threads : {1, 2})
    contest.contestants.push_back({"voxcarve", threads, prepared_call(input, threads, opening(radius))});
  for (const int threads : {1, 2}) {
    const auto make_peer = [=](const BinaryVolume& volume, int count) { return itk_opening(volume, radius, count); };
    contest.contestants.push_back(itk("itk::SignedMaurer twice", threads, input, make_peer, compare));
  }
  contest.rows = rows_by_threads(goal, finding);
  return contest;
}

/// Ours tells distances outside the features, ITK also inside of them; compared is what both tell.
Contest distance_contest(std::int64_t side, std::optional<double> goal) {
  const Lazy<BinaryVolume> input = scattered(side);
  const auto call = [](const BinaryVolume& volume, RunContext& context) {
    return squared_distance(volume, 1, context);
  };
  const auto finding = std::make_shared<std::string>();
  const auto compare = [=](const Grid<std::int32_t>& theirs) {
    const Grid<std::int32_t> ours = on_all_threads(input, call);
    std::int64_t differing = 0;
    for (std::size_t v = 0; v < ours.values.size(); ++v)
      differing += ours.values[v] > 0 && ours.values[v] != theirs.values[v];
    *finding = share_of_voxels(differing, ours.frame) + "; the peer's is signed";
  };
  Contest contest{"distance transform", fmt::format("{}^3 squared", side), {}, {}, {}};
  for (const int threads : {1, 2})
    contest.contestants.push_back({"voxcarve", threads, prepared_call(input, threads, call)});
  for (const int threads : {1, 2})
    contest.contestants.push_back(itk("itk::SignedMaurer", threads, input, itk_squared_distance, compare));
  contest.rows = rows_by_threads(goal, finding);
  return contest;
}

Labelling labelled(const BinaryVolume& volume, RunContext& context) {
  return label_components(volume, 1, Connectivity::kFace, context);
}

Contest labelling_contest(const Lazy<BinaryVolume>& input, std::int64_t side, std::optional<double> goal) {
  const auto ours = std::make_shared<std::int64_t>(0);
  const auto finding = std::make_shared<std::string>();
  const auto count = [=](const Labelling& made) { *ours = made.count; };
  const auto compare = [=](std::int64_t theirs) {
    *finding = fmt::format("{} components, the peer's {}", with_thousands(*ours), with_thousands(theirs));
  };
  Contest contest{"labelling", fmt::format("{}^3 faces", side), {}, {}, {}};
  for (const int threads : {1, 2})
    contest.contestants.push_back({"voxcarve", threads, prepared_call(input, threads, labelled, count)});
  for (const int threads : {1, 2}) {
    Contestant peer = itk("itk::ConnectedComponent", threads, input, itk_labelling, compare);
    peer.warm_up = true;
    contest.contestants.push_back(peer);
  }
  contest.rows = rows_by_threads(goal, finding);
  return contest;
}

/// From bits to runs with components: what Mason and the metrics take.
Contest run_labelling_contest(const Lazy<BinaryVolume>& input, std::int64_t side) {
  const Lazy<BitVolume> bits([=] {
    return on_all_threads(input, [](const BinaryVolume& volume, RunContext& context) {
      return packed(volume, Index3::Zero(), false, context);
    });
  });
  Contest contest{"labelling", fmt::format("{}^3 faces bits to runs", side), {}, {}, {}};
  for (const int threads : {1, 2}) {
    contest.rows.push_back({contest.contestants.size(), {}, {}, {}});
    contest.contestants.push_back(
        {"voxcarve", threads, prepared_call(bits, threads, [](const BitVolume& volume, RunContext& context) {
           return label_runs(volume, Connectivity::kFace, context);
         })});
  }
  return contest;
}

/// What the runs of one size cost the processors.
struct Spent {
  ProcessorTime time;
  int runs = 0;
};

/// How far the costs are from one cost for all: that one lies midway between the extremes.
double deviation_from_linear(const std::vector<double>& costs) {
  const auto [least, most] = std::ranges::minmax(costs);
  return (most - least) / (most + least);
}

/// "2.4, 2.6, 2.6".
std::string listed(const std::vector<double>& costs) {
  std::string text;
  for (const double cost : costs) text += fmt::format("{}{:.3g}", text.empty() ? "" : ", ", cost);
  return text;
}

/// The ball stays the same while the grid grows. Judged by the wall; the time in our own code is told beside it, for
/// fresh memory in a virtual machine costs more where there is much of it.
std::vector<Contest> opening_growth(const Scope& scope) {
  constexpr std::int64_t kRadius = 8;
  constexpr double kMayDeviate = 0.15;
  const std::vector<std::int64_t> sides =
      scope.quick ? std::vector<std::int64_t>{64, 128} : std::vector<std::int64_t>{128, 256, 512, 1024};
  const auto spent = std::make_shared<std::vector<Spent>>(sides.size());
  std::vector<GrowthPoint> points;
  for (std::size_t s = 0; s < sides.size(); ++s) {
    const std::int64_t side = sides[s];
    const auto prepare = [=, input = scattered(side)] {
      return [=, &volume = input.get()] {
        RunContext context;
        context.threads = kThreads;
        const ProcessorTime before = processor_time();
        const auto made = timed([&] { return opening(kRadius)(volume, context); });
        (*spent)[s].time += processor_time() - before;
        ++(*spent)[s].runs;
        return made.seconds;
      };
    };
    points.push_back({fmt::format("by grid: {}^3 radius {}", side, kRadius), std::pow(static_cast<double>(side), 3),
                      prepare,
                      side <= 128   ? 20
                      : side <= 256 ? 5
                                    : 1});
  }
  const auto judge = [=](std::span<const double> seconds, Tables& tables) {
    std::vector<double> wall;
    std::vector<double> user;
    std::vector<double> system;
    for (std::size_t s = 0; s < sides.size(); ++s) {
      const double nanoseconds = 1e9 / std::pow(static_cast<double>(sides[s]), 3);
      wall.push_back(nanoseconds * seconds[s]);
      user.push_back(nanoseconds * (*spent)[s].time.user / (*spent)[s].runs);
      system.push_back(nanoseconds * (*spent)[s].time.system / (*spent)[s].runs);
    }
    const double deviation = deviation_from_linear(wall);
    const std::string work = fmt::format("{}^3 to {}^3 radius {}", sides.front(), sides.back(), kRadius);
    tables.remarks.push_back(fmt::format(
        "opening, T{}, {}, ns a voxel: {} by the wall, which is {}linear within 15 %; on all processors {} in our code "
        "and {} in the system",
        kThreads, work, listed(wall), deviation < kMayDeviate ? "" : "not ", listed(user), listed(system)));
    const auto row = [&](const char* clock, double value, std::optional<double> limit) {
      tables.errors.push_back({fmt::format("opening growth T{} {} (deviation from linear)", kThreads, clock),
                               work,
                               value,
                               "",
                               {},
                               {},
                               limit});
    };
    row("wall", deviation, scope.goal(kMayDeviate));
    row("user time", deviation_from_linear(user), std::nullopt);
  };
  return growth_contests("opening", "voxel", kThreads, std::move(points), judge);
}

/// Seconds and memory of the runs of one contest; the memory is that of the input and what was added at the peak.
struct Record {
  std::vector<double> seconds;
  std::uint64_t peak_bytes = 0;
  bool peak_known = true;
  std::optional<double> peak() const {
    return peak_known && !seconds.empty() ? std::optional(static_cast<double>(peak_bytes)) : std::nullopt;
  }
};

template <class Call>
Contestant recorded(const Lazy<BinaryVolume>& input, const std::shared_ptr<Record>& record, Call call) {
  Contestant ours{"voxcarve", kThreads, {}};
  ours.warm_up = false;  // every run stands in the record
  ours.prepare = [=] {
    const BinaryVolume& volume = input.get();
    return [=, &volume] {
      RunContext context;
      context.threads = kThreads;
      const PeakMemory memory;
      const auto made = timed([&] { return call(volume, context); });
      const auto growth = memory.growth();
      record->peak_known = record->peak_known && growth.has_value();
      record->peak_bytes = std::max(record->peak_bytes, growth.value_or(0) + volume.values.size());
      record->seconds.push_back(made.seconds);
      return made.seconds;
    };
  };
  return ours;
}

/// The largest padded grid in [WR05, 5] has 94 million voxels; a transform of it took 24 minutes, and Mason needs
/// eight.
Contest mason_contest(const Scope& scope) {
  constexpr double kSeconds = 30;
  constexpr double kBytesPerVoxel = 6;
  // The dragon's proportions, 363 x 231 x 514, and a size such that the padded grid has 94 million voxels.
  const Index3 dims = scope.quick ? Index3(83, 53, 118) : Index3(333, 212, 472);
  const std::int64_t radius = scope.size(64, 16);
  const Index3 padded_dims = dims + 2 * ball_margin(dims, static_cast<double>(radius));
  const auto voxels = static_cast<double>(padded_dims.prod());
  const Lazy<BinaryVolume> input([=] { return pitted_ellipsoid(dims); });
  const auto counts = std::make_shared<MasonCounts>();
  const auto record = std::make_shared<Record>();
  Contest contest{
      "mason", fmt::format("{} voxels padded radius {}", short_count(voxels), radius), {}, {{0, {}, {}, {}}}, {}};
  contest.contestants = {recorded(input, record, [=](const BinaryVolume& shape, RunContext& context) {
    const Index3 margin = ball_margin(shape.frame.dims, static_cast<double>(radius));
    const BitVolume bits = packed(shape, margin, false, context);
    const BitVolume result = RegularFilters(bits, squared_reach(static_cast<double>(radius)), false, context)
                                 .mason(TieRule::kPaper, counts.get());
    return expanded(result, shape.frame, margin, context);
  })};
  contest.rows.front().note = [=] {
    return fmt::format(
        "8 transforms, as in the paper; {} voxels of mortar in {} components: {} by RF, {} by FR, {} tied",
        with_thousands(counts->mortar_voxels), counts->mortar_components, counts->by_rf, counts->by_fr, counts->ties);
  };
  contest.afterwards = [=, work = contest.work](Tables& tables) {
    if (record->seconds.empty()) return;
    const auto peak = record->peak();
    const double seconds = median(record->seconds);
    tables.errors.push_back(
        {fmt::format("mason T{} (seconds)", kThreads), work, seconds, "", {}, {}, scope.goal(kSeconds)});
    tables.errors.push_back({fmt::format("mason peak memory T{} (bytes a padded voxel)", kThreads),
                             work,
                             peak ? std::optional(*peak / voxels) : std::nullopt,
                             "",
                             {},
                             {},
                             scope.goal(kBytesPerVoxel)});
    tables.remarks.push_back(fmt::format(
        "mason, T{}: {} x {} x {} padded voxels in {:.3g} s, {:.3g} ns a voxel and transform (the paper, 94 "
        "million: about 3 hours, 15000 ns, on an 800 MHz G4)",
        kThreads, padded_dims[0], padded_dims[1], padded_dims[2], seconds, 1e9 * seconds / voxels / 8));
  };
  return contest;
}

Contest large_closing_contest(const Scope& scope) {
  constexpr double kGibibytes = 6;
  constexpr double kRadius = 8;
  const std::int64_t side = scope.size(1024, 128);
  const auto record = std::make_shared<Record>();
  Contest contest{"closing", fmt::format("{}^3 radius {:g}", side, kRadius), {}, {{0, {}, {}, {}}}, {}};
  contest.contestants = {recorded(scattered(side), record, [](const BinaryVolume& volume, RunContext& context) {
    return close(volume, kRadius, context);
  })};
  contest.afterwards = [=, work = contest.work](Tables& tables) {
    const auto peak = record->peak();
    tables.errors.push_back({fmt::format("closing peak memory T{} (GiB)", kThreads),
                             work,
                             peak ? std::optional(*peak / kGibibyte) : std::nullopt,
                             "",
                             {},
                             {},
                             scope.goal(kGibibytes)});
  };
  return contest;
}

/// A series over grids of the sides `resolutions`, all holding one ball.
template <class Call>
void add_ball_series(std::vector<Contest>& contests, const std::string& stage, const std::string& setting,
                     const std::vector<std::int64_t>& resolutions, const Call& call) {
  std::vector<GrowthPoint> points;
  for (const std::int64_t side : resolutions) {
    const Lazy<BinaryVolume> ball([=] { return thresholded(bumpy_ball_density(side), 0.5F); });
    points.push_back({fmt::format("by grid: {}^3{}", side, setting), std::pow(static_cast<double>(side), 3),
                      prepared_call(ball, kThreads, call)});
  }
  std::ranges::move(growth_contests(stage, "voxel", kThreads, std::move(points)), std::back_inserter(contests));
}

void add_ball_series(std::vector<Contest>& contests, const Scope& scope) {
  const std::vector<std::int64_t> resolutions =
      scope.quick ? std::vector<std::int64_t>{64, 128} : std::vector<std::int64_t>{128, 256};
  add_ball_series(contests, "distance transform", "", resolutions,
                  [](const BinaryVolume& volume, RunContext& context) { return squared_distance(volume, 1, context); });
  for (const double distance : {3.0, 10.0}) {
    add_ball_series(contests, "closing", fmt::format(" distance {}", distance), resolutions,
                    [=](const BinaryVolume& volume, RunContext& context) { return close(volume, distance, context); });
  }
  add_ball_series(contests, "labelling", "", resolutions, labelled);
}

}  // namespace

std::vector<Contest> morphology_contests(const Scope& scope) {
  const std::int64_t side = scope.size(512, 128);
  // Those that measure memory first: later contests find it in pieces.
  std::vector<Contest> contests{mason_contest(scope), large_closing_contest(scope)};
  const Lazy<BinaryVolume> input = scattered(side);
  contests.push_back(opening_contest(input, side, 8, scope.goal(40)));
  contests.push_back(opening_contest(input, side, scope.size(32, 16), scope.goal(10)));
  contests.push_back(opening_contest(input, side, scope.size(100, 24), scope.goal(5)));
  contests.push_back(distance_contest(side, scope.goal(5)));
  contests.push_back(labelling_contest(input, side, scope.goal(1)));
  contests.push_back(run_labelling_contest(input, side));
  std::ranges::move(opening_growth(scope), std::back_inserter(contests));
  add_ball_series(contests, scope);
  return contests;
}

}  // namespace voxcarve::bench
