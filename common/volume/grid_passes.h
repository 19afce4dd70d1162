// Passes over whole grids on several threads, which can be cancelled: the same results as their namesakes in grid.h.
#pragma once

#include <algorithm>
#include <cstdint>

#include "common/run/context.h"
#include "common/volume/grid.h"

namespace voxcarve {

inline constexpr std::int64_t kVoxelsPerPass = 1 << 18;  ///< that one piece of such a pass treats

/// The voxels whose value is at least `threshold`.
BinaryVolume thresholded(const Grid<float>& field, float threshold, const RunContext& context);

/// Number of interior voxels.
std::int64_t count_interior(const BinaryVolume& volume, const RunContext& context);

/// The part of `grid` on `frame`, which must lie on the same lattice; voxels of `frame` outside `grid` become
/// `outside`.
template <class T>
Grid<T> resized(const Grid<T>& grid, const GridFrame& frame, T outside, const RunContext& context) {
  auto result = Grid<T>::uninitialized(frame);
  const Point shift = (frame.origin - grid.frame.origin) / grid.frame.voxel_size;
  const Index3 offset = shift.array().round().cast<std::int64_t>();
  const std::int64_t nx = frame.dims[0];
  const std::int64_t begin = std::clamp<std::int64_t>(-offset[0], 0, nx);
  const std::int64_t end = std::clamp<std::int64_t>(grid.nx() - offset[0], begin, nx);
  const std::int64_t grain = std::max<std::int64_t>(1, kVoxelsPerPass / std::max<std::int64_t>(nx, 1));
  parallel_for(context, 0, frame.dims[1] * frame.dims[2], grain, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t row = first; row < last; ++row) {
      T* const values = result.values.data() + row * nx;
      const std::int64_t j = row % frame.dims[1] + offset[1];
      const std::int64_t k = row / frame.dims[1] + offset[2];
      const bool meets = begin < end && j >= 0 && j < grid.ny() && k >= 0 && k < grid.nz();
      std::fill(values, values + (meets ? begin : nx), outside);
      if (!meets) continue;
      std::copy_n(grid.values.data() + grid.index(begin + offset[0], j, k), end - begin, values + begin);
      std::fill(values + end, values + nx, outside);
    }
  });
  return result;
}

}  // namespace voxcarve
