// Based on [HCS08]: runs instead of voxels, joined with those of the rows before them. Differs in finding runs in words
// of bits, in three dimensions, in trees of runs (parent before child, paths halved) in place of their equivalence
// table, and in slabs of rows that are joined by themselves, on several threads, before their borders are.
#include "common/volume/run_labelling.h"

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include "common/run/errors.h"
#include "common/volume/vectorized.h"

namespace voxcarve {

namespace {

/// A row before (j, k) whose voxels are neighbours of that row's: those at most `reach` places aside.
struct EarlierRow {
  std::int64_t dj, dk;
  std::int32_t reach;
};

std::vector<EarlierRow> earlier_rows(Connectivity connectivity) {
  constexpr std::array<std::array<std::int64_t, 2>, 4> kRows = {{{-1, -1}, {0, -1}, {1, -1}, {-1, 0}}};
  std::vector<EarlierRow> rows;
  for (const auto [dj, dk] : kRows) {
    const std::int64_t differing = (dj != 0 ? 1 : 0) + (dk != 0 ? 1 : 0);
    const std::int64_t left = static_cast<std::int64_t>(connectivity) - differing;
    if (left >= 0) rows.push_back({dj, dk, left > 0 ? 1 : 0});
  }
  return rows;
}

/// Number of runs of every one of `rows` rows, which lie one after the other.
VOXCARVE_VECTORIZED void count_runs(const BitWord* words, std::int64_t row_words, std::int64_t rows,
                                    std::int32_t* counts) {
  for (std::int64_t row = 0; row < rows; ++row, words += row_words) {
    std::int32_t count = 0;
    BitWord before = 0;
    for (std::int64_t w = 0; w < row_words; ++w) {
      const BitWord word = words[w];
      count += std::popcount(word & ~(word << 1 | before));
      before = word >> (kWordBits - 1);
    }
    counts[row] = count;
  }
}

/// Writes the places of the runs of a row of `length` bits.
void extract_runs(const BitWord* row, std::int64_t length, LabelledRun* runs) {
  LabelledRun* begun = runs;
  LabelledRun* ended = runs;
  BitWord before = 0;
  for (std::int64_t w = 0; w * kWordBits < length; ++w) {
    const BitWord shifted = row[w] << 1 | before;
    before = row[w] >> (kWordBits - 1);
    const auto base = static_cast<std::int32_t>(w * kWordBits);
    for (BitWord begins = row[w] & ~shifted; begins != 0; begins &= begins - 1) {
      (begun++)->begin = base + std::countr_zero(begins);
    }
    for (BitWord ends = ~row[w] & shifted; ends != 0; ends &= ends - 1) {
      (ended++)->end = base + std::countr_zero(ends);
    }
  }
  if (ended != begun) ended->end = static_cast<std::int32_t>(length);  // no word of the row shows the bit beyond it
}

/// The first run of every row, and at the end the number of runs.
GridValues<std::int32_t> first_runs(const BitVolume& bits, RunContext& context) {
  const std::int64_t rows = bits.dims()[1] * bits.dims()[2];
  GridValues<std::int32_t> first(static_cast<std::size_t>(rows + 1), 0);
  constexpr std::int64_t kWordsPerChunk = 1 << 16;
  const std::int64_t grain = kWordsPerChunk / std::max<std::int64_t>(bits.row_words(), 1);
  parallel_for(context, 0, rows, grain, [&](std::int64_t begin, std::int64_t end) {
    count_runs(bits.row(begin, 0), bits.row_words(), end - begin, first.data() + begin);
  });
  std::int64_t total = 0;
  for (std::int32_t& value : first) {
    const std::int32_t count = value;
    value = static_cast<std::int32_t>(total);
    total += count;
    if (total > std::numeric_limits<std::int32_t>::max()) {
      throw ResourceError("component labelling takes less than 2^31 runs of voxels; lower the resolution");
    }
  }
  return first;
}

/// Joins runs. Until it is done, a run's `component` is its parent: an earlier run of the same component, or itself.
class RunJoiner {
 public:
  RunJoiner(const BitVolume& bits, Connectivity connectivity, const GridValues<std::int32_t>& first_run,
            LabelledRun* runs)
      : bits_(bits), earlier_rows_(earlier_rows(connectivity)), first_run_(first_run.data()), runs_(runs) {}

  /// Finds the runs of rows begin ... end - 1 and joins them with each other.
  void join_slab(std::int64_t begin, std::int64_t end, const RunContext& context) {
    for (std::int64_t row = begin; row < end; ++row) {
      context.check_cancelled();
      if (first_run_[row] == first_run_[row + 1]) continue;
      extract_runs(bits_.row(row, 0), bits_.dims()[0], runs_ + first_run_[row]);
      for (std::int32_t run = first_run_[row]; run < first_run_[row + 1]; ++run) runs_[run].component = run;
      for_each_earlier(row, [&](std::int64_t earlier, std::int32_t reach) {
        if (earlier >= begin) join_rows(row, earlier, reach);
      });
    }
  }

  /// Joins the runs of a slab with those of the slabs before it, which end at row `begin`.
  void join_border(std::int64_t begin, std::int64_t end) {
    for (std::int64_t row = begin; row < end; ++row) {
      for_each_earlier(row, [&](std::int64_t earlier, std::int32_t reach) {
        if (earlier < begin) join_rows(row, earlier, reach);
      });
    }
  }

 private:
  template <class Visit>
  void for_each_earlier(std::int64_t row, const Visit& visit) const {
    const std::int64_t ny = bits_.dims()[1];
    const std::int64_t j = row % ny;
    for (const EarlierRow& earlier : earlier_rows_) {
      const bool inside = j + earlier.dj >= 0 && j + earlier.dj < ny && row + earlier.dk * ny >= 0;
      if (inside) visit(row + earlier.dk * ny + earlier.dj, earlier.reach);
    }
  }

  void join_rows(std::int64_t row, std::int64_t earlier, std::int32_t reach) {
    LabelledRun* a = runs_ + first_run_[row];
    LabelledRun* b = runs_ + first_run_[earlier];
    const LabelledRun* const a_end = runs_ + first_run_[row + 1];
    const LabelledRun* const b_end = runs_ + first_run_[earlier + 1];
    while (a < a_end && b < b_end) {
      const std::int32_t ahead = a->end - b->end;
      const bool touch = std::max(a->begin, b->begin) < std::min(a->end, b->end) + reach;
      if (touch && a->component != b->component) join(a->component, b->component);
      // The run that ends first touches nothing that comes after the other one.
      a += ahead <= 0 ? 1 : 0;
      b += ahead >= 0 ? 1 : 0;
    }
  }

  void join(std::int32_t a, std::int32_t b) {
    a = root(a);
    b = root(b);
    if (a < b) {
      parent(b) = a;
    } else {
      parent(a) = b;
    }
  }

  std::int32_t root(std::int32_t run) {
    while (parent(run) != run) {
      parent(run) = parent(parent(run));
      run = parent(run);
    }
    return run;
  }

  std::int32_t& parent(std::int32_t run) { return runs_[run].component; }

  const BitVolume& bits_;
  std::vector<EarlierRow> earlier_rows_;
  const std::int32_t* first_run_;
  LabelledRun* runs_;
};

/// Turns parents into numbers of components and returns how many there are. A parent is earlier, so it has its number.
std::int64_t number_components(GridValues<LabelledRun>& runs, const RunContext& context) {
  constexpr std::int64_t kRunsPerCheck = 1 << 20;
  std::int32_t count = 0;
  const auto size = static_cast<std::int64_t>(runs.size());
  for (std::int64_t begin = 0; begin < size; begin += kRunsPerCheck) {
    context.check_cancelled();
    for (std::int64_t run = begin; run < std::min(begin + kRunsPerCheck, size); ++run) {
      std::int32_t& component = runs[static_cast<std::size_t>(run)].component;
      component = component == run ? count++ : runs[static_cast<std::size_t>(component)].component;
    }
  }
  return count;
}

}  // namespace

RunLabelling label_runs(const BitVolume& bits, Connectivity connectivity, RunContext& context, std::uint64_t held) {
  const std::int64_t ny = bits.dims()[1];
  const std::int64_t rows = ny * bits.dims()[2];
  held += BitVolume::memory(bits.dims()) + static_cast<std::uint64_t>(rows + 1) * sizeof(std::int32_t);
  context.require_memory(held, "component labelling");
  GridValues<std::int32_t> first_run = first_runs(bits, context);
  const auto size = static_cast<std::size_t>(first_run.back());
  context.require_memory(held + size * sizeof(LabelledRun), "component labelling");
  GridValues<LabelledRun> runs;
  runs.resize(size);

  // Whole slices, so that only the first slice of a slab has neighbours in another.
  constexpr std::int64_t kSlicesPerSlab = 16;
  constexpr std::int64_t kRowsPerSlab = 256;  // of an image
  const bool image = bits.dims()[2] == 1;
  const std::int64_t grain = image ? kRowsPerSlab : kSlicesPerSlab * ny;
  RunJoiner joiner(bits, connectivity, first_run, runs.data());
  parallel_for(context, 0, rows, grain,
               [&](std::int64_t begin, std::int64_t end) { joiner.join_slab(begin, end, context); });
  for (std::int64_t border = grain; border < rows; border += grain) {
    context.check_cancelled();
    joiner.join_border(border, border + (image ? 1 : ny));
  }
  const std::int64_t count = number_components(runs, context);
  return {bits.dims(), count, std::move(first_run), std::move(runs)};
}

}  // namespace voxcarve
