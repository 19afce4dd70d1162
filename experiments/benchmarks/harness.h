// Contests on Google Benchmark: ours and its peers on one input, in interleaved rounds, then one row a pair.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/run/context.h"
#include "experiments/benchmarks/ratios.h"

namespace voxcarve::bench {

/// A result and the wall time of the call that made it; neither preparing its input nor destroying it counts.
template <class Result>
struct Timed {
  double seconds = 0;
  Result result{};
};

/// Times one call.
template <class Call>
auto timed(Call&& call) {
  const auto start = std::chrono::steady_clock::now();
  auto result = call();
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  return Timed<decltype(result)>{elapsed.count(), std::move(result)};
}

/// The input of contestants, that a filter may leave out: made when it is first asked for and shared by all copies.
/// Contestants ask for it while they prepare, never under the clock.
template <class Value>
class Lazy {
 public:
  explicit Lazy(std::function<Value()> make) : state_(std::make_shared<State>(std::move(make))) {}
  /// Lives as long as some copy of this object.
  const Value& get() const {
    if (!state_->value) state_->value.emplace(state_->make());
    return *state_->value;
  }

 private:
  struct State {
    explicit State(std::function<Value()> m) : make(std::move(m)) {}
    std::function<Value()> make;
    std::optional<Value> value;
  };
  std::shared_ptr<State> state_;
};

/// A contestant's `prepare` for call(input, context): `inspect` is shown each result after the clock has stopped.
template <class Input, class Call, class Inspect>
auto prepared_call(Lazy<Input> input, int threads, Call call, Inspect inspect) {
  return [=] {
    const Input& made = input.get();
    return [=, &made] {
      RunContext context;
      context.threads = threads;
      const auto run = timed([&] { return call(made, context); });
      inspect(run.result);
      return run.seconds;
    };
  };
}

template <class Input, class Call>
auto prepared_call(Lazy<Input> input, int threads, Call call) {
  return prepared_call(std::move(input), threads, std::move(call), [](const auto&) {});
}

/// One run; returns its seconds.
using TimedRun = std::function<double()>;

/// Ours or a peer, with a number of threads.
struct Contestant {
  std::string name;
  int threads = 1;
  /// Called once, untimed, before the first run. Empty: not built in.
  std::function<TimedRun()> prepare;
  bool once = false;   ///< in the first round only: for what takes half a minute and is not judged by it
  int iterations = 1;  ///< runs within a repetition, whose mean counts: for what takes milliseconds
  /// An untimed run before every repetition. In a virtual machine that gives free memory back to its host, touching it
  /// again costs several times what the voxelization of a large grid does, and who ran before decides who pays.
  bool warm_up = true;
};

/// A row: which contestants stand in it (indices), and what is asked of their ratio.
struct Pairing {
  std::size_t ours = 0;
  std::optional<std::size_t> peer;
  std::optional<double> goal;
  std::function<std::string()> note;  ///< called after the runs; may be empty
};

struct Tables {
  std::vector<RatioRow> ratios;
  std::vector<ErrorRow> errors;
  std::vector<PipelineRow> pipeline;
  std::vector<std::string> remarks;  ///< printed under the tables
};

/// What runs together: in every round each of its contestants once, in random order. So all meet the same moods of the
/// machine, which may last for less than a contest.
struct Contest {
  std::string stage;
  std::string work;
  std::vector<Contestant> contestants;
  std::vector<Pairing> rows;
  std::function<void(Tables&)> afterwards;  ///< called when some contestant has run; may be empty
};

/// What every file of contests is asked for.
struct Scope {
  bool quick = false;  ///< small sizes, for a smoke run; goals are of the full sizes and left out
  /// `size`, or `small` for a smoke run.
  std::int64_t size(std::int64_t full, std::int64_t small) const { return quick ? small : full; }
  std::optional<double> goal(double ratio) const { return quick ? std::nullopt : std::optional(ratio); }
};

/// "1.0M", "100k", "9998".
std::string short_count(double count);

/// Runs contests one after another and collects their tables.
class Harness {
 public:
  explicit Harness(int rounds);
  ~Harness();
  Harness(const Harness&) = delete;
  Harness& operator=(const Harness&) = delete;

  /// Runs those contestants that the benchmark filter lets through; each run is printed and logged as it ends.
  /// Benchmarks are called "STAGE/WORK/CONTESTANT/T1".
  void run(const Contest& contest);

  const Tables& tables() const { return tables_; }
  /// Every repetition in the order it was run: sequence,benchmark,seconds.
  const Table& repetitions() const { return repetitions_; }
  /// What Google Benchmark complained of last, when nothing matched the filter.
  std::string complaint() const;
  std::size_t matched() const { return matched_; }
  /// Whether some run ended with an error.
  bool failed() const;

 private:
  class Reporter;
  /// One repetition of every contestant that the filter lets through; false when nothing ran.
  bool run_round(const Contest& contest, std::vector<TimedRun>& prepared, int round);

  int rounds_;
  std::unique_ptr<Reporter> reporter_;
  Tables tables_;
  Table repetitions_{{"sequence", "benchmark", "seconds"}, {}};
  std::size_t matched_ = 0;
};

}  // namespace voxcarve::bench
