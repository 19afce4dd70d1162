#include "common/mesh/io/mesh_io.h"

#include <algorithm>
#include <cmath>

#include "common/mesh/io/formats.h"
#include "common/run/atomic_file.h"
#include "common/run/errors.h"
#include "common/run/text.h"
#include "common/run/text_scanner.h"

namespace voxcarve {

namespace {

constexpr std::string_view kKnownExtensions = ".ply, .obj, .off or .stl";
constexpr std::uint64_t kMaxMaterialBytes = std::uint64_t{64} << 20;

/// Looks for material files beside the OBJ. What cannot be read counts as missing: colours are optional.
MaterialLoader materials_beside(const std::filesystem::path& path) {
  return [folder = path.parent_path()](std::string_view file) -> std::optional<std::string> {
    std::string name(file);
    std::ranges::replace(name, '\\', '/');  // as written on Windows
    try {
      return read_file(folder / name, kMaxMaterialBytes);
    } catch (const InputError&) {
      return std::nullopt;
    }
  };
}

}  // namespace

std::optional<MeshFormat> mesh_format(const std::filesystem::path& path) {
  const std::string extension = to_lower(path.extension().string());
  if (extension == ".ply") return MeshFormat::kPly;
  if (extension == ".obj") return MeshFormat::kObj;
  if (extension == ".off") return MeshFormat::kOff;
  if (extension == ".stl") return MeshFormat::kStl;
  return std::nullopt;
}

TriangleSoup read_mesh(const std::filesystem::path& path) {
  const std::optional<MeshFormat> format = mesh_format(path);
  if (!format) {
    throw InputError("cannot read " + path.string() + ": no mesh format has this extension; use " +
                     std::string(kKnownExtensions));
  }
  return parse_mesh(*format, read_file(path), path.string(), materials_beside(path));
}

TriangleSoup parse_mesh(MeshFormat format, std::string_view bytes, std::string_view name,
                        const MaterialLoader& materials) {
  switch (format) {
    case MeshFormat::kPly:
      return mesh_io::parse_ply(bytes, name);
    case MeshFormat::kObj:
      return mesh_io::parse_obj(bytes, name, materials);
    case MeshFormat::kOff:
      return mesh_io::parse_off(bytes, name);
    case MeshFormat::kStl:
      return mesh_io::parse_stl(bytes, name);
  }
  throw ParameterError("unknown mesh format");
}

std::string serialize_mesh(const TriangleSoup& soup, MeshFormat format, const WriteOptions& options) {
  validate(soup, "the mesh to write");
  switch (format) {
    case MeshFormat::kPly:
      return mesh_io::serialize_ply(soup, options.binary);
    case MeshFormat::kObj:
      return mesh_io::serialize_obj(soup, options.material_library);
    case MeshFormat::kOff:
      return mesh_io::serialize_off(soup);
    case MeshFormat::kStl:
      return mesh_io::serialize_stl(soup, options.binary);
  }
  throw ParameterError("unknown mesh format");
}

void write_mesh(const TriangleSoup& soup, const std::filesystem::path& path, const WriteOptions& options) {
  const std::optional<MeshFormat> format = mesh_format(path);
  if (!format) {
    throw ParameterError("cannot write " + path.string() + ": no mesh format has this extension; use " +
                         std::string(kKnownExtensions));
  }
  if (format != MeshFormat::kObj || soup.triangle_colors.empty()) {
    write_file_atomically(path, serialize_mesh(soup, *format, options));
    return;
  }
  std::filesystem::path companion = path;
  companion.replace_extension(".mtl");
  WriteOptions with_materials = options;
  with_materials.material_library = companion.filename().string();
  const std::string bytes = serialize_mesh(soup, *format, with_materials);
  AtomicFile materials(companion);
  AtomicFile mesh(path);
  materials.write(serialize_materials(soup));
  mesh.write(bytes);
  materials.commit();
  mesh.commit();
}

namespace mesh_io {

std::array<std::uint8_t, 3> to_bytes(const Color& color) {
  std::array<std::uint8_t, 3> bytes{};
  for (std::size_t channel = 0; channel < 3; ++channel) {
    const float value = std::clamp(color[static_cast<Eigen::Index>(channel)], 0.0F, 1.0F);
    bytes[channel] = static_cast<std::uint8_t>(std::lround(value * 255.0F));
  }
  return bytes;
}

void append_point(std::string& text, const Point& point) {
  append_number(text, point[0]);
  append_number(text += ' ', point[1]);
  append_number(text += ' ', point[2]);
}

}  // namespace mesh_io

}  // namespace voxcarve
