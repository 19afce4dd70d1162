// The benchmark program: runs the contests, prints their tables and leaves them as CSV.
//
//     voxcarve_benchmarks [--quick] [--results=FOLDER] [--benchmark_filter=REGEX ...]
//
// Tables of a whole run are ratios.csv, errors.csv, pipeline.csv and repetitions.csv in FOLDER (build/bench). A
// filtered run writes ratios-partial.csv and so on, a quick one ratios-quick.csv: neither replaces what a whole run
// found.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <charconv>
#include <chrono>
#include <filesystem>
#include <iostream>

#include "common/run/atomic_file.h"
#include "common/run/errors.h"
#include "experiments/benchmarks/contests.h"
#include "experiments/benchmarks/peers.h"

namespace voxcarve::bench {
namespace {

struct Arguments {
  bool quick = false;
  int rounds = 0;
  std::filesystem::path results = "build/bench";
  std::vector<std::string> to_google_benchmark;
};

/// Ours and the number of repetitions are taken out; the rest goes to Google Benchmark.
Arguments parse(int argc, char** argv) {
  constexpr std::string_view kResults = "--results=";
  Arguments arguments;
  constexpr std::string_view kRepetitions = "--benchmark_repetitions=";
  constexpr int kQuickRounds = 2;
  // A round is one repetition of each contestant; Google Benchmark shuffles these.
  arguments.to_google_benchmark = {argv[0], "--benchmark_enable_random_interleaving=true"};
  for (int i = 1; i < argc; ++i) {
    const std::string_view argument = argv[i];
    if (argument == "--quick") {
      arguments.quick = true;
    } else if (argument.starts_with(kResults)) {
      arguments.results = argument.substr(kResults.size());
    } else if (argument.starts_with(kRepetitions)) {
      const auto rounds = argument.substr(kRepetitions.size());
      const auto parsed = std::from_chars(rounds.data(), rounds.data() + rounds.size(), arguments.rounds);
      if (parsed.ec != std::errc() || parsed.ptr != rounds.data() + rounds.size() || arguments.rounds < 1)
        throw ParameterError(std::string(argument) + " is no number of repetitions");
    } else if (argument.starts_with("--benchmark_out")) {
      throw ParameterError("--benchmark_out would hold the last contest only; every repetition is in repetitions.csv");
    } else {
      arguments.to_google_benchmark.emplace_back(argument);
    }
  }
  if (arguments.rounds == 0) arguments.rounds = arguments.quick ? kQuickRounds : static_cast<int>(kFewestRuns);
  return arguments;
}

/// False when some argument was not understood, which Google Benchmark has said then.
bool initialize(std::vector<std::string> arguments) {
  std::vector<char*> pointers;
  for (std::string& argument : arguments) pointers.push_back(argument.data());
  int count = static_cast<int>(pointers.size());
  benchmark::Initialize(&count, pointers.data());
  return !benchmark::ReportUnrecognizedArguments(count, pointers.data());
}

bool is_filtered() {
  const std::string filter = benchmark::GetBenchmarkFilter();
  return !filter.empty() && filter != "all" && filter != ".";
}

void write_tables(const Harness& harness, const std::filesystem::path& folder, const std::string& suffix) {
  const Tables& tables = harness.tables();
  std::filesystem::create_directories(folder);
  const auto write = [&](const char* name, const Table& table) {
    if (table.rows.empty()) return;
    const std::filesystem::path path = folder / (name + suffix + ".csv");
    write_file_atomically(path, to_csv(table));
    std::cout << "wrote " << path.string() << "\n";
  };
  write("ratios", ratio_csv(tables.ratios));
  write("errors", error_csv(tables.errors));
  write("pipeline", pipeline_csv(tables.pipeline));
  write("repetitions", harness.repetitions());
}

void print_tables(const Tables& tables) {
  std::cout << "\n" << to_text(ratio_summary(tables.ratios));
  if (!tables.errors.empty()) std::cout << "\n" << to_text(error_csv(tables.errors));
  if (!tables.pipeline.empty()) std::cout << "\n" << to_text(pipeline_csv(tables.pipeline));
  if (!tables.remarks.empty()) std::cout << "\n";
  for (const std::string& remark : tables.remarks) std::cout << remark << "\n";
  std::size_t goals = 0;
  std::size_t met = 0;
  const auto count = [&](const std::string& verdict) {
    goals += verdict.empty() ? 0 : 1;
    met += verdict == "yes" ? 1 : 0;
  };
  for (const RatioRow& row : tables.ratios) count(row.met());
  for (const ErrorRow& row : tables.errors) count(row.met());
  std::cout << "\ntimes are medians, ratio = peer / ours";
  if (goals > 0) std::cout << fmt::format("; {} of {} goals met", met, goals);
  std::cout << "\n";
}

int run(int argc, char** argv) {
  const auto start = std::chrono::steady_clock::now();
  const Arguments arguments = parse(argc, argv);
  if (!initialize(arguments.to_google_benchmark)) return static_cast<int>(ExitCode::kUsage);
  const Scope scope{arguments.quick};
  std::vector<Contest> contests;
  // The pipeline and morphology first: they measure memory, which no earlier contest should have fragmented.
  for (const auto list : {pipeline_contests, morphology_contests, voxelization_contests, isosurface_contests,
                          filter_contests, low_pass_contests, reduction_contests, carving_contests, other_contests})
    std::ranges::move(list(scope), std::back_inserter(contests));
  Harness harness(arguments.rounds);
  for (Contest& contest : contests) {
    harness.run(contest);
    contest = {};  // and with it its input
  }
  if (harness.matched() == 0) {
    std::cerr << "voxcarve_benchmarks: " << harness.complaint() << "\n";
    return static_cast<int>(ExitCode::kUsage);
  }
  if (harness.tables().ratios.empty())
    return static_cast<int>(harness.failed() ? ExitCode::kMethod : ExitCode::kSuccess);
  print_tables(harness.tables());
  write_tables(harness, arguments.results, arguments.quick ? "-quick" : is_filtered() ? "-partial" : "");
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  std::cout << fmt::format("{:.0f} s in all\n", elapsed.count());
  return static_cast<int>(harness.failed() ? ExitCode::kMethod : ExitCode::kSuccess);
}

}  // namespace
}  // namespace voxcarve::bench

int main(int argc, char** argv) {
  try {
    return voxcarve::bench::run(argc, argv);
  } catch (const voxcarve::Error& error) {
    std::cerr << "voxcarve_benchmarks: " << error.what() << "\n";
    return static_cast<int>(error.exit_code());
  } catch (const std::exception& error) {
    std::cerr << "voxcarve_benchmarks: " << error.what() << "\n";
    return 1;
  }
}
