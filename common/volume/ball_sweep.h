// Which voxels lie within a given distance of a feature: what dilation and erosion by a ball come down to.
#pragma once

#include <cstdint>

#include "common/run/context.h"
#include "common/volume/bit_volume.h"

namespace voxcarve {

/// Largest squared distance that `within_reach` takes: beyond it two squares no longer fit into 16 bits. That is a ball
/// of radius 180.
inline constexpr std::int64_t kLargestSweptReach = 32760;

/// What a question about distances takes for features.
struct Features {
  bool value = true;    ///< the bits that are features
  bool outside = true;  ///< features lie everywhere outside the grid; on an image, that is in its plane
};

/// The voxels that lie within sqrt(`squared_reach`) voxels of a feature, as set bits; with `inverted`, all others.
/// Exact in integers. Balls are disks on a single slice. `squared_reach` is at most kLargestSweptReach. Rows of
/// slices are shared out among threads, so that an image is too; cancellation is checked at every row.
BitVolume within_reach(const BitVolume& volume, const Features& features, std::int64_t squared_reach, bool inverted,
                       RunContext& context);

/// Bytes that `within_reach` holds beside its argument.
std::uint64_t within_reach_memory(const Index3& dims, std::int64_t squared_reach);

}  // namespace voxcarve
