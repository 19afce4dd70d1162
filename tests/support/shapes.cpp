#include "tests/support/shapes.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <random>
#include <utility>

namespace voxcarve::test {

TriangleSoup inside_out(TriangleSoup soup) {
  for (Triangle& triangle : soup.triangles) std::swap(triangle[1], triangle[2]);
  return soup;
}

TriangleSoup joined(const std::vector<TriangleSoup>& parts) {
  TriangleSoup all;
  for (const TriangleSoup& part : parts) append(all, part);
  return all;
}

GridFrame frame_of(const Index3& dims, const Point& origin, double voxel_size) {
  GridFrame frame;
  frame.dims = dims;
  frame.origin = origin;
  frame.voxel_size = voxel_size;
  return frame;
}

BinaryVolume random_volume(const Index3& dims, double fill, std::uint64_t seed) {
  BinaryVolume volume(frame_of(dims));
  std::mt19937_64 generator(seed);
  const auto threshold = static_cast<std::uint64_t>(fill * 1e6);
  for (std::uint8_t& value : volume.values) value = static_cast<std::uint8_t>(generator() % 1000000 < threshold);
  return volume;
}

BinaryVolume slow_dilation(const BinaryVolume& volume, double radius, bool outside) {
  const auto margin = static_cast<std::int64_t>(std::ceil(radius));
  const BinaryVolume wider = resized(volume, padded(volume.frame, margin), static_cast<std::uint8_t>(outside));
  const std::int64_t depth = volume.frame.is_image() ? 0 : margin;
  std::vector<std::int64_t> ball;  // how far its voxels lie from its centre among the values of `wider`
  for (std::int64_t z = -depth; z <= depth; ++z)
    for (std::int64_t y = -margin; y <= margin; ++y)
      for (std::int64_t x = -margin; x <= margin; ++x)
        if (static_cast<double>(x * x + y * y + z * z) <= radius * radius)
          ball.push_back((z * wider.ny() + y) * wider.nx() + x);
  BinaryVolume result(volume.frame);
  for (std::int64_t k = 0; k < volume.nz(); ++k)
    for (std::int64_t j = 0; j < volume.ny(); ++j)
      for (std::int64_t i = 0; i < volume.nx(); ++i) {
        const std::uint8_t* center = &wider(i + margin, j + margin, k + depth);
        result(i, j, k) = std::ranges::any_of(ball, [&](std::int64_t offset) { return center[offset] != 0; });
      }
  return result;
}

BinaryVolume slow_erosion(const BinaryVolume& volume, double radius, bool outside) {
  const auto turned = [](BinaryVolume all) {
    for (std::uint8_t& value : all.values) value = static_cast<std::uint8_t>(1 - value);
    return all;
  };
  return turned(slow_dilation(turned(volume), radius, !outside));
}

std::optional<std::filesystem::path> data_file(const std::string& name) {
  const char* folder = std::getenv("VOXCARVE_DATA");
  if (folder == nullptr) return std::nullopt;
  std::filesystem::path path = std::filesystem::path(folder) / name;
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) return std::nullopt;
  return path;
}

}  // namespace voxcarve::test
