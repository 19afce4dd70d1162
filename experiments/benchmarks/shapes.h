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

/// A volume of side^3 voxels for morphology: balls of 2 to 12 voxels' radius wherever they fall and four of 0.22 side
/// (at 512 that is 113 voxels) apart from each other, 30 % interior in all. One layer all around is exterior, so that a
/// transform that does not see beyond the grid finds the same. Large and small balls take the same shares at every
/// side, so the work of a voxel stays the same.
BinaryVolume scattered_balls(std::int64_t side);

/// The bumpy ball stretched to fill `dims`, with 200 balls added to its surface and as many taken out of it, of 3
/// voxels radius up to a ninth of the smallest dimension: a core that a ball of 0.3 of that still fits into, and
/// irregular regions of both kinds all around.
BinaryVolume pitted_ellipsoid(const Index3& dims);

/// Densities of the part within a ball of the gyroid sin x cos y + sin y cos z + sin z cos x >= 0 with `periods`
/// periods along each axis, on `resolution`^3 voxels of size 1. Tunnels of one size all over.
DensityVolume gyroid_density(std::int64_t resolution, double periods);

}  // namespace voxcarve::bench
