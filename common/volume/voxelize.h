// Soup to volume: which voxel centres lie inside.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/mesh/triangle_soup.h"
#include "common/run/context.h"
#include "common/volume/grid.h"

namespace voxcarve {

/// How a voxel is classified from the crossings of its rays with the soup.
enum class Classifier {
  kParity,   ///< parity count [NT03, 3.1]: an odd number of crossings in front means interior; majority of the
             ///< directions
  kStabbing  ///< ray stabbing [NT03, 3.2]: interior iff between the first and the last crossing in every direction
};

/// "parity" or "stabbing"; throws ParameterError for another name.
Classifier classifier_from(std::string_view name);

struct VoxelizeOptions {
  Classifier classifier = Classifier::kParity;
  int directions = 3;  ///< 1 (`axis`), 3 (the axes) or 13 (with the face normals of the regular icosahedron)
  int axis = 1;        ///< of the rays when directions == 1: 0 x, 1 y, 2 z
  /// Parity count in several directions: how often disputed voxels take the class of most of their 26 neighbours. Near
  /// a hole only few rays are valid, and where these few disagree the bare majority leaves specks and small handles. A
  /// voxel is disputed when its valid votes are split, or it has none, and neither class has half of all directions; of
  /// a watertight model no voxel is. 0 gives the paper's rule alone.
  int settle_sweeps = 4;
};

/// What the classification met on its way.
struct VoxelizeReport {
  /// Per axis: voxel columns that some crossing fell into, and those of them with an odd count, which do not vote
  /// (parity count only).
  struct Axis {
    int axis = 0;
    std::int64_t columns = 0;
    std::int64_t invalid_columns = 0;
  };
  std::vector<Axis> axes;
  std::int64_t settled_voxels = 0;  ///< disputed voxels that their neighbours gave another class than the votes
};

/// Unit vectors of `count` in {1, 3, 13} directions: the axes (or `axis` alone), then the ten distinct face normals of
/// the regular icosahedron. Throws ParameterError for another count.
std::vector<Point> voxelization_directions(int count, int axis = 1);

/// The frame of `resolution` cubic voxels along the longest side of `box`. A side of t voxels gets round(t) of them, at
/// least one (along z two, of which the second may be beyond the box), centred in the box: a symmetric model gives a
/// symmetric volume, and a slab is as often made thicker as thinner. Throws InputError when the voxels would be smaller
/// than the coordinates' digits.
GridFrame voxel_frame(const Box& box, std::int64_t resolution);

/// Classifies every voxel centre of `frame`. Rays pass exactly through voxel centres in every direction, where the
/// papers snap them to a pixel raster, so no direction adds an error of its own. Vertices are rounded to 2^-16 voxel
/// (coarser for more than 8192 voxels a side); on this lattice a ray through a shared edge or vertex counts exactly
/// once, as if all voxel centres were moved by (e, e^2, e^3) for an infinitesimal e (along directions that are no axis,
/// by 2^-10, 2^-13 and 2^-16 voxel). Edge-on triangles never count. No valid vote, and ties, are
/// exterior [NT03, 3.1].
///
/// Ray stabbing gives the intersection of the line hulls of the soup along the directions: of a set of parts not the
/// union but something larger that no ray enters from outside.
BinaryVolume voxelize(const TriangleSoup& soup, const GridFrame& frame, const VoxelizeOptions& options,
                      RunContext& context, VoxelizeReport* report = nullptr);

}  // namespace voxcarve
