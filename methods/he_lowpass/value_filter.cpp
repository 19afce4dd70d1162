#include "methods/he_lowpass/value_filter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "common/volume/gaussian_filter.h"

namespace voxcarve {

namespace {

/// Between samples `first` and `next`, which are the same at the borders.
struct Between {
  std::int64_t first = 0;
  std::int64_t next = 0;
  double share = 0;  ///< of the second
};

/// In units of samples; 0 is the first one.
double position_of(const GridFrame& field, const GridFrame& frame, int axis, std::int64_t i) {
  const double center = frame.origin[axis] + (static_cast<double>(i) + 0.5) * frame.voxel_size;
  return (center - field.origin[axis]) / field.voxel_size - 0.5;
}

std::vector<Between> positions_along(const GridFrame& field, const GridFrame& frame, int axis) {
  std::vector<Between> positions;
  for (std::int64_t i = 0; i < frame.dims[axis]; ++i) {
    const double last = static_cast<double>(field.dims[axis] - 1);
    const double at = std::clamp(position_of(field, frame, axis, i), 0.0, last);
    const auto first = static_cast<std::int64_t>(at);
    positions.push_back({first, std::min(first + 1, field.dims[axis] - 1), at - static_cast<double>(first)});
  }
  return positions;
}

class Interpolation {
 public:
  Interpolation(const Grid<float>& field, const GridFrame& frame)
      : field_(field),
        x_(positions_along(field.frame, frame, 0)),
        y_(positions_along(field.frame, frame, 1)),
        z_(positions_along(field.frame, frame, 2)) {}

  double at(std::int64_t i, std::int64_t j, std::int64_t k) const {
    const Between& x = x_[static_cast<std::size_t>(i)];
    const Between& y = y_[static_cast<std::size_t>(j)];
    const Between& z = z_[static_cast<std::size_t>(k)];
    const auto along_x = [&](std::int64_t row, std::int64_t slice) {
      const double a = static_cast<double>(field_(x.first, row, slice));
      return a + x.share * (static_cast<double>(field_(x.next, row, slice)) - a);
    };
    const auto along_y = [&](std::int64_t slice) {
      const double a = along_x(y.first, slice);
      return a + y.share * (along_x(y.next, slice) - a);
    };
    const double a = along_y(z.first);
    return a + z.share * (along_y(z.next) - a);
  }

 private:
  const Grid<float>& field_;
  std::vector<Between> x_, y_, z_;
};

/// The samples within the support of a centre along an axis, and how far off they are in supports.
struct Reached {
  std::int64_t index;  ///< clamped to the grid
  double distance;
};

std::vector<Reached> reached_along(const GridFrame& field, double center, int axis, double support) {
  std::vector<Reached> reached;
  const auto last = static_cast<std::int64_t>(std::floor(center + support));
  for (auto i = static_cast<std::int64_t>(std::ceil(center - support)); i <= last; ++i) {
    reached.push_back(
        {std::clamp<std::int64_t>(i, 0, field.dims[axis] - 1), (static_cast<double>(i) - center) / support});
  }
  return reached;
}

}  // namespace

Grid<float> interpolated(const Grid<float>& field, const GridFrame& frame, RunContext& context) {
  context.require_memory(static_cast<std::uint64_t>(field.frame.voxels() + frame.voxels()) * sizeof(float),
                         "a resampled volume");
  auto result = Grid<float>::uninitialized(frame);
  const Interpolation interpolation(field, frame);
  parallel_for(context, 0, frame.dims[2], 1, [&](std::int64_t k, std::int64_t) {
    for (std::int64_t j = 0; j < frame.dims[1]; ++j) {
      for (std::int64_t i = 0; i < frame.dims[0]; ++i) result(i, j, k) = static_cast<float>(interpolation.at(i, j, k));
    }
  });
  return result;
}

Grid<float> filter_values(const Grid<float>& field, const GridFrame& frame, const RadialFilter& filter, double support,
                          RunContext& context) {
  const double samples = support / field.frame.voxel_size;  // R in samples
  if (filter.shape == RadialShape::kGaussian) {
    GaussianOptions options;
    options.sigma = Point::Constant(filter.sigma_ratio * samples);
    options.support = Point::Constant(samples);
    return interpolated(gaussian_filtered(field, options, context), frame, context);
  }
  Stage stage(context, "low-pass filtering of values", frame.dims[2]);
  context.require_memory(static_cast<std::uint64_t>(field.frame.voxels() + frame.voxels()) * sizeof(float),
                         "low-pass filtering of values");
  auto result = Grid<float>::uninitialized(frame);
  const Interpolation interpolation(field, frame);
  std::array<std::vector<std::vector<Reached>>, 3> reached;
  for (int axis = 0; axis < 3; ++axis) {
    for (std::int64_t i = 0; i < frame.dims[axis]; ++i) {
      reached[static_cast<std::size_t>(axis)].push_back(
          reached_along(field.frame, position_of(field.frame, frame, axis, i), axis, samples));
    }
  }
  parallel_for(context, 0, frame.dims[2], 1, [&](std::int64_t k, std::int64_t) {
    for (std::int64_t j = 0; j < frame.dims[1]; ++j) {
      context.check_cancelled();
      for (std::int64_t i = 0; i < frame.dims[0]; ++i) {
        double sum = 0;
        double weights = 0;
        std::int64_t count = 0;
        for (const Reached& z : reached[2][static_cast<std::size_t>(k)]) {
          for (const Reached& y : reached[1][static_cast<std::size_t>(j)]) {
            const double beside = z.distance * z.distance + y.distance * y.distance;
            if (beside > 1) continue;
            for (const Reached& x : reached[0][static_cast<std::size_t>(i)]) {
              const double squared = beside + x.distance * x.distance;
              if (squared > 1) continue;
              const double weight = filter.weight(std::sqrt(squared));
              sum += weight * static_cast<double>(field(x.index, y.index, z.index));
              weights += weight;
              ++count;
            }
          }
        }
        constexpr std::int64_t kFewest = 8;
        result(i, j, k) =
            static_cast<float>(count >= kFewest && weights > 0 ? sum / weights : interpolation.at(i, j, k));
      }
    }
    stage.advance(1);
  });
  return result;
}

}  // namespace voxcarve
