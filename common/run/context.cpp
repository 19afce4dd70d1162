#include "common/run/context.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#include <unistd.h>

#include <algorithm>
#include <exception>
#include <thread>

#include "common/run/errors.h"
#include "common/run/text.h"

namespace voxcarve {

std::uint64_t default_memory_budget() {
  const long pages = sysconf(_SC_PHYS_PAGES);
  const long page_size = sysconf(_SC_PAGE_SIZE);
  constexpr std::uint64_t kFallback = std::uint64_t{4} << 30;
  if (pages <= 0 || page_size <= 0) return kFallback;
  return static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(page_size) / 5 * 4;
}

void RunContext::check_cancelled() const {
  if (cancellation.stop_requested()) throw Cancelled();
}

void RunContext::require_memory(std::uint64_t bytes, std::string_view what) {
  if (bytes > memory_budget) {
    throw ResourceError(std::string(what) + " needs " + format_bytes(bytes) + ", more than the memory budget of " +
                        format_bytes(memory_budget) + "; lower the resolution or raise --memory");
  }
  const std::scoped_lock lock(mutex_);
  stage_bytes_ = std::max(stage_bytes_, bytes);
}

void RunContext::notice(std::string text) {
  const std::scoped_lock lock(mutex_);
  notices_.push_back(std::move(text));
}

void RunContext::clear_log() {
  timings_.clear();
  notices_.clear();
  stage_bytes_ = 0;
}

void RunContext::report(const ProgressEvent& event) {
  if (!progress) return;
  const std::scoped_lock lock(mutex_);
  progress(event);
}

Stage::Stage(RunContext& context, std::string name, std::int64_t total)
    : context_(context),
      name_(std::move(name)),
      total_(std::max<std::int64_t>(total, 0)),
      exceptions_(std::uncaught_exceptions()),
      start_(std::chrono::steady_clock::now()) {
  context_.check_cancelled();
  context_.stage_bytes_ = 0;
  reported_ = 0;
  context_.report({name_, 0, total_});
}

Stage::~Stage() {
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  const bool failed = std::uncaught_exceptions() > exceptions_;
  try {
    context_.timings_.push_back(
        {name_ + (failed ? " (failed)" : ""), seconds, failed ? done_ : total_, context_.stage_bytes_});
    if (!failed) context_.report({name_, total_, total_});
  } catch (...) {  // a progress sink must not turn the end of a stage into the end of the program
  }
}

void Stage::advance(std::int64_t items) {
  context_.check_cancelled();
  const std::scoped_lock lock(mutex_);
  done_ = std::min(done_ + items, total_);
  // At most about a thousand reports a stage, so that a sink may be slow.
  if (done_ - reported_ < std::max<std::int64_t>(total_ / 1024, 1)) return;
  reported_ = done_;
  context_.report({name_, done_, total_});
}

void Stage::set_total(std::int64_t total) {
  const std::scoped_lock lock(mutex_);
  total_ = std::max(total, done_);
}

void parallel_for(const RunContext& context, std::int64_t begin, std::int64_t end, std::int64_t grain,
                  const std::function<void(std::int64_t, std::int64_t)>& body) {
  if (begin >= end) return;
  grain = std::max<std::int64_t>(grain, 1);
  const std::int64_t chunks = (end - begin + grain - 1) / grain;
  const auto run_chunk = [&](std::int64_t chunk) {
    context.check_cancelled();
    const std::int64_t first = begin + chunk * grain;
    body(first, std::min(first + grain, end));
  };
  if (context.threads <= 1 || chunks == 1) {
    for (std::int64_t chunk = 0; chunk < chunks; ++chunk) run_chunk(chunk);
    return;
  }
  // More threads than cores would only make the scheduler complain; the result does not depend on their number.
  const int cores = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  tbb::task_arena arena(std::min(context.threads, cores));
  arena.execute([&] { tbb::parallel_for(std::int64_t{0}, chunks, run_chunk); });
}

}  // namespace voxcarve
