// Binary morphology with the Euclidean ball {|x| <= distance}.
#pragma once

#include "common/run/context.h"
#include "common/volume/distance_transform.h"
#include "common/volume/grid.h"

namespace voxcarve {

// Distances are in voxels, any real >= 0; the ball is closed, so a distance of 1 reaches the six face neighbours [NT03,
// 4: "distance less than or equal to the threshold"]. The complement is unbounded: everything outside a grid is
// exterior. Results that can grow come on a padded grid; the others on the grid of `volume`. With Danielsson's map,
// which now and then says too much, an opening may gain and a closing lose single voxels; it holds 7 bytes a padded
// voxel, the caller's volume among them. The exact ball takes the caller's byte a voxel, the result's, and three bits
// beside (bit_morphology.h), or 7 bytes beyond a radius of 180 voxels.

/// Every voxel within `distance` of an interior one; the grid grows by ceil(distance) on every side.
BinaryVolume dilate(const BinaryVolume& volume, double distance, RunContext& context,
                    DistanceMap map = DistanceMap::kExact);

/// Every voxel whose distance to the exterior is more than `distance`.
BinaryVolume erode(const BinaryVolume& volume, double distance, RunContext& context,
                   DistanceMap map = DistanceMap::kExact);

/// Erosion, then dilation: removes what the ball does not fit into. On the grid of `volume`.
BinaryVolume open(const BinaryVolume& volume, double distance, RunContext& context,
                  DistanceMap map = DistanceMap::kExact);

/// Dilation, then erosion: fills what the ball does not fit into from outside. On the grid of `volume`, which it never
/// leaves, because a closing stays within the convex hull.
BinaryVolume close(const BinaryVolume& volume, double distance, RunContext& context,
                   DistanceMap map = DistanceMap::kExact);

}  // namespace voxcarve
