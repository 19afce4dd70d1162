// Point membership of any kind of solid, on lattices.
#pragma once

#include <cstdint>
#include <memory>

#include "common/model.h"
#include "common/run/context.h"
#include "common/volume/bit_volume.h"
#include "common/volume/voxelize.h"

namespace voxcarve {

/// S of [He95, eq. 2]: which points are the object's.
class SolidSampler {
 public:
  virtual ~SolidSampler() = default;

  /// Holds the object.
  virtual Box box() const = 0;

  /// The items of progress of `sample`.
  virtual std::int64_t items(const GridFrame& lattice) const = 0;

  /// A bit for the centre of every voxel of `lattice`, 1 inside. Advances `stage` by `items(lattice)`. `held` are the
  /// bytes that the caller holds meanwhile, the result among them.
  virtual BitVolume sample(const GridFrame& lattice, std::uint64_t held, Stage& stage, RunContext& context) const = 0;
};

/// Of a soup: the majority of the parity counts, or ray stabbing, as `options` say [NT03, 3.1 and 3.2]. Of a scalar
/// volume: the trilinear interpolation of its samples against the iso-value [He95, 4], constant from the outermost
/// samples to the faces of their voxels, exterior beyond them. Of a binary volume: the same of 0 and 1 with iso-value
/// 1/2. Of an implicit solid: itself; blocks that its clearance shows to be of one class cost one evaluation. `model`
/// must outlive the sampler.
std::unique_ptr<SolidSampler> make_sampler(const Model& model, const VoxelizeOptions& options);

}  // namespace voxcarve
