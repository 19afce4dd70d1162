#include "experiments/cli/session.h"

#include <fmt/format.h>
#include <pthread.h>
#include <unistd.h>
#include <filesystem>

#include <CLI/CLI.hpp>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "common/run/errors.h"
#include "common/run/text.h"
#include "experiments/cli/checks.h"

namespace voxcarve {

namespace {

/// The stop source of the session that runs, for the thread that waits for signals.
std::mutex g_session_mutex;
std::stop_source* g_session_stop = nullptr;

std::string rate_text(double per_second) {
  if (per_second >= 1e6) return fmt::format("{:.1f}M/s", per_second / 1e6);
  if (per_second >= 1e3) return fmt::format("{:.1f}k/s", per_second / 1e3);
  return fmt::format("{:.0f}/s", per_second);
}

}  // namespace

std::string version() {
  return VOXCARVE_VERSION;
}

void handle_interrupts() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);  // every thread started later inherits this
  std::thread([signals] {
    // A shell or a job control may send the same request to a process and to its group: what comes within this time of
    // the first signal is taken for the same request.
    constexpr auto kSameRequest = std::chrono::milliseconds(300);
    std::optional<std::chrono::steady_clock::time_point> first;
    for (;;) {
      int signal = 0;
      sigwait(&signals, &signal);
      const auto now = std::chrono::steady_clock::now();
      const std::scoped_lock lock(g_session_mutex);
      if (g_session_stop == nullptr || (first && now - *first > kSameRequest))
        _exit(static_cast<int>(ExitCode::kCancelled));
      if (!first) first = now;
      g_session_stop->request_stop();
    }
  }).detach();
}

/// One line on stderr: stage, share, rate and time left. Draws only on a terminal, at most ten times a second.
class Session::ProgressBar {
 public:
  ProgressBar() : enabled_(isatty(STDERR_FILENO) != 0) {}
  ~ProgressBar() { clear(); }

  void announce(const std::string& what) { what_ = what; }

  void update(const ProgressEvent& event) {
    if (!enabled_) return;
    const auto now = std::chrono::steady_clock::now();
    if (event.stage != stage_ || event.done == 0) {
      stage_ = event.stage;
      stage_start_ = now;
    }
    if (event.done >= event.total) {
      clear();
      return;
    }
    if (now - last_drawn_ < std::chrono::milliseconds(100)) return;
    last_drawn_ = now;
    const double elapsed = std::chrono::duration<double>(now - stage_start_).count();
    const double share = event.total > 0 ? static_cast<double>(event.done) / static_cast<double>(event.total) : 0;
    const std::string left = share > 0.01 ? fmt::format("{:.0f} s left", elapsed / share * (1 - share)) : "";
    constexpr int kWidth = 30;
    const int filled = static_cast<int>(share * kWidth);
    fmt::print(stderr, "\r\033[K{}{} [{}{}] {:3.0f} % {} {}", what_.empty() ? "" : what_ + ": ", stage_,
               std::string(static_cast<std::size_t>(filled), '#'),
               std::string(static_cast<std::size_t>(kWidth - filled), ' '), 100 * share,
               elapsed > 0 ? rate_text(static_cast<double>(event.done) / elapsed) : "", left);
    std::fflush(stderr);
    drawn_ = true;
  }

 private:
  void clear() {
    if (drawn_) fmt::print(stderr, "\r\033[K");
    drawn_ = false;
  }

  bool enabled_;
  bool drawn_ = false;
  std::string what_;
  std::string stage_;
  std::chrono::steady_clock::time_point stage_start_;
  std::chrono::steady_clock::time_point last_drawn_;
};

Session::Session(const CommonOptions& options) : options_(options), bar_(std::make_unique<ProgressBar>()) {
  context_.threads =
      options.threads > 0 ? options.threads : static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  context_.seed = options.seed;
  if (options.memory_gib > 0)
    context_.memory_budget = static_cast<std::uint64_t>(options.memory_gib * 1024 * 1024 * 1024);
  context_.cancellation = stop_.get_token();
  context_.progress = [bar = bar_.get()](const ProgressEvent& event) { bar->update(event); };
  const std::scoped_lock lock(g_session_mutex);
  g_session_stop = &stop_;
}

Session::~Session() {
  const std::scoped_lock lock(g_session_mutex);
  g_session_stop = nullptr;
}

ModelSourceOptions Session::source_options() const {
  ModelSourceOptions source;
  source.data_folder = options_.data;
  if (options_.has_iso_value) source.iso_value = options_.iso_value;
  return source;
}

std::string Session::data_folder() const {
  return voxcarve::data_folder(source_options()).string();
}

Model Session::open(const std::string& input) {
  std::vector<std::string> notices;
  Model model = open_model(input, source_options(), notices);
  print_notices(notices);
  return model;
}

void Session::print_notices(const std::vector<std::string>& notices) const {
  if (options_.json) return;
  for (const std::string& notice : notices) fmt::print(stderr, "note: {}\n", notice);
}

void Session::print_timings(const std::vector<StageTiming>& timings) const {
  if (!options_.verbose) return;
  for (const StageTiming& timing : timings) {
    fmt::print(stderr, "{:>28}  {:8.3f} s  {:>12} items  {}\n", timing.stage, timing.seconds, timing.items,
               format_bytes(timing.bytes));
  }
}

void Session::announce(const std::string& what) {
  bar_->announce(what);
}

void add_common_options(CLI::App& command, CommonOptions& options) {
  command.add_flag("--json", options.json, "print JSON instead of text");
  command.add_option("-j,--threads", options.threads, "threads (default: as many as the machine has)")
      ->check(in_range(1, 1024));
  command.add_option("--seed", options.seed, "seed of everything that samples (default 0)")
      ->check(in_range(0, 9007199254740992));
  command.add_option("--memory", options.memory_gib, "memory budget in GiB (default: 80 % of the machine's)")
      ->check(in_range(1e-6, 1e6));
  command.add_option("--data", options.data, "folder of the external models (default: the variable VOXCARVE_DATA)");
  command
      .add_option_function<double>(
          "--iso",
          [&options](double value) {
            options.iso_value = value;
            options.has_iso_value = true;
          },
          "iso-value of a scalar volume, threshold of a grey image (default: the middle of its values)")
      ->check(in_range(-3e38, 3e38));
  command.add_flag("-v,--verbose", options.verbose, "print the time of every stage");
}

std::string json_text(const nlohmann::ordered_json& json) {
  // A file name need not be UTF-8: what is not becomes the replacement character.
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

void print_json(const nlohmann::ordered_json& json) {
  fmt::print("{}\n", json_text(json));
}

void require_folder(const std::string& file) {
  if (file.empty()) return;
  const std::filesystem::path folder = std::filesystem::absolute(file).parent_path();
  if (!std::filesystem::is_directory(folder))
    throw ResourceError("cannot write " + file + ": there is no folder " + folder.string());
}

}  // namespace voxcarve
