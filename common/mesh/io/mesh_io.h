// Meshes in files: PLY, OBJ, OFF and STL, read into and written from a triangle soup.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "common/mesh/triangle_soup.h"

namespace voxcarve {

enum class MeshFormat { kPly, kObj, kOff, kStl };

/// The format that the file's extension names (.ply .obj .off .stl, in either case), or nothing.
std::optional<MeshFormat> mesh_format(const std::filesystem::path& path);

/// Gives the bytes of a material file that an OBJ names, or nothing when there is none.
using MaterialLoader = std::function<std::optional<std::string>(std::string_view file)>;

/// Reads a mesh file; the extension says the format.
///
/// Vertices keep their number and order, except in STL, where equal positions become one vertex. Polygons are
/// triangulated into n - 2 triangles: convex ones as a fan about the first corner, others by clipping ears in the
/// projection along the dominant axis of their Newell normal; faces of one or two corners are dropped. Colours of
/// integer type are shares of 255 (65535 for 16 bits); real ones lie in [0, 1], or in [0, 255] where one of the file's
/// exceeds 1. Colours of faces, or of the materials of an OBJ (Kd; a missing material file means no colours), become
/// triangle colours; what has none among coloured ones is mid-grey.
///
/// Throws InputError, with the line of a text or the byte of a binary file, for anything truncated, inconsistent or
/// out of range, for coordinates that are not finite, and for a mesh without triangles. Nothing is allocated on the
/// word of a header.
TriangleSoup read_mesh(const std::filesystem::path& path);

/// The same from bytes in memory. `name` stands in messages; `materials` may be empty.
TriangleSoup parse_mesh(MeshFormat format, std::string_view bytes, std::string_view name,
                        const MaterialLoader& materials = {});

struct WriteOptions {
  bool binary = true;  ///< PLY and STL: binary (little endian) or text
  std::string material_library =
      {};  ///< OBJ: name of the companion that holds triangle colours; without it they are left out
};

/// The bytes of a mesh file. Positions read back exactly, except from binary STL, which holds single precision; colours
/// to 8 bits (STL holds none). Throws InputError when the soup is invalid or empty, or when a coordinate exceeds the
/// range of binary STL.
std::string serialize_mesh(const TriangleSoup& soup, MeshFormat format, const WriteOptions& options = {});

/// The material file that belongs to an OBJ with triangle colours.
std::string serialize_materials(const TriangleSoup& soup);

/// Writes a mesh file; the extension says the format. Triangle colours of an OBJ go to a companion with the extension
/// .mtl, whatever `material_library` says. No partial file remains after an error. Throws ParameterError for an unknown
/// extension, ResourceError when the file cannot be written, InputError as above.
void write_mesh(const TriangleSoup& soup, const std::filesystem::path& path, const WriteOptions& options = {});

}  // namespace voxcarve
