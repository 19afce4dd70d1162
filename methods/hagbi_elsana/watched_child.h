// A forked child of this process that computes something which may crash, hang or exhaust memory, and the pipe on which
// it answers. Linux and glibc.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

#include "common/run/context.h"

namespace voxcarve {

/// Limits of a child, both positive.
struct ChildLimits {
  double seconds = 0;       ///< elapsed since `start`
  std::uint64_t bytes = 0;  ///< resident, beyond what it shared with this process when it was made
  std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
};

/// Why a child gave no answer.
enum class ChildEnd { kCrashed, kTimeLimit, kMemoryLimit };

/// Thrown by WatchedChild; `signal` is what a crashed child died of, 0 where it is not known.
struct ChildFailure {
  ChildEnd end = ChildEnd::kCrashed;
  int signal = 0;
};

/// In the child: says `bytes` bytes to the parent. Ends the child when the parent does not listen any more.
void send_to_parent(int pipe, const void* data, std::size_t bytes);

/// In the child: its resident memory at its peak in bytes, with what it shares, by the system's count.
std::uint64_t peak_resident_bytes();

/// A child that is watched while it is listened to, and that is gone, killed if need be, when this object is.
///
/// The system sends SIGCHLD for it. A program that ignores that signal, or reaps children that it does not know, takes
/// away the reason of a crash and nothing else.
class WatchedChild {
 public:
  /// Calls body(pipe) in a child: without output, without signal handlers, and with its own copy of all memory. The
  /// child ends when the body returns; no destructor of the parent's objects and no exit handler runs in it.
  ///
  /// A child of a process with several threads has but the thread that forked. That is safe with glibc, whose fork()
  /// hands over allocator and stdio in a usable state whatever other threads were doing, as long as the body takes no
  /// other lock that a thread of the parent might have held: it must not use oneTBB, CGAL, the context, or anything
  /// that makes static objects at its first use.
  ///
  /// Throws ResourceError when the system gives no child.
  WatchedChild(const ChildLimits& limits, Stage& stage, const std::function<void(int pipe)>& body);
  ~WatchedChild();
  WatchedChild(const WatchedChild&) = delete;
  WatchedChild& operator=(const WatchedChild&) = delete;

  /// Waits for exactly `bytes` bytes of the child's. Throws ChildFailure when it ends before or exceeds a limit, and
  /// Cancelled; looks about fifty times a second.
  void receive(void* data, std::size_t bytes);

  /// Takes note of a peak that the child itself reported. Throws ChildFailure when that exceeds the limit.
  void note_peak(std::uint64_t resident_bytes);

  /// The most memory seen so far, in bytes, beyond what was shared.
  std::uint64_t peak_bytes() const { return peak_; }

 private:
  bool running();
  void watch();
  void stop();
  [[noreturn]] void throw_crashed();

  ChildLimits limits_;
  Stage& stage_;
  pid_t process_ = -1;
  int pipe_ = -1;
  int status_ = 0;
  bool ended_ = false;
  std::uint64_t shared_ = 0;
  std::uint64_t peak_ = 0;
  std::chrono::steady_clock::time_point looked_{};
};

}  // namespace voxcarve
