// What a run costs all processors together, apart from waiting.
#pragma once

namespace voxcarve::bench {

/// Seconds of all threads of this process: in its own code, and in the system on its behalf, which for large volumes is
/// the clearing of fresh memory.
struct ProcessorTime {
  double user = 0;
  double system = 0;

  ProcessorTime& operator+=(const ProcessorTime& other) {
    user += other.user;
    system += other.system;
    return *this;
  }
  friend ProcessorTime operator-(const ProcessorTime& a, const ProcessorTime& b) {
    return {a.user - b.user, a.system - b.system};
  }
};

/// Spent so far; 0 where the system does not tell.
ProcessorTime processor_time();

}  // namespace voxcarve::bench
