// Eight-bit colours of pixels, vertices and voxels.
#pragma once

#include <array>
#include <cstdint>

namespace voxcarve {

using Rgb8 = std::array<std::uint8_t, 3>;

/// Warm grey: the colour of a shape that has none.
inline constexpr Rgb8 kNeutralColor = {215, 207, 194};

}  // namespace voxcarve
