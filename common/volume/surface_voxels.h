// Voxels near the polygons of a soup, and the colours found there.
#pragma once

#include <cstdint>
#include <vector>

#include "common/mesh/triangle_soup.h"
#include "common/run/context.h"
#include "common/volume/grid.h"

namespace voxcarve {

/// Thin-shell voxelization [NT03, 3 and Fig. 2a], for comparison: density 1 on the surface, falling linearly with the
/// distance to the nearest triangle to 0 at `reach` voxels (more than 0, at most 16). The inside of a closed surface
/// stays empty. Distances are measured from voxel centres to the triangles themselves.
DensityVolume thin_shell(const TriangleSoup& soup, const GridFrame& frame, double reach, RunContext& context);

/// The colours that scan conversion records on surface voxels [NT03, 5.2]: those whose closed cube meets a triangle. Of
/// several triangles in a voxel the one nearest to the centre counts, of equally near ones the first in the soup; its
/// colour is taken at its point nearest to the centre.
struct SurfaceColors {
  GridFrame frame;
  std::vector<std::int64_t> voxels;  ///< indices into the grid, ascending
  std::vector<Color> colors;         ///< one a voxel

  bool empty() const { return voxels.empty(); }
};

/// Surface voxels of `frame` and their colours. The soup has vertex or triangle colours, or both (then the triangle's
/// wins); one without gives nothing.
SurfaceColors record_surface_colors(const TriangleSoup& soup, const GridFrame& frame, RunContext& context);

/// A colour for every voxel of a grid: that of the nearest surface voxel [NT03, 5.2].
class NearestColors {
 public:
  /// By a feature transform over `frame`, which lies on the lattice of `surface` and may be larger or smaller.
  /// `surface` is not empty.
  NearestColors(const SurfaceColors& surface, const GridFrame& frame, RunContext& context);

  const GridFrame& frame() const { return frame_; }
  /// The colour at a voxel; beyond the grid, of the voxel of its border nearest to it.
  const Color& at(Index3 voxel) const;

 private:
  GridFrame frame_;
  Grid<std::uint32_t> nearest_;  ///< into colors_
  std::vector<Color> colors_;
};

/// Gives the vertices of an isosurface that was extracted on the frame of `colors`, and not moved since, the colours
/// interpolated along the grid edges that they lie on [NT03, 5.2].
void interpolate_colors(TriangleSoup& surface, const NearestColors& colors, RunContext& context);

}  // namespace voxcarve
