// Random numbers that are a function of (seed, stream, counter), so that they do not depend on the order of evaluation.
#pragma once

#include <cstdint>

namespace voxcarve {

/// The finaliser of splitmix64 [SLF14], applied to the words in turn.
class CounterRandom {
 public:
  CounterRandom(std::uint64_t seed, std::uint64_t stream) : key_(mix(mix(seed) ^ stream)) {}

  /// Uniform in [0, 1), a multiple of 2^-53.
  double operator()(std::uint64_t counter) const {
    return static_cast<double>(mix(key_ ^ mix(counter)) >> 11) * 0x1p-53;
  }

 private:
  static std::uint64_t mix(std::uint64_t x) {
    x += 0x9e3779b97f4a7c15ULL;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
    return x ^ (x >> 31);
  }
  std::uint64_t key_;
};

}  // namespace voxcarve
