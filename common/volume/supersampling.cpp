// Based on supersampling with a Gaussian of radius 2 and standard deviation 0.7 voxels [NT03, 3.3]; differs in integer
// weights and in the cut-off along each axis instead of by distance, so that the kernel is separable and sums are
// exact. Runs of 16 voxels that see nothing but interior, or nothing but exterior, are filled without being summed.
#include "common/volume/supersampling.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <vector>

#include "common/run/errors.h"
#include "common/volume/bit_voxelizer.h"
#include "common/volume/workspace_pool.h"

namespace voxcarve {

namespace {

constexpr std::array<std::uint16_t, 3> kBoxWeights = {1, 1, 1};
// Offsets of the samples from a voxel's centre are m / 3 for m = -6 ... 6, (m + 1/2) / 2 for m = -4 ... 3, and m for
// m = -2 ... 2 voxels.
constexpr std::array<std::uint16_t, 5> kGaussianOfOne = {10, 210, 584, 210, 10};
constexpr std::array<std::uint16_t, 8> kGaussianOfTwo = {13, 59, 165, 275, 275, 165, 59, 13};
constexpr std::array<std::uint16_t, 13> kGaussianOfThree = {3, 11, 32, 70, 124, 174, 196, 174, 124, 70, 32, 11, 3};

constexpr std::int64_t kRun = 16;      ///< voxels along x that are filled or summed together
constexpr std::int64_t kGroup = 8;     ///< runs whose contents are tested together
constexpr std::uint8_t kInterior = 1;  ///< some sample that a run sees is interior
constexpr std::uint8_t kExterior = 2;  ///< some is exterior
constexpr std::uint8_t kMixed = 3;

/// Sums of runs of voxels and what the runs see. A run's sums are there only where it sees both classes.
template <class Sum>
struct RunRow {
  Sum* sums = nullptr;               ///< kRun a run
  std::uint8_t* contents = nullptr;  ///< one a run, whole groups of them
};

/// Rows of runs that follow one another, of which only the last few are kept.
template <class Sum>
class RunRing {
 public:
  RunRing(std::int64_t kept, std::int64_t rows, std::int64_t runs)
      : kept_(kept),
        rows_(rows),
        runs_(runs),
        sums_(static_cast<std::size_t>(kept * rows * runs * kRun)),
        contents_(static_cast<std::size_t>(kept * rows * runs), kExterior) {}

  /// Row `row` of item `item`, one of the last `kept`.
  RunRow<Sum> at(std::int64_t item, std::int64_t row = 0) {
    const std::int64_t first = (item % kept_ * rows_ + row) * runs_;
    return {sums_.data() + first * kRun, contents_.data() + first};
  }
  static std::uint64_t memory(std::int64_t kept, std::int64_t rows, std::int64_t runs) {
    return static_cast<std::uint64_t>(kept * rows * runs) * (kRun * sizeof(Sum) + 1);
  }

 private:
  std::int64_t kept_, rows_, runs_;
  GridValues<Sum> sums_;
  std::vector<std::uint8_t> contents_;
};

/// What a column of rows sees, and the sums of its mixed runs: calls mixed(run, sums of its kRun voxels) for these.
/// `full` is the sum of a run in a row that sees nothing but interior.
template <class Sum, class Mixed>
void sum_rows(std::span<const RunRow<Sum>> rows, std::span<const std::uint16_t> weights, std::uint32_t full,
              std::int64_t runs, std::uint8_t* contents, const Mixed& mixed) {
  for (std::int64_t first = 0; first < runs; first += kGroup) {
    std::uint64_t seen = 0;
    for (const RunRow<Sum>& row : rows) {
      std::uint64_t of_row = 0;
      std::memcpy(&of_row, row.contents + first, kGroup);
      seen |= of_row;
    }
    std::memcpy(contents + first, &seen, kGroup);
    if ((seen & (seen >> 1) & 0x0101010101010101) == 0) continue;
    for (std::int64_t run = first; run < first + kGroup; ++run) {
      if (contents[run] != kMixed) continue;
      std::array<std::uint32_t, kRun> sums{};
      for (std::size_t tap = 0; tap < rows.size(); ++tap) {
        const std::uint32_t weight = weights[tap];
        if (rows[tap].contents[run] == kExterior) continue;
        if (rows[tap].contents[run] == kInterior) {
          for (std::uint32_t& sum : sums) sum += weight * full;
          continue;
        }
        const Sum* values = rows[tap].sums + run * kRun;
        for (std::size_t i = 0; i < kRun; ++i) sums[i] += weight * values[i];
      }
      mixed(run, sums);
    }
  }
}

/// Filters slabs of slices: samples become sums along x, rows of these sums along y, and slices of those densities.
class DensityFilter {
 public:
  DensityFilter(const BitVolume& samples, const SampleKernel& kernel, DensityVolume& densities)
      : samples_(samples),
        kernel_(kernel),
        densities_(densities),
        taps_(std::ssize(kernel.weights)),
        runs_(runs_of(densities.frame)),
        sum_of_bits_(std::size_t{1} << taps_) {
    for (std::size_t bits = 0; bits < sum_of_bits_.size(); ++bits) {
      for (std::size_t tap = 0; tap < kernel.weights.size(); ++tap) {
        if ((bits >> tap & 1) != 0)
          sum_of_bits_[bits] = static_cast<std::uint16_t>(sum_of_bits_[bits] + kernel.weights[tap]);
      }
    }
  }

  struct Workspace {
    RunRing<std::uint16_t> rows;    ///< sums along x of rows of samples
    RunRing<std::uint32_t> slices;  ///< sums along x and y of slices of samples
    std::vector<std::uint8_t> contents;
  };
  Workspace make_workspace() const {
    return {RunRing<std::uint16_t>(taps_, 1, runs_), RunRing<std::uint32_t>(taps_, densities_.ny(), runs_),
            std::vector<std::uint8_t>(static_cast<std::size_t>(runs_))};
  }
  static std::uint64_t workspace_memory(const GridFrame& frame, const SampleKernel& kernel) {
    const std::int64_t taps = std::ssize(kernel.weights);
    const std::int64_t runs = runs_of(frame);
    return RunRing<std::uint16_t>::memory(taps, 1, runs) + RunRing<std::uint32_t>::memory(taps, frame.dims[1], runs) +
           static_cast<std::uint64_t>(runs);
  }

  void filter_slab(std::int64_t begin, std::int64_t end, Workspace& space, Stage& stage) const {
    std::int64_t next = begin * kernel_.samples + kernel_.offset;
    for (std::int64_t k = begin; k < end; ++k) {
      const std::int64_t first = k * kernel_.samples + kernel_.offset;
      for (; next < first + taps_; ++next) sum_slice(next, space);
      for (std::int64_t j = 0; j < densities_.ny(); ++j) write_row(j, k, first, space);
      stage.advance(1);
    }
  }

 private:
  /// Of a row, in whole groups.
  static std::int64_t runs_of(const GridFrame& frame) {
    constexpr std::int64_t kVoxels = kRun * kGroup;
    return (frame.dims[0] + kVoxels - 1) / kVoxels * kGroup;
  }

  /// The `width` samples of a row from `first` on, 0 beyond the row.
  BitWord samples_from(const BitWord* row, std::int64_t first, std::int64_t width) const {
    const std::int64_t word = first / kWordBits;
    const std::int64_t shift = first % kWordBits;
    if (word >= samples_.row_words()) return 0;
    BitWord bits = row[word] >> shift;
    if (shift + width > kWordBits && word + 1 < samples_.row_words()) bits |= row[word + 1] << (kWordBits - shift);
    return bits & (bit_of(width) - 1);
  }

  void sum_row(std::int64_t j, std::int64_t k, RunRow<std::uint16_t> out) const {
    const BitWord* row = samples_.row(j, k);
    const std::int64_t samples = kernel_.samples;
    const std::int64_t width = (kRun - 1) * samples + taps_;  // at most 58
    const BitWord all = bit_of(width) - 1;
    const BitWord window = bit_of(taps_) - 1;
    for (std::int64_t run = 0; run < runs_; ++run) {
      BitWord bits = samples_from(row, run * kRun * samples + kernel_.offset, width);
      out.contents[run] = bits == 0 ? kExterior : bits == all ? kInterior : kMixed;
      if (out.contents[run] != kMixed) continue;
      std::uint16_t* sums = out.sums + run * kRun;
      for (std::int64_t i = 0; i < kRun; ++i, bits >>= samples) sums[i] = sum_of_bits_[bits & window];
    }
  }

  void sum_slice(std::int64_t k, Workspace& space) const {
    std::int64_t next = kernel_.offset;
    std::array<RunRow<std::uint16_t>, kMostTaps> rows;
    for (std::int64_t j = 0; j < densities_.ny(); ++j) {
      const std::int64_t first = j * kernel_.samples + kernel_.offset;
      for (; next < first + taps_; ++next) sum_row(next, k, space.rows.at(next));
      for (std::int64_t tap = 0; tap < taps_; ++tap) rows[static_cast<std::size_t>(tap)] = space.rows.at(first + tap);
      const RunRow<std::uint32_t> out = space.slices.at(k, j);
      sum_rows<std::uint16_t>(
          std::span(rows).first(kernel_.weights.size()), kernel_.weights, kernel_.total, runs_, out.contents,
          [&](std::int64_t run, const auto& sums) { std::ranges::copy(sums, out.sums + run * kRun); });
    }
  }

  void write_row(std::int64_t j, std::int64_t k, std::int64_t first, Workspace& space) const {
    std::array<RunRow<std::uint32_t>, kMostTaps> rows;
    for (std::int64_t tap = 0; tap < taps_; ++tap)
      rows[static_cast<std::size_t>(tap)] = space.slices.at(first + tap, j);
    float* out = densities_.values.data() + densities_.index(0, j, k);
    const std::int64_t nx = densities_.nx();
    const std::uint32_t total = kernel_.total * kernel_.total * kernel_.total;
    sum_rows<std::uint32_t>(
        std::span(rows).first(kernel_.weights.size()), kernel_.weights, kernel_.total * kernel_.total, runs_,
        space.contents.data(), [&](std::int64_t run, const auto& sums) {
          // A run beyond the row's end, which a group still has, may see samples of the margin.
          const auto voxels = static_cast<std::size_t>(std::clamp<std::int64_t>(nx - run * kRun, 0, kRun));
          for (std::size_t i = 0; i < voxels; ++i) {
            out[run * kRun + static_cast<std::int64_t>(i)] = static_cast<float>(sums[i]) / static_cast<float>(total);
          }
        });
    for (std::int64_t run = 0; run * kRun < nx; ++run) {
      const std::uint8_t contents = space.contents[static_cast<std::size_t>(run)];
      if (contents == kMixed) continue;
      std::fill_n(out + run * kRun, std::min(kRun, nx - run * kRun), contents == kInterior ? 1.0F : 0.0F);
    }
  }

  static constexpr std::size_t kMostTaps = kGaussianOfThree.size();
  const BitVolume& samples_;
  const SampleKernel& kernel_;
  DensityVolume& densities_;
  std::int64_t taps_;
  std::int64_t runs_;
  std::vector<std::uint16_t> sum_of_bits_;  ///< of the samples in a voxel's reach, first in the lowest bit
};

}  // namespace

SampleKernel sample_kernel(const SupersamplingOptions& options) {
  if (options.samples < 1 || options.samples > 3) throw ParameterError("samples must be 1, 2 or 3");
  if (options.kernel == FilterKernel::kBox) {
    const auto samples = static_cast<std::size_t>(options.samples);
    return {options.samples, 0, 0, std::span(kBoxWeights).first(samples), static_cast<std::uint32_t>(options.samples)};
  }
  constexpr int kReach = 2;
  switch (options.samples) {
    case 1:
      return {1, kReach, 0, kGaussianOfOne, 1024};
    case 2:
      return {2, kReach, 1, kGaussianOfTwo, 1024};  // offset -7/4 is the second sample of the voxel before the last
    default:
      return {3, kReach, 1, kGaussianOfThree, 1024};  // offset -2 is the middle sample of that voxel
  }
}

GridFrame density_frame(const GridFrame& frame, const SampleKernel& kernel) {
  return padded(frame, kernel.reach);
}

GridFrame sample_frame(const GridFrame& frame, const SampleKernel& kernel) {
  GridFrame samples = density_frame(frame, kernel);
  samples.origin -= Point::Constant(kernel.reach * samples.voxel_size);
  samples.dims = (samples.dims + Index3::Constant(2 * kernel.reach)) * kernel.samples;
  samples.voxel_size /= kernel.samples;
  return samples;
}

DensityVolume filtered(const BitVolume& samples, const GridFrame& frame, const SampleKernel& kernel,
                       RunContext& context) {
  const GridFrame to = density_frame(frame, kernel);
  Stage stage(context, "supersampling", to.dims[2]);
  constexpr std::int64_t kSlab = 32;  // slices; the kernel's reach before a slab is summed twice
  const std::uint64_t workspaces = workspaces_at_once(context, (to.dims[2] + kSlab - 1) / kSlab);
  context.require_memory(BitVolume::memory(samples.dims()) + static_cast<std::uint64_t>(to.voxels()) * sizeof(float) +
                             workspaces * DensityFilter::workspace_memory(to, kernel),
                         "supersampling");
  DensityVolume densities = DensityVolume::uninitialized(to);
  const DensityFilter filter(samples, kernel, densities);
  WorkspacePool<DensityFilter::Workspace> pool;
  parallel_for(context, 0, to.dims[2], kSlab, [&](std::int64_t begin, std::int64_t end) {
    auto space = pool.take([&] { return filter.make_workspace(); });
    filter.filter_slab(begin, end, *space, stage);
    pool.give(std::move(space));
  });
  return densities;
}

DensityVolume voxelize_density(const TriangleSoup& soup, const GridFrame& frame, const VoxelizeOptions& options,
                               const SupersamplingOptions& supersampling, RunContext& context, VoxelizeReport* report) {
  const SampleKernel kernel = sample_kernel(supersampling);
  voxelization_directions(options.directions, options.axis);  // throws for a count that there is not
  require_voxels(frame);
  const GridFrame fine = sample_frame(frame, kernel);
  BitVolume samples;
  {
    Stage stage(context, "voxelization", voxelization_items(soup, fine, options));
    samples = voxelize_bits(soup, fine, options, 0, stage, context, report);
  }
  return filtered(samples, frame, kernel, context);
}

}  // namespace voxcarve
