// Based on [WR05]; differs in exact transforms of which only what lies within the radius is computed, on bits.
#include "methods/mason/regular_filters.h"

#include <bit>
#include <numeric>
#include <utility>

#include "common/volume/bit_morphology.h"
#include "common/volume/run_labelling.h"

namespace voxcarve {

namespace {

/// What the filters would change in one component of the mortar.
struct Ballot {
  std::int64_t voxels = 0;
  std::int64_t interior = 0;    ///< voxels of S
  std::int64_t changed_rf = 0;  ///< voxels where RF disagrees with S
  std::int64_t changed_fr = 0;
  bool first_voxel = false;  ///< whether its first voxel is in S
};

std::vector<Ballot> count_ballots(const RunLabelling& labelling, const BitVolume& shape, const BitVolume& rf,
                                  const BitVolume& fr, std::uint64_t held, RunContext& context) {
  context.require_memory(held + labelling.memory() + static_cast<std::uint64_t>(labelling.count()) * sizeof(Ballot),
                         "Mason's components");
  std::vector<Ballot> ballots(static_cast<std::size_t>(labelling.count()));
  for (std::int64_t k = 0; k < shape.dims()[2]; ++k) {
    context.check_cancelled();
    for (std::int64_t j = 0; j < shape.dims()[1]; ++j) {
      const BitWord* s = shape.row(j, k);
      const BitWord* by_rf = rf.row(j, k);
      const BitWord* by_fr = fr.row(j, k);
      for (const auto& run : labelling.runs_of_row(j, k)) {
        Ballot& ballot = ballots[static_cast<std::size_t>(run.component)];
        if (ballot.voxels == 0) ballot.first_voxel = shape.get(run.begin, j, k);
        for_each_word(run.begin, run.end, [&](std::int64_t w, BitWord mask) {
          ballot.voxels += std::popcount(mask);
          ballot.interior += std::popcount(s[w] & mask);
          ballot.changed_rf += std::popcount((s[w] ^ by_rf[w]) & mask);
          ballot.changed_fr += std::popcount((s[w] ^ by_fr[w]) & mask);
        });
      }
    }
  }
  return ballots;
}

/// Whether the tie rule sends a component to FR.
bool tie_takes_fr(const Ballot& ballot, TieRule tie) {
  if (tie == TieRule::kPaper) return false;
  // FR leaves out what RF fills: it is the side of a component that mostly is exterior.
  const std::int64_t exterior = ballot.voxels - ballot.interior;
  return ballot.interior == exterior ? !ballot.first_voxel : exterior > ballot.interior;
}

/// The voxels of the components that are `chosen`.
BitVolume voxels_of(const RunLabelling& labelling, const std::vector<char>& chosen, const RunContext& context) {
  BitVolume result(labelling.dims());
  for_each_row(result, context, [&](BitWord* row, std::int64_t row_words, std::int64_t j, std::int64_t k) {
    std::fill_n(row, row_words, BitWord{0});
    for (const LabelledRun& run : labelling.runs_of_row(j, k)) {
      if (chosen[static_cast<std::size_t>(run.component)] == 0) continue;
      for_each_word(run.begin, run.end, [&](std::int64_t w, BitWord mask) { row[w] |= mask; });
    }
  });
  return result;
}

/// Sums count(words of a, words of b) over all words.
template <class Count>
std::int64_t sum_words(const BitVolume& a, const BitVolume& b, const RunContext& context, const Count& count) {
  const std::int64_t slices = a.dims()[2];
  std::vector<std::int64_t> sums(static_cast<std::size_t>(slices));
  parallel_for(context, 0, slices, 1, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t k = begin; k < end; ++k) {
      const BitWord* left = a.row(0, k);
      const BitWord* right = b.row(0, k);
      std::int64_t sum = 0;
      for (std::int64_t w = 0; w < a.dims()[1] * a.row_words(); ++w) sum += std::popcount(count(left[w], right[w]));
      sums[static_cast<std::size_t>(k)] = sum;
    }
  });
  return std::accumulate(sums.begin(), sums.end(), std::int64_t{0});
}

}  // namespace

std::int64_t count_difference(const BitVolume& a, const BitVolume& b, const RunContext& context) {
  return sum_words(a, b, context, [](BitWord left, BitWord right) { return left ^ right; });
}

std::int64_t count_beyond(const BitVolume& a, const BitVolume& b, const RunContext& context) {
  return sum_words(a, b, context, [](BitWord left, BitWord right) { return left & ~right; });
}

BitVolume complement(const BitVolume& volume, const RunContext& context) {
  BitVolume result(volume.dims());
  for_each_row(result, context, [&](BitWord* row, std::int64_t row_words, std::int64_t j, std::int64_t k) {
    const BitWord* from = volume.row(j, k);
    for (std::int64_t w = 0; w < row_words; ++w) row[w] = ~from[w];
    row[row_words - 1] &= last_word_mask(volume.dims()[0]);
  });
  return result;
}

const BitVolume& RegularFilters::rounded() {
  if (!rounded_) rounded_ = open(shape_, reach_, outside_, context_);
  return *rounded_;
}

const BitVolume& RegularFilters::filleted() {
  if (!filleted_) filleted_ = close(shape_, reach_, outside_, context_);
  return *filleted_;
}

const BitVolume& RegularFilters::rf() {
  if (!rf_) rf_ = open(filleted(), reach_, outside_, context_);
  return *rf_;
}

const BitVolume& RegularFilters::fr() {
  if (!fr_) fr_ = close(rounded(), reach_, outside_, context_);
  return *fr_;
}

BitVolume RegularFilters::mortar() {
  const BitVolume& inner = rounded();
  BitVolume result = filleted();
  for_each_row(result, context_, [&](BitWord* row, std::int64_t row_words, std::int64_t j, std::int64_t k) {
    const BitWord* core = inner.row(j, k);
    for (std::int64_t w = 0; w < row_words; ++w) row[w] &= ~core[w];
  });
  return result;
}

BitVolume RegularFilters::mason(TieRule tie, MasonCounts* counts, MasonMaps* maps, std::uint64_t held) {
  const BitVolume& by_rf = rf();
  const BitVolume& by_fr = fr();
  const RunLabelling labelling = label_runs(mortar(), Connectivity::kFace, context_, held);
  const std::vector<Ballot> ballots = count_ballots(labelling, shape_, by_rf, by_fr, held, context_);
  std::vector<char> takes_fr(ballots.size());
  std::vector<char> ties(ballots.size());
  MasonCounts counted;
  counted.mortar_components = labelling.count();
  for (std::size_t component = 0; component < ballots.size(); ++component) {
    const Ballot& ballot = ballots[component];
    const bool tied = ballot.changed_fr == ballot.changed_rf;
    ties[component] = tied;
    takes_fr[component] = tied ? tie_takes_fr(ballot, tie) : ballot.changed_fr < ballot.changed_rf;
    counted.mortar_voxels += ballot.voxels;
    ++(tied ? counted.ties : takes_fr[component] != 0 ? counted.by_fr : counted.by_rf);
  }
  if (counts != nullptr) *counts = counted;
  if (maps != nullptr) {
    maps->took_fr = voxels_of(labelling, takes_fr, context_);
    maps->tied = voxels_of(labelling, ties, context_);
  }
  BitVolume result = shape_;  // outside the mortar all filters agree with S
  for_each_row(result, context_, [&](BitWord* row, std::int64_t, std::int64_t j, std::int64_t k) {
    for (const auto& run : labelling.runs_of_row(j, k)) {
      const BitWord* from = (takes_fr[static_cast<std::size_t>(run.component)] != 0 ? by_fr : by_rf).row(j, k);
      for_each_word(run.begin, run.end,
                    [&](std::int64_t w, BitWord mask) { row[w] = (row[w] & ~mask) | (from[w] & mask); });
    }
  });
  return result;
}

BitVolume RegularFilters::apply(MorphologicalFilter filter, TieRule tie, MasonCounts* counts, std::uint64_t held) && {
  switch (filter) {
    case MorphologicalFilter::kDilate:
      return dilate(shape_, reach_, outside_, context_);
    case MorphologicalFilter::kErode:
      return erode(shape_, reach_, outside_, context_);
    case MorphologicalFilter::kRound:
      rounded();
      return *std::exchange(rounded_, std::nullopt);
    case MorphologicalFilter::kFillet:
      filleted();
      return *std::exchange(filleted_, std::nullopt);
    case MorphologicalFilter::kRf:
      rf();
      return *std::exchange(rf_, std::nullopt);
    case MorphologicalFilter::kFr:
      fr();
      return *std::exchange(fr_, std::nullopt);
    case MorphologicalFilter::kMason:
      return mason(tie, counts, nullptr, held);
  }
  return shape_;
}

}  // namespace voxcarve
