// Buffers that pieces of a parallel loop hand on to one another.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "common/run/context.h"

namespace voxcarve {

/// Workspaces of type T, at most one a thread at once: a piece of work takes one and gives it back as it wants the next
/// one to find it. What is not given back, because of an exception, is freed.
template <class T>
class WorkspacePool {
 public:
  /// One that was given back, or make().
  template <class Make>
  std::unique_ptr<T> take(const Make& make) {
    {
      const std::scoped_lock lock(mutex_);
      if (!idle_.empty()) {
        std::unique_ptr<T> workspace = std::move(idle_.back());
        idle_.pop_back();
        return workspace;
      }
    }
    return std::make_unique<T>(make());
  }
  void give(std::unique_ptr<T> workspace) {
    const std::scoped_lock lock(mutex_);
    idle_.push_back(std::move(workspace));
  }

 private:
  std::mutex mutex_;
  std::vector<std::unique_ptr<T>> idle_;
};

/// How many workspaces a loop over `pieces` holds at most.
inline std::uint64_t workspaces_at_once(const RunContext& context, std::int64_t pieces) {
  const auto cores = static_cast<std::int64_t>(std::max(1U, std::thread::hardware_concurrency()));
  const std::int64_t threads = std::min<std::int64_t>(std::max(context.threads, 1), cores);
  return static_cast<std::uint64_t>(std::min(threads, pieces));
}

}  // namespace voxcarve
