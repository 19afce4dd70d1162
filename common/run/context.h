// What a run is given and what it reports: threads, seed, progress, cancellation, a memory budget, stage timings and
// notices. Nothing here depends on meshes or volumes.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <mutex>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

namespace voxcarve {

/// One report of progress. Within a stage `done` never decreases and never exceeds `total`; a stage that ends without
/// an error reports done == total.
struct ProgressEvent {
  std::string_view stage;
  std::int64_t done = 0;
  std::int64_t total = 0;
};

using ProgressSink = std::function<void(const ProgressEvent&)>;

/// What one stage of a method cost.
struct StageTiming {
  std::string stage;  ///< "NAME (failed)" of one that an error ended: a run that went another way paid for it too
  double seconds = 0;
  std::int64_t items = 0;   ///< voxels, triangles, ...: what the stage counts its progress in; of a failed one, so far
  std::uint64_t bytes = 0;  ///< memory that the stage asked for at its peak, as declared with `require_memory`
};

/// Physical memory of this machine in bytes times 0.8; the default budget of a run.
std::uint64_t default_memory_budget();

/// Everything a run needs beside its model and parameters. Not copyable: stages report into it. A context serves one
/// run at a time.
class RunContext {
 public:
  int threads = 1;
  std::uint64_t seed = 0;
  std::uint64_t memory_budget = default_memory_budget();  ///< bytes
  ProgressSink progress;                                  ///< may be empty; calls are serialised
  std::stop_token cancellation;
  bool surfaces = true;  ///< false: the caller takes volumes only, and surfaces may be left out of the result

  RunContext() = default;
  RunContext(const RunContext&) = delete;
  RunContext& operator=(const RunContext&) = delete;

  /// Throws Cancelled when a stop was requested. Long loops call it at least every tenth of a second.
  void check_cancelled() const;

  /// Declares that `bytes` are about to be held at once by `what`. Throws ResourceError, before anything is allocated,
  /// when that exceeds the budget.
  void require_memory(std::uint64_t bytes, std::string_view what);

  /// Records a remark for the user, such as "3 facets intersected and were resolved".
  void notice(std::string text);

  const std::vector<StageTiming>& timings() const { return timings_; }
  const std::vector<std::string>& notices() const { return notices_; }
  /// Forgets timings and notices; called when a new run starts.
  void clear_log();

 private:
  friend class Stage;
  void report(const ProgressEvent& event);

  std::mutex mutex_;
  std::vector<StageTiming> timings_;
  std::vector<std::string> notices_;
  std::uint64_t stage_bytes_ = 0;
};

/// A timed stage of a run: reports progress while it lives and its timing when it ends, be it by an exception.
///
///     Stage stage(context, "distance transform", voxels);
///     stage.advance(row);   // from any thread
class Stage {
 public:
  Stage(RunContext& context, std::string name, std::int64_t total);
  ~Stage();
  Stage(const Stage&) = delete;
  Stage& operator=(const Stage&) = delete;

  /// Adds to the number of items done and checks for cancellation (throws Cancelled).
  void advance(std::int64_t items);
  /// Replaces the total once it is known better; progress never falls.
  void set_total(std::int64_t total);

 private:
  RunContext& context_;
  std::string name_;
  std::int64_t total_;
  std::int64_t done_ = 0;
  std::int64_t reported_ = -1;
  int exceptions_;
  std::mutex mutex_;
  std::chrono::steady_clock::time_point start_;
};

/// Calls body(first, last) over consecutive chunks of [begin, end), at most `grain` long, on `context.threads` threads.
/// The chunks are the same for every number of threads, so a body that writes only to its own chunk gives the same
/// bytes on one thread and on many. Exceptions of the body reach the caller; cancellation is checked at every chunk.
void parallel_for(const RunContext& context, std::int64_t begin, std::int64_t end, std::int64_t grain,
                  const std::function<void(std::int64_t, std::int64_t)>& body);

}  // namespace voxcarve
