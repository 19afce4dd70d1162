#include "common/volume/labelling.h"

#include <algorithm>
#include <span>
#include <vector>

#include "common/volume/bit_volume.h"
#include "common/volume/run_labelling.h"

namespace voxcarve {

namespace {

/// The runs of {volume == value}.
RunLabelling label_runs_of(const BinaryVolume& volume, bool value, Connectivity connectivity, RunContext& context) {
  const std::uint64_t held = volume.values.size();
  context.require_memory(held + BitVolume::memory(volume.frame.dims), "component labelling");
  if (volume.values.empty()) return label_runs(BitVolume(volume.frame.dims), connectivity, context, held);
  BitVolume bits = packed(volume, Index3::Zero(), false, context);
  if (!value) {
    const BitWord last_mask = last_word_mask(volume.nx());
    for_each_row(bits, context, [last_mask](BitWord* row, std::int64_t row_words, std::int64_t, std::int64_t) {
      for (std::int64_t w = 0; w < row_words; ++w) row[w] = ~row[w];
      row[row_words - 1] &= last_mask;
    });
  }
  return label_runs(bits, connectivity, context, held);
}

}  // namespace

Labelling label_components(const BinaryVolume& volume, std::uint8_t value, Connectivity connectivity,
                           RunContext& context) {
  const std::uint64_t held = volume.values.size() * (1 + sizeof(std::int32_t));
  context.require_memory(held, "component labelling");
  const RunLabelling labelling = label_runs_of(volume, value != 0, connectivity, context);
  context.require_memory(held + labelling.memory(), "component labelling");
  Labelling result{Grid<std::int32_t>::uninitialized(volume.frame), static_cast<std::int32_t>(labelling.count())};
  constexpr std::int64_t kVoxelsPerChunk = 1 << 18;
  const std::int64_t rows = volume.ny() * volume.nz();
  const std::int64_t grain = kVoxelsPerChunk / std::max<std::int64_t>(volume.nx(), 1);
  parallel_for(context, 0, rows, grain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t row = begin; row < end; ++row) {
      std::int32_t* labels = result.labels.values.data() + row * volume.nx();
      std::int64_t done = 0;
      for (const LabelledRun& run : labelling.runs_of_row(row % volume.ny(), row / volume.ny())) {
        std::fill(labels + done, labels + run.begin, 0);
        std::fill(labels + run.begin, labels + run.end, run.component + 1);
        done = run.end;
      }
      std::fill(labels + done, labels + volume.nx(), 0);
    }
  });
  return result;
}

std::int64_t count_interior_components(const BinaryVolume& volume, Connectivity connectivity, RunContext& context) {
  return label_runs_of(volume, true, connectivity, context).count();
}

std::int64_t count_exterior_components(const BinaryVolume& volume, Connectivity connectivity, RunContext& context) {
  const RunLabelling labelling = label_runs_of(volume, false, connectivity, context);
  const Index3& dims = volume.frame.dims;
  std::vector<bool> unbounded(static_cast<std::size_t>(labelling.count()), false);
  std::int64_t bounded = labelling.count();
  const auto reaches_outside = [&](const LabelledRun& run) {
    const auto component = static_cast<std::size_t>(run.component);
    bounded -= unbounded[component] ? 0 : 1;
    unbounded[component] = true;
  };
  // Voxels at the border of the grid are neighbours of the outside, and only they are, by every connectivity. The one
  // slice of an image is not a border.
  for (std::int64_t k = 0; k < dims[2]; ++k) {
    const bool border_slice = !volume.frame.is_image() && (k == 0 || k + 1 == dims[2]);
    for (std::int64_t j = 0; j < dims[1]; ++j) {
      const std::span<const LabelledRun> runs = labelling.runs_of_row(j, k);
      if (runs.empty()) continue;
      if (border_slice || j == 0 || j + 1 == dims[1]) {
        std::ranges::for_each(runs, reaches_outside);
      } else {
        if (runs.front().begin == 0) reaches_outside(runs.front());
        if (runs.back().end == dims[0]) reaches_outside(runs.back());
      }
    }
  }
  return bounded + 1;
}

}  // namespace voxcarve
