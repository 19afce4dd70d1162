// Based on filtering the original volume directly [He95, 4]; differs in a Gaussian that is cut off along each axis
// instead of by distance, so that it is separable. Sums are of differences from the middle sample: what is constant
// stays so to the bit, whatever the weights are rounded to.
#include "common/volume/gaussian_filter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <utility>

#include "common/run/errors.h"
#include "common/volume/vectorized.h"
#include "common/volume/workspace_pool.h"

namespace voxcarve {

namespace {

using Lanes [[gnu::vector_size(32)]] = float;
/// The same at any address. (`auto` in place of this name would ask for whole alignment again.)
using LooseLanes [[gnu::aligned(alignof(float))]] = Lanes;
constexpr std::int64_t kLanes = 8;
constexpr std::int64_t kBlock = 4 * kLanes;  ///< values that are summed together

/// Filters `count` values side by side, each among its likes on 2 radius + 1 lines: those at window[0 ... 2 radius] +
/// first, which may be read up to the end of the last block. Every value is summed on its own, farthest samples first
/// and those of either side together, so results depend neither on registers nor on blocks; and registers of 256 bits
/// alone bring no fused multiply-add, so both versions round alike.
VOXCARVE_VECTORIZED void filter_lines(const float* const* window, std::int64_t first, const float* weights,
                                      std::int64_t radius, std::int64_t count, float* result) {
  const float* const* middle = window + radius;
  for (std::int64_t x = 0; x < count; x += kBlock) {
    const LooseLanes* center = reinterpret_cast<const LooseLanes*>(*middle + first + x);
    const std::array<Lanes, 4> twice = {center[0] + center[0], center[1] + center[1], center[2] + center[2],
                                        center[3] + center[3]};
    std::array<Lanes, 4> sum{};
    for (std::int64_t step = radius; step > 0; --step) {
      const LooseLanes* below = reinterpret_cast<const LooseLanes*>(middle[-step] + first + x);
      const LooseLanes* above = reinterpret_cast<const LooseLanes*>(middle[step] + first + x);
      for (std::size_t lane = 0; lane < 4; ++lane)
        sum[lane] += weights[step - 1] * ((below[lane] + above[lane]) - twice[lane]);
    }
    for (std::size_t lane = 0; lane < 4; ++lane) sum[lane] += center[lane];
    const std::int64_t wanted = std::min(count - x, kBlock);
    if (wanted == kBlock) {
      LooseLanes* to = reinterpret_cast<LooseLanes*>(result + x);
      for (std::size_t lane = 0; lane < 4; ++lane) to[lane] = sum[lane];
    } else {
      std::memcpy(result + x, sum.data(), static_cast<std::size_t>(wanted) * sizeof(float));
    }
  }
}

std::int64_t divided_up(std::int64_t count, std::int64_t by) {
  return (count + by - 1) / by;
}

/// Values from the beginning of a cache line on, so that no aligned load takes two.
class Buffer {
 public:
  Buffer(std::int64_t count, float value)
      : values_(static_cast<std::size_t>(divided_up(count, kLine)), Line{filled(value)}) {}
  float* data() { return reinterpret_cast<float*>(values_.data()); }

 private:
  static constexpr std::int64_t kLine = 16;
  struct alignas(64) Line {
    std::array<float, kLine> values;
  };
  static std::array<float, kLine> filled(float value) {
    std::array<float, kLine> values;
    values.fill(value);
    return values;
  }
  std::vector<Line> values_;
};

struct Range {
  std::int64_t begin = 0;
  std::int64_t end = 0;
  std::int64_t size() const { return end - begin; }
};

/// Part `part` of `parts`, about equal ones.
Range part_of(std::int64_t length, std::int64_t parts, std::int64_t part) {
  return {length * part / parts, length * (part + 1) / parts};
}

/// Filters columns of the grid: samples become sums along x, rows of these sums along y, and slices of those results.
/// A column is as wide as its last slices fit the processor's own cache, so that the grid is read and written once.
class GaussianFilter {
 public:
  GaussianFilter(const Grid<float>& field, const GaussianOptions& options, Grid<float>& result)
      : field_(field), result_(result), border_(options.border), outside_(options.outside) {
    for (int axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      weights_[a] = gaussian_weights(options.sigma[axis], options.support[axis]);
      if (axis == 2 && field.frame.is_image()) weights_[a].clear();
      radius_[a] = std::ssize(weights_[a]);
      kept_[a] = std::min(2 * radius_[a] + 1, field.frame.dims[axis]);
    }
    const Index3& dims = field.frame.dims;
    parts_ = {std::max<std::int64_t>(divided_up(dims[0], kMostWidth), 1),
              std::max<std::int64_t>(divided_up(dims[1], kMostRows), 1), 1};
    // Sums before a piece's first slice are made twice, so columns are cut only where there are few.
    parts_[2] = std::clamp<std::int64_t>(dims[2] / std::max<std::int64_t>(4 * radius_[2], 16), 1,
                                         divided_up(kFewestPieces, parts_[0] * parts_[1]));
    stride_ = divided_up(divided_up(dims[0], parts_[0]), kBlock) * kBlock;
    rows_ = divided_up(dims[1], parts_[1]);
  }

  std::int64_t pieces() const { return parts_[0] * parts_[1] * parts_[2]; }
  /// Of all pieces together.
  std::int64_t slices() const { return parts_[0] * parts_[1] * field_.nz(); }

  struct Workspace {
    Buffer samples;  ///< a row with the samples before and behind it
    Buffer rows;     ///< the last rows summed along x
    Buffer slices;   ///< the last slices summed along x and y
    Buffer outside;  ///< a slice
    std::array<std::vector<const float*>, 3> windows;
  };
  Workspace make_workspace() const {
    Workspace space{Buffer(stride_ + 2 * radius_[0], 0),
                    Buffer(kept_[1] * stride_, 0),
                    Buffer(kept_[2] * rows_ * stride_, 0),
                    Buffer(border_ == BorderRule::kConstant ? rows_ * stride_ : 0, outside_),
                    {}};
    for (std::int64_t i = 0; i <= 2 * radius_[0]; ++i) space.windows[0].push_back(space.samples.data() + i);
    return space;
  }
  std::uint64_t workspace_memory() const {
    const std::int64_t values =
        stride_ + 2 * radius_[0] + kept_[1] * stride_ + kept_[2] * rows_ * stride_ + rows_ * stride_;
    const std::int64_t pointers = 2 * (radius_[0] + radius_[1] + radius_[2]) + 3 + rows_ + field_.nz();
    return static_cast<std::uint64_t>(values) * sizeof(float) + static_cast<std::uint64_t>(pointers) * sizeof(float*);
  }

  void filter_piece(std::int64_t piece, Workspace& space, Stage& stage, const RunContext& context) const {
    const Range columns = part_of(field_.nx(), parts_[0], piece % parts_[0]);
    const Range rows = part_of(field_.ny(), parts_[1], piece / parts_[0] % parts_[1]);
    const Range slices = part_of(field_.nz(), parts_[2], piece / (parts_[0] * parts_[1]));
    point_at_lines(1, rows, space.rows.data(), stride_, space);
    point_at_lines(2, slices, space.slices.data(), rows_ * stride_, space);
    std::int64_t next = std::max<std::int64_t>(slices.begin - radius_[2], 0);
    for (std::int64_t k = slices.begin; k < slices.end; ++k) {
      for (; next < std::min(k + radius_[2] + 1, field_.nz()); ++next) {
        context.check_cancelled();
        sum_slice(columns, rows, next, space);
      }
      const float* const* window = space.windows[2].data() + (k - slices.begin);
      for (std::int64_t j = rows.begin; j < rows.end; ++j) {
        filter_lines(window, (j - rows.begin) * stride_, weights_[2].data(), radius_[2], columns.size(),
                     result_.values.data() + result_.index(columns.begin, j, k));
      }
      stage.advance(1);
    }
  }

 private:
  static constexpr std::int64_t kMostWidth = 128;
  static constexpr std::int64_t kMostRows = 64;
  static constexpr std::int64_t kFewestPieces = 16;  ///< that let threads end at about the same time

  /// Where the lines from range.begin - radius to range.end + radius along `axis` are found, when each lies where the
  /// one kept_ lines before it did. Windows of neighbouring lines are parts of this list.
  void point_at_lines(std::size_t axis, const Range& range, const float* lines, std::int64_t size,
                      Workspace& space) const {
    std::vector<const float*>& window = space.windows[axis];
    window.clear();
    const std::int64_t length = field_.frame.dims[static_cast<Eigen::Index>(axis)];
    for (std::int64_t line = range.begin - radius_[axis]; line < range.end + radius_[axis]; ++line) {
      const std::int64_t nearest = std::clamp<std::int64_t>(line, 0, length - 1);
      const bool beyond = nearest != line && border_ == BorderRule::kConstant;
      window.push_back(beyond ? space.outside.data() : lines + nearest % kept_[axis] * size);
    }
  }

  /// The samples of a row and those before and behind it.
  void take_row(const Range& columns, std::int64_t j, std::int64_t k, float* samples) const {
    const float* row = field_.values.data() + field_.index(0, j, k);
    const std::int64_t radius = radius_[0];
    const std::int64_t begin = std::max<std::int64_t>(columns.begin - radius, 0);
    const std::int64_t end = std::min(columns.end + radius, field_.nx());
    const bool repeat = border_ == BorderRule::kRepeat;
    samples = std::fill_n(samples, begin - (columns.begin - radius), repeat ? row[0] : outside_);
    samples = std::copy(row + begin, row + end, samples);
    std::fill_n(samples, columns.end + radius - end, repeat ? row[field_.nx() - 1] : outside_);
  }

  void sum_slice(const Range& columns, const Range& rows, std::int64_t k, Workspace& space) const {
    float* slice = space.slices.data() + k % kept_[2] * rows_ * stride_;
    std::int64_t next = std::max<std::int64_t>(rows.begin - radius_[1], 0);
    for (std::int64_t j = rows.begin; j < rows.end; ++j) {
      for (; next < std::min(j + radius_[1] + 1, field_.ny()); ++next) {
        take_row(columns, next, k, space.samples.data());
        filter_lines(space.windows[0].data(), 0, weights_[0].data(), radius_[0], stride_,
                     space.rows.data() + next % kept_[1] * stride_);
      }
      filter_lines(space.windows[1].data() + (j - rows.begin), 0, weights_[1].data(), radius_[1], stride_,
                   slice + (j - rows.begin) * stride_);
    }
  }

  const Grid<float>& field_;
  Grid<float>& result_;
  BorderRule border_;
  float outside_;
  std::array<std::vector<float>, 3> weights_;
  std::array<std::int64_t, 3> radius_{};
  std::array<std::int64_t, 3> kept_{};   ///< lines; along x this is the length of no buffer
  std::array<std::int64_t, 3> parts_{};  ///< that an axis is cut into
  std::int64_t stride_ = 0;              ///< of a row of a piece, whole blocks
  std::int64_t rows_ = 0;                ///< of a slice of a piece, at most
};

}  // namespace

std::vector<float> gaussian_weights(double sigma, double support) {
  constexpr double kLongestSupport = 16384;
  if (!(sigma >= 0) || !std::isfinite(sigma)) throw ParameterError("sigma must be a number and not negative");
  if (!(support >= 0) || support > kLongestSupport) {
    throw ParameterError("the support of a filter must be 0 to " + std::to_string(static_cast<int>(kLongestSupport)) +
                         " voxels");
  }
  std::vector<double> values;
  double total = 1;
  for (int step = 1; sigma > 0 && step <= support; ++step) {
    values.push_back(std::exp(-0.5 * (step / sigma) * (step / sigma)));
    total += 2 * values.back();
  }
  std::vector<float> weights;
  for (const double value : values) {
    const auto weight = static_cast<float>(value / total);
    if (weight < std::numeric_limits<float>::min()) break;  // slow to compute with, and of no effect
    weights.push_back(weight);
  }
  return weights;
}

Grid<float> gaussian_filtered(const Grid<float>& field, const GaussianOptions& options, RunContext& context) {
  Grid<float> result;
  result.frame = field.frame;
  const GaussianFilter filter(field, options, result);
  if (field.values.empty()) return result;
  Stage stage(context, "gaussian filter", filter.slices());
  context.require_memory(2 * field.values.size() * sizeof(float) +
                             workspaces_at_once(context, filter.pieces()) * filter.workspace_memory(),
                         "the gaussian filter");
  result.values.resize(field.values.size());
  WorkspacePool<GaussianFilter::Workspace> pool;
  parallel_for(context, 0, filter.pieces(), 1, [&](std::int64_t begin, std::int64_t end) {
    auto space = pool.take([&] { return filter.make_workspace(); });
    for (std::int64_t piece = begin; piece < end; ++piece) filter.filter_piece(piece, *space, stage, context);
    pool.give(std::move(space));
  });
  return result;
}

}  // namespace voxcarve
