// Slices as [NT03, Figs. 2 and 5] shows them. The paper does not state its colours in numbers ("blue indicates a small
// distance, red a large distance, the colors cycle at greater distances"); here the hue runs from blue to red and jumps
// back, so that every period ends in a line of equal distance. Distances are exact, not Danielsson's, and of the whole
// volume.
#include "experiments/render/slice.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string>

#include "common/run/errors.h"
#include "common/run/text.h"
#include "common/volume/distance_transform.h"

namespace voxcarve {

namespace {

constexpr std::string_view kAxisNames = "xyz";
constexpr double kMarginShare = 1.0 / 100;  ///< of the scene's shorter side, left white on every side
constexpr Rgb8 kInteriorInDistanceMap = {48, 48, 48};
constexpr unsigned char kFrame = 128;  ///< grey of the line around a slice
constexpr int kMostSamples = 64;       ///< along each side of a pixel: beyond it more of them change no colour visibly
constexpr Rgb8 kContourOnGrey = {230, 60, 20};
constexpr Rgb8 kContourOnColors = {0, 0, 0};

/// The axes that run to the right and upwards in a slice.
struct SliceAxes {
  int right, up;
  explicit SliceAxes(int axis) : right(axis == 0 ? 1 : 0), up(axis == 2 ? 1 : 2) {}
};

/// A whole number from all of `text`.
template <class Number>
bool read_number(std::string_view text, Number& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return !text.empty() && error == std::errc() && end == text.data() + text.size();
}

}  // namespace

SlicePosition parse_slice(std::string_view text) {
  SlicePosition position;
  const std::size_t axis = text.empty() ? std::string_view::npos : kAxisNames.find(text[0]);
  bool good = axis != std::string_view::npos && (text.size() == 1 || text[1] == '=');
  if (good) position.axis = static_cast<int>(axis);
  if (good && text.size() > 1) {
    std::string_view where = text.substr(2);
    if (where.ends_with('%')) {
      where.remove_suffix(1);
      good = read_number(where, position.share) && position.share >= 0 && position.share <= 100;
      position.share /= 100;
    } else {
      std::int64_t index = 0;
      good = read_number(where, index);
      position.index = index;
    }
  }
  if (!good) {
    throw ParameterError("slice '" + std::string(text) +
                         "' is none: write x, y or z, with a voxel index or a share from 0 to 100 %: z, z=12, z=50%");
  }
  return position;
}

std::int64_t slice_index(const SlicePosition& position, const GridFrame& frame, std::string_view name) {
  const std::int64_t count = frame.dims[position.axis];
  if (!position.index) {
    const double slice = std::floor(position.share * static_cast<double>(count));
    return std::clamp<std::int64_t>(static_cast<std::int64_t>(slice), 0, count - 1);
  }
  if (*position.index < 0 || *position.index >= count) {
    const std::string axis(1, kAxisNames[static_cast<std::size_t>(position.axis)]);
    throw ParameterError(std::string(name) + " has no slice " + axis + "=" + std::to_string(*position.index) +
                         ": along " + axis + " it has " + std::to_string(count) + ", numbered from 0");
  }
  return *position.index;
}

std::int64_t slice_at(int axis, double coordinate, const GridFrame& frame, std::string_view name) {
  const double slice = std::floor((coordinate - frame.origin[axis]) / frame.voxel_size);
  if (!(slice >= 0 && slice < static_cast<double>(frame.dims[axis]))) {
    throw ParameterError(std::string(name) + " has no slice in the first volume's plane " +
                         kAxisNames[static_cast<std::size_t>(axis)] + " = " + format_real(coordinate) +
                         "; give --separate to slice every volume by itself");
  }
  return static_cast<std::int64_t>(slice);
}

template <class T>
SliceField extract_slice(const Grid<T>& grid, int axis, std::int64_t index) {
  const SliceAxes axes(axis);
  SliceField field;
  field.width = grid.frame.dims[axes.right];
  field.height = grid.frame.dims[axes.up];
  field.lower = {grid.frame.origin[axes.right], grid.frame.origin[axes.up]};
  field.voxel_size = grid.frame.voxel_size;
  field.values.reserve(static_cast<std::size_t>(field.width * field.height));
  Index3 voxel = Index3::Constant(index);
  for (std::int64_t row = 0; row < field.height; ++row) {
    for (std::int64_t column = 0; column < field.width; ++column) {
      voxel[axes.right] = column;
      voxel[axes.up] = row;
      field.values.push_back(static_cast<float>(grid(voxel[0], voxel[1], voxel[2])));
    }
  }
  return field;
}

template SliceField extract_slice(const Grid<std::uint8_t>&, int, std::int64_t);
template SliceField extract_slice(const Grid<std::int32_t>&, int, std::int64_t);
template SliceField extract_slice(const Grid<float>&, int, std::int64_t);

SliceField distance_slice(const BinaryVolume& volume, int axis, std::int64_t index, std::string_view name,
                          RunContext& context) {
  const Grid<std::int32_t> squared = squared_distance(volume, 1, context);
  // One voxel tells for all: with a feature anywhere, every distance is finite.
  if (squared.values.empty() || squared.values.front() == kInfiniteDistance) {
    throw InputError(std::string(name) + " has no interior voxel that distances could be measured to");
  }
  SliceField field = extract_slice(squared, axis, index);
  for (float& value : field.values) value = std::sqrt(value);
  return field;
}

Rgb8 grey_color(double value, double low, double high) {
  const double share = high > low ? std::clamp((value - low) / (high - low), 0.0, 1.0) : (value > low ? 1.0 : 0.0);
  const auto grey = static_cast<std::uint8_t>(std::lround(255 * share));
  return {grey, grey, grey};
}

Rgb8 cyclic_color(double value, double period) {
  const double cycles = value / period;
  // The four sides of the hue circle from blue over cyan, green and yellow to red.
  const double hue = 4 * (cycles - std::floor(cycles));
  const auto channel = [](double x) { return static_cast<std::uint8_t>(std::lround(255 * std::clamp(x, 0.0, 1.0))); };
  return {channel(hue - 2), channel(std::min(hue, 4 - hue)), channel(2 - hue)};
}

SlicePicture color_slice(const SliceField& field, const SliceColors& colors) {
  SlicePicture picture;
  picture.width = field.width;
  picture.height = field.height;
  picture.lower = field.lower;
  picture.voxel_size = field.voxel_size;
  picture.contour_color = colors.map == ColorMap::kGrey ? kContourOnGrey : kContourOnColors;
  picture.colors.reserve(field.values.size());
  for (const float sample : field.values) {
    const auto value = static_cast<double>(sample);
    if (colors.mark_zero && value == 0) {
      picture.colors.push_back(kInteriorInDistanceMap);
    } else if (colors.map == ColorMap::kGrey) {
      picture.colors.push_back(grey_color(value, colors.low, colors.high));
    } else {
      picture.colors.push_back(cyclic_color(value, colors.period));
    }
  }
  return picture;
}

void add_contour(SlicePicture& picture, const SliceField& field, double iso_value) {
  picture.above_iso.clear();
  for (const float value : field.values)
    picture.above_iso.push_back(static_cast<float>(static_cast<double>(value) - iso_value));
}

SlicePainter::SlicePainter(const std::vector<const SlicePicture*>& slices, bool common, int width, int height)
    : common_(common), width_(width), height_(height) {
  if (common) common_fit_ = fit(slices);
}

SlicePainter::Fit SlicePainter::fit(const std::vector<const SlicePicture*>& slices) const {
  Fit fit;
  if (slices.empty()) return fit;
  Eigen::Vector2d lower = slices[0]->lower;
  Eigen::Vector2d upper = lower;
  double voxel = slices[0]->voxel_size;
  for (const SlicePicture* slice : slices) {
    const Eigen::Vector2d size(static_cast<double>(slice->width), static_cast<double>(slice->height));
    lower = lower.cwiseMin(slice->lower);
    upper = upper.cwiseMax(slice->lower + slice->voxel_size * size);
    voxel = std::min(voxel, slice->voxel_size);
  }
  const int margin = std::max(1, static_cast<int>(std::min(width_, height_) * kMarginShare));
  const Eigen::Array2d room = Eigen::Array2d(width_ - 2 * margin, height_ - 2 * margin).max(1);
  // Sums of coordinates miss whole numbers of voxels by some rounding.
  const Eigen::Array2d voxels = ((upper - lower).array() / voxel - 1e-6).ceil().max(1);
  const double enlargement = (room / voxels).minCoeff();
  if (enlargement >= 1) {
    fit.pixel = voxel / std::floor(enlargement);
  } else {
    const double voxels_a_pixel = std::ceil(1 / enlargement - 1e-9);
    fit.samples = static_cast<int>(std::min<double>(voxels_a_pixel, kMostSamples));
    fit.pixel = voxel * voxels_a_pixel;
  }
  if (!std::isfinite(fit.pixel))
    throw ParameterError("the slices lie too far apart for one scale; give --separate to draw every one by itself");
  const Eigen::Array2d used = (voxels * voxel / fit.pixel).round();
  const Eigen::Array2d border = ((Eigen::Array2d(width_, height_) - used) / 2).floor();
  fit.lower = lower.array() - border * fit.pixel;
  return fit;
}

namespace {

/// The voxel that holds a position along one axis, of `count`; -1 or `count` outside the slice, however far.
std::int64_t voxel_at(double position, double lower, double voxel_size, std::int64_t count) {
  const double voxel = std::floor((position - lower) / voxel_size);
  return static_cast<std::int64_t>(std::clamp(voxel, -1.0, static_cast<double>(count)));
}

std::int64_t voxels_along(const SlicePicture& slice, int axis) {
  return axis == 0 ? slice.width : slice.height;
}

/// The field between the voxel centres, constant beyond the outermost.
double bilinear(const SlicePicture& slice, const Eigen::Vector2d& position) {
  const Eigen::Array2d last(static_cast<double>(slice.width - 1), static_cast<double>(slice.height - 1));
  const Eigen::Array2d at = ((position - slice.lower).array() / slice.voxel_size - 0.5).max(0).min(last);
  const auto column = std::min(static_cast<std::int64_t>(at.x()), std::max<std::int64_t>(slice.width - 2, 0));
  const auto row = std::min(static_cast<std::int64_t>(at.y()), std::max<std::int64_t>(slice.height - 2, 0));
  const std::int64_t right = std::min(column + 1, slice.width - 1);
  const std::int64_t above = std::min(row + 1, slice.height - 1);
  const double x = at.x() - static_cast<double>(column);
  const double y = at.y() - static_cast<double>(row);
  const auto value = [&](std::int64_t i, std::int64_t j) {
    return static_cast<double>(slice.above_iso[static_cast<std::size_t>(j * slice.width + i)]);
  };
  return (1 - y) * ((1 - x) * value(column, row) + x * value(right, row)) +
         y * ((1 - x) * value(column, above) + x * value(right, above));
}

}  // namespace

/// The samples of a scene's pixels along one axis.
struct SlicePainter::Lane {
  std::vector<std::int64_t> voxels;  ///< of every sample, `samples` a pixel; outside the slice -1 or the number of them
  int first = 0, last = 0;           ///< the pixels from the first to before the last hold all that lie inside
};

SlicePainter::Lane SlicePainter::lane(const SlicePicture& slice, const Fit& fit, int axis) const {
  const int pixels = axis == 0 ? width_ : height_;
  const std::int64_t count = voxels_along(slice, axis);
  Lane lane{{}, pixels, 0};
  lane.voxels.reserve(static_cast<std::size_t>(pixels) * static_cast<std::size_t>(fit.samples));
  for (int pixel = 0; pixel < pixels; ++pixel) {
    for (int sample = 0; sample < fit.samples; ++sample) {
      const double position = fit.lower[axis] + fit.pixel * (pixel + (sample + 0.5) / fit.samples);
      const std::int64_t voxel = voxel_at(position, slice.lower[axis], slice.voxel_size, count);
      lane.voxels.push_back(voxel);
      if (voxel < 0 || voxel >= count) continue;
      lane.first = std::min(lane.first, pixel);
      lane.last = pixel + 1;
    }
  }
  return lane;
}

std::vector<unsigned char> SlicePainter::paint(const SlicePicture& slice, const std::stop_token& cancellation) const {
  const Fit fit = common_ ? common_fit_ : this->fit({&slice});
  const Lane columns = lane(slice, fit, 0);
  const Lane rows = lane(slice, fit, 1);
  const auto color_at = [&](std::size_t x, std::size_t y) {
    const std::int64_t column = columns.voxels[x];
    const std::int64_t row = rows.voxels[y];
    if (column < 0 || row < 0 || column >= slice.width || row >= slice.height) return Rgb8{255, 255, 255};
    return slice.colors[static_cast<std::size_t>(row * slice.width + column)];
  };
  const auto samples = static_cast<std::size_t>(fit.samples);
  std::vector<unsigned char> rgb(3 * static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), 255);
  for (int y = rows.first; y < rows.last; ++y) {
    if (cancellation.stop_requested()) throw Cancelled();
    for (int x = columns.first; x < columns.last; ++x) {
      std::array<std::size_t, 3> sum = {0, 0, 0};
      for (std::size_t sample = 0; sample < samples * samples; ++sample) {
        const Rgb8 color = color_at(static_cast<std::size_t>(x) * samples + sample % samples,
                                    static_cast<std::size_t>(y) * samples + sample / samples);
        for (std::size_t channel = 0; channel < 3; ++channel) sum[channel] += color[channel];
      }
      unsigned char* const pixel = rgb.data() + 3 * pixel_index(x, y);
      for (std::size_t channel = 0; channel < 3; ++channel)
        pixel[channel] = static_cast<unsigned char>((sum[channel] + samples * samples / 2) / (samples * samples));
    }
  }
  if (!slice.above_iso.empty()) draw_contour(slice, fit, rgb, cancellation);
  draw_frame(slice, fit, rgb);
  return rgb;
}

void SlicePainter::draw_frame(const SlicePicture& slice, const Fit& fit, std::vector<unsigned char>& rgb) const {
  const auto pixel_of = [&fit](double position, int axis) {
    return static_cast<int>(std::lround((position - fit.lower[axis]) / fit.pixel));
  };
  const double size = slice.voxel_size;
  const int left = pixel_of(slice.lower.x(), 0) - 1;
  const int right = pixel_of(slice.lower.x() + size * static_cast<double>(slice.width), 0);
  const int bottom = pixel_of(slice.lower.y(), 1) - 1;
  const int top = pixel_of(slice.lower.y() + size * static_cast<double>(slice.height), 1);
  for (int y = std::max(bottom, 0); y <= std::min(top, height_ - 1); ++y) {
    for (int x = std::max(left, 0); x <= std::min(right, width_ - 1); ++x) {
      if (x != left && x != right && y != bottom && y != top) continue;
      std::fill_n(rgb.data() + 3 * pixel_index(x, y), 3, kFrame);
    }
  }
}

void SlicePainter::draw_contour(const SlicePicture& slice, const Fit& fit, std::vector<unsigned char>& rgb,
                                const std::stop_token& cancellation) const {
  const auto inside = [&](int x, int y) {
    const Eigen::Vector2d position = fit.lower + fit.pixel * Eigen::Vector2d(x + 0.5, y + 0.5);
    // Everything beyond the grid counts as exterior.
    for (int axis = 0; axis < 2; ++axis) {
      const std::int64_t count = voxels_along(slice, axis);
      const std::int64_t voxel = voxel_at(position[axis], slice.lower[axis], slice.voxel_size, count);
      if (voxel < 0 || voxel >= count) return false;
    }
    return bilinear(slice, position) >= 0;
  };
  // The outermost interior pixels.
  for (int y = 0; y < height_; ++y) {
    if (cancellation.stop_requested()) throw Cancelled();
    for (int x = 0; x < width_; ++x) {
      if (!inside(x, y) || (inside(x - 1, y) && inside(x + 1, y) && inside(x, y - 1) && inside(x, y + 1))) continue;
      std::copy(slice.contour_color.begin(), slice.contour_color.end(), rgb.data() + 3 * pixel_index(x, y));
    }
  }
}

}  // namespace voxcarve
