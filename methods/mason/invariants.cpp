#include "methods/mason/invariants.h"

#include <algorithm>

#include "common/volume/bit_morphology.h"

namespace voxcarve {

namespace {

class Theorems {
 public:
  Theorems(const BitVolume& shape, const BitVolume& result, std::int64_t reach, RunContext& context)
      : shape_(shape), result_(result), reach_(reach), context_(context), filters_(shape, reach, false, context) {}

  void result_is(const char* name, const BitVolume& expected) {
    none(name, count_difference(result_, expected, context_));
  }

  void grows() { none("S <= result", count_beyond(shape_, result_, context_)); }
  void shrinks() { none("result <= S", count_beyond(result_, shape_, context_)); }

  /// Theorems 1 and 2.
  void stays_between() {
    none("R <= RF", count_beyond(filters_.rounded(), filters_.rf(), context_));
    none("RF <= F", count_beyond(filters_.rf(), filters_.filleted(), context_));
    none("R <= FR", count_beyond(filters_.rounded(), filters_.fr(), context_));
    none("FR <= F", count_beyond(filters_.fr(), filters_.filleted(), context_));
  }

  /// Theorem 3, and that no change is farther than the radius from a voxel of the opposite colour.
  void changes_only_the_mortar() {
    const BitVolume changed = xor_of(shape_, result_);
    none("the result differs from S only in the mortar", count_beyond(changed, filters_.mortar(), context_));
    none("every changed voxel has one of the opposite colour of S within the radius",
         count_beyond(changed, near_both_sides(), context_));
  }

  void is_idempotent() {
    none("R(R) = R", count_difference(filters_.rounded(), open(filters_.rounded(), reach_, false, context_), context_));
    none("F(F) = F",
         count_difference(filters_.filleted(), close(filters_.filleted(), reach_, false, context_), context_));
  }

  void is_regular_on_one_side() {
    none("RF has no inner-irregular voxels",
         count_beyond(filters_.rf(), open(filters_.rf(), reach_, false, context_), context_));
    none("FR has no outer-irregular voxels",
         count_beyond(close(filters_.fr(), reach_, false, context_), filters_.fr(), context_));
  }

  void is_dual() {
    const BitVolume other = complement(shape_, context_);
    RegularFilters dual(other, reach_, true, context_);
    none("complement of RF(S) = FR(complement of S)",
         count_difference(complement(filters_.rf(), context_), dual.fr(), context_));
  }

  /// Of Mason: no worse than either, and self-dual, with the paper's rule but for components that tie.
  void mason_holds(TieRule tie) {
    const std::int64_t mason = count_difference(shape_, result_, context_);
    const std::int64_t rf = count_difference(shape_, filters_.rf(), context_);
    const std::int64_t fr = count_difference(shape_, filters_.fr(), context_);
    add("Mason changes no more than RF or FR", mason <= std::min(rf, fr),
        "Mason " + std::to_string(mason) + ", RF " + std::to_string(rf) + ", FR " + std::to_string(fr));
    const BitVolume other = complement(shape_, context_);
    RegularFilters dual(other, reach_, true, context_);
    const BitVolume different = xor_of(complement(result_, context_), dual.mason(tie));
    if (tie == TieRule::kSelfDual) {
      none("Mason is self-dual", count_set(different, context_));
      return;
    }
    MasonCounts counts;
    MasonMaps maps;
    filters_.mason(tie, &counts, &maps);
    const std::int64_t beyond = count_beyond(different, maps.tied, context_);
    add("Mason is self-dual but for components that tie", beyond == 0,
        std::to_string(beyond) + " exceptions, and " + std::to_string(count_set(different, context_)) + " voxels of " +
            std::to_string(counts.ties) + " components that tie");
  }

  std::vector<InvariantCheck> take() { return std::move(checks_); }
  RegularFilters& filters() { return filters_; }

 private:
  void add(const char* name, bool holds, std::string detail) { checks_.push_back({name, holds, std::move(detail)}); }
  void none(const char* name, std::int64_t exceptions) {
    add(name, exceptions == 0, std::to_string(exceptions) + (exceptions == 1 ? " exception" : " exceptions"));
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
    const BitVolume near_exterior = dilate(complement(shape_, context_), reach_, true, context_);
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
  std::vector<InvariantCheck> checks_;
};

}  // namespace

std::vector<InvariantCheck> check_theorems(const BitVolume& shape, const BitVolume& result, std::int64_t reach,
                                           MorphologicalFilter filter, TieRule tie, RunContext& context) {
  Theorems theorems(shape, result, reach, context);
  if (filter == MorphologicalFilter::kDilate) {
    theorems.grows();
    return theorems.take();
  }
  if (filter == MorphologicalFilter::kErode) {
    theorems.shrinks();
    return theorems.take();
  }
  if (filter == MorphologicalFilter::kRound) {
    theorems.shrinks();
    theorems.result_is("the result is R(S)", theorems.filters().rounded());
  }
  if (filter == MorphologicalFilter::kFillet) {
    theorems.grows();
    theorems.result_is("the result is F(S)", theorems.filters().filleted());
  }
  theorems.stays_between();
  theorems.changes_only_the_mortar();
  theorems.is_idempotent();
  theorems.is_regular_on_one_side();
  theorems.is_dual();
  if (filter == MorphologicalFilter::kMason) theorems.mason_holds(tie);
  return theorems.take();
}

}  // namespace voxcarve
