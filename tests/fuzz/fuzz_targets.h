// What fuzzers and the deterministic fuzz test call. Each takes any bytes and returns when the reader gave something
// valid or refused with InputError; everything else (another exception, an invalid result) leaves as an exception.
#pragma once

#include <cstddef>
#include <cstdint>

namespace voxcarve::fuzz {

/// The first byte modulo 4 selects PLY, OBJ, OFF or STL. In an OBJ, what follows the first byte 0 is its material file.
/// Returns true when a mesh was read.
bool mesh(const std::uint8_t* data, std::size_t size);

/// The first byte modulo 4 selects NRRD, MetaImage, PNG or PBM/PGM. Returns true when a volume was read.
bool volume(const std::uint8_t* data, std::size_t size);

}  // namespace voxcarve::fuzz
