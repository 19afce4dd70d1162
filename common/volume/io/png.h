// PNG images in memory.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace voxcarve {

/// The bytes of a PNG file of 1 (grey), 2 (grey, alpha), 3 (RGB) or 4 (RGBA) channels of 8 bits, rows from the top, the
/// same on every machine. Throws ParameterError when the sizes do not fit `pixels`, or 2 GiB.
std::string encode_png(int width, int height, int channels, std::span<const std::uint8_t> pixels);

/// An image of luminance in [0, 255], rows from the top.
struct GreyImage {
  std::int64_t width = 0;
  std::int64_t height = 0;
  std::vector<float> values;
};

/// Reads a PNG of any kind over white; see read_volume. Throws InputError with the byte.
GreyImage decode_png(std::string_view bytes, std::string_view name);

}  // namespace voxcarve
