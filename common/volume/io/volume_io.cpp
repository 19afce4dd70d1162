#include "common/volume/io/volume_io.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "common/run/atomic_file.h"
#include "common/run/byte_order.h"
#include "common/run/errors.h"
#include "common/run/text.h"
#include "common/volume/io/png.h"
#include "common/volume/io/samples.h"

namespace voxcarve {

namespace {

using volume_io::RawVolume;
using volume_io::SampleType;

constexpr std::string_view kKnownExtensions = ".nrrd, .mhd, .mha, .png, .pbm or .pgm";

RawVolume to_raw(const BinaryVolume& volume) {
  RawVolume raw{volume.frame, SampleType::kUint8, std::string(volume.values.size(), '\0')};
  std::ranges::transform(volume.values, raw.bytes.begin(), [](std::uint8_t value) { return value != 0 ? '\1' : '\0'; });
  return raw;
}

RawVolume to_raw(const DensityVolume& volume) {
  RawVolume raw{volume.frame, SampleType::kFloat32, {}};
  raw.bytes.reserve(volume.values.size() * sizeof(float));
  for (const float value : volume.values) append_little_endian(raw.bytes, value);
  return raw;
}

std::uint8_t to_grey(std::uint8_t interior) {
  return interior != 0 ? 255 : 0;
}
std::uint8_t to_grey(float density) {
  return static_cast<std::uint8_t>(std::lround(255.0F * std::clamp(density, 0.0F, 1.0F)));
}

/// Grey values in rows from the top, which is the highest y.
template <class T>
std::vector<std::uint8_t> rows_from_top(const Grid<T>& image) {
  std::vector<std::uint8_t> pixels;
  pixels.reserve(image.values.size());
  for (std::int64_t j = image.ny() - 1; j >= 0; --j) {
    for (std::int64_t i = 0; i < image.nx(); ++i) pixels.push_back(to_grey(image(i, j, 0)));
  }
  return pixels;
}

template <class T>
std::string serialize_png(const Grid<T>& image, const std::string& shown) {
  constexpr std::int64_t kMaxSide = std::int64_t{1} << 24;
  if (image.nx() > kMaxSide || image.ny() > kMaxSide) {
    throw ParameterError(
        fmt::format("cannot write {}: {} x {} pixels are too many for PNG", shown, image.nx(), image.ny()));
  }
  return encode_png(static_cast<int>(image.nx()), static_cast<int>(image.ny()), 1, rows_from_top(image));
}

template <class T>
std::string serialize_pgm(const Grid<T>& image) {
  std::string bytes = fmt::format("P5\n{} {}\n255\n", image.nx(), image.ny());
  for (const std::uint8_t pixel : rows_from_top(image)) bytes += static_cast<char>(pixel);
  return bytes;
}

/// Eight pixels a byte, the leftmost in the highest bit; rows begin with a new byte.
std::string serialize_pbm(const BinaryVolume& image) {
  std::string bytes = fmt::format("P4\n{} {}\n", image.nx(), image.ny());
  for (std::int64_t j = image.ny() - 1; j >= 0; --j) {
    for (std::int64_t begin = 0; begin < image.nx(); begin += 8) {
      unsigned byte = 0;
      for (std::int64_t i = begin; i < std::min(begin + 8, image.nx()); ++i) {
        if (image(i, j, 0) != 0) byte |= 0x80U >> static_cast<unsigned>(i - begin);
      }
      bytes += static_cast<char>(static_cast<unsigned char>(byte));
    }
  }
  return bytes;
}

void write_metaimage(const RawVolume& raw, const std::filesystem::path& path, bool detached) {
  if (!detached) {
    write_file_atomically(path, volume_io::metaimage_header(raw, "LOCAL") + raw.bytes);
    return;
  }
  std::filesystem::path companion = path;
  companion.replace_extension(".raw");
  AtomicFile samples(companion);
  AtomicFile header(path);
  samples.write(raw.bytes);
  header.write(volume_io::metaimage_header(raw, companion.filename().string()));
  samples.commit();
  header.commit();
}

template <class T>
void write(const Grid<T>& volume, const std::filesystem::path& path) {
  const std::string shown = path.string();
  const std::string extension = to_lower(path.extension().string());
  if (volume.frame.voxels() < 1 || volume.frame.voxels() != static_cast<std::int64_t>(volume.values.size())) {
    throw ParameterError(fmt::format("cannot write {}: the volume is empty", shown));
  }
  if (extension == ".nrrd") return write_file_atomically(path, volume_io::serialize_nrrd(to_raw(volume)));
  if (extension == ".mhd" || extension == ".mha") return write_metaimage(to_raw(volume), path, extension == ".mhd");
  if (extension != ".png" && extension != ".pgm" && extension != ".pbm") {
    throw ParameterError(
        fmt::format("cannot write {}: no volume is written with this extension; use {}", shown, kKnownExtensions));
  }
  if (!volume.frame.is_image()) {
    throw ParameterError(
        fmt::format("cannot write {}: a volume of {} slices is no image; use .nrrd, .mhd or .mha", shown, volume.nz()));
  }
  if (extension == ".png") return write_file_atomically(path, serialize_png(volume, shown));
  if (extension == ".pgm") return write_file_atomically(path, serialize_pgm(volume));
  if constexpr (std::is_same_v<T, std::uint8_t>) {
    write_file_atomically(path, serialize_pbm(volume));
  } else {
    throw ParameterError(fmt::format("cannot write {}: PBM holds binary images only; use .png or .pgm", shown));
  }
}

}  // namespace

std::optional<VolumeFormat> volume_format(const std::filesystem::path& path) {
  const std::string extension = to_lower(path.extension().string());
  if (extension == ".nrrd" || extension == ".nhdr") return VolumeFormat::kNrrd;
  if (extension == ".mhd" || extension == ".mha") return VolumeFormat::kMetaImage;
  if (extension == ".png") return VolumeFormat::kPng;
  if (extension == ".pbm" || extension == ".pgm") return VolumeFormat::kNetpbm;
  return std::nullopt;
}

VolumeFile read_volume(const std::filesystem::path& path) {
  const std::optional<VolumeFormat> format = volume_format(path);
  if (!format) {
    throw InputError(
        fmt::format("cannot read {}: no volume format has this extension; use {}", path.string(), kKnownExtensions));
  }
  const DataLoader beside = [folder = path.parent_path()](std::string_view file) { return read_file(folder / file); };
  return parse_volume(*format, read_file(path), path.string(), beside);
}

VolumeFile parse_volume(VolumeFormat format, std::string_view bytes, std::string_view name, const DataLoader& data) {
  switch (format) {
    case VolumeFormat::kNrrd:
      return volume_io::parse_nrrd(bytes, name, data);
    case VolumeFormat::kMetaImage:
      return volume_io::parse_metaimage(bytes, name, data);
    case VolumeFormat::kPng: {
      const GreyImage image = decode_png(bytes, name);
      return volume_io::image_volume(image.width, image.height, image.values);
    }
    case VolumeFormat::kNetpbm:
      return volume_io::parse_netpbm(bytes, name);
  }
  throw ParameterError("unknown volume format");
}

void write_volume(const BinaryVolume& volume, const std::filesystem::path& path) {
  write(volume, path);
}

void write_volume(const DensityVolume& volume, const std::filesystem::path& path) {
  if (!std::ranges::all_of(volume.values, [](float value) { return std::isfinite(value); })) {
    throw InputError(fmt::format("cannot write {}: a sample is not finite", path.string()));
  }
  write(volume, path);
}

}  // namespace voxcarve
