// Regular grids of samples at voxel centres.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "common/mesh/triangle_soup.h"
#include "common/volume/grid_allocator.h"

namespace voxcarve {

using Index3 = Eigen::Matrix<std::int64_t, 3, 1>;

/// Where a grid lies: dims (nx, ny, nz), the position of its lower corner and the edge length of its cubic voxels, both
/// in model units. The sample of voxel (i, j, k) lies at its centre, origin + (i + 1/2, j + 1/2, k + 1/2) voxel_size.
struct GridFrame {
  Index3 dims = Index3::Zero();
  Point origin = Point::Zero();
  double voxel_size = 1;

  std::int64_t voxels() const { return dims.prod(); }
  Point center(const Index3& voxel) const {
    return origin + voxel_size * (voxel.cast<double>() + Point::Constant(0.5));
  }
  bool contains(const Index3& voxel) const {
    return (voxel.array() >= 0).all() && (voxel.array() < dims.array()).all();
  }
  /// True for a single slice: a 2D image, on which connectivity and balls are two-dimensional.
  bool is_image() const { return dims[2] == 1; }
  bool operator==(const GridFrame&) const = default;
};

/// The same voxels with `margin` more on every side along the axes that the grid extends in (an image stays an image).
GridFrame padded(const GridFrame& frame, std::int64_t margin);

/// Samples on a frame, x fastest. Everything outside counts as exterior.
template <class T>
struct Grid {
  GridFrame frame;
  GridValues<T> values;

  Grid() = default;
  explicit Grid(const GridFrame& f, T value = T{}) : frame(f), values(static_cast<std::size_t>(f.voxels()), value) {}

  /// A grid whose values have yet to be written, every one of them.
  static Grid uninitialized(const GridFrame& f) {
    Grid grid;
    grid.frame = f;
    grid.values.resize(static_cast<std::size_t>(f.voxels()));
    return grid;
  }

  std::int64_t nx() const { return frame.dims[0]; }
  std::int64_t ny() const { return frame.dims[1]; }
  std::int64_t nz() const { return frame.dims[2]; }
  std::size_t index(std::int64_t i, std::int64_t j, std::int64_t k) const {
    return static_cast<std::size_t>((k * ny() + j) * nx() + i);
  }
  T& operator()(std::int64_t i, std::int64_t j, std::int64_t k) { return values[index(i, j, k)]; }
  const T& operator()(std::int64_t i, std::int64_t j, std::int64_t k) const { return values[index(i, j, k)]; }
  /// The value there, or `outside` beyond the grid.
  T get(std::int64_t i, std::int64_t j, std::int64_t k, T outside) const {
    return frame.contains({i, j, k}) ? (*this)(i, j, k) : outside;
  }
  bool operator==(const Grid&) const = default;
};

using BinaryVolume = Grid<std::uint8_t>;  ///< 0 exterior, 1 interior
using DensityVolume = Grid<float>;        ///< share of the voxel that is interior, in [0, 1]

/// The part of `grid` on `frame`, which must lie on the same lattice; voxels of `frame` outside `grid` become
/// `outside`.
template <class T>
Grid<T> resized(const Grid<T>& grid, const GridFrame& frame, T outside = T{}) {
  Grid<T> result(frame, outside);
  const Point shift = (frame.origin - grid.frame.origin) / grid.frame.voxel_size;
  const Index3 offset = shift.array().round().cast<std::int64_t>();
  const Index3 low = (-offset).cwiseMax(0);
  const Index3 high = (grid.frame.dims - offset).cwiseMin(frame.dims);
  for (std::int64_t k = low[2]; k < high[2]; ++k) {
    for (std::int64_t j = low[1]; j < high[1]; ++j) {
      for (std::int64_t i = low[0]; i < high[0]; ++i) {
        result(i, j, k) = grid(i + offset[0], j + offset[1], k + offset[2]);
      }
    }
  }
  return result;
}

/// The voxels whose value is at least `threshold`.
BinaryVolume thresholded(const Grid<float>& field, float threshold);

/// Number of interior voxels.
std::int64_t count_interior(const BinaryVolume& volume);

}  // namespace voxcarve
