#include "experiments/benchmarks/harness.h"

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <iostream>
#include <map>
#include <sstream>

namespace voxcarve::bench {

namespace {

/// No spaces, colons and carets, so that a filter can be typed.
std::string benchmark_name(const Contest& contest, const Contestant& contestant) {
  std::string name = contest.stage + "/" + contest.work + "/" + contestant.name;
  std::string plain;
  for (const char c : name) {
    if (c == ' ') {
      plain += '-';
    } else if (c != ':') {
      plain += c;
    }
  }
  for (std::size_t at = plain.find("^3"); at != std::string::npos; at = plain.find("^3")) plain.erase(at, 2);
  return plain + "/T" + std::to_string(contestant.threads);
}

}  // namespace

std::string short_count(double count) {
  if (count >= 1e6) return fmt::format("{:.1f}M", count * 1e-6);
  if (count >= 1e4) return fmt::format("{:.0f}k", count * 1e-3);
  return fmt::format("{:.0f}", count);
}

/// Collects the seconds of the repetitions by benchmark; what contests print themselves need not be printed again.
class Harness::Reporter final : public benchmark::BenchmarkReporter {
 public:
  Reporter() {
    SetErrorStream(&complaints);  // "failed to match any benchmarks": of one contest, that is no fault
  }

  bool ReportContext(const Context& context) override {
    if (!context_printed_) PrintBasicContext(&std::cout, context);
    context_printed_ = true;
    return true;
  }

  void ReportRuns(const std::vector<Run>& runs) override {
    for (const Run& run : runs) {
      if (run.run_type != Run::RT_Iteration) continue;
      if (run.error_occurred) {
        std::cout << run.run_name.function_name << ": failed: " << run.error_message << "\n";
        failed = true;
      } else {
        seconds[run.run_name.function_name].push_back(run.real_accumulated_time / static_cast<double>(run.iterations));
      }
    }
  }

  std::map<std::string, std::vector<double>> seconds;
  std::ostringstream complaints;
  bool failed = false;

 private:
  bool context_printed_ = false;
};

Harness::Harness(int rounds) : rounds_(rounds), reporter_(std::make_unique<Reporter>()) {}

Harness::~Harness() = default;

std::string Harness::complaint() const {
  const std::string text = reporter_->complaints.str();
  return text.substr(0, text.find('\n'));
}

bool Harness::failed() const {
  return reporter_->failed;
}

bool Harness::run_round(const Contest& contest, std::vector<TimedRun>& prepared, int round) {
  for (std::size_t c = 0; c < contest.contestants.size(); ++c) {
    const Contestant& contestant = contest.contestants[c];
    if (!contestant.prepare || (contestant.once && round > 0)) continue;
    const std::string name = benchmark_name(contest, contestant);
    const auto repetition = [&, c, name](benchmark::State& state) {
      try {
        if (!prepared[c]) prepared[c] = contestant.prepare();
        if (contestant.warm_up) prepared[c]();
        double total = 0;
        for (auto _ : state) {
          const double seconds = prepared[c]();
          state.SetIterationTime(seconds);
          total += seconds;
        }
        const std::string mean = rounded(total / static_cast<double>(state.iterations()), 6);
        const std::string sequence = std::to_string(repetitions_.rows.size() + 1);
        std::cout << fmt::format("{:>4}  {}  {} s", sequence, name, mean) << std::endl;
        repetitions_.rows.push_back({sequence, name, mean});
      } catch (const std::exception& error) {
        state.SkipWithError(error.what());
      }
    };
    benchmark::RegisterBenchmark(name.c_str(), repetition)
        ->UseManualTime()
        ->Unit(benchmark::kSecond)
        ->Iterations(contestant.iterations);
  }
  const std::size_t matched = benchmark::RunSpecifiedBenchmarks(reporter_.get());
  benchmark::ClearRegisteredBenchmarks();
  matched_ += matched;
  return matched > 0 && !reporter_->seconds.empty();
}

void Harness::run(const Contest& contest) {
  std::vector<TimedRun> prepared(contest.contestants.size());
  reporter_->seconds.clear();
  reporter_->complaints.str("");
  for (int round = 0; round < rounds_; ++round) {
    if (!run_round(contest, prepared, round)) break;  // filtered out, or only listed
  }
  if (reporter_->seconds.empty()) return;

  const auto seconds_of = [&](std::size_t index) {
    return reporter_->seconds[benchmark_name(contest, contest.contestants[index])];
  };
  for (const Pairing& pairing : contest.rows) {
    RatioRow row;
    row.stage = contest.stage;
    row.work = contest.work;
    row.threads = contest.contestants[pairing.ours].threads;
    row.ours_seconds = seconds_of(pairing.ours);
    row.goal = pairing.goal;
    if (pairing.peer) {
      const Contestant& peer = contest.contestants[*pairing.peer];
      row.peer = peer.name;
      row.peer_present = static_cast<bool>(peer.prepare);
      row.peer_seconds = seconds_of(*pairing.peer);
    }
    if (row.ours_seconds.empty() && row.peer_seconds.empty()) continue;
    if (pairing.note) row.note = pairing.note();
    tables_.ratios.push_back(std::move(row));
  }
  if (contest.afterwards) contest.afterwards(tables_);
}

}  // namespace voxcarve::bench
