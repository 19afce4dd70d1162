// Based on parity count and ray stabbing [NT03, 3.1 and 3.2]; differs in casting a ray of every direction exactly
// through every voxel centre. Along the axes all voxels of a column share one ray, so a column needs one toggled bit a
// crossing instead of a sorted list, and the votes of 64 voxels are counted at once, a word for each binary digit.
#include "common/volume/bit_voxelizer.h"

#include <algorithm>
#include <atomic>
#include <optional>

#include "common/run/errors.h"
#include "common/volume/column_votes.h"
#include "common/volume/oblique_votes.h"
#include "common/volume/settling.h"

namespace voxcarve {

namespace {

/// The classes of a word of voxels, and which of them are disputed.
struct WordClasses {
  BitWord interior = 0;
  BitWord disputed = 0;
};

/// The majority of three axes, some of which may abstain. Disputed is a draw, be it for want of votes.
WordClasses majority(const RowVotes& votes, std::int64_t word) {
  const auto interior = [&](std::size_t axis) { return votes.interior[axis][word]; };
  const auto abstains = [&](std::size_t axis) { return votes.abstains[axis][word]; };
  const auto two_of = [](BitWord a, BitWord b, BitWord c) { return (a & b) | (c & (a | b)); };
  if ((abstains(0) | abstains(1) | abstains(2)) == 0) return {two_of(interior(0), interior(1), interior(2)), 0};
  const BitWord a = interior(0) & ~abstains(0);
  const BitWord b = interior(1) & ~abstains(1);
  const BitWord c = interior(2) & ~abstains(2);
  const BitWord not_a = ~interior(0) & ~abstains(0);
  const BitWord not_b = ~interior(1) & ~abstains(1);
  const BitWord not_c = ~interior(2) & ~abstains(2);
  const BitWord two_in = two_of(a, b, c);
  const BitWord two_out = two_of(not_a, not_b, not_c);
  const BitWord any_in = a | b | c;
  const BitWord any_out = not_a | not_b | not_c;
  return {two_in | (any_in & ~any_out), ~two_in & ~two_out & ~(any_in ^ any_out)};
}

/// Interior where every axis that votes says so, and one does.
BitWord unanimity(const RowVotes& votes, std::int64_t word) {
  BitWord interior = kAllBits;
  BitWord nobody = kAllBits;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (votes.interior[axis] == nullptr) continue;
    interior &= votes.interior[axis][word] | votes.abstains[axis][word];
    nobody &= votes.abstains[axis][word];
  }
  return interior & ~nobody;
}

/// Counts of votes on a word of voxels: at most 64.
WordClasses classes_of(const VoteCount* counts, std::int64_t voxels, const VoxelizeOptions& options) {
  WordClasses classes;
  for (std::int64_t i = 0; i < voxels; ++i) {
    const int in = interior_votes(counts[i]);
    const int out = exterior_votes(counts[i]);
    const bool interior = options.classifier == Classifier::kStabbing ? in > 0 && out == 0 : in > out;
    const bool split = (in > 0 && out > 0) || in + out == 0;
    classes.interior |= BitWord{interior} << i;
    classes.disputed |= BitWord{split && 2 * std::max(in, out) < options.directions} << i;
  }
  return classes;
}

/// A voxelization on its way from votes to classes.
class BitVoxelizer {
 public:
  BitVoxelizer(const TriangleSoup& soup, const GridFrame& frame, const VoxelizeOptions& options, std::uint64_t held,
               Stage& stage, RunContext& context)
      : soup_(soup), frame_(frame), options_(options), held_(held), stage_(stage), context_(context) {}

  BitVolume run(VoxelizeReport* report) {
    context_.require_memory(held_ + BitVolume::memory(frame_.dims) + soup_.positions.size() * sizeof(LatticePoint),
                            "voxelization");
    bits_ = BitVolume(frame_.dims);
    {
      const LatticeSoup lattice(soup_, frame_, context_);
      vote(lattice, report);
    }
    if (settles()) {
      const std::int64_t settled = settle(bits_, disputed_, options_.settle_sweeps, context_);
      if (report != nullptr) report->settled_voxels = settled;
    }
    return std::move(bits_);
  }

 private:
  /// A single direction has no majority: what its invalid columns lose is lost [NT03, Fig. 4].
  bool settles() const {
    return options_.classifier == Classifier::kParity && options_.directions > 1 && options_.settle_sweeps > 0;
  }

  ColumnVoteOptions column_options() const {
    ColumnVoteOptions columns;
    if (options_.directions == 1) {
      columns.axes = {options_.axis == 0, options_.axis == 1, options_.axis == 2};
    }
    columns.stabbing = options_.classifier == Classifier::kStabbing;
    columns.odd_abstain = !columns.stabbing || options_.stab_validity;
    return columns;
  }

  void vote(const LatticeSoup& lattice, VoxelizeReport* report) {
    const ColumnVoteOptions columns = column_options();
    ColumnVotes votes(lattice, bits_, columns, held_, stage_, context_);
    held_before_disputes_ = votes.memory();
    disputed_.resize(static_cast<std::size_t>(votes.slabs()));
    if (options_.directions == 13) {
      vote_all_ways(lattice, votes, columns);
    } else {
      parallel_for(context_, 0, votes.slabs(), 1, [&](std::int64_t slab, std::int64_t) { vote_by_axes(votes, slab); });
    }
    for (std::size_t axis = 0; axis < 3 && report != nullptr; ++axis) {
      if (!columns.axes[axis]) continue;
      report->axes.push_back(
          {static_cast<int>(axis), votes.columns(axis), columns.odd_abstain ? votes.odd_columns(axis) : 0});
    }
  }

  void vote_by_axes(ColumnVotes& votes, std::int64_t slab) {
    const bool by_majority = options_.classifier == Classifier::kParity && options_.directions == 3;
    const std::int64_t words = bits_.row_words();
    const BitWord last_mask = last_word_mask(frame_.dims[0]);
    auto& disputed = disputed_[static_cast<std::size_t>(slab)];
    votes.classify_slab(slab, [&](std::int64_t j, std::int64_t k, const RowVotes& row) {
      BitWord* out = bits_.row(j, k);
      for (std::int64_t word = 0; word < words; ++word) {
        if (!by_majority) {
          out[word] = unanimity(row, word);
          continue;
        }
        const WordClasses classes = majority(row, word);
        out[word] = classes.interior;
        if (classes.disputed != 0) note_disputed(disputed, j, k, word, classes);
      }
      out[words - 1] &= last_mask;
    });
    declare_disputed(disputed);
  }

  /// Counts votes a chunk of slabs at a time, so that counts of one byte a voxel stay small beside the grid's, and
  /// large beside the triangles, which are sorted anew for every direction of a chunk.
  void vote_all_ways(const LatticeSoup& lattice, ColumnVotes& votes, const ColumnVoteOptions& columns) {
    const std::vector<Point> all = voxelization_directions(options_.directions);
    const std::vector<Point> oblique(all.begin() + 3, all.end());
    const std::int64_t slice_voxels = frame_.dims[0] * frame_.dims[1];
    constexpr std::int64_t kChunkVoxels = std::int64_t{1} << 27;
    GridValues<VoteCount> counts;
    std::optional<Curtains> curtains;
    std::uint64_t held_by_curtains = 0;
    if (!columns.stabbing) {
      held_by_curtains = Curtains::memory(soup_);
      context_.require_memory(votes.memory() + held_by_curtains, "voxelization");
      curtains.emplace(soup_, lattice);
      if (!curtains->pay_off(frame_.dims)) curtains.reset();
    }
    for (std::int64_t slab = 0; slab < votes.slabs();) {
      std::int64_t end = slab + 1;
      const std::int64_t first = votes.slices(slab).first;
      while (end < votes.slabs() && (votes.slices(end).last - first + 1) * slice_voxels <= kChunkVoxels) ++end;
      const IndexRange slices{first, votes.slices(end - 1).last};
      const Index3 dims(frame_.dims[0], frame_.dims[1], slices.size());
      const std::uint64_t held = votes.memory() + held_by_curtains + static_cast<std::uint64_t>(dims.prod()) +
                                 (curtains ? BitVolume::memory(dims) : 0);
      held_before_disputes_ = held;
      context_.require_memory(held, "voxelization");
      counts.assign(static_cast<std::size_t>(dims.prod()), 0);
      BitVolume along_x;
      if (curtains) along_x = BitVolume(dims);
      const auto row_of = [&](std::int64_t j, std::int64_t k) {
        return counts.data() + (k - first) * slice_voxels + j * frame_.dims[0];
      };
      parallel_for(context_, slab, end, 1, [&](std::int64_t at, std::int64_t) {
        votes.classify_slab(at, [&](std::int64_t j, std::int64_t k, const RowVotes& row) {
          count_row(row, dims[0], row_of(j, k));
          if (curtains) std::copy_n(row.interior[0], along_x.row_words(), along_x.row(j, k - first));
        });
      });
      std::optional<KnownParities> known;
      if (curtains) known.emplace(KnownParities{*curtains, along_x});
      vote_oblique(soup_, frame_, slices, oblique, {options_.directions, columns.stabbing, columns.odd_abstain},
                   known ? &*known : nullptr, held, counts, stage_, context_);
      parallel_for(context_, slab, end, 1, [&](std::int64_t at, std::int64_t) {
        classify_counted(votes.slices(at), counts.data() + (votes.slices(at).first - first) * slice_voxels,
                         disputed_[static_cast<std::size_t>(at)]);
      });
      slab = end;
    }
  }

  /// Classes of the slices of a slab from their counts of votes.
  void classify_counted(IndexRange slices, const VoteCount* counts, std::vector<DisputedWord>& disputed) {
    const std::int64_t nx = frame_.dims[0];
    for (std::int64_t k = slices.first; k <= slices.last; ++k) {
      for (std::int64_t j = 0; j < frame_.dims[1]; ++j, counts += nx) {
        for (std::int64_t word = 0; word < bits_.row_words(); ++word) {
          const std::int64_t voxels = std::min(kWordBits, nx - word * kWordBits);
          const WordClasses classes = classes_of(counts + word * kWordBits, voxels, options_);
          bits_.row(j, k)[word] = classes.interior;
          if (classes.disputed != 0) note_disputed(disputed, j, k, word, classes);
        }
      }
    }
    declare_disputed(disputed);
  }

  void note_disputed(std::vector<DisputedWord>& disputed, std::int64_t j, std::int64_t k, std::int64_t word,
                     const WordClasses& classes) {
    if (!settles()) return;
    const bool is_last = word == bits_.row_words() - 1;
    const BitWord voxels = classes.disputed & (is_last ? last_word_mask(frame_.dims[0]) : kAllBits);
    if (voxels == 0) return;
    disputed.push_back({(k * frame_.dims[1] + j) * bits_.row_words() + word, voxels, classes.interior, 0});
  }

  /// Disputed words cannot be counted before they are there: a slab's are declared with those of all before it.
  void declare_disputed(const std::vector<DisputedWord>& disputed) {
    const std::uint64_t bytes = disputed_bytes_ += disputed.capacity() * sizeof(DisputedWord);
    context_.require_memory(held_before_disputes_ + bytes, "settling disputed votes");
  }

  const TriangleSoup& soup_;
  const GridFrame& frame_;
  const VoxelizeOptions& options_;
  std::uint64_t held_;
  Stage& stage_;
  RunContext& context_;
  BitVolume bits_;
  std::vector<std::vector<DisputedWord>> disputed_;  ///< of every slab
  std::uint64_t held_before_disputes_ = 0;
  std::atomic<std::uint64_t> disputed_bytes_ = 0;
};

}  // namespace

void require_voxels(const GridFrame& frame) {
  if (frame.dims.minCoeff() < 1) throw InputError("there is nothing to voxelize: the grid has no voxels");
}

BitVolume voxelize_bits(const TriangleSoup& soup, const GridFrame& frame, const VoxelizeOptions& options,
                        std::uint64_t held, Stage& stage, RunContext& context, VoxelizeReport* report) {
  return BitVoxelizer(soup, frame, options, held, stage, context).run(report);
}

std::int64_t voxelization_items(const TriangleSoup& soup, const GridFrame& frame, const VoxelizeOptions& options) {
  const auto triangles = static_cast<std::int64_t>(soup.triangles.size());
  const std::int64_t axes = options.directions == 1 ? 1 : 3;
  return axes * triangles + (options.directions - axes) * frame.dims[2];
}

}  // namespace voxcarve
