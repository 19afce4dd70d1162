// Based on volume sampling by a discrete filter [He95, 2]; differs in sampling the solid once, on a lattice that the
// supports of all grid points share, and in summing only near the surface: a run of samples of one class is a
// difference of two partial sums.
#include "methods/he_lowpass/low_pass.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "common/run/errors.h"
#include "common/volume/bit_voxelizer.h"

namespace voxcarve {

namespace {

constexpr std::uint64_t kSlabBytes = std::uint64_t{128} << 20;

/// Rows of lattice samples, reordered so that the taps of a row lie side by side: all points of one phase, that is
/// index modulo the stride, then those of the next one. Bytes beyond the last row may be read.
class TapRows {
 public:
  TapRows(const BitVolume& samples, std::int64_t stride, const RunContext& context) : stride_(stride) {
    const Index3& dims = samples.dims();
    phase_bits_ = words_for((dims[0] + stride - 1) / stride) * kWordBits;
    row_bytes_ = phase_bits_ / 8 * stride;
    rows_y_ = dims[1];
    bytes_.resize(static_cast<std::size_t>(row_bytes_ * dims[1] * dims[2]) + sizeof(BitWord));
    std::fill(bytes_.end() - sizeof(BitWord), bytes_.end(), std::uint8_t{0});
    parallel_for(context, 0, dims[2], 1, [&](std::int64_t k, std::int64_t) {
      for (std::int64_t j = 0; j < dims[1]; ++j) {
        std::uint8_t* row = bytes_.data() + (k * rows_y_ + j) * row_bytes_;
        if (stride == 1) {
          std::memcpy(row, samples.row(j, k), static_cast<std::size_t>(row_bytes_));
          continue;
        }
        std::fill_n(row, row_bytes_, std::uint8_t{0});
        for (std::int64_t i = 0; i < dims[0]; ++i) {
          if (!samples.get(i, j, k)) continue;
          const std::int64_t bit = i % stride * phase_bits_ + i / stride;
          row[bit / 8] = static_cast<std::uint8_t>(row[bit / 8] | 1U << bit % 8);
        }
      }
    });
  }

  const std::uint8_t* row(std::int64_t j, std::int64_t k) const {
    return bytes_.data() + (k * rows_y_ + j) * row_bytes_;
  }
  /// Where in a row the sample of lattice index i is.
  std::int64_t bit(std::int64_t i) const { return i % stride_ * phase_bits_ + i / stride_; }

  static std::uint64_t memory(const Index3& dims, std::int64_t stride) {
    return static_cast<std::uint64_t>(words_for((dims[0] + stride - 1) / stride) * 8 * stride * dims[1] * dims[2]) +
           sizeof(BitWord);
  }

 private:
  std::int64_t stride_;
  std::int64_t phase_bits_ = 0;
  std::int64_t row_bytes_ = 0;
  std::int64_t rows_y_ = 0;
  GridValues<std::uint8_t> bytes_;
};

constexpr std::int64_t kWindowBits = 57;  ///< that eight bytes hold wherever the first one starts in its byte

/// The kWindowBits bits from `bit` on, and some more.
BitWord window_at(const std::uint8_t* row, std::int64_t bit) {
  BitWord word;
  std::memcpy(&word, row + bit / 8, sizeof(word));
  return word >> (bit % 8);
}

/// For every grid point whether some sample, and whether every sample, of the blocks of lattice points that its
/// support touches is inside.
class Classes {
 public:
  /// The lattice begins `reach` points before the first grid point, and has `per_voxel` points to the next one.
  Classes(const BitVolume& samples, const Index3& grid, std::int64_t per_voxel, std::int64_t reach,
          const RunContext& context)
      : grid_(grid), below_((reach + per_voxel - 1) / per_voxel), above_(reach / per_voxel) {
    // Block b holds the lattice points of grid point b - below and of the way to the next one.
    const Index3 blocks = grid_ + Index3::Constant(below_ + above_);
    any_.assign(static_cast<std::size_t>(blocks.prod()), 0);
    const std::int64_t lead = below_ * per_voxel - reach;  // points by which the first block begins before the lattice
    parallel_for(context, 0, blocks[2], 1, [&](std::int64_t bk, std::int64_t) {
      const auto range = [&](std::int64_t block, int axis) {
        return std::pair{std::max<std::int64_t>(0, block * per_voxel - lead),
                         std::min(samples.dims()[axis], (block + 1) * per_voxel - lead)};
      };
      const auto words = static_cast<std::size_t>(samples.row_words());
      std::vector<BitWord> interior(words);
      std::vector<BitWord> exterior(words);
      const auto [k0, k1] = range(bk, 2);
      for (std::int64_t bj = 0; bj < blocks[1]; ++bj) {
        const auto [j0, j1] = range(bj, 1);
        std::ranges::fill(interior, 0);
        std::ranges::fill(exterior, 0);
        for (std::int64_t k = k0; k < k1; ++k) {
          for (std::int64_t j = j0; j < j1; ++j) {
            const BitWord* row = samples.row(j, k);
            for (std::size_t word = 0; word < words; ++word) {
              interior[word] |= row[word];
              exterior[word] |= ~row[word];
            }
          }
        }
        std::uint8_t* out = any_.data() + (bk * blocks[1] + bj) * blocks[0];
        mark(interior, samples.dims()[0], per_voxel, lead, kInterior, out);
        mark(exterior, samples.dims()[0], per_voxel, lead, kExterior, out);
      }
    });
    spread(blocks, context);
  }

  static constexpr std::uint8_t kExterior = 1;
  static constexpr std::uint8_t kInterior = 2;
  static constexpr std::uint8_t kMixed = 3;
  /// What the support of a grid point holds, kMixed when it may hold both.
  std::uint8_t at(std::int64_t i, std::int64_t j, std::int64_t k) const {
    return any_[static_cast<std::size_t>((k * stride_y_ + j) * stride_x_ + i)];
  }

  static std::uint64_t memory(const Index3& grid, std::int64_t per_voxel, std::int64_t reach) {
    const Index3 blocks = grid + Index3::Constant((reach + per_voxel - 1) / per_voxel + reach / per_voxel);
    return static_cast<std::uint64_t>(blocks.prod());
  }

 private:
  /// Marks the blocks along x that hold a set bit.
  static void mark(const std::vector<BitWord>& row, std::int64_t points, std::int64_t per_voxel, std::int64_t lead,
                   std::uint8_t mask, std::uint8_t* out) {
    for (std::int64_t at = 0; at < points;) {
      const BitWord rest = row[static_cast<std::size_t>(at / kWordBits)] >> (at % kWordBits);
      if (rest == 0) {
        at = (at / kWordBits + 1) * kWordBits;
        continue;
      }
      at += __builtin_ctzll(rest);
      if (at >= points) break;
      const std::int64_t block = (at + lead) / per_voxel;
      out[block] |= mask;
      at = (block + 1) * per_voxel - lead;  // the first point of the next block
    }
  }

  /// Gives grid point g the union over the blocks g ... g + below + above, along each axis in turn.
  void spread(const Index3& blocks, const RunContext& context) {
    const std::int64_t width = below_ + above_ + 1;
    stride_x_ = blocks[0];
    stride_y_ = blocks[1];
    const std::int64_t slice = blocks[0] * blocks[1];
    // Unions over 1, 2, 4, ... blocks, then over the last power of two from both ends.
    const auto along = [&](std::uint8_t* first, std::int64_t count, std::int64_t step, std::int64_t length) {
      // `length` values side by side, `count` of them `step` apart.
      std::int64_t covered = 1;
      const auto join = [&](std::int64_t shift) {
        for (std::int64_t at = 0; at + shift < count; ++at) {
          std::uint8_t* to = first + at * step;
          const std::uint8_t* from = to + shift * step;
          for (std::int64_t i = 0; i < length; ++i) to[i] |= from[i];
        }
      };
      for (; 2 * covered <= width; covered *= 2) join(covered);
      if (covered < width) join(width - covered);
    };
    parallel_for(context, 0, blocks[2], 1, [&](std::int64_t k, std::int64_t) {
      for (std::int64_t j = 0; j < blocks[1]; ++j) along(any_.data() + k * slice + j * blocks[0], blocks[0], 1, 1);
      along(any_.data() + k * slice, blocks[1], blocks[0], blocks[0]);
    });
    parallel_for(context, 0, blocks[1], 1, [&](std::int64_t j, std::int64_t) {
      along(any_.data() + j * blocks[0], blocks[2], slice, blocks[0]);
    });
  }

  Index3 grid_;
  std::int64_t below_;
  std::int64_t above_;
  std::int64_t stride_x_ = 0;
  std::int64_t stride_y_ = 0;
  std::vector<std::uint8_t> any_;
};

class LowPass {
 public:
  LowPass(const SolidSampler& solid, const GridFrame& frame, const LowPassOptions& options, RunContext& context)
      : solid_(solid),
        context_(context),
        lattice_(tap_lattice(options.support, options.taps)),
        kernel_(make_kernel(options)),
        reach_(lattice_.reach(kernel_)),
        density_(DensityVolume::uninitialized(GridFrame{})) {
    density_.frame = frame;
  }

  DensityVolume run(LowPassReport* report) {
    const GridFrame& frame = density_.frame;
    const std::int64_t slices = slices_a_slab();
    std::int64_t items = frame.dims[2];
    for (std::int64_t k = 0; k < frame.dims[2]; k += slices)
      items += solid_.items(lattice_frame(k, std::min(slices, frame.dims[2] - k)));
    Stage stage(context_, "low-pass filtering", items);
    const std::uint64_t result = static_cast<std::uint64_t>(frame.voxels()) * sizeof(float);
    context_.require_memory(result + slab_memory(std::min(slices, frame.dims[2])), "low-pass filtering");
    density_ = DensityVolume::uninitialized(frame);
    for (std::int64_t k = 0; k < frame.dims[2]; k += slices)
      filter_slab(k, std::min(slices, frame.dims[2] - k), result, stage);
    if (report != nullptr) *report = {evaluated_, kernel_.taps()};
    return std::move(density_);
  }

 private:
  LatticeKernel make_kernel(const LowPassOptions& options) const {
    context_.require_memory(LatticeKernel::memory(lattice_.radius), "a filter of so many taps");
    return {options.filter, lattice_.radius, options.rule};
  }

  GridFrame lattice_frame(std::int64_t first, std::int64_t slices) const {
    const GridFrame& frame = density_.frame;
    const double spacing = frame.voxel_size / static_cast<double>(lattice_.per_voxel);
    const Index3 grid(frame.dims[0], frame.dims[1], slices);
    GridFrame lattice;
    lattice.dims = (grid - Index3::Ones()) * lattice_.per_voxel + Index3::Constant(2 * reach_ + 1);
    lattice.voxel_size = spacing;
    lattice.origin = frame.center({0, 0, first}) - Point::Constant((static_cast<double>(reach_) + 0.5) * spacing);
    return lattice;
  }

  std::uint64_t slab_memory(std::int64_t slices) const {
    const Index3 dims = lattice_frame(0, slices).dims;
    const Index3 grid(density_.frame.dims[0], density_.frame.dims[1], slices);
    return BitVolume::memory(dims) + TapRows::memory(dims, lattice_.stride) +
           Classes::memory(grid, lattice_.per_voxel, reach_);
  }

  /// As many as a fixed amount of memory takes, whatever the machine has, and at least so many that the slices which
  /// neighbouring slabs both sample are not most of them.
  std::int64_t slices_a_slab() const {
    const std::int64_t all = density_.frame.dims[2];
    const std::int64_t least = std::min(all, 2 * reach_ / lattice_.per_voxel + 1);
    const std::uint64_t one = std::max<std::uint64_t>(1, slab_memory(2) - slab_memory(1));
    const std::uint64_t fixed = slab_memory(1);
    const std::int64_t fit = fixed >= kSlabBytes ? 1 : 1 + static_cast<std::int64_t>((kSlabBytes - fixed) / one);
    return std::clamp(fit, std::max<std::int64_t>(1, least), std::max<std::int64_t>(1, all));
  }

  void filter_slab(std::int64_t first, std::int64_t slices, std::uint64_t held, Stage& stage) {
    const GridFrame lattice = lattice_frame(first, slices);
    const Index3 grid(density_.nx(), density_.ny(), slices);
    BitVolume samples = solid_.sample(lattice, held + slab_memory(slices), stage, context_);
    const Classes classes(samples, grid, lattice_.per_voxel, reach_, context_);
    const TapRows rows(samples, lattice_.stride, context_);
    samples = {};
    std::atomic<std::int64_t> evaluated = 0;
    parallel_for(context_, 0, slices, 1, [&](std::int64_t k, std::int64_t) {
      std::vector<std::int64_t> points;
      std::vector<std::int64_t> bits;
      std::vector<std::int64_t> sums;
      for (std::int64_t j = 0; j < grid[1]; ++j) {
        float* out = &density_(0, j, first + k);
        points.clear();
        for (std::int64_t i = 0; i < grid[0]; ++i) {
          const std::uint8_t seen = classes.at(i, j, k);
          if (seen == Classes::kMixed) {
            points.push_back(i);
          } else {
            out[i] = seen == Classes::kInterior ? 1.0F : 0.0F;
          }
        }
        sum_row(rows, points, j, k, bits, sums);
        for (std::size_t p = 0; p < points.size(); ++p) {
          out[points[p]] = static_cast<float>(static_cast<double>(sums[p]) / static_cast<double>(kernel_.total()));
        }
        evaluated += static_cast<std::int64_t>(points.size());
        if (j % 16 == 0) context_.check_cancelled();
      }
      stage.advance(1);
    });
    evaluated_ += evaluated;
  }

  /// The weighted sums about the points of a row of the grid.
  void sum_row(const TapRows& rows, const std::vector<std::int64_t>& points, std::int64_t j, std::int64_t k,
               std::vector<std::int64_t>& bits, std::vector<std::int64_t>& sums) const {
    sums.assign(points.size(), 0);
    if (points.empty()) return;
    const std::int64_t taps = 2 * kernel_.reach() + 1;
    // Of the first tap of a grid point; the lattice begins at `reach` before the grid.
    bits.clear();
    for (const std::int64_t i : points) bits.push_back(rows.bit(i * lattice_.per_voxel));
    for (const LatticeKernel::Row& row : kernel_.rows()) {
      const std::uint8_t* samples = rows.row(j * lattice_.per_voxel + reach_ + row.dy * lattice_.stride,
                                             k * lattice_.per_voxel + reach_ + row.dz * lattice_.stride);
      for (std::int64_t first = 0; first < taps; first += kWindowBits) {
        const BitWord mask = (BitWord{1} << std::min(kWindowBits, taps - first)) - 1;
        for (std::size_t p = 0; p < points.size(); ++p) {
          const BitWord window = window_at(samples, bits[p] + first) & mask;
          if (window != 0) sums[p] += kernel_.sum(row, first, window);
        }
      }
    }
  }

  const SolidSampler& solid_;
  RunContext& context_;
  TapLattice lattice_;
  LatticeKernel kernel_;
  std::int64_t reach_;
  DensityVolume density_;
  std::int64_t evaluated_ = 0;
};

}  // namespace

TapLattice tap_lattice(double support, double taps) {
  if (!(support >= 0.01)) throw ParameterError("the support is narrower than a hundredth of a voxel");
  TapLattice lattice;
  const double wanted = 0.5 * taps / support;  // lattice points a voxel
  if (wanted > 1) {
    lattice.per_voxel = static_cast<std::int64_t>(std::ceil(wanted * (1 - 1e-12)));
  } else {
    lattice.stride = std::max<std::int64_t>(1, static_cast<std::int64_t>(std::floor((1 + 1e-12) / wanted)));
  }
  lattice.radius = support * static_cast<double>(lattice.per_voxel) / static_cast<double>(lattice.stride);
  return lattice;
}

DensityVolume low_pass(const SolidSampler& solid, const GridFrame& frame, const LowPassOptions& options,
                       RunContext& context, LowPassReport* report) {
  require_voxels(frame);
  return LowPass(solid, frame, options, context).run(report);
}

}  // namespace voxcarve
