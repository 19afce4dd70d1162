#include "tests/support/shapes.h"

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

std::optional<std::filesystem::path> data_file(const std::string& name) {
  const char* folder = std::getenv("VOXCARVE_DATA");
  if (folder == nullptr) return std::nullopt;
  std::filesystem::path path = std::filesystem::path(folder) / name;
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) return std::nullopt;
  return path;
}

}  // namespace voxcarve::test
