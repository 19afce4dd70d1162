#include "experiments/benchmarks/shapes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <random>

#include "common/mesh/models/primitives.h"
#include "common/run/context.h"

namespace voxcarve::bench {

namespace {

/// Half the width of the band over which a density goes from 0 to 1, in voxels.
constexpr double kHalfBand = 2;

/// The radius of the ball in a direction; at most 1.
double bumpy_radius(const Point& direction) {
  const double bumps = std::sin(7 * direction[0] + 1) * std::sin(6 * direction[1] + 2) * std::sin(8 * direction[2] + 3);
  return 0.95 + 0.05 * bumps;
}

/// Density as a function of the depth below the surface, in voxels.
float density_at_depth(double depth) {
  return static_cast<float>(std::clamp(0.5 + depth / (2 * kHalfBand), 0.0, 1.0));
}

/// Evaluates `depth`, a signed depth in voxels, at every voxel of a cube about the origin whose half side is 1.
template <class Depth>
DensityVolume density_volume(std::int64_t resolution, const Depth& depth) {
  GridFrame frame;
  frame.dims = Index3::Constant(resolution);
  DensityVolume volume(frame);
  RunContext context;
  context.threads = 2;
  const double half = 0.5 * static_cast<double>(resolution);
  parallel_for(context, 0, resolution, 1, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t k = first; k < last; ++k) {
      for (std::int64_t j = 0; j < resolution; ++j) {
        for (std::int64_t i = 0; i < resolution; ++i) {
          const Point p = frame.center({i, j, k}) / half - Point::Ones();
          volume(i, j, k) = density_at_depth(depth(p, half));
        }
      }
    }
  });
  return volume;
}

/// Sets the voxels of a ball, cut off at the border of the grid, and tells how many of them had another value.
std::int64_t paint_ball(BinaryVolume& volume, const Index3& center, std::int64_t radius, std::uint8_t value) {
  const auto& dims = volume.frame.dims;
  const Index3 low = (center.array() - radius).max(0).matrix();
  const Index3 high = (center.array() + radius).min(dims.array() - 1).matrix();
  std::int64_t changed = 0;
  for (std::int64_t k = low[2]; k <= high[2]; ++k) {
    for (std::int64_t j = low[1]; j <= high[1]; ++j) {
      const std::int64_t dj = j - center[1];
      const std::int64_t dk = k - center[2];
      const std::int64_t left = radius * radius - dj * dj - dk * dk;
      if (left < 0) continue;
      const auto half = static_cast<std::int64_t>(std::sqrt(static_cast<double>(left)));
      const std::int64_t begin = std::max(center[0] - half, low[0]);
      const std::int64_t end = std::min(center[0] + half, high[0]) + 1;
      if (begin >= end) continue;
      std::uint8_t* row = volume.values.data() + volume.index(0, j, k);
      changed += (end - begin) - std::count(row + begin, row + end, value);
      std::fill(row + begin, row + end, value);
    }
  }
  return changed;
}

/// Whole numbers from `low` to `high`, the same on every machine: the distributions of the standard library are not.
class Dice {
 public:
  std::int64_t roll(std::int64_t low, std::int64_t high) {
    return low + static_cast<std::int64_t>(engine_() % static_cast<std::uint64_t>(high - low + 1));
  }
  /// A voxel at least `margin` away from the border of the grid.
  Index3 voxel(const Index3& dims, std::int64_t margin) {
    Index3 result;
    for (int axis = 0; axis < 3; ++axis) result[axis] = roll(margin, dims[axis] - 1 - margin);
    return result;
  }

 private:
  std::mt19937_64 engine_;  // its default seed
};

/// Radius of the solids in a cube of half side 1: three voxels of exterior are left all around.
double unit_radius(double half) {
  return 1 - 3 / half;
}

}  // namespace

TriangleSoup bumpy_ball(std::int64_t triangles) {
  const TriangleSoup icosahedron = icosphere(Point::Zero(), 1, 0);
  const auto n = std::max<std::int64_t>(1, std::llround(std::sqrt(static_cast<double>(triangles) / 20)));
  const Eigen::Matrix3d askew =
      (Eigen::AngleAxisd(0.3, Point::UnitX()) * Eigen::AngleAxisd(0.5, Point::UnitZ())).toRotationMatrix();
  TriangleSoup soup;
  // A vertex by its whole-number weights on the icosahedron's corners: the same from either side of an edge.
  std::map<std::array<std::array<std::int64_t, 2>, 3>, std::uint32_t> index_of;
  for (const Triangle& face : icosahedron.triangles) {
    const auto vertex = [&](std::int64_t a, std::int64_t b) {
      std::array<std::array<std::int64_t, 2>, 3> weights{{{face[0], n - a - b}, {face[1], a}, {face[2], b}}};
      for (auto& weight : weights) {
        if (weight[1] == 0) weight[0] = -1;
      }
      std::ranges::sort(weights);
      const auto [entry, is_new] = index_of.try_emplace(weights, static_cast<std::uint32_t>(soup.positions.size()));
      if (is_new) {
        Point p = Point::Zero();
        for (const auto& [corner, weight] : weights) {
          if (corner >= 0) p += static_cast<double>(weight) * icosahedron.positions[static_cast<std::size_t>(corner)];
        }
        const Point direction = askew * p.normalized();
        soup.positions.push_back(bumpy_radius(direction) * direction);
      }
      return entry->second;
    };
    for (std::int64_t b = 0; b < n; ++b) {
      for (std::int64_t a = 0; a + b < n; ++a) {
        soup.triangles.push_back({vertex(a, b), vertex(a + 1, b), vertex(a, b + 1)});
        if (a + b + 1 < n) soup.triangles.push_back({vertex(a + 1, b), vertex(a + 1, b + 1), vertex(a, b + 1)});
      }
    }
  }
  return soup;
}

DensityVolume bumpy_ball_density(std::int64_t resolution) {
  return density_volume(resolution, [](const Point& p, double half) {
    const double distance = p.norm();
    const Point direction = distance > 0 ? Point(p / distance) : Point(Point::UnitX());
    return (unit_radius(half) * bumpy_radius(direction) - distance) * half;
  });
}

DensityVolume gyroid_density(std::int64_t resolution, double periods) {
  return density_volume(resolution, [periods](const Point& p, double half) {
    const Point t = std::numbers::pi * periods * p;
    const double value =
        std::sin(t[0]) * std::cos(t[1]) + std::sin(t[1]) * std::cos(t[2]) + std::sin(t[2]) * std::cos(t[0]);
    // The gradient of the gyroid at its zero is about 3/2 a radian.
    const double gyroid = value / (1.5 * std::numbers::pi * periods);
    return std::min(gyroid, unit_radius(half) - p.norm()) * half;
  });
}

BinaryVolume scattered_balls(std::int64_t side) {
  GridFrame frame;
  frame.dims = Index3::Constant(side);
  BinaryVolume volume(frame);
  const std::int64_t wanted = frame.voxels() * 3 / 10;
  std::int64_t interior = 0;
  for (const Index3& corner : {Index3(1, 1, 1), Index3(3, 3, 1), Index3(3, 1, 3), Index3(1, 3, 3)})
    interior += paint_ball(volume, corner * side / 4, side * 22 / 100, 1);
  Dice dice;
  while (interior < wanted) {
    const std::int64_t radius = dice.roll(2, 12);
    interior += paint_ball(volume, dice.voxel(frame.dims, radius + 1), radius, 1);
  }
  return volume;
}

BinaryVolume pitted_ellipsoid(const Index3& dims) {
  GridFrame frame;
  frame.dims = dims;
  BinaryVolume volume(frame);
  RunContext context;
  context.threads = 2;
  const Point half = 0.5 * dims.cast<double>();
  parallel_for(context, 0, dims[2], 1, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t k = first; k < last; ++k) {
      for (std::int64_t j = 0; j < dims[1]; ++j) {
        for (std::int64_t i = 0; i < dims[0]; ++i) {
          const Point p = frame.center({i, j, k}).cwiseQuotient(half) - Point::Ones();
          volume(i, j, k) = static_cast<std::uint8_t>(p.norm() <= bumpy_radius(p.normalized()));
        }
      }
    }
  });
  Dice dice;
  for (int ball = 0; ball < 400; ++ball) {
    Point direction = dice.voxel(Index3::Constant(2001), 0).cast<double>() - Point::Constant(1000);
    direction.normalize();
    const Point surface = half + bumpy_radius(direction) * direction.cwiseProduct(half);
    paint_ball(volume, surface.cast<std::int64_t>(), dice.roll(3, dims.minCoeff() / 9), ball % 2 == 0);
  }
  return volume;
}

}  // namespace voxcarve::bench
