// What the voxelizer is asked for; bit_voxelizer.cpp is how it is done.
#include "common/volume/voxelize.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/run/errors.h"
#include "common/volume/bit_voxelizer.h"

namespace voxcarve {

Classifier classifier_from(std::string_view name) {
  if (name == "parity") return Classifier::kParity;
  if (name == "stabbing") return Classifier::kStabbing;
  throw ParameterError("there is no classifier '" + std::string(name) + "'; choose parity or stabbing");
}

FilterKernel filter_kernel_from(std::string_view name) {
  if (name == "box") return FilterKernel::kBox;
  if (name == "gaussian") return FilterKernel::kGaussian;
  throw ParameterError("there is no kernel '" + std::string(name) + "'; choose box or gaussian");
}

std::vector<Point> voxelization_directions(int count, int axis) {
  if (count == 1) return {Point::Unit(axis)};
  if (count != 3 && count != 13) throw ParameterError("directions must be 1, 3 or 13");
  std::vector<Point> directions = {Point::UnitX(), Point::UnitY(), Point::UnitZ()};
  if (count == 3) return directions;
  // The face normals of a regular icosahedron are the vertices of its dual, the dodecahedron: (+-1, +-1, +-1) and the
  // cyclic shifts of (0, +-1/phi, +-phi), here one of every opposite pair.
  const double phi = (1 + std::sqrt(5.0)) / 2;
  for (const double y : {1.0, -1.0}) {
    for (const double z : {1.0, -1.0}) directions.push_back(Point(1, y, z).normalized());
  }
  for (const double sign : {1.0, -1.0}) {
    directions.push_back(Point(0, 1 / phi, sign * phi).normalized());
    directions.push_back(Point(1 / phi, sign * phi, 0).normalized());
    directions.push_back(Point(sign * phi, 0, 1 / phi).normalized());
  }
  return directions;
}

GridFrame voxel_frame(const Box& box, std::int64_t resolution) {
  if (resolution < 1) throw ParameterError("resolution must be at least 1");
  const Point extent = box.extent();
  const double longest = extent.maxCoeff();
  GridFrame frame;
  frame.voxel_size = longest / static_cast<double>(resolution);
  const double largest_coordinate = std::max(box.lower.cwiseAbs().maxCoeff(), box.upper.cwiseAbs().maxCoeff());
  constexpr double kDigits = 8 * std::numeric_limits<double>::epsilon();
  if (!(longest > 0) || frame.voxel_size < largest_coordinate * kDigits ||
      frame.voxel_size < std::numeric_limits<double>::min()) {
    throw InputError(
        "a voxel would be smaller than the last digits of the coordinates; move the model nearer to the origin or "
        "lower the resolution");
  }
  // The layers of centres that the box holds, centred in it: none lies beyond it, and none is missing.
  for (int axis = 0; axis < 3; ++axis) {
    frame.dims[axis] = std::max<std::int64_t>(std::llround(extent[axis] / frame.voxel_size), 1);
  }
  frame.origin = box.center() - 0.5 * frame.voxel_size * frame.dims.cast<double>();
  if (frame.is_image()) frame.dims[2] = 2;  // a single slice would count as a 2D image; the second one stays empty
  return frame;
}

BinaryVolume voxelize(const TriangleSoup& soup, const GridFrame& frame, const VoxelizeOptions& options,
                      RunContext& context, VoxelizeReport* report) {
  voxelization_directions(options.directions, options.axis);  // throws for a count that there is not
  require_voxels(frame);
  Stage stage(context, "voxelization", voxelization_items(soup, frame, options));
  const auto bytes = static_cast<std::uint64_t>(frame.voxels());
  return expanded(voxelize_bits(soup, frame, options, bytes, stage, context, report), frame, context);
}

}  // namespace voxcarve
