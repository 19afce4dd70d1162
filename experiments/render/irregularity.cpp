#include "experiments/render/irregularity.h"

#include <array>

#include "common/volume/bit_morphology.h"

namespace voxcarve {

namespace {

/// Of the voxels that none of R(S), S and F(S) holds, that F(S) alone does, S and F(S), and all three.
constexpr std::array<Rgb8, 4> kColors = {{{255, 255, 255}, {0, 160, 0}, {220, 0, 0}, {0, 0, 0}}};

/// How many of R(S), S and F(S), one within the other, hold each voxel.
Grid<std::uint8_t> count_holders(const BinaryVolume& volume, double radius, RunContext& context) {
  const std::int64_t reach = squared_reach(radius);
  const Index3 margin = ball_margin(volume.frame.dims, radius);
  context.require_memory(3 * volume.values.size() + BitVolume::memory(volume.frame.dims + 2 * margin), "regularity");
  const BitVolume shape = packed(volume, margin, false, context);
  Grid<std::uint8_t> holders = expanded(open(shape, reach, false, context), volume.frame, margin, context);
  const BinaryVolume filleted = expanded(close(shape, reach, false, context), volume.frame, margin, context);
  for (std::size_t at = 0; at < holders.values.size(); ++at) {
    holders.values[at] = static_cast<std::uint8_t>(holders.values[at] + volume.values[at] + filleted.values[at]);
  }
  return holders;
}

}  // namespace

SlicePicture irregularity_slice(const BinaryVolume& volume, int axis, std::int64_t index, double radius,
                                RunContext& context) {
  const SliceField field = extract_slice(count_holders(volume, radius, context), axis, index);
  SlicePicture picture = color_slice(field, {});
  for (std::size_t at = 0; at < picture.colors.size(); ++at)
    picture.colors[at] = kColors[static_cast<std::size_t>(field.values[at])];
  return picture;
}

}  // namespace voxcarve
