// How far from simple a binary volume is, voxel by voxel [WR05, 1 and 3.3].
#pragma once

#include <cstdint>
#include <span>

#include "common/run/context.h"
#include "common/volume/grid.h"

namespace voxcarve {

// Distances are in voxels and balls are closed; on an image, balls are disks in its plane. Everything outside a grid is
// `outside`: false for a solid, true for the complement of one. The mortar M_r of a volume is what neither its opening
// nor its complement's opening by the ball of radius r holds. The maps are exact in integers and give the same
// for a volume and for its complement with `outside` flipped. `held` are the bytes that the caller holds meanwhile, to
// be declared with what a function holds itself; it throws ResourceError when both exceed the memory budget.

/// Stability [WR05, 3.3]: of each voxel the squared radius of the largest ball of a radius up to `largest` that
/// contains it and lies wholly on its side, whether in the volume or in its complement. An integer: a ball about a
/// voxel at squared distance D from the nearest voxel of the other side reaches D - 1.
///
/// The ball of radius r has the squared radius floor(r^2), so it is that to compare with: r^2 itself may lie between a
/// value and the next. For every r <= `largest`, {value < floor(r^2)} lies within M_r, and it is M_r for r = `largest`.
/// Below that it may be less, because digital balls are not made of the smaller ones: a voxel in a larger ball may lie
/// in none of radius r. For the same reason a smaller `largest` may give less than min(value, floor(`largest`^2)).
///
/// Holds about 10 bytes a voxel of the grid padded by `largest`, and 16 for each ball that no larger one about a
/// neighbouring voxel holds: some in a hundred voxels where a boundary is smooth, up to one in a few in noise. Throws
/// ParameterError unless 0 <= `largest` <= 20000, and ResourceError when a padded side exceeds 26,754 voxels.
Grid<std::int32_t> squared_stability(const BinaryVolume& volume, double largest, bool outside, RunContext& context,
                                     std::uint64_t held = 0);

/// Stability in voxels, from the squared one up to the same `largest`. The ball of squared radius D - 1 is that of
/// every r below sqrt(D), so a value D - 1 becomes the greatest float below sqrt(D) and below `largest`; where the ball
/// of radius `largest` fits, its radius is rounded up to a float.
///
/// For every float r <= `largest`, {stability < r} lies within M_r. For r = `largest` it is M_r, whether compared as a
/// double or rounded to a float; that float stands for `largest` even where its own ball is smaller. Holds 8 bytes a
/// voxel with its argument. Throws ParameterError unless 0 <= `largest` <= 20000.
Grid<float> stability_radii(const Grid<std::int32_t>& squared, double largest, RunContext& context,
                            std::uint64_t held = 0);

/// The abstract's other stability [WR05]: of each voxel the first of `radii` whose mortar contains it, 0 where none
/// does. Digital mortars do not always grow with the radius, so a voxel may have left those of larger radii again.
/// Holds 4 bytes a voxel, and of the grid padded by a radius what `morphology_memory` says and two volumes of bits.
/// Throws ParameterError unless the radii increase and lie between 0 and 20000.
Grid<float> first_mortar(const BinaryVolume& volume, std::span<const double> radii, bool outside, RunContext& context,
                         std::uint64_t held = 0);

/// The radii 1, 2, ..., 12.
std::span<const double> default_stability_radii();

}  // namespace voxcarve
