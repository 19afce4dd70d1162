#include "methods/he_lowpass/lattice_kernel.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "common/run/errors.h"

namespace voxcarve {

namespace {

constexpr double kTotal = 0x1p50;
/// Parts of a cell along each axis: fewer where cells are a small share of the support.
int cell_parts(double radius) {
  constexpr double kFine = 128;
  return radius <= 16 ? 8 : std::max(1, static_cast<int>(std::ceil(kFine / radius)));
}

/// The mean of the filter over the cell about a lattice point, or its value there.
double tap(const RadialFilter& filter, double radius, TapRule rule, std::int64_t dx, std::int64_t dy, std::int64_t dz) {
  const Eigen::Vector3d center(static_cast<double>(dx), static_cast<double>(dy), static_cast<double>(dz));
  if (rule == TapRule::kPoint) return filter.weight(center.norm() / radius);
  const int parts = cell_parts(radius);
  double sum = 0;
  for (int k = 0; k < parts; ++k) {
    for (int j = 0; j < parts; ++j) {
      for (int i = 0; i < parts; ++i) {
        const Eigen::Vector3d part(i + 0.5, j + 0.5, k + 0.5);
        sum += filter.weight((center + part / parts - Eigen::Vector3d::Constant(0.5)).norm() / radius);
      }
    }
  }
  return sum / (parts * parts * parts);
}

}  // namespace

std::uint64_t LatticeKernel::memory(double radius) {
  const auto taps = static_cast<std::uint64_t>(radius) + 2;
  return taps * taps / 2 * 3 * taps * sizeof(double) + 4 * taps * taps * sizeof(Row);
}

LatticeKernel::LatticeKernel(const RadialFilter& filter, double radius, TapRule rule) {
  if (!(radius >= 0.5 && radius <= kMostRadius))
    throw ParameterError("a filter of " + std::to_string(2 * radius) + " taps: use 1 to 1024");
  reach_ = static_cast<std::int64_t>(rule == TapRule::kPoint ? std::floor(radius) : std::floor(radius + 0.5));
  // By symmetry, taps of 0 <= dx, 0 <= dy <= dz are all there are.
  using Class = std::pair<std::int64_t, std::int64_t>;
  std::map<Class, std::vector<double>> taps;
  double sum = 0;
  for (std::int64_t dz = 0; dz <= reach_; ++dz) {
    for (std::int64_t dy = 0; dy <= dz; ++dy) {
      std::vector<double>& row = taps[{dy, dz}];
      const double rows = (dy == 0 ? 1 : 2) * (dz == 0 ? 1 : 2) * (dy == dz ? 1 : 2);
      for (std::int64_t dx = 0; dx <= reach_; ++dx) {
        row.push_back(tap(filter, radius, rule, dx, dy, dz));
        sum += rows * (dx == 0 ? 1 : 2) * row.back();
      }
    }
  }
  std::map<Class, std::size_t> starts;
  for (const auto& [offset, row] : taps) {
    const std::size_t start = sums_.size();
    std::int64_t before = 0;
    sums_.push_back(0);
    for (std::int64_t dx = -reach_; dx <= reach_; ++dx) {
      before += std::llround(row[static_cast<std::size_t>(std::abs(dx))] / sum * kTotal);
      sums_.push_back(before);
    }
    if (before == 0) {
      sums_.resize(start);
    } else {
      starts[offset] = start;
    }
  }
  for (std::int64_t dz = -reach_; dz <= reach_; ++dz) {
    for (std::int64_t dy = -reach_; dy <= reach_; ++dy) {
      const auto found = starts.find(std::minmax({std::abs(dy), std::abs(dz)}));
      if (found == starts.end()) continue;
      rows_.push_back({dy, dz, found->second});
      total_ += sums_[found->second + static_cast<std::size_t>(2 * reach_ + 1)];
    }
  }
}

std::int64_t LatticeKernel::taps() const {
  std::int64_t count = 0;
  for (const Row& row : rows_) {
    for (std::size_t i = row.sums; i < row.sums + static_cast<std::size_t>(2 * reach_ + 1); ++i)
      count += sums_[i + 1] != sums_[i] ? 1 : 0;
  }
  return count;
}

std::int64_t LatticeKernel::weight(std::int64_t dx, std::int64_t dy, std::int64_t dz) const {
  if (std::abs(dx) > reach_) return 0;
  for (const Row& row : rows_) {
    if (row.dy != dy || row.dz != dz) continue;
    const auto at = row.sums + static_cast<std::size_t>(dx + reach_);
    return sums_[at + 1] - sums_[at];
  }
  return 0;
}

}  // namespace voxcarve
