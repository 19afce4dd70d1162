// The header of a PLY file [Turk, The PLY Polygon File Format, 1994].
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace voxcarve::mesh_io {

enum class PlyEncoding { kText, kLittleEndian, kBigEndian };

enum class PlyType { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };

std::size_t size_of(PlyType type);
inline bool is_real(PlyType type) {
  return type == PlyType::kFloat32 || type == PlyType::kFloat64;
}

/// What a property of an element "vertex" or "face" is read as.
enum class PlyRole { kSkipped, kX, kY, kZ, kRed, kGreen, kBlue, kCorners };

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::kFloat32;
  std::optional<PlyType> count_type;  ///< set for a list
  PlyRole role = PlyRole::kSkipped;
};

struct PlyElement {
  std::string name;
  std::int64_t count = 0;
  std::size_t line = 0;  ///< of the header
  std::vector<PlyProperty> properties;

  bool has(PlyRole role) const;
  /// The fewest bytes that one item takes in a binary body: lists may be empty.
  std::size_t smallest_size() const;
};

struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::kText;
  std::vector<PlyElement> elements;  ///< in the order of the body
  std::size_t size = 0;              ///< bytes, the end of the line "end_header" included
  std::size_t lines = 0;
};

/// Throws InputError unless the header is complete and describes vertices with x, y and z and faces with corners.
PlyHeader parse_ply_header(std::string_view bytes, std::string_view name);

}  // namespace voxcarve::mesh_io
