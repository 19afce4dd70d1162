#include "common/volume/io/samples.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/run/byte_order.h"
#include "common/run/context.h"
#include "common/run/errors.h"
#include "common/run/text.h"
#include "common/run/text_scanner.h"

namespace voxcarve::volume_io {

namespace {

constexpr std::int64_t kMaxSamples = std::int64_t{1} << 40;

/// Single precision of a sample, or nothing when that is not finite.
template <class T>
std::optional<float> to_float(T value) {
  if constexpr (std::is_same_v<T, double>) {
    // Converting what float cannot hold is undefined.
    if (!(std::abs(value) <= static_cast<double>(std::numeric_limits<float>::max()))) return std::nullopt;
  }
  const auto result = static_cast<float>(value);
  return std::isfinite(result) ? std::optional(result) : std::nullopt;
}

template <class T>
void decode(const VolumeLayout& layout, std::string_view data, std::string_view name, std::size_t offset,
            GridValues<float>& values) {
  for (std::size_t sample = 0; sample < values.size(); ++sample) {
    const std::optional<float> value = to_float(load<T>(data.data() + sample * sizeof(T), layout.order));
    if (!value) {
      throw InputError(name, fmt::format("byte {}", offset + sample * sizeof(T)),
                       "a sample is not finite in single precision");
    }
    values[sample] = *value;
  }
}

VolumeFile allocate(const VolumeLayout& layout) {
  VolumeFile file;
  file.values = Grid<float>({layout.dims, Point::Zero(), 1.0});
  return file;
}

void detect_binary(const VolumeLayout& layout, VolumeFile& file) {
  file.is_binary = !is_real(layout.type) &&
                   std::ranges::all_of(file.values.values, [](float value) { return value == 0 || value == 1; });
}

}  // namespace

std::size_t size_of(SampleType type) {
  switch (type) {
    case SampleType::kInt8:
    case SampleType::kUint8:
      return 1;
    case SampleType::kInt16:
    case SampleType::kUint16:
      return 2;
    case SampleType::kInt32:
    case SampleType::kUint32:
    case SampleType::kFloat32:
      return 4;
    case SampleType::kInt64:
    case SampleType::kUint64:
    case SampleType::kFloat64:
      return 8;
  }
  return 0;
}

std::int64_t count_samples(const VolumeLayout& layout, std::string_view name) {
  std::int64_t count = 1;
  for (const std::int64_t size : layout.dims) {
    if (size < 1) throw InputError(fmt::format("{}: the volume is empty: one of its sizes is {}", name, size));
    if (size > kMaxSamples / count) {
      throw InputError(
          fmt::format("{}: absurd sizes {} x {} x {}", name, layout.dims[0], layout.dims[1], layout.dims[2]));
    }
    count *= size;
  }
  return count;
}

void check_geometry(const VolumeLayout& layout, std::string_view name) {
  for (const double spacing : layout.spacing) {
    if (!(spacing > 0) || !std::isfinite(spacing)) {
      throw InputError(fmt::format("{}: spacing {} is not positive and finite", name, format_real(spacing)));
    }
  }
  for (const std::optional<Point>& position : {layout.first_sample, layout.lower_corner}) {
    if (position && !position->allFinite()) throw InputError(fmt::format("{}: the origin is not finite", name));
  }
  const Point extent = layout.spacing.cwiseProduct(layout.dims.cast<double>());
  if (!(layout.first_sample.value_or(Point::Zero()) + extent).allFinite()) {
    throw InputError(fmt::format("{}: the volume's extent is not finite", name));
  }
}

void require_samples(const VolumeLayout& layout, std::size_t available, std::string_view name) {
  const auto count = static_cast<std::uint64_t>(count_samples(layout, name));
  const std::uint64_t bytes = count * size_of(layout.type);
  if (bytes > available) {
    throw InputError(fmt::format(
        "{}: {} x {} x {} samples take {} bytes, but the data hold {}; the file is truncated or its sizes are wrong",
        name, layout.dims[0], layout.dims[1], layout.dims[2], bytes, available));
  }
  const std::uint64_t needed = count * sizeof(float);
  if (needed > default_memory_budget()) {
    throw ResourceError(fmt::format("{}: the volume needs {} of memory", name, format_bytes(needed)));
  }
}

VolumeFile decode_binary(const VolumeLayout& layout, std::string_view data, std::string_view name, std::size_t offset) {
  require_samples(layout, data.size(), name);
  VolumeFile file = allocate(layout);
  GridValues<float>& values = file.values.values;
  switch (layout.type) {
    case SampleType::kInt8:
      decode<std::int8_t>(layout, data, name, offset, values);
      break;
    case SampleType::kUint8:
      decode<std::uint8_t>(layout, data, name, offset, values);
      break;
    case SampleType::kInt16:
      decode<std::int16_t>(layout, data, name, offset, values);
      break;
    case SampleType::kUint16:
      decode<std::uint16_t>(layout, data, name, offset, values);
      break;
    case SampleType::kInt32:
      decode<std::int32_t>(layout, data, name, offset, values);
      break;
    case SampleType::kUint32:
      decode<std::uint32_t>(layout, data, name, offset, values);
      break;
    case SampleType::kInt64:
      decode<std::int64_t>(layout, data, name, offset, values);
      break;
    case SampleType::kUint64:
      decode<std::uint64_t>(layout, data, name, offset, values);
      break;
    case SampleType::kFloat32:
      decode<float>(layout, data, name, offset, values);
      break;
    case SampleType::kFloat64:
      decode<double>(layout, data, name, offset, values);
      break;
  }
  detect_binary(layout, file);
  return file;
}

VolumeFile decode_text(const VolumeLayout& layout, std::string_view data, std::string_view name) {
  const auto count = static_cast<std::uint64_t>(count_samples(layout, name));
  VolumeLayout text = layout;
  text.type = SampleType::kUint8;  // a number and its separator take two bytes, so even one byte each is too much
  require_samples(text, (data.size() + 1) / 2, name);
  VolumeFile file = allocate(layout);
  TextScanner scanner(data, name);
  for (std::uint64_t sample = 0; sample < count; ++sample) {
    const std::string_view token = scanner.stream_token();
    if (token.empty()) {
      throw InputError(fmt::format("{}: the data end after {} of {} samples", name, sample, count));
    }
    const std::optional<double> number = parse_real(token);
    const std::optional<float> value = number ? to_float(*number) : std::nullopt;
    if (!value) {
      throw InputError(fmt::format("{}: sample {} is not a finite number: {}", name, sample, in_quotes(token)));
    }
    if (!is_real(layout.type) && *number != std::floor(*number)) {
      throw InputError(fmt::format("{}: sample {} is no integer: {}", name, sample, in_quotes(token)));
    }
    file.values.values[sample] = *value;
  }
  detect_binary(layout, file);
  return file;
}

VolumeFile image_volume(std::int64_t width, std::int64_t height, const std::vector<float>& values) {
  VolumeFile file;
  file.values = Grid<float>({{width, height, 1}, Point::Zero(), 1.0});
  const auto [low, high] = std::ranges::minmax(values);
  file.is_binary = std::ranges::all_of(values, [l = low, h = high](float value) { return value == l || value == h; });
  const float threshold = low < high ? high : 128.0F;
  for (std::int64_t row = 0; row < height; ++row) {
    for (std::int64_t column = 0; column < width; ++column) {
      const float value = values[static_cast<std::size_t>(row * width + column)];
      // The first row of the file is the top one, and y points up.
      file.values(column, height - 1 - row, 0) = file.is_binary ? (value >= threshold ? 1.0F : 0.0F) : value;
    }
  }
  return file;
}

}  // namespace voxcarve::volume_io
