// Based on [MRH00]; differs in running the same envelope pass along all three axes, and in taking lines without any
// feature apart.
#include "common/volume/distance_transform.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/run/errors.h"

namespace voxcarve {

namespace {

/// Room for one line: its values and the stack of parabolas of the envelope.
struct LineBuffer {
  explicit LineBuffer(std::int64_t length)
      : value(static_cast<std::size_t>(length)),
        apex(static_cast<std::size_t>(length)),
        start(static_cast<std::size_t>(length)) {}
  std::vector<std::int32_t> value;
  std::vector<std::int64_t> apex;   ///< where the parabola of the stack has its minimum
  std::vector<std::int64_t> start;  ///< first position at which it is the lowest
};

/// First integer position at which the parabola with apex b lies strictly below the one with apex a < b.
std::int64_t first_below(std::int64_t a, std::int64_t value_a, std::int64_t b, std::int64_t value_b) {
  // (x-b)^2 + value_b < (x-a)^2 + value_a  <=>  x > (b^2 - a^2 + value_b - value_a) / (2 (b - a))
  const std::int64_t numerator = b * b - a * a + value_b - value_a;
  const std::int64_t denominator = 2 * (b - a);
  const std::int64_t quotient =
      numerator >= 0 ? numerator / denominator : -((-numerator + denominator - 1) / denominator);
  return quotient + 1;
}

/// Replaces line[i] by min over j of line[j] + (i - j)^2; entries of kInfiniteDistance are no parabolas.
void lower_envelope(std::int32_t* line, std::int64_t length, std::int64_t stride, LineBuffer& buffer) {
  const auto size = static_cast<std::size_t>(length);
  for (std::size_t i = 0; i < size; ++i) buffer.value[i] = line[static_cast<std::int64_t>(i) * stride];
  std::int64_t top = -1;
  for (std::int64_t i = 0; i < length; ++i) {
    const std::int64_t value = buffer.value[static_cast<std::size_t>(i)];
    if (value == kInfiniteDistance) continue;
    std::int64_t begins = 0;
    while (top >= 0) {
      const auto t = static_cast<std::size_t>(top);
      const std::int64_t apex = buffer.apex[t];
      begins = first_below(apex, buffer.value[static_cast<std::size_t>(apex)], i, value);
      if (begins > buffer.start[t]) break;
      --top;  // it is nowhere the lowest any more
      begins = 0;
    }
    if (begins >= length) continue;
    ++top;
    buffer.apex[static_cast<std::size_t>(top)] = i;
    buffer.start[static_cast<std::size_t>(top)] = top == 0 ? 0 : begins;
  }
  if (top < 0) return;  // no feature on this line yet
  for (std::int64_t i = length - 1; i >= 0; --i) {
    while (buffer.start[static_cast<std::size_t>(top)] > i) --top;
    const std::int64_t apex = buffer.apex[static_cast<std::size_t>(top)];
    const std::int64_t distance = (i - apex) * (i - apex) + buffer.value[static_cast<std::size_t>(apex)];
    line[i * stride] = static_cast<std::int32_t>(distance);
  }
}

}  // namespace

Grid<std::int32_t> squared_distance(const BinaryVolume& volume, std::uint8_t feature, RunContext& context) {
  constexpr std::int64_t kLongestExactSide = 26754;  // 3 * 26754^2 < 2^31
  const Index3 dims = volume.frame.dims;
  if (dims.maxCoeff() > kLongestExactSide) {
    throw ResourceError("a distance transform takes at most " + std::to_string(kLongestExactSide) + " voxels a side");
  }
  context.require_memory(volume.values.size() * (sizeof(std::int32_t) + 2), "the distance transform");
  Grid<std::int32_t> distance(volume.frame);
  std::ranges::transform(volume.values, distance.values.begin(),
                         [feature](std::uint8_t value) { return value == feature ? 0 : kInfiniteDistance; });
  const std::array<std::int64_t, 3> stride = {1, dims[0], dims[0] * dims[1]};
  for (int axis = 0; axis < 3; ++axis) {
    if (dims[axis] == 1) continue;
    const int first_axis = axis == 0 ? 1 : 0;
    const int second_axis = axis == 2 ? 1 : 2;
    parallel_for(context, 0, dims[second_axis], 1, [&](std::int64_t begin, std::int64_t end) {
      LineBuffer buffer(dims[axis]);
      for (std::int64_t b = begin; b < end; ++b) {
        for (std::int64_t a = 0; a < dims[first_axis]; ++a) {
          const std::int64_t offset =
              a * stride[static_cast<std::size_t>(first_axis)] + b * stride[static_cast<std::size_t>(second_axis)];
          lower_envelope(distance.values.data() + offset, dims[axis], stride[static_cast<std::size_t>(axis)], buffer);
        }
      }
    });
  }
  return distance;
}

}  // namespace voxcarve
