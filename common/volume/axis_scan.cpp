#include "common/volume/axis_scan.h"

namespace voxcarve {

LatticeSoup::LatticeSoup(const TriangleSoup& soup, const GridFrame& frame) : triangles_(&soup.triangles) {
  // Coordinates below 2^29 keep an edge function below 2^61.
  const std::int64_t longest = frame.dims.maxCoeff() + 4;
  while (bits_ > 0 && (longest << bits_) >= (std::int64_t{1} << 29)) --bits_;
  const double scale = static_cast<double>(one());
  const Point limit = frame.dims.cast<double>() + Point::Constant(2);
  points_.reserve(soup.positions.size());
  for (const Point& position : soup.positions) {
    // A vertex that no triangle uses may lie anywhere: clamping keeps the conversion defined.
    const Point voxel =
        ((position - frame.origin) / frame.voxel_size - Point::Constant(0.5)).cwiseMin(limit).cwiseMax(-2.0);
    points_.emplace_back((voxel * scale).array().round().cast<std::int64_t>());
  }
}

}  // namespace voxcarve
