// How much memory a run takes at its peak.
#pragma once

#include <cstdint>
#include <optional>

namespace voxcarve::bench {

/// Resident memory of this process from its construction on. Memory that was freed before is handed back to the system
/// first, so that the run cannot hide in it.
class PeakMemory {
 public:
  PeakMemory();
  /// Bytes that the largest resident size since then is above the one at the start; none where the system (not Linux,
  /// or a sandbox) does not tell.
  std::optional<std::uint64_t> growth() const;

 private:
  bool reset_ = false;
  std::optional<std::uint64_t> start_;
};

}  // namespace voxcarve::bench
