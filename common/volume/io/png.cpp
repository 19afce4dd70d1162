// PNG through stb_image and stb_image_write. stb trusts sizes and ignores checksums, so the chunks are checked before.
#include "common/volume/io/png.h"

#include <fmt/format.h>
#include <zlib.h>

#include <array>
#include <bit>
#include <cstdlib>
#include <limits>
#include <memory>

#include "common/run/byte_order.h"
#include "common/run/errors.h"
#include "common/volume/io/samples.h"

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_ONLY_PNG
#define STBI_NO_STDIO
#define STBI_MAX_DIMENSIONS (1 << 24)
#include <stb/stb_image.h>

#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#define STBI_WRITE_NO_STDIO
#include <stb/stb_image_write.h>

namespace voxcarve {

namespace {

constexpr std::string_view kSignature("\x89PNG\r\n\x1a\n", 8);

[[noreturn]] void fail(std::string_view name, std::size_t offset, std::string_view message) {
  throw InputError(name, fmt::format("byte {}", offset), message);
}

struct PngHeader {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  unsigned bits_per_pixel = 0;
  bool interlaced = false;
};

PngHeader read_header(std::string_view data, std::string_view name, std::size_t offset) {
  if (data.size() != 13) fail(name, offset, "the header chunk has a wrong length");
  PngHeader header;
  header.width = load<std::uint32_t>(data.data(), std::endian::big);
  header.height = load<std::uint32_t>(data.data() + 4, std::endian::big);
  constexpr std::array<unsigned, 7> kChannels{1, 0, 3, 1, 2, 0, 4};  // by colour type; 0 is none
  const auto color_type = static_cast<unsigned char>(data[9]);
  const unsigned channels = color_type < kChannels.size() ? kChannels[color_type] : 0;
  const auto depth = static_cast<unsigned char>(data[8]);
  if (header.width == 0 || header.height == 0) fail(name, offset, "the image is empty");
  if (channels == 0 || std::popcount(depth) != 1 || depth > 16) fail(name, offset, "unknown kind of pixels");
  header.bits_per_pixel = channels * depth;
  header.interlaced = data[12] != 0;
  return header;
}

/// Bytes of the rows that the compressed data must hold: one for the filter, then the pixels.
std::uint64_t rows_size(const PngHeader& header) {
  const auto pass = [&header](std::uint64_t x, std::uint64_t y, std::uint64_t step_x, std::uint64_t step_y) {
    const std::uint64_t columns = (header.width + step_x - 1 - x) / step_x;
    const std::uint64_t rows = (header.height + step_y - 1 - y) / step_y;
    return columns == 0 ? 0 : rows * (1 + (columns * header.bits_per_pixel + 7) / 8);
  };
  if (!header.interlaced) return pass(0, 0, 1, 1);
  // Adam7, the seven passes of the specification.
  return pass(0, 0, 8, 8) + pass(4, 0, 8, 8) + pass(0, 4, 4, 8) + pass(2, 0, 4, 4) + pass(0, 2, 2, 4) +
         pass(1, 0, 2, 2) + pass(0, 1, 1, 2);
}

/// Walks through the chunks; throws unless all are whole and the pixels are there.
void check_chunks(std::string_view bytes, std::string_view name) {
  if (!bytes.starts_with(kSignature)) fail(name, 0, "this is no PNG file");
  std::optional<PngHeader> header;
  std::string pixels;
  std::size_t offset = kSignature.size();
  for (std::string_view kind; kind != "IEND";) {
    if (bytes.size() - offset < 12) fail(name, offset, "the file ends before its last chunk; it is truncated");
    const std::size_t length = load<std::uint32_t>(bytes.data() + offset, std::endian::big);
    if (length > bytes.size() - offset - 12) {
      fail(name, offset, fmt::format("a chunk of {} bytes exceeds the file; it is truncated", length));
    }
    kind = bytes.substr(offset + 4, 4);
    const std::string_view data = bytes.substr(offset + 8, length);
    const auto* const checked = reinterpret_cast<const Bytef*>(kind.data());
    if (crc32_z(0, checked, 4 + length) != load<std::uint32_t>(data.data() + length, std::endian::big)) {
      fail(name, offset, "a chunk's checksum is wrong; the file is damaged");
    }
    if (!header.has_value() != (kind == "IHDR")) fail(name, offset, "the header chunk is missing or repeated");
    if (kind == "IHDR") header = read_header(data, name, offset + 8);
    if (kind == "IDAT") pixels += data;
    offset += 12 + length;
  }
  const std::uint64_t expected = rows_size(*header);
  // Without keeping them, so that stb allocates for sizes that the data confirm.
  const std::optional<std::size_t> found = volume_io::inflated_size(pixels, expected);
  if (found && *found >= expected) return;
  throw InputError(fmt::format("{}: the compressed pixels of {} x {} are damaged or incomplete", name, header->width,
                               header->height));
}

struct Free {
  void operator()(void* pointer) const { std::free(pointer); }
};

/// Luminance (ITU-R BT.601) over white; `T` has 8 or 16 bits.
template <class T>
GreyImage to_grey(const T* pixels, int width, int height) {
  GreyImage image{width, height, {}};
  image.values.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  constexpr double kWhite = std::numeric_limits<T>::max();
  for (std::size_t pixel = 0; pixel < image.values.size(); ++pixel) {
    const T* const p = pixels + 4 * pixel;
    const bool is_grey = p[0] == p[1] && p[1] == p[2];  // the weights' sum is not exactly 1
    const double luminance = is_grey ? static_cast<double>(p[0]) : 0.299 * p[0] + 0.587 * p[1] + 0.114 * p[2];
    const double over_white = (luminance * p[3] + kWhite * (kWhite - p[3])) / kWhite;
    image.values[pixel] = static_cast<float>(over_white * (255.0 / kWhite));
  }
  return image;
}

}  // namespace

GreyImage decode_png(std::string_view bytes, std::string_view name) {
  check_chunks(bytes, name);
  if (bytes.size() > static_cast<std::size_t>(std::numeric_limits<int>::max())) {
    throw InputError(fmt::format("{}: images of more than 2 GiB are not supported", name));
  }
  const auto* const data = reinterpret_cast<const stbi_uc*>(bytes.data());
  const int size = static_cast<int>(bytes.size());
  int width = 0;
  int height = 0;
  int channels = 0;
  if (stbi_is_16_bit_from_memory(data, size) != 0) {
    const std::unique_ptr<stbi_us, Free> pixels(stbi_load_16_from_memory(data, size, &width, &height, &channels, 4));
    if (pixels) return to_grey(pixels.get(), width, height);
  } else {
    const std::unique_ptr<stbi_uc, Free> pixels(stbi_load_from_memory(data, size, &width, &height, &channels, 4));
    if (pixels) return to_grey(pixels.get(), width, height);
  }
  throw InputError(fmt::format("{}: cannot decode the image: {}", name, stbi_failure_reason()));
}

std::string encode_png(int width, int height, int channels, std::span<const std::uint8_t> pixels) {
  if (width < 1 || height < 1 || channels < 1 || channels > 4) {
    throw ParameterError(fmt::format("no PNG has {} x {} pixels of {} channels", width, height, channels));
  }
  const std::int64_t row = std::int64_t{width} * channels;
  // stb counts the rows with their filter bytes, and twice that for compression, in an int.
  if ((row + 1) * height > std::numeric_limits<int>::max() / 2) {
    throw ParameterError(fmt::format("an image of {} x {} pixels is too large for PNG", width, height));
  }
  if (static_cast<std::int64_t>(pixels.size()) != row * height) {
    throw ParameterError(fmt::format("{} bytes for an image that takes {}", pixels.size(), row * height));
  }
  int size = 0;
  const std::unique_ptr<unsigned char, Free> png(
      stbi_write_png_to_mem(pixels.data(), static_cast<int>(row), width, height, channels, &size));
  if (!png) throw ResourceError("not enough memory to encode an image");
  return {reinterpret_cast<const char*>(png.get()), static_cast<std::size_t>(size)};
}

}  // namespace voxcarve
