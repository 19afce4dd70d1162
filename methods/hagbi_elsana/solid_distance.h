// How far a carved solid reaches from the model.
#pragma once

#include <optional>

#include "methods/hagbi_elsana/stream.h"

namespace voxcarve {

/// The first step whose solid C_i lies within `distance` (model units) of the model: no point of it is farther from M.
/// Certified: distances between sampled points are bounded, so the step is never too early; it may come later than
/// need be where a tetrahedron's greatest distance is not proven to be within reach by 20,000 pieces of it: where it
/// misses `distance` by less than 1 in 1,000, or halfway between walls. Nothing when no step does, because
/// of voids that were left shut. Throws Cancelled.
std::optional<std::uint32_t> step_within(const CarvingStream& stream, double distance, RunContext& context);

}  // namespace voxcarve
