#include "common/volume/isosurface.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/run/errors.h"
#include "common/volume/isosurface_table.h"

namespace voxcarve {

namespace {

constexpr std::uint32_t kUnset = std::numeric_limits<std::uint32_t>::max();
constexpr double kClearance = 1.0 / 1024;  ///< voxels between a crossing and a sample

/// Sweeps the cells slice by slice. Cells and samples are counted from the layer of exterior samples around the grid:
/// padded sample (i, j, k) is voxel (i - 1, j - 1, k - 1).
template <class Samples>
class CubeMarcher {
 public:
  CubeMarcher(const Samples& samples, const GridFrame& frame, RunContext& context)
      : samples_(samples),
        frame_(frame),
        context_(context),
        nx_(frame.dims[0] + 2),
        ny_(frame.dims[1] + 2),
        nz_(frame.dims[2] + 2) {
    const auto slice = static_cast<std::size_t>(nx_ * ny_);
    for (auto& inside : inside_) inside.assign(slice, 0);
    for (auto& edges : edge_vertex_) edges.assign(slice, kUnset);
  }

  TriangleSoup run() {
    Stage stage(context_, "isosurface", 2 * frame_.dims[2]);
    reserve(stage);
    for (std::int64_t k = 0; k + 1 < nz_; ++k) {
      std::swap(inside_[0], inside_[1]);
      classify(k + 1);
      march_slice(k);
      // The upper edges of this slice are the lower ones of the next.
      std::swap(edge_vertex_[kLowerX], edge_vertex_[kUpperX]);
      std::swap(edge_vertex_[kLowerY], edge_vertex_[kUpperY]);
      for (const std::size_t edges : {kUpperX, kUpperY, kZ}) std::ranges::fill(edge_vertex_[edges], kUnset);
      if (k < frame_.dims[2]) stage.advance(1);
    }
    return std::move(surface_);
  }

 private:
  static constexpr std::size_t kLowerX = 0, kUpperX = 1, kLowerY = 2, kUpperY = 3, kZ = 4;

  void classify(std::int64_t k) {
    auto& inside = inside_[1];
    if (k == nz_ - 1) {
      std::ranges::fill(inside, std::uint8_t{0});
      return;
    }
    for (std::int64_t j = 1; j + 1 < ny_; ++j) {
      std::uint8_t* row = inside.data() + j * nx_;
      for (std::int64_t i = 1; i + 1 < nx_; ++i) row[i] = samples_.inside(i - 1, j - 1, k - 1);
    }
  }

  /// Counts the surface before anything of it is made, and leaves the samples as they were: all exterior.
  void reserve(Stage& stage) {
    std::size_t triangles = 0;
    std::size_t vertices = 0;
    for (std::int64_t k = 0; k + 1 < nz_; ++k) {
      std::swap(inside_[0], inside_[1]);
      classify(k + 1);
      for_each_cut_cell([&](std::int64_t, std::int64_t, unsigned mask) {
        triangles += cube_cases()[mask].triangle_count;
        // A crossed grid edge belongs to the one cell whose lowest corner it starts at.
        for (const unsigned other : {1U, 2U, 4U}) vertices += (mask & 1U) != (mask >> other & 1U);
      });
      if (k < frame_.dims[2]) stage.advance(1);
    }
    std::ranges::fill(inside_[0], std::uint8_t{0});
    std::ranges::fill(inside_[1], std::uint8_t{0});
    context_.require_memory(
        triangles * sizeof(Triangle) + vertices * sizeof(Point) + inside_[0].size() * (2 + 5 * sizeof(std::uint32_t)),
        "marching cubes");
    if (vertices >= kUnset)
      throw ResourceError("the isosurface has more vertices than 32-bit indices reach; lower the resolution");
    surface_.triangles.reserve(triangles);
    surface_.positions.reserve(vertices);
  }

  /// Calls visit(i, j, mask) for the cells of the current slice that the surface passes through.
  template <class Visit>
  void for_each_cut_cell(const Visit& visit) const {
    for (std::int64_t j = 0; j + 1 < ny_; ++j) {
      const std::uint8_t* rows[4] = {inside_[0].data() + j * nx_, inside_[0].data() + (j + 1) * nx_,
                                     inside_[1].data() + j * nx_, inside_[1].data() + (j + 1) * nx_};
      const auto column = [&](std::int64_t i) {
        return static_cast<unsigned>(rows[0][i] | rows[1][i] << 2 | rows[2][i] << 4 | rows[3][i] << 6);
      };
      unsigned left = column(0);
      for (std::int64_t i = 0; i + 1 < nx_; ++i) {
        const unsigned right = column(i + 1);
        const unsigned mask = left | right << 1;
        left = right;
        if (mask != 0 && mask != 255) visit(i, j, mask);
      }
    }
  }

  void march_slice(std::int64_t k) {
    for_each_cut_cell([&](std::int64_t i, std::int64_t j, unsigned mask) {
      const CubeCase& cube = cube_cases()[mask];
      for (std::size_t t = 0; t < cube.triangle_count; ++t) {
        const auto& edges = cube.triangles[t];
        surface_.triangles.push_back({vertex(i, j, k, edges[0]), vertex(i, j, k, edges[1]), vertex(i, j, k, edges[2])});
      }
    });
  }

  /// The vertex on edge `edge` of cell (i, j, k), made at its first use.
  std::uint32_t vertex(std::int64_t i, std::int64_t j, std::int64_t k, std::uint8_t edge) {
    const std::uint8_t corner = kEdgeCorners[edge][0];
    const std::int64_t ci = i + (corner & 1);
    const std::int64_t cj = j + (corner >> 1 & 1);
    const std::int64_t ck = k + (corner >> 2 & 1);
    const int axis = edge / 4;
    const bool upper = (corner >> 2 & 1) != 0;
    const std::size_t edges = axis == 0 ? (upper ? kUpperX : kLowerX) : axis == 1 ? (upper ? kUpperY : kLowerY) : kZ;
    std::uint32_t& slot = edge_vertex_[edges][static_cast<std::size_t>(cj * nx_ + ci)];
    if (slot == kUnset) {
      if (surface_.positions.size() >= kUnset)
        throw ResourceError("the isosurface has more vertices than 32-bit indices reach; lower the resolution");
      slot = static_cast<std::uint32_t>(surface_.positions.size());
      surface_.positions.push_back(crossing({ci - 1, cj - 1, ck - 1}, axis));
    }
    return slot;
  }

  Point crossing(const Index3& sample, int axis) const {
    Index3 other = sample;
    ++other[axis];
    const double share = std::clamp(samples_.share(sample, other), kClearance, 1 - kClearance);
    Point position = sample.cast<double>() + Point::Constant(0.5);
    position[axis] += share;
    return frame_.origin + frame_.voxel_size * position;
  }

  const Samples& samples_;
  GridFrame frame_;
  RunContext& context_;
  std::int64_t nx_, ny_, nz_;
  std::array<std::vector<std::uint8_t>, 2> inside_;        ///< of padded slices k and k + 1
  std::array<std::vector<std::uint32_t>, 5> edge_vertex_;  ///< vertex on the edge that starts at a padded sample
  TriangleSoup surface_;
};

struct BinarySamples {
  const BinaryVolume& volume;
  std::uint8_t inside(std::int64_t i, std::int64_t j, std::int64_t k) const { return volume(i, j, k) != 0; }
  double share(const Index3&, const Index3&) const { return 0.5; }
};

struct FieldSamples {
  const Grid<float>& field;
  float iso_value;
  bool zero_outside;  ///< the field is 0 beyond the grid; otherwise it mirrors, so that the surface closes midway

  std::uint8_t inside(std::int64_t i, std::int64_t j, std::int64_t k) const { return field(i, j, k) >= iso_value; }
  double share(const Index3& a, const Index3& b) const {
    const bool a_in_grid = field.frame.contains(a);
    const bool b_in_grid = field.frame.contains(b);
    if (!zero_outside && !(a_in_grid && b_in_grid)) return 0.5;
    const double value_a = a_in_grid ? field(a[0], a[1], a[2]) : 0.0;
    const double value_b = b_in_grid ? field(b[0], b[1], b[2]) : 0.0;
    return (static_cast<double>(iso_value) - value_a) / (value_b - value_a);
  }
};

}  // namespace

TriangleSoup isosurface(const DensityVolume& volume, float iso_value, RunContext& context) {
  if (!(iso_value > 0)) throw ParameterError("iso_value must be more than 0, the density outside the grid");
  const FieldSamples samples{volume, iso_value, true};
  return CubeMarcher(samples, volume.frame, context).run();
}

TriangleSoup isosurface(const BinaryVolume& volume, RunContext& context) {
  const BinarySamples samples{volume};
  return CubeMarcher(samples, volume.frame, context).run();
}

TriangleSoup scalar_isosurface(const Grid<float>& field, float iso_value, RunContext& context) {
  const FieldSamples samples{field, iso_value, false};
  return CubeMarcher(samples, field.frame, context).run();
}

}  // namespace voxcarve
