#include "methods/hagbi_elsana/watched_child.h"

#include <fcntl.h>
#include <malloc.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <system_error>

#include "common/run/address_sanitizer.h"
#include "common/run/errors.h"

namespace voxcarve {

namespace {

using Clock = std::chrono::steady_clock;

constexpr int kPollMilliseconds = 20;
constexpr std::size_t kMostAtOnce = std::size_t{1} << 20;

std::string error_text() {
  return std::generic_category().message(errno);
}

/// Pages of a process: all of its addresses, and those in memory. Zeros when it is gone.
struct Pages {
  std::uint64_t addresses = 0;
  std::uint64_t resident = 0;
};

/// `process` is a number or "self". Without stdio and without allocation.
Pages read_pages(const char* process) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "/proc/%s/statm", process);
  const int file = open(text.data(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return {};
  text.fill('\0');
  const ssize_t size = read(file, text.data(), text.size() - 1);
  close(file);
  Pages pages;
  if (size > 0) {
    char* rest = nullptr;
    pages.addresses = std::strtoull(text.data(), &rest, 10);
    pages.resident = std::strtoull(rest, nullptr, 10);
  }
  return pages;
}

std::uint64_t page_size() {
  return static_cast<std::uint64_t>(sysconf(_SC_PAGE_SIZE));
}

/// Leaves the child with nothing of the parent's that it could disturb: no handler, no output, no terminal.
void detach(pid_t parent, std::uint64_t limit) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);   // when the thread that forked ends, which waits for us
  if (getppid() != parent) _exit(1);  // it ended before the line above
  for (int number = 1; number < NSIG; ++number) std::signal(number, SIG_DFL);
  // What a terminal or a shutdown sends to all of a group is the parent's business: it cancels, and then kills us.
  for (const int number : {SIGHUP, SIGINT, SIGQUIT, SIGTERM}) std::signal(number, SIG_IGN);
  const int null = open("/dev/null", O_RDWR | O_CLOEXEC);
  if (null < 0) _exit(1);
  dup2(null, STDOUT_FILENO);
  dup2(null, STDERR_FILENO);
  const rlimit no_core = {0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  if constexpr (kAddressSanitizer) return;  // its shadow takes up most addresses
  // Only for a leap that the parent, which looks every few milliseconds, would notice too late: addresses are not
  // memory, and the allocator reserves up to 128 MiB of them at once.
  constexpr std::uint64_t kSlack = std::uint64_t{256} << 20;
  const std::uint64_t addresses = read_pages("self").addresses * page_size();
  rlimit all{};
  if (addresses > 0 && getrlimit(RLIMIT_AS, &all) == 0 && limit < RLIM_INFINITY - addresses - kSlack) {
    all.rlim_cur = std::min<rlim_t>(all.rlim_cur, addresses + limit + kSlack);
    setrlimit(RLIMIT_AS, &all);
  }
}

/// Makes what the child takes from now on count as its own, and returns what it shares, in bytes. Pages of the parent's
/// free heap would otherwise be written to without a trace in the resident size.
std::uint64_t settle_memory() {
  malloc_trim(0);
  const int file = open("/proc/self/clear_refs", O_WRONLY | O_CLOEXEC);
  if (file >= 0) {
    [[maybe_unused]] const ssize_t written = write(file, "5", 1);  // forget the peak; where it cannot, it stays shared
    close(file);
  }
  return peak_resident_bytes();
}

}  // namespace

void send_to_parent(int pipe, const void* data, std::size_t bytes) {
  const char* next = static_cast<const char*>(data);
  while (bytes > 0) {
    const ssize_t sent = write(pipe, next, bytes);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) _exit(1);
    next += sent;
    bytes -= static_cast<std::size_t>(sent);
  }
}

std::uint64_t peak_resident_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

WatchedChild::WatchedChild(const ChildLimits& limits, Stage& stage, const std::function<void(int pipe)>& body)
    : limits_(limits), stage_(stage) {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) throw ResourceError("no pipe to a child process: " + error_text());
  pipe_ = ends[0];
  const pid_t parent = getpid();
  // The parent's handlers must never run in the child, where they would act on what the two share.
  sigset_t all;
  sigset_t before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  process_ = fork();
  if (process_ == 0) {
    close(ends[0]);
    const int pipe = fcntl(ends[1], F_DUPFD_CLOEXEC, STDERR_FILENO + 1);  // clear of what becomes /dev/null
    if (pipe < 0) _exit(1);
    detach(parent, limits.bytes);
    sigemptyset(&all);
    pthread_sigmask(SIG_SETMASK, &all, nullptr);
    const std::uint64_t shared = settle_memory();
    send_to_parent(pipe, &shared, sizeof shared);
    try {
      body(pipe);
    } catch (...) {  // the parent must not be run a second time
      _exit(1);
    }
    _exit(0);
  }
  const std::string reason = process_ < 0 ? error_text() : "";
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  close(ends[1]);
  if (process_ < 0) {
    close(pipe_);
    throw ResourceError("no child process: " + reason);
  }
  fcntl(pipe_, F_SETFL, O_NONBLOCK);
  try {
    receive(&shared_, sizeof shared_);
  } catch (...) {
    stop();
    throw;
  }
}

WatchedChild::~WatchedChild() {
  stop();
}

void WatchedChild::stop() {
  if (running()) {
    kill(process_, SIGKILL);
    while (waitpid(process_, nullptr, 0) < 0 && errno == EINTR) {
    }
    ended_ = true;
  }
  close(pipe_);
}

/// False once the child ended and was reaped, by us or by someone else in this program.
bool WatchedChild::running() {
  if (ended_) return false;
  const pid_t reaped = waitpid(process_, &status_, WNOHANG);
  ended_ = reaped == process_ || (reaped < 0 && errno == ECHILD);
  return !ended_;
}

void WatchedChild::receive(void* data, std::size_t bytes) {
  char* next = static_cast<char*>(data);
  while (bytes > 0) {
    const bool alive = running();  // first: what it wrote before it ended is still to be read
    const ssize_t got = read(pipe_, next, std::min(bytes, kMostAtOnce));
    if (got > 0) {
      next += got;
      bytes -= static_cast<std::size_t>(got);
    } else if (got == 0 || !alive) {
      throw_crashed();
    } else if (errno == EAGAIN) {
      pollfd waiting = {pipe_, POLLIN, 0};
      poll(&waiting, 1, kPollMilliseconds);
    } else if (errno != EINTR) {
      throw ResourceError("cannot read from a child process: " + error_text());
    }
    watch();
  }
}

void WatchedChild::note_peak(std::uint64_t resident_bytes) {
  if (resident_bytes > shared_) peak_ = std::max(peak_, resident_bytes - shared_);
  if (peak_ > limits_.bytes) throw ChildFailure{ChildEnd::kMemoryLimit, 0};
}

/// Cancellation and both limits.
void WatchedChild::watch() {
  stage_.advance(0);
  const Clock::time_point now = Clock::now();
  if (std::chrono::duration<double>(now - limits_.start).count() > limits_.seconds) {
    throw ChildFailure{ChildEnd::kTimeLimit, 0};
  }
  if (shared_ == 0 || now - looked_ < std::chrono::milliseconds(kPollMilliseconds)) return;
  looked_ = now;
  note_peak(read_pages(std::to_string(process_).c_str()).resident * page_size());
}

void WatchedChild::throw_crashed() {
  while (running()) {  // it closed its pipe, so it is about to end
    poll(nullptr, 0, 1);
    watch();
  }
  throw ChildFailure{ChildEnd::kCrashed, WIFSIGNALED(status_) ? WTERMSIG(status_) : 0};
}

}  // namespace voxcarve
