// Shapes and slow, obvious twins that several test files use.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/mesh/triangle_soup.h"
#include "common/run/address_sanitizer.h"
#include "common/volume/grid.h"

namespace voxcarve::test {

/// How many of `cases` random ones a test runs: under sanitizers, whose every case takes ten times as long, a tenth.
template <class Count>
constexpr Count case_count(Count cases) {
  return kAddressSanitizer ? (cases + 9) / 10 : cases;
}

/// A soup with its triangles turned round.
TriangleSoup inside_out(TriangleSoup soup);

/// Both soups in one.
TriangleSoup joined(const std::vector<TriangleSoup>& parts);

/// A frame of dims voxels of size `voxel_size` with its lower corner at `origin`.
GridFrame frame_of(const Index3& dims, const Point& origin = Point::Zero(), double voxel_size = 1);

/// A volume whose voxels are interior with probability `fill`, the same for the same seed.
BinaryVolume random_volume(const Index3& dims, double fill, std::uint64_t seed);

/// Every voxel within `radius` of an interior one, by the definition of the ball: a disk on an image. Everything
/// outside the grid is `outside`; the result is cut off at the grid's border.
BinaryVolume slow_dilation(const BinaryVolume& volume, double radius, bool outside);

/// Every interior voxel that is farther than `radius` from all others; likewise.
BinaryVolume slow_erosion(const BinaryVolume& volume, double radius, bool outside);

/// The file of DATA, or nothing when VOXCARVE_DATA is not set or the file is not there.
std::optional<std::filesystem::path> data_file(const std::string& name);

}  // namespace voxcarve::test

/// Skips the test, visibly, when a file of the external models is missing; otherwise declares its path.
#define VOXCARVE_REQUIRE_DATA(variable, name)                                                  \
  const auto variable##_found = voxcarve::test::data_file(name);                               \
  if (!variable##_found) GTEST_SKIP() << "needs " << (name) << " in the folder VOXCARVE_DATA"; \
  const std::filesystem::path variable = *variable##_found
