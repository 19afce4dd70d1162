#include "common/volume/axis_scan.h"

#include <algorithm>
#include <cmath>

#include "common/run/errors.h"

namespace voxcarve {

LatticeSoup::LatticeSoup(const TriangleSoup& soup, const GridFrame& frame) : triangles_(&soup.triangles) {
  const auto to_voxels = [&](const Point& position) -> Point {
    return (position - frame.origin) / frame.voxel_size - Point::Constant(0.5);
  };
  const Box box = bounds(soup);
  double largest = 1;
  if (!box.empty()) {
    largest =
        std::max({largest, to_voxels(box.lower).cwiseAbs().maxCoeff(), to_voxels(box.upper).cwiseAbs().maxCoeff()});
  }
  // Coordinates up to 2^28 keep an edge function below 2^60.
  const double limit = 0x1p28;
  if (largest > limit) throw InputError("the grid is too fine for a soup so much larger than it");
  while (bits_ > 0 && std::ldexp(largest + 1, bits_) > limit) --bits_;
  points_.reserve(soup.positions.size());
  for (const Point& position : soup.positions) {
    // A vertex that no triangle uses may lie anywhere: clamping keeps the conversion defined and moves no other.
    const Point voxel = to_voxels(position).cwiseMin(largest).cwiseMax(-largest);
    points_.emplace_back((voxel * static_cast<double>(one())).array().round().cast<std::int64_t>());
  }
}

}  // namespace voxcarve
