// The grids and supports of a hierarchy of filtered volumes.
#pragma once

#include <cstdint>
#include <vector>

#include "common/mesh/triangle_soup.h"
#include "common/run/parameters.h"
#include "common/volume/grid.h"

namespace voxcarve {

/// One level of detail.
struct HierarchyLevel {
  std::int64_t resolution = 0;  ///< voxels along the longest side of the model's box
  double support = 0;           ///< radius R of the filter, model units
  GridFrame frame;              ///< without a margin for the support
};

/// Schema lines `resolution`, `margin`, `placement`, `factor`, `levels`, `support` and `support_model`.
std::vector<ParameterSpec> hierarchy_parameters();

/// Throws ParameterError for combinations of these that say nothing, or two things at once.
void check_hierarchy(const Parameters& parameters);

/// What the grids of all levels share: the model's box with the margin that `parameters`, of a schema with the lines
/// above, ask for.
Box grid_box(const Parameters& parameters, const Box& box);

/// The levels that `parameters`, of a schema with the lines above, ask for on a `grid_box`, from the coarsest to the
/// finest. Supports that are given in voxels are voxels of the finest level [He95, Tables 1 to 3]; one support for
/// several levels is the finest one's, and others have it in inverse proportion to their resolution, as in the tables.
std::vector<HierarchyLevel> hierarchy_levels(const Parameters& parameters, const Box& box);

/// Where the samples of a grid lie.
enum class Placement {
  kVoxels,  ///< `resolution` voxels fill the box, and are sampled at their centres
  kEnds     ///< of `resolution` samples along the longest side the first and the last lie on the box
};

Placement placement_of(const Parameters& parameters);

/// The grid of a level without the margin: cubic voxels, counts rounded up, centred in the box, so that
/// every level holds it (225 voxels beside 256 become 113, 57, 29, 8 and 4 beside 128, 64, 32, 8 and 4, as in [He95,
/// Table 3]). Throws InputError when voxels would be smaller than the last digits of the coordinates.
GridFrame level_frame(const Box& box, std::int64_t resolution, Placement placement = Placement::kVoxels);

}  // namespace voxcarve
