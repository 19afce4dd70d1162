#include "experiments/benchmarks/processor_time.h"

#if __has_include(<sys/resource.h>)
#include <sys/resource.h>
#endif

namespace voxcarve::bench {

ProcessorTime processor_time() {
#if __has_include(<sys/resource.h>)
  rusage usage{};
  if (getrusage(RUSAGE_SELF, &usage) != 0) return {};
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  return {seconds(usage.ru_utime), seconds(usage.ru_stime)};
#else
  return {};
#endif
}

}  // namespace voxcarve::bench
