// Where the parity of rays along an oblique direction differs from that of rays along x.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/mesh/triangle_soup.h"
#include "common/run/context.h"
#include "common/volume/axis_scan.h"
#include "common/volume/bit_volume.h"

namespace voxcarve {

/// The parity of a voxel's crossings in front of it, as a function of the voxel, changes where the voxel passes through
/// the surface, and where its ray passes over the surface's boundary: the edges that an odd number of triangles share.
/// The latter places form curtains, each swept by a boundary edge along the direction; the part behind the edge changes
/// the crossings in front, and the whole curtain those of the whole line. So the parities of a row of voxels follow
/// from those along x and from the row's crossings with curtains, of which a closed surface has none.
///
/// That is exact but for voxels so close to the surface or to a curtain that the ways in which rays along the axes and
/// others round coordinates may tell on them; they are marked, and have to be looked at one by one.
class Curtains {
 public:
  /// Both must outlive it.
  Curtains(const TriangleSoup& soup, const LatticeSoup& lattice);

  /// False when the lattice is too coarse for the marks' distance, or when there are so many boundary edges that every
  /// voxel is looked at sooner.
  bool pay_off(const Index3& dims) const;

  /// Bytes that are held, and, a little less, were at most while it was made.
  static std::uint64_t memory(const TriangleSoup& soup);

  /// Marks the voxels of `slices` near the surface; `marks` are those of the slices.
  void mark_surface(const Index3& dims, IndexRange slices, BitVolume& marks, const RunContext& context) const;
  /// Marks the voxels of `slices` near the curtains along `direction`.
  void mark_curtains(const Point& direction, const Index3& dims, IndexRange slices, BitVolume& marks,
                     const RunContext& context) const;

  /// Toggles, for rows of slice k, the first voxel behind every curtain: in `total` of all, in `in_front` of the parts
  /// behind their edges. Both are planes of rows of words.
  void toggle_slice(const Point& direction, const Index3& dims, std::int64_t k, std::vector<BitWord>& in_front,
                    std::vector<BitWord>& total) const;

 private:
  const LatticeSoup& lattice_;
  std::vector<std::array<LatticePoint, 2>> edges_;  ///< the boundary
};

}  // namespace voxcarve
