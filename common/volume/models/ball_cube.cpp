// ball-cube: based on [WR05, 6 and Fig. 7], "27 overlapping balls arranged to almost completely fill the space inside a
// cube" on the right and their complement on the left, 425 x 150 x 150 voxels of which 3,375,000 are interior.
//
// The paper gives neither the radius of the balls, nor where their centres lie, nor the distance of the halves. Taken
// here: two cubes of 150 voxels with 125 empty ones between them, which is what 425 leaves when both halves are cubes
// of the paper's volume, 150^3 (a shape and its complement fill one of them together); centres on the regular lattice
// that divides the cube in 27 cells, each ball in the middle of its cell: 25, 75 and 125 in coordinates in which voxel
// i covers [i, i + 1]. The middle of an even number of voxels is a corner of voxels, so the model is symmetric about
// it, and the left half is both the complement of the right one and that of its mirror image. The default radius of 35
// is a guess: it leaves 4 % of the cube to the gaps between the balls.
#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "common/run/errors.h"
#include "common/volume/models/builders.h"

namespace voxcarve {

namespace {

constexpr int kBalls = 3;             // along each axis
constexpr std::int64_t kUnits = 150;  // lengths are given in shares of the paper's side
constexpr double kMaximumVoxels = 1 << 30;

std::int64_t gap_voxels(const Parameters& parameters) {
  return (2 * parameters.integer("gap") * parameters.integer("side") + kUnits) / (2 * kUnits);
}

/// The least squared distances from the centre of voxel i to the centres of the lattice along one axis, in units of a
/// sixth of a voxel, in which both are integers: 6 i + 3 and (2 m + 1) side.
std::vector<std::int64_t> squared_distances(std::int64_t side) {
  std::vector<std::int64_t> squares(static_cast<std::size_t>(side), std::int64_t{1} << 60);
  for (std::int64_t i = 0; i < side; ++i) {
    std::int64_t& least = squares[static_cast<std::size_t>(i)];
    for (int m = 0; m < kBalls; ++m) {
      const std::int64_t offset = 6 * i + 3 - (2 * m + 1) * side;
      least = std::min(least, offset * offset);
    }
  }
  return squares;
}

BinaryVolume build_ball_cube(const Parameters& parameters) {
  const std::int64_t side = parameters.integer("side");
  const std::int64_t right = side + gap_voxels(parameters);
  const double radius = 6 * parameters.real("ball_radius") * static_cast<double>(side) / kUnits;
  const std::vector<std::int64_t> squares = squared_distances(side);
  const auto square = [&](std::int64_t i) { return squares[static_cast<std::size_t>(i)]; };
  BinaryVolume volume(GridFrame{.dims = {right + side, side, side}});
  for (std::int64_t k = 0; k < side; ++k) {
    for (std::int64_t j = 0; j < side; ++j) {
      for (std::int64_t i = 0; i < side; ++i) {
        // Balls are closed. The nearest centre is the nearest one along each axis.
        const bool in_ball = static_cast<double>(square(i) + square(j) + square(k)) <= radius * radius;
        volume(right + i, j, k) = in_ball ? 1 : 0;
        volume(i, j, k) = in_ball ? 0 : 1;
      }
    }
  }
  return volume;
}

}  // namespace

VolumeModel ball_cube_model() {
  ModelInfo info{
      "ball-cube", "a cube of 27 balls and, apart from it, the complement of them in another", "WR Fig. 7", {}};
  info.parameters.specs = {
      ParameterSpec::real("ball_radius", "side / 150", 0, 150, 35,
                          "of each ball; from 43.3 on the balls fill their cube"),
      ParameterSpec::integer("gap", "side / 150", 0, 1500, 125, "between the cubes, rounded to whole voxels"),
      ParameterSpec::integer("side", "voxels", 3, 1000, 150, "of each cube; the volume is its third power")};
  info.parameters.check = [](const Parameters& parameters) {
    const auto side = static_cast<double>(parameters.integer("side"));
    const double voxels = (2 * side + static_cast<double>(gap_voxels(parameters))) * side * side;
    if (voxels <= kMaximumVoxels) return;
    throw ParameterError("ball-cube: these parameters make " + std::to_string(static_cast<std::int64_t>(voxels)) +
                         " voxels, more than the limit of 2^30");
  };
  return {std::move(info), false, build_ball_cube};
}

}  // namespace voxcarve
