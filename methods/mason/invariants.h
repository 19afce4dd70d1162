// The theorems of Williams and Rossignac, checked on one result.
#pragma once

#include <vector>

#include "methods/mason/regular_filters.h"
#include "methods/method.h"

namespace voxcarve {

/// Every theorem [WR05, 3.2 to 3.6 and 8] that says something of `filter`, with the numbers that decide it in
/// `detail`: first what they say of `result`, that it is what the filter makes of `shape` among it, then what they say
/// of the sets R, F, RF and FR of the shape. Both volumes lie on the same grid, padded as RegularFilters asks, in an
/// exterior. Holds up to 15 volumes of bits beside them, and the components of the mortar.
std::vector<InvariantCheck> check_theorems(const BitVolume& shape, const BitVolume& result, std::int64_t reach,
                                           MorphologicalFilter filter, TieRule tie, RunContext& context);

}  // namespace voxcarve
