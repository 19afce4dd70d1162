// Arrays of samples as volume files store them, and the grids made of them.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "common/volume/io/volume_io.h"

namespace voxcarve::volume_io {

enum class SampleType { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kInt64, kUint64, kFloat32, kFloat64 };

std::size_t size_of(SampleType type);
inline bool is_real(SampleType type) {
  return type == SampleType::kFloat32 || type == SampleType::kFloat64;
}

/// What a header says of a volume.
struct VolumeLayout {
  Index3 dims = Index3::Ones();
  Point spacing = Point::Ones();      ///< along each axis; that of an image's third axis does not matter
  std::optional<Point> first_sample;  ///< position of the first sample's centre
  std::optional<Point> lower_corner;  ///< what our own files add, to read back exactly
  SampleType type = SampleType::kUint8;
  std::endian order = std::endian::little;
};

/// Number of samples. Throws InputError when a dimension is below 1 or the product of them absurd (above 2^40).
std::int64_t count_samples(const VolumeLayout& layout, std::string_view name);

/// Throws InputError unless every spacing is positive and finite and every position finite.
void check_geometry(const VolumeLayout& layout, std::string_view name);

/// Throws InputError when `available` bytes cannot hold the samples, ResourceError when memory cannot.
void require_samples(const VolumeLayout& layout, std::size_t available, std::string_view name);

/// The samples from binary `data`, whose first byte is byte `offset` of file `name`.
VolumeFile decode_binary(const VolumeLayout& layout, std::string_view data, std::string_view name, std::size_t offset);

/// The samples from numbers in text.
VolumeFile decode_text(const VolumeLayout& layout, std::string_view data, std::string_view name);

/// Decompresses zlib or gzip data until they end or `size` bytes came, and throws InputError when fewer come.
std::string inflate(std::string_view data, std::size_t size, std::string_view name);

/// Number of bytes that a zlib stream holds, counted without keeping them, up to `limit`; nothing when it is broken.
std::optional<std::size_t> inflated_size(std::string_view data, std::size_t limit);

/// Takes the grid to cubic voxels if they are not, and shifts it to where the layout says.
void place(const VolumeLayout& layout, std::string_view name, VolumeFile& file);

/// Makes the volume of an image whose rows come from the top; values are as read_volume states.
VolumeFile image_volume(std::int64_t width, std::int64_t height, const std::vector<float>& values);

VolumeFile parse_nrrd(std::string_view bytes, std::string_view name, const DataLoader& data);
VolumeFile parse_metaimage(std::string_view bytes, std::string_view name, const DataLoader& data);
VolumeFile parse_netpbm(std::string_view bytes, std::string_view name);

/// Samples to be written: little endian, uint8 or float32.
struct RawVolume {
  GridFrame frame;
  SampleType type = SampleType::kUint8;
  std::string bytes;
};

std::string serialize_nrrd(const RawVolume& volume);
/// The header; `data_file` is "LOCAL" or the name of the companion.
std::string metaimage_header(const RawVolume& volume, std::string_view data_file);

}  // namespace voxcarve::volume_io
