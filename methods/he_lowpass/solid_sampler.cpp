#include "methods/he_lowpass/solid_sampler.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "common/run/errors.h"
#include "common/volume/bit_voxelizer.h"

namespace voxcarve {

namespace {

/// Sets bits [begin, end) of a row.
void set_bits(BitWord* row, std::int64_t begin, std::int64_t end) {
  while (begin < end) {
    const std::int64_t first = begin % kWordBits;
    const std::int64_t count = std::min(kWordBits - first, end - begin);
    row[begin / kWordBits] |= (count == kWordBits ? kAllBits : (BitWord{1} << count) - 1) << first;
    begin += count;
  }
}

class SoupSampler final : public SolidSampler {
 public:
  SoupSampler(const TriangleSoup& soup, const VoxelizeOptions& options) : soup_(soup), options_(options) {}
  Box box() const override { return bounds(soup_); }
  std::int64_t items(const GridFrame& lattice) const override { return voxelization_items(soup_, lattice, options_); }
  BitVolume sample(const GridFrame& lattice, std::uint64_t held, Stage& stage, RunContext& context) const override {
    return voxelize_bits(soup_, lattice, options_, held, stage, context, nullptr);
  }

 private:
  const TriangleSoup& soup_;
  VoxelizeOptions options_;
};

/// A range of lattice points, and what they are sampled into.
struct Block {
  Index3 begin;
  Index3 end;
};

class ImplicitSampler final : public SolidSampler {
 public:
  explicit ImplicitSampler(const ImplicitSolid& solid) : solid_(solid) {}
  Box box() const override { return solid_.box; }
  std::int64_t items(const GridFrame& lattice) const override { return columns_of_blocks(lattice); }

  BitVolume sample(const GridFrame& lattice, std::uint64_t, Stage& stage, RunContext& context) const override {
    BitVolume bits(lattice.dims);
    bits.clear();
    const std::int64_t along_y = blocks_along(lattice.dims[1]);
    parallel_for(context, 0, columns_of_blocks(lattice), 1, [&](std::int64_t column, std::int64_t) {
      const std::int64_t j = column % along_y * kBlock;
      const std::int64_t k = column / along_y * kBlock;
      for (std::int64_t i = 0; i < lattice.dims[0]; i += kBlock) {
        context.check_cancelled();
        const Index3 begin(i, j, k);
        const Index3 end = (begin + Index3::Constant(kBlock)).cwiseMin(lattice.dims);
        fill({begin, end}, lattice, bits);
      }
      stage.advance(1);
    });
    return bits;
  }

 private:
  static constexpr std::int64_t kBlock = 64;      ///< whole words along x, so that no two threads write one
  static constexpr std::int64_t kLeafPoints = 8;  ///< fewer are asked one by one

  static std::int64_t blocks_along(std::int64_t points) { return (points + kBlock - 1) / kBlock; }
  static std::int64_t columns_of_blocks(const GridFrame& lattice) {
    return blocks_along(lattice.dims[1]) * blocks_along(lattice.dims[2]);
  }

  void fill(const Block& block, const GridFrame& lattice, BitVolume& bits) const {
    const Index3 size = block.end - block.begin;
    if (!solid_.clearance || size.prod() <= kLeafPoints) {
      fill_by_points(block, lattice, bits);
      return;
    }
    const Point first = lattice.center(block.begin);
    const Point last = lattice.center(block.end - Index3::Ones());
    const Point middle = 0.5 * (first + last);
    // Some digits of the coordinates are lost in the distance.
    if (solid_.clearance(middle) > (1 + 1e-9) * 0.5 * (last - first).norm()) {
      if (!solid_.inside(middle)) return;
      for (std::int64_t k = block.begin[2]; k < block.end[2]; ++k) {
        for (std::int64_t j = block.begin[1]; j < block.end[1]; ++j)
          set_bits(bits.row(j, k), block.begin[0], block.end[0]);
      }
      return;
    }
    Eigen::Index axis = 0;
    size.maxCoeff(&axis);
    Block low = block;
    Block high = block;
    low.end[axis] = high.begin[axis] = block.begin[axis] + size[axis] / 2;
    fill(low, lattice, bits);
    fill(high, lattice, bits);
  }

  void fill_by_points(const Block& block, const GridFrame& lattice, BitVolume& bits) const {
    for (std::int64_t k = block.begin[2]; k < block.end[2]; ++k) {
      for (std::int64_t j = block.begin[1]; j < block.end[1]; ++j) {
        for (std::int64_t i = block.begin[0]; i < block.end[0]; ++i) {
          if (solid_.inside(lattice.center({i, j, k}))) bits.row(j, k)[i / kWordBits] |= bit_of(i);
        }
      }
    }
  }

  const ImplicitSolid& solid_;
};

/// Trilinear interpolation; T are the samples.
template <class T>
class FieldSampler final : public SolidSampler {
 public:
  FieldSampler(const Grid<T>& grid, double iso_value) : grid_(grid), iso_value_(iso_value) {}

  Box box() const override {
    Box box;
    box.extend(grid_.frame.origin);
    box.extend(grid_.frame.origin + grid_.frame.voxel_size * grid_.frame.dims.template cast<double>());
    return box;
  }
  std::int64_t items(const GridFrame& lattice) const override { return lattice.dims[2]; }

  BitVolume sample(const GridFrame& lattice, std::uint64_t, Stage& stage, RunContext& context) const override {
    BitVolume bits(lattice.dims);
    bits.clear();
    const AxisMap x = map_axis(lattice, 0);
    const AxisMap y = map_axis(lattice, 1);
    const AxisMap z = map_axis(lattice, 2);
    parallel_for(context, 0, lattice.dims[2], 1, [&](std::int64_t k, std::int64_t) {
      std::vector<double> values(static_cast<std::size_t>(grid_.nx()));
      for (std::int64_t j = y.begin; j < y.end && k >= z.begin && k < z.end; ++j) {
        interpolate_row(y.at(j), z.at(k), values);
        fill_row(values, x, bits.row(j, k));
      }
      stage.advance(1);
    });
    return bits;
  }

 private:
  /// A position between samples `first` and `first` + 1, or at `first`, where there is none after it.
  struct Position {
    std::int64_t first;
    double share;  ///< of the second
  };
  /// The lattice points [begin, end) that lie in the grid.
  struct AxisMap {
    std::int64_t begin = 0;
    std::int64_t end = 0;
    std::vector<Position> positions;
    const Position& at(std::int64_t i) const { return positions[static_cast<std::size_t>(i - begin)]; }
  };

  AxisMap map_axis(const GridFrame& lattice, int axis) const {
    const auto samples = static_cast<double>(grid_.frame.dims[axis]);
    AxisMap map;
    map.begin = map.end = lattice.dims[axis];
    for (std::int64_t i = 0; i < lattice.dims[axis]; ++i) {
      const double center = lattice.origin[axis] + (static_cast<double>(i) + 0.5) * lattice.voxel_size;
      const double at = (center - grid_.frame.origin[axis]) / grid_.frame.voxel_size;  // 0 at the first voxel's face
      if (at < 0 || at > samples) {
        if (map.begin == lattice.dims[axis] || at < 0) continue;
        map.end = i;
        break;
      }
      if (map.begin == lattice.dims[axis]) map.begin = i;
      const double clamped = std::clamp(at - 0.5, 0.0, samples - 1);
      const auto first = static_cast<std::int64_t>(clamped);
      map.positions.push_back({first, clamped - static_cast<double>(first)});
    }
    return map;
  }

  /// The values on a line along x, at the samples' own positions.
  void interpolate_row(const Position& y, const Position& z, std::vector<double>& values) const {
    const std::int64_t next_y = std::min(y.first + 1, grid_.ny() - 1);
    const std::int64_t next_z = std::min(z.first + 1, grid_.nz() - 1);
    const T* corners[4] = {&grid_(0, y.first, z.first), &grid_(0, next_y, z.first), &grid_(0, y.first, next_z),
                           &grid_(0, next_y, next_z)};
    for (std::size_t i = 0; i < values.size(); ++i) {
      const auto value = [&](int corner) { return static_cast<double>(corners[corner][i]); };
      const double near = value(0) + y.share * (value(1) - value(0));
      const double far = value(2) + y.share * (value(3) - value(2));
      values[i] = near + z.share * (far - near);
    }
  }

  void fill_row(const std::vector<double>& values, const AxisMap& x, BitWord* row) const {
    for (std::int64_t i = x.begin; i < x.end;) {
      const std::int64_t cell = x.at(i).first;
      std::int64_t end = i + 1;
      while (end < x.end && x.at(end).first == cell) ++end;
      const double a = values[static_cast<std::size_t>(cell)];
      const double b = values[static_cast<std::size_t>(std::min(cell + 1, grid_.nx() - 1))];
      if (a >= iso_value_ && b >= iso_value_) {
        set_bits(row, i, end);
      } else if (a >= iso_value_ || b >= iso_value_) {
        for (std::int64_t p = i; p < end; ++p)
          if (a + x.at(p).share * (b - a) >= iso_value_) row[p / kWordBits] |= bit_of(p);
      }
      i = end;
    }
  }

  const Grid<T>& grid_;
  double iso_value_;
};

}  // namespace

std::unique_ptr<SolidSampler> make_sampler(const Model& model, const VoxelizeOptions& options) {
  if (const auto* soup = model.soup()) return std::make_unique<SoupSampler>(*soup, options);
  if (const auto* scalar = std::get_if<ScalarVolume>(&model.shape)) {
    return std::make_unique<FieldSampler<float>>(scalar->grid, static_cast<double>(scalar->iso_value));
  }
  if (const auto* binary = std::get_if<BinaryVolume>(&model.shape))
    return std::make_unique<FieldSampler<std::uint8_t>>(*binary, 0.5);
  return std::make_unique<ImplicitSampler>(std::get<ImplicitSolid>(model.shape));
}

}  // namespace voxcarve
