#include "common/volume/axis_scan.h"

#include <cmath>

#include "common/run/errors.h"

namespace voxcarve {

namespace {

/// To the nearest integer, halves away from zero, without a call of the library for every coordinate. |value| < 2^31.
std::int32_t round_to_int(double value) {
  const auto whole = static_cast<std::int32_t>(value);
  const double rest = value - whole;  // exact
  return whole + (rest >= 0.5) - (rest <= -0.5);
}

/// The box of all positions, used or not.
Box box_of_positions(const TriangleSoup& soup) {
  Box box;
  for (const Point& position : soup.positions) box.extend(position);
  return box;
}

}  // namespace

LatticeSoup::LatticeSoup(const TriangleSoup& soup, const GridFrame& frame, RunContext& context)
    : triangles_(&soup.triangles) {
  const auto to_voxels = [&](const Point& position) -> Point {
    return (position - frame.origin) / frame.voxel_size - Point::Constant(0.5);
  };
  const auto reach = [&](const Box& box) {
    if (box.empty()) return 1.0;
    return std::max({1.0, to_voxels(box.lower).cwiseAbs().maxCoeff(), to_voxels(box.upper).cwiseAbs().maxCoeff()});
  };
  // Coordinates up to 2^28 keep an edge function below 2^60.
  const double limit = 0x1p28;
  const auto is_fine = [&](double largest) { return std::ldexp(largest + 1, bits_) <= limit; };
  // The box of all positions is quicker to find than that of the used ones, and mostly says the same.
  double largest = reach(box_of_positions(soup));
  if (!is_fine(largest)) largest = reach(bounds(soup));
  if (!(largest <= limit)) throw InputError("the grid is too fine for a soup so much larger than it");
  while (bits_ > 0 && !is_fine(largest)) --bits_;
  const auto one = static_cast<double>(std::int64_t{1} << bits_);
  points_.resize(soup.positions.size());
  constexpr std::int64_t kGrain = 1 << 15;  // vertices
  parallel_for(context, 0, static_cast<std::int64_t>(points_.size()), kGrain,
               [&](std::int64_t begin, std::int64_t end) {
                 for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
                   // A vertex that no triangle uses may lie anywhere: clamping keeps the conversion defined and moves
                   // no other.
                   const Point voxel = to_voxels(soup.positions[i]).cwiseMin(largest).cwiseMax(-largest) * one;
                   points_[i] = {round_to_int(voxel[0]), round_to_int(voxel[1]), round_to_int(voxel[2])};
                 }
               });
}

}  // namespace voxcarve
