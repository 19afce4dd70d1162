#include "experiments/benchmarks/peak_memory.h"

#include <fstream>
#include <string>
#include <string_view>

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace voxcarve::bench {

namespace {

/// A line "NAME:   1234 kB" of /proc/self/status, in bytes.
std::optional<std::uint64_t> status_bytes(std::string_view name) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with(name)) return 1024 * std::stoull(line.substr(name.size()));
  }
  return std::nullopt;
}

}  // namespace

PeakMemory::PeakMemory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
  // "5" sets the peak resident size to the present one.
  std::ofstream clear("/proc/self/clear_refs");
  clear << "5" << std::flush;
  reset_ = clear.good();
  start_ = status_bytes("VmRSS:");
}

std::optional<std::uint64_t> PeakMemory::growth() const {
  const auto peak = status_bytes("VmHWM:");
  if (!reset_ || !start_ || !peak || *peak < *start_) return std::nullopt;
  return *peak - *start_;
}

}  // namespace voxcarve::bench
