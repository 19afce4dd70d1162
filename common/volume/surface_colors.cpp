// Based on [NT03, 5.2]: each voxel takes the colour of the nearest surface voxel, and marching cubes interpolates along
// grid edges. Differs in using a feature transform in place of a second distance map.
#include <algorithm>
#include <cmath>

#include "common/run/errors.h"
#include "common/volume/distance_transform.h"
#include "common/volume/grid_passes.h"
#include "common/volume/surface_voxels.h"

namespace voxcarve {

namespace {

Index3 voxel_of(std::int64_t index, const GridFrame& frame) {
  return {index % frame.dims[0], index / frame.dims[0] % frame.dims[1], index / (frame.dims[0] * frame.dims[1])};
}

/// `frame` grown so that it holds every surface voxel.
GridFrame holding(const GridFrame& frame, const SurfaceColors& surface, const Index3& shift) {
  Index3 low = Index3::Zero();
  Index3 high = frame.dims;
  for (const std::int64_t index : surface.voxels) {
    const Index3 voxel = voxel_of(index, surface.frame) + shift;
    low = low.cwiseMin(voxel);
    high = high.cwiseMax(voxel + Index3::Ones());
  }
  GridFrame larger = frame;
  larger.dims = high - low;
  larger.origin += frame.voxel_size * low.cast<double>();
  return larger;
}

/// Surface voxels by their index in another grid: from an index to the number of the voxel.
class VoxelNumbers {
 public:
  VoxelNumbers(std::vector<std::uint32_t> ascending, const GridFrame& frame)
      : voxels_(std::move(ascending)),
        nx_(static_cast<std::uint32_t>(frame.dims[0])),
        row_(static_cast<std::size_t>(frame.dims[1] * frame.dims[2]) + 1, 0) {
    for (const std::uint32_t voxel : voxels_) ++row_[voxel / nx_ + std::size_t{1}];
    for (std::size_t r = 1; r < row_.size(); ++r) row_[r] += row_[r - 1];
  }

  std::uint32_t operator()(std::uint32_t voxel) const {
    const std::size_t row = voxel / nx_;
    const auto first = voxels_.begin() + row_[row];
    const auto last = voxels_.begin() + row_[row + 1];
    return static_cast<std::uint32_t>(std::lower_bound(first, last, voxel) - voxels_.begin());
  }

 private:
  std::vector<std::uint32_t> voxels_;
  std::uint32_t nx_;
  std::vector<std::uint32_t> row_;  ///< number of the first voxel of every row
};

}  // namespace

NearestColors::NearestColors(const SurfaceColors& surface, const GridFrame& frame, RunContext& context)
    : frame_(frame), colors_(surface.colors) {
  if (surface.empty()) throw InputError("there is no coloured surface voxel to take colours from");
  Stage stage(context, "nearest colours", frame.voxels());
  const Point distance = (surface.frame.origin - frame.origin) / frame.voxel_size;
  const Index3 shift = distance.array().round().cast<std::int64_t>();
  // The nearest surface voxel may lie beyond `frame`.
  const GridFrame whole = holding(frame, surface, shift);
  const auto voxels = static_cast<std::uint64_t>(whole.voxels());
  context.require_memory(voxels * (sizeof(std::uint32_t) + 1) +
                             (whole == frame ? 0 : static_cast<std::uint64_t>(frame.voxels()) * sizeof(std::uint32_t)) +
                             surface.voxels.size() * (sizeof(Color) + sizeof(std::uint32_t)),
                         "the nearest colours");
  const Index3 inner = ((frame.origin - whole.origin) / frame.voxel_size).array().round().cast<std::int64_t>();
  std::vector<std::uint32_t> marked;
  marked.reserve(surface.voxels.size());
  {
    BinaryVolume volume(whole);
    for (const std::int64_t index : surface.voxels) {
      const Index3 voxel = voxel_of(index, surface.frame) + shift + inner;
      const std::size_t place = volume.index(voxel[0], voxel[1], voxel[2]);
      volume.values[place] = 1;
      marked.push_back(static_cast<std::uint32_t>(place));  // nearest_feature refuses more voxels than that
    }
    nearest_ = nearest_feature(volume, 1, context);
  }
  if (whole != frame) nearest_ = resized(nearest_, frame, kNoFeature, context);
  const VoxelNumbers number_of(std::move(marked), whole);
  constexpr std::int64_t kVoxelsPerChunk = 1 << 17;
  parallel_for(context, 0, frame.voxels(), kVoxelsPerChunk, [&](std::int64_t begin, std::int64_t end) {
    std::uint32_t last = kNoFeature;
    std::uint32_t number = 0;
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
      std::uint32_t& value = nearest_.values[i];
      if (value != last) {
        last = value;
        number = number_of(value);
      }
      value = number;
    }
    stage.advance(end - begin);
  });
}

const Color& NearestColors::at(Index3 voxel) const {
  voxel = voxel.cwiseMax(0).cwiseMin(frame_.dims - Index3::Ones());
  return colors_[nearest_(voxel[0], voxel[1], voxel[2])];
}

void interpolate_colors(TriangleSoup& surface, const NearestColors& colors, RunContext& context) {
  const GridFrame& frame = colors.frame();
  context.require_memory(surface.positions.size() * sizeof(Color), "the surface's colours");
  surface.vertex_colors.resize(surface.positions.size());
  constexpr std::int64_t kVerticesPerChunk = 1 << 14;
  const auto count = static_cast<std::int64_t>(surface.positions.size());
  parallel_for(context, 0, count, kVerticesPerChunk, [&](std::int64_t begin, std::int64_t end) {
    for (auto v = static_cast<std::size_t>(begin); v < static_cast<std::size_t>(end); ++v) {
      // Of a vertex on a grid edge, the coordinate along the edge is the only one that is no voxel centre's.
      const Point place = (surface.positions[v] - frame.origin) / frame.voxel_size - Point::Constant(0.5);
      const Point nearest = place.array().round();
      Eigen::Index axis = 0;
      (place - nearest).cwiseAbs().maxCoeff(&axis);
      Index3 low = nearest.cast<std::int64_t>();
      low[axis] = static_cast<std::int64_t>(std::floor(place[axis]));
      Index3 high = low;
      ++high[axis];
      const auto share = static_cast<float>(place[axis] - std::floor(place[axis]));
      surface.vertex_colors[v] = (1 - share) * colors.at(low) + share * colors.at(high);
    }
  });
}

}  // namespace voxcarve
