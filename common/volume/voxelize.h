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
  /// Ray stabbing: a ray with an odd number of crossings does not vote. [KJ01, 2.2] ascribes this test to the method. A
  /// voxel for which no ray votes is exterior.
  bool stab_validity = false;
};

/// How the samples of a voxel's neighbourhood become its density [NT03, 3.3].
enum class FilterKernel {
  kBox,      ///< the mean of the voxel's own samples
  kGaussian  ///< standard deviation 0.7 voxels, cut off at 2 voxels along each axis
};

/// "box" or "gaussian"; throws ParameterError for another name.
FilterKernel filter_kernel_from(std::string_view name);

struct SupersamplingOptions {
  int samples = 1;  ///< a voxel is sampled at samples^3 points: 1, 2 or 3
  FilterKernel kernel = FilterKernel::kBox;
};

/// What the classification met on its way.
struct VoxelizeReport {
  /// Per axis: voxel columns that some crossing fell into, and those of them with an odd count, which do not vote
  /// (parity count, and stabbing with `stab_validity`; else none).
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
/// (coarser where the soup reaches beyond 4095 voxels from the grid's lower corner); on this lattice a ray through a
/// shared edge or vertex counts exactly once, as if all voxel centres were moved by (e, e^2, e^3) for an infinitesimal
/// e (along directions that are no axis, by 2^-10, 2^-13 and 2^-16 voxel). Edge-on triangles never count. No valid
/// vote, and ties, are exterior [NT03, 3.1].
///
/// Ray stabbing gives the intersection of the line hulls of the soup along the directions: of a set of parts not the
/// union but something larger that no ray enters from outside.
///
/// The soup may reach beyond the grid: a part of a grid gets the part of the volume. Beside the result, an eighth of
/// its bytes are held, what the triangles need, and with 13 directions a byte a voxel. Throws ParameterError for
/// another number of directions, InputError for a grid without voxels or a soup that reaches 2^28 voxels beyond it.
BinaryVolume voxelize(const TriangleSoup& soup, const GridFrame& frame, const VoxelizeOptions& options,
                      RunContext& context, VoxelizeReport* report = nullptr);

/// The density of every voxel: each is divided into samples^3 smaller ones, these are classified as `voxelize` does,
/// and the kernel weighs them [NT03, 3.3]. Weights are integers, so that a voxel whose whole neighbourhood is interior
/// has a density of exactly 1, one whose neighbourhood is exterior of exactly 0, and the same bytes come out in any
/// order of summation. The Gaussian reaches beyond the model, so the result's grid has 2 voxels more than `frame` on
/// every side (an image stays an image), and samples are taken wherever it reaches. Disputed votes are settled among
/// the smaller voxels, and the counts of the report are of these. Beside the result, samples^3 / 8 bytes a voxel are
/// held. Throws as `voxelize` does, and ParameterError for another number of samples.
DensityVolume voxelize_density(const TriangleSoup& soup, const GridFrame& frame, const VoxelizeOptions& options,
                               const SupersamplingOptions& supersampling, RunContext& context,
                               VoxelizeReport* report = nullptr);

}  // namespace voxcarve
