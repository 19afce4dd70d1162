// Carving streams in files.
//
// All numbers are little-endian; there is no padding.
//
//   bytes             what
//   8                 "VOXCARVE"
//   4                 version of the format, 1
//   4                 length p of the provenance
//   4                 points n
//   4                 how many of them, the first, are the model's
//   4                 tetrahedra t, ghosts included
//   4                 the first ghost g; ghosts are the last
//   p                 provenance, any text
//   24 n              points: x, y, z as IEEE 754 doubles
//   4 n               per point: the component of the solid that it lies on, or 2^32 - 1
//   16 t              corners of the tetrahedra; the last of a ghost is 2^32 - 1
//   16 t              neighbours opposite each corner; 2^32 - 1 where the solid is
//   t                 per tetrahedron: bit i says that the face opposite corner i lies in the model
//   4 g               the step that carves each, from 1; 2^32 - 1 for none. Ghosts are outside from the start.
//   4                 CRC-32 of all bytes before (zlib's polynomial)
#pragma once

#include <filesystem>

#include "common/run/context.h"
#include "methods/hagbi_elsana/stream.h"

namespace voxcarve {

/// True for a name that ends in ".vcs", in small letters or capitals.
bool is_stream_file(const std::filesystem::path& path);

/// Writes the whole file or nothing. Throws ResourceError.
void write_stream(const CarvingStream& stream, const std::filesystem::path& path);

/// Throws InputError, with the file and what is wrong, for a file that is truncated, longer than it says, altered, or
/// whose tetrahedra do not share their faces. Their volumes are not looked at.
CarvingStream read_stream(const std::filesystem::path& path, RunContext& context);

}  // namespace voxcarve
