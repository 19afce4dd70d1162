// Inputs of the benchmarks: one bumpy ball as triangles of even size at any count, and smooth densities.
#pragma once

#include <cstdint>

#include "common/mesh/triangle_soup.h"
#include "common/volume/grid.h"

namespace voxcarve::bench {

/// A ball with bumps of a tenth of its radius: an icosahedron whose faces are cut into n^2 triangles, with n chosen so
/// that 20 n^2 is nearest to `triangles`. Closed, outward, vertices shared; lies askew to the axes.
TriangleSoup bumpy_ball(std::int64_t triangles);

/// Densities of the same ball filling `resolution`^3 voxels of size 1: 0 outside, 1 inside, linear over a band of about
/// four voxels. Its surface at 1/2 has about 9 resolution^2 triangles.
DensityVolume bumpy_ball_density(std::int64_t resolution);

/// Densities of the part within a ball of the gyroid sin x cos y + sin y cos z + sin z cos x >= 0 with `periods`
/// periods along each axis, on `resolution`^3 voxels of size 1. Tunnels of one size all over.
DensityVolume gyroid_density(std::int64_t resolution, double periods);

}  // namespace voxcarve::bench
