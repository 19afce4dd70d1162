// Based on [WR05, 3.2 to 3.6, 4.2, 4.3 and 8]; differs in checking, beside the theorems on the sets that the filters
// make of a shape, what they say of the result that was handed over.
#include "methods/mason/invariants.h"

#include <algorithm>
#include <string>
#include <utility>

#include "common/volume/bit_morphology.h"
#include "common/volume/run_labelling.h"

namespace voxcarve {

namespace {

/// Bit volumes that a check holds at its peak, the caller's two and those of a transform among them. Of a dilation or
/// erosion: the complement, the change and both neighbourhoods; of the others also four sets and the dual four; of
/// Mason also its own, its dual and its maps.
constexpr std::uint64_t volumes_held(MorphologicalFilter filter) {
  switch (filter) {
    case MorphologicalFilter::kDilate:
    case MorphologicalFilter::kErode:
      return 8;
    case MorphologicalFilter::kMason:
      return 17;
    default:
      return 14;
  }
}

class Theorems {
 public:
  Theorems(const BitVolume& shape, const BitVolume& result, std::int64_t reach, RunContext& context)
      : shape_(shape),
        result_(result),
        reach_(reach),
        context_(context),
        filters_(shape, reach, false, context),
        other_(complement(shape, context)),
        dual_(other_, reach, true, context) {}

  /// All that is said of one dilation or erosion.
  void check_step(MorphologicalFilter filter) {
    const bool grows = filter == MorphologicalFilter::kDilate;
    grows ? result_contains_shape() : shape_contains_result();
    result_is(grows ? "the result is S grown" : "the result is S shrunk",
              (grows ? dilate : erode)(shape_, reach_, false, context_));
    result_is_dual(grows ? "complement of the result = complement of S shrunk"
                         : "complement of the result = complement of S grown",
                   (grows ? erode : dilate)(other_, reach_, true, context_));
    changes_only_near_both_sides();
  }

  /// All that is said of the others.
  void check_regularization(MorphologicalFilter filter, TieRule tie) {
    switch (filter) {
      case MorphologicalFilter::kRound:
        shape_contains_result();
        result_is("the result is R(S)", filters_.rounded());
        result_is_dual("complement of the result = F(complement of S)", dual_.filleted());
        break;
      case MorphologicalFilter::kFillet:
        result_contains_shape();
        result_is("the result is F(S)", filters_.filleted());
        result_is_dual("complement of the result = R(complement of S)", dual_.rounded());
        break;
      case MorphologicalFilter::kRf:
        result_is("the result is RF(S)", filters_.rf());
        result_is_dual("complement of the result = FR(complement of S)", dual_.fr());
        break;
      case MorphologicalFilter::kFr:
        result_is("the result is FR(S)", filters_.fr());
        result_is_dual("complement of the result = RF(complement of S)", dual_.rf());
        break;
      default:
        mason_holds(tie);
    }
    if (filter != MorphologicalFilter::kRound && filter != MorphologicalFilter::kFillet) result_stays_between();
    result_is_regular(filter);
    changes_only_the_mortar();
    changes_only_near_both_sides();
    sets_stay_between();
    sets_are_idempotent();
    sets_are_regular_on_one_side();
    none("complement of RF(S) = FR(complement of S)",
         count_difference(complement(filters_.rf(), context_), dual_.fr(), context_));
  }

  std::vector<InvariantCheck> take() { return std::move(checks_); }

 private:
  void add(const char* name, bool holds, std::string detail) { checks_.push_back({name, holds, std::move(detail)}); }
  void none(const char* name, std::int64_t exceptions) {
    add(name, exceptions == 0, std::to_string(exceptions) + (exceptions == 1 ? " exception" : " exceptions"));
  }

  /// Bytes held while the components of the mortar are.
  std::uint64_t held() const { return volumes_held(MorphologicalFilter::kMason) * BitVolume::memory(shape_.dims()); }

  // What is said of the result.

  void result_contains_shape() { none("S <= result", count_beyond(shape_, result_, context_)); }
  void shape_contains_result() { none("result <= S", count_beyond(result_, shape_, context_)); }

  void result_is(const char* name, const BitVolume& expected) {
    none(name, count_difference(result_, expected, context_));
  }

  /// `expected` is what the dual filter makes of the complement.
  void result_is_dual(const char* name, const BitVolume& expected) {
    none(name, count_difference(complement(result_, context_), expected, context_));
  }

  void result_stays_between() {
    none("R <= result", count_beyond(filters_.rounded(), result_, context_));
    none("result <= F", count_beyond(result_, filters_.filleted(), context_));
  }

  /// Of a filter that ends with a rounding or a filleting: that another one finds nothing left to do.
  void result_is_regular(MorphologicalFilter filter) {
    const bool round = filter == MorphologicalFilter::kRound;
    const bool fillet = filter == MorphologicalFilter::kFillet;
    if (round || filter == MorphologicalFilter::kRf) {
      const BitVolume again = open(result_, reach_, false, context_);
      none("the result has no inner-irregular voxels", count_beyond(result_, again, context_));
      if (round) result_is("R(result) = result", again);
    }
    if (fillet || filter == MorphologicalFilter::kFr) {
      const BitVolume again = close(result_, reach_, false, context_);
      none("the result has no outer-irregular voxels", count_beyond(again, result_, context_));
      if (fillet) result_is("F(result) = result", again);
    }
  }

  /// Theorem 3.
  void changes_only_the_mortar() {
    none("the result differs from S only in the mortar",
         count_beyond(xor_of(shape_, result_), filters_.mortar(), context_));
  }

  /// No change is farther than the radius from a voxel of the opposite colour.
  void changes_only_near_both_sides() {
    const BitVolume changed = xor_of(shape_, result_);
    none("every changed voxel has one of the opposite colour of S within the radius",
         count_beyond(changed, near_both_sides(), context_));
  }

  /// Of Mason: what it is made of, no worse than either, and self-dual, with the paper's rule but for components that
  /// tie.
  void mason_holds(TieRule tie) {
    MasonCounts counts;
    MasonMaps maps;
    const BitVolume expected = filters_.mason(tie, &counts, &maps, held());
    maps.took_fr = BitVolume();
    result_is("the result is Mason(S)", expected);
    mortar_is_by_components();
    const std::int64_t mason = count_difference(shape_, result_, context_);
    const std::int64_t rf = count_difference(shape_, filters_.rf(), context_);
    const std::int64_t fr = count_difference(shape_, filters_.fr(), context_);
    add("Mason changes no more than RF or FR", mason <= std::min(rf, fr),
        "Mason " + std::to_string(mason) + ", RF " + std::to_string(rf) + ", FR " + std::to_string(fr));
    const BitVolume different = xor_of(complement(result_, context_), dual_.mason(tie, nullptr, nullptr, held()));
    if (tie == TieRule::kSelfDual) {
      none("Mason is self-dual", count_set(different, context_));
      return;
    }
    const std::int64_t beyond = count_beyond(different, maps.tied, context_);
    add("Mason is self-dual but for components that tie", beyond == 0,
        std::to_string(beyond) + " exceptions, and " + std::to_string(count_set(different, context_)) + " voxels of " +
            std::to_string(counts.ties) + " components that tie");
  }

  void mortar_is_by_components() {
    const RunLabelling mortar = label_runs(filters_.mortar(), Connectivity::kFace, context_, held());
    const BitVolume against_rf = xor_of(result_, filters_.rf());
    const BitVolume against_fr = xor_of(result_, filters_.fr());
    context_.require_memory(held() + mortar.memory() + 2 * static_cast<std::uint64_t>(mortar.count()),
                            "the mortar's components");
    std::vector<char> off_rf(static_cast<std::size_t>(mortar.count()));
    std::vector<char> off_fr(off_rf.size());
    for (std::int64_t k = 0; k < shape_.dims()[2]; ++k) {
      context_.check_cancelled();
      for (std::int64_t j = 0; j < shape_.dims()[1]; ++j) {
        for (const LabelledRun& run : mortar.runs_of_row(j, k)) {
          const auto component = static_cast<std::size_t>(run.component);
          if (count_bits(against_rf.row(j, k), run.begin, run.end) > 0) off_rf[component] = 1;
          if (count_bits(against_fr.row(j, k), run.begin, run.end) > 0) off_fr[component] = 1;
        }
      }
    }
    std::int64_t exceptions = 0;
    for (std::size_t component = 0; component < off_rf.size(); ++component)
      exceptions += off_rf[component] != 0 && off_fr[component] != 0 ? 1 : 0;
    add("each component of the mortar is RF or FR there", exceptions == 0,
        std::to_string(exceptions) + " of " + std::to_string(mortar.count()) + " components are neither");
  }

  // What is said of the sets of S, whatever the result.

  /// Theorems 1 and 2.
  void sets_stay_between() {
    none("R <= RF", count_beyond(filters_.rounded(), filters_.rf(), context_));
    none("RF <= F", count_beyond(filters_.rf(), filters_.filleted(), context_));
    none("R <= FR", count_beyond(filters_.rounded(), filters_.fr(), context_));
    none("FR <= F", count_beyond(filters_.fr(), filters_.filleted(), context_));
  }

  void sets_are_idempotent() {
    none("R(R) = R", count_difference(filters_.rounded(), open(filters_.rounded(), reach_, false, context_), context_));
    none("F(F) = F",
         count_difference(filters_.filleted(), close(filters_.filleted(), reach_, false, context_), context_));
  }

  void sets_are_regular_on_one_side() {
    none("RF has no inner-irregular voxels",
         count_beyond(filters_.rf(), open(filters_.rf(), reach_, false, context_), context_));
    none("FR has no outer-irregular voxels",
         count_beyond(close(filters_.fr(), reach_, false, context_), filters_.fr(), context_));
  }

  BitVolume xor_of(BitVolume a, const BitVolume& b) {
    for_each_row(a, context_, [&](BitWord* row, std::int64_t row_words, std::int64_t j, std::int64_t k) {
      for (std::int64_t w = 0; w < row_words; ++w) row[w] ^= b.row(j, k)[w];
    });
    return a;
  }

  /// Voxels within reach of S and of its complement.
  BitVolume near_both_sides() {
    BitVolume near = dilate(shape_, reach_, false, context_);
    const BitVolume near_exterior = dilate(other_, reach_, true, context_);
    for_each_row(near, context_, [&](BitWord* row, std::int64_t row_words, std::int64_t j, std::int64_t k) {
      for (std::int64_t w = 0; w < row_words; ++w) row[w] &= near_exterior.row(j, k)[w];
    });
    return near;
  }

  const BitVolume& shape_;
  const BitVolume& result_;
  std::int64_t reach_;
  RunContext& context_;
  RegularFilters filters_;
  BitVolume other_;  ///< complement of S
  RegularFilters dual_;
  std::vector<InvariantCheck> checks_;
};

}  // namespace

std::vector<InvariantCheck> check_theorems(const BitVolume& shape, const BitVolume& result, std::int64_t reach,
                                           MorphologicalFilter filter, TieRule tie, RunContext& context) {
  context.require_memory(volumes_held(filter) * BitVolume::memory(shape.dims()), "the check of the theorems");
  Theorems theorems(shape, result, reach, context);
  if (filter == MorphologicalFilter::kDilate || filter == MorphologicalFilter::kErode) {
    theorems.check_step(filter);
  } else {
    theorems.check_regularization(filter, tie);
  }
  return theorems.take();
}

}  // namespace voxcarve
