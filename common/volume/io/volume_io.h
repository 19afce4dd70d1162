// Volumes and images in files: NRRD, MetaImage, PNG, PBM and PGM.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/volume/grid.h"

namespace voxcarve {

enum class VolumeFormat { kNrrd, kMetaImage, kPng, kNetpbm };

/// The format that the file's extension names (.nrrd .nhdr, .mhd .mha, .png, .pbm .pgm, in either case), or nothing.
std::optional<VolumeFormat> volume_format(const std::filesystem::path& path);

inline bool is_volume_file(const std::filesystem::path& path) {
  return volume_format(path).has_value();
}

/// What a volume file holds.
struct VolumeFile {
  Grid<float> values;
  /// The samples are 0 and 1 and mean exterior and interior. So are those of NRRD and MetaImage files of integer type
  /// that hold nothing else, of PBM (black, stored as 1, is interior), and of PNG and PGM with at most two grey values
  /// (the lighter one is interior and becomes 1; a single one is interior from 128 on).
  bool is_binary = false;
  std::vector<std::string> notices;  ///< what the file says and the grid cannot hold
};

/// Gives the bytes of a data file that a header names; throws InputError when there is none.
using DataLoader = std::function<std::string(std::string_view file)>;

/// Reads a volume or image; the extension says the format.
///
/// The origin of NRRD and MetaImage is the centre of the first sample, so the grid's corner lies half a voxel before
/// it; files without an origin have that centre at 0. Two-dimensional files have one slice. Images have voxels of size
/// 1, the corner at 0, and the top row of the file at the highest y, so that y points up. Grey values lie in [0, 255]
/// (deeper ones are scaled to that), colours become luminance (0.299 R + 0.587 G + 0.114 B), and transparent pixels
/// are laid over white. A volume of anisotropic spacing is resampled trilinearly to the smallest one, with a notice;
/// axes that the file rotates or mirrors are kept as they are stored, with a notice.
///
/// Throws InputError, with the line or byte, for anything truncated, inconsistent or not finite, and ResourceError when
/// the volume exceeds this machine's memory. Nothing is allocated on the word of a header.
VolumeFile read_volume(const std::filesystem::path& path);

/// The same from bytes in memory. `name` stands in messages; `data` serves headers whose data lie in another file, and
/// without it they are refused.
VolumeFile parse_volume(VolumeFormat format, std::string_view bytes, std::string_view name,
                        const DataLoader& data = {});

/// Writes a volume; the extension says the format. NRRD, MHA and MHD (with a companion .raw) are uncompressed and
/// little endian, binary volumes as bytes 0 and 1 and densities as 32-bit floats; they read back on exactly the same
/// grid. Images take volumes of one slice: PNG with interior white and densities as round(255 d), clamped to [0, 1];
/// PGM the same; PBM binary volumes only, with interior black (stored as 1). No partial file remains after an error.
/// Throws ParameterError when the format cannot hold the volume or the extension is unknown, ResourceError when writing
/// fails.
void write_volume(const BinaryVolume& volume, const std::filesystem::path& path);
void write_volume(const DensityVolume& volume, const std::filesystem::path& path);

}  // namespace voxcarve
