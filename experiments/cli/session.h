// What all commands share: the common options, a run context that obeys Ctrl-C, progress, notices and JSON output.
#pragma once

#include <cstdint>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <stop_token>
#include <string>
#include <vector>

#include "common/model_source.h"
#include "common/run/context.h"

namespace CLI {
class App;
}

namespace voxcarve {

/// The version of the program, as CMake's project says it.
std::string version();

/// Options that every command takes.
struct CommonOptions {
  int threads = 0;  ///< 0: as many as the machine has
  std::uint64_t seed = 0;
  double memory_gib = 0;  ///< 0: default_memory_budget()
  bool json = false;
  bool verbose = false;
  std::string data;
  double iso_value = 0;
  bool has_iso_value = false;
};

/// Adds them to a command.
void add_common_options(CLI::App& command, CommonOptions& options);

/// One run of the program.
class Session {
 public:
  explicit Session(const CommonOptions& options);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  RunContext& context() { return context_; }
  const CommonOptions& options() const { return options_; }

  /// Opens an INPUT and prints its notices.
  Model open(const std::string& input);
  /// The folder of external models.
  std::string data_folder() const;
  /// Prints "note: ..." lines on stderr, unless output is JSON.
  void print_notices(const std::vector<std::string>& notices) const;
  /// Stage timings on stderr with -v.
  void print_timings(const std::vector<StageTiming>& timings) const;
  /// Names what the progress bar is about: a method, a model.
  void announce(const std::string& what);

 private:
  class ProgressBar;
  ModelSourceOptions source_options() const;
  CommonOptions options_;
  std::unique_ptr<ProgressBar> bar_;
  std::stop_source stop_;
  RunContext context_;
};

/// From the moment of the call, the first Ctrl-C asks running sessions to stop and the second ends the program. Call
/// before any thread is started.
void handle_interrupts();

/// Throws ResourceError for a file whose folder does not exist, before a long run finds out; "" is no file.
void require_folder(const std::string& file);

/// The text of JSON, two spaces an indent.
std::string json_text(const nlohmann::ordered_json& json);

/// Prints it to stdout.
void print_json(const nlohmann::ordered_json& json);

}  // namespace voxcarve
