// The theorems of Williams and Rossignac, checked on one result.
#pragma once

#include <vector>

#include "methods/mason/regular_filters.h"
#include "methods/method.h"

namespace voxcarve {

/// Every theorem [WR05, 3.2 to 3.6 and 8] that says something of `filter`, with the numbers that decide it in
/// `detail`, on a result of it and the shape it was made of: both on the same grid, padded as RegularFilters asks, in
/// an exterior.
std::vector<InvariantCheck> check_theorems(const BitVolume& shape, const BitVolume& result, std::int64_t reach,
                                           MorphologicalFilter filter, TieRule tie, RunContext& context);

}  // namespace voxcarve
