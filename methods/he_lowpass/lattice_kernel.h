// A radial filter as integer weights on a lattice.
#pragma once

#include <cstdint>
#include <vector>

#include "common/volume/bit_volume.h"
#include "methods/he_lowpass/radial_filter.h"

namespace voxcarve {

/// What a weight stands for.
enum class TapRule {
  kPoint,  ///< the filter at the lattice point, as in the paper
  kCell    ///< its mean over the lattice cell: what a solid that is constant on cells sees
};

/// Weights of the lattice points within the support, as rows along x. They are integers with a sum of about 2^50, so
/// that densities are exact at 0 and 1 and independent of the order of summation and of the machine.
class LatticeKernel {
 public:
  static constexpr double kMostRadius = 512;

  /// `radius`: lattice points from the centre to the end of the support, a real number in [0.5, kMostRadius].
  LatticeKernel(const RadialFilter& filter, double radius, TapRule rule);

  /// Bytes that a kernel of this radius holds at most, while it is made.
  static std::uint64_t memory(double radius);

  /// Lattice points along x from dx = -reach() to reach(), at some (dy, dz).
  struct Row {
    std::int64_t dy = 0;
    std::int64_t dz = 0;
    std::size_t sums = 0;  ///< where its partial sums begin
  };

  std::int64_t reach() const { return reach_; }
  const std::vector<Row>& rows() const { return rows_; }
  std::int64_t total() const { return total_; }
  /// Lattice points with a weight.
  std::int64_t taps() const;
  std::int64_t weight(std::int64_t dx, std::int64_t dy, std::int64_t dz) const;

  /// The weights of the set bits of `window`, whose lowest bit is tap `first` of the row; it has no set bit beyond the
  /// row's last tap, and not its own highest one.
  std::int64_t sum(const Row& row, std::int64_t first, BitWord window) const {
    // Bit i of the changes: where a run of ones starts or has ended. The alternating sum of the partial sums there.
    BitWord changes = window ^ (window << 1);
    const std::int64_t* sums = sums_.data() + row.sums + first;
    std::int64_t sum = 0;
    while (changes != 0) {
      sum = sums[__builtin_ctzll(changes)] - sum;
      changes &= changes - 1;
    }
    return sum;
  }

 private:
  std::int64_t reach_;
  std::int64_t total_ = 0;
  std::vector<Row> rows_;
  std::vector<std::int64_t> sums_;  ///< 2 reach + 2 a class of rows: of the weights before each point
};

}  // namespace voxcarve
