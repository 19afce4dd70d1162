// Hagbi & El-Sana: topology simplification by carving the complement.
#pragma once

#include <memory>

#include "methods/hagbi_elsana/stream.h"
#include "methods/method.h"

namespace voxcarve {

/// The method `hagbi-elsana`; parameters: `voxcarve methods hagbi-elsana`, or README.md beside this file.
std::unique_ptr<Method> make_hagbi_elsana();

/// The stream behind the levels of a run of it; null for those of other methods.
std::shared_ptr<const CarvingStream> stream_of(const LevelSequence& levels);

/// The levels of a stream, one for every number of vertices.
std::shared_ptr<const LevelSequence> make_levels(std::shared_ptr<const CarvingStream> stream);

}  // namespace voxcarve
