#include "common/mesh/io/ply_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "common/run/errors.h"
#include "common/run/text_scanner.h"

namespace voxcarve::mesh_io {

namespace {

constexpr std::array<std::pair<std::string_view, PlyType>, 16> kTypeNames{{{"char", PlyType::kInt8},
                                                                           {"int8", PlyType::kInt8},
                                                                           {"uchar", PlyType::kUint8},
                                                                           {"uint8", PlyType::kUint8},
                                                                           {"short", PlyType::kInt16},
                                                                           {"int16", PlyType::kInt16},
                                                                           {"ushort", PlyType::kUint16},
                                                                           {"uint16", PlyType::kUint16},
                                                                           {"int", PlyType::kInt32},
                                                                           {"int32", PlyType::kInt32},
                                                                           {"uint", PlyType::kUint32},
                                                                           {"uint32", PlyType::kUint32},
                                                                           {"float", PlyType::kFloat32},
                                                                           {"float32", PlyType::kFloat32},
                                                                           {"double", PlyType::kFloat64},
                                                                           {"float64", PlyType::kFloat64}}};

constexpr std::array<std::pair<std::string_view, PlyRole>, 9> kColorNames{{{"red", PlyRole::kRed},
                                                                           {"green", PlyRole::kGreen},
                                                                           {"blue", PlyRole::kBlue},
                                                                           {"diffuse_red", PlyRole::kRed},
                                                                           {"diffuse_green", PlyRole::kGreen},
                                                                           {"diffuse_blue", PlyRole::kBlue},
                                                                           {"r", PlyRole::kRed},
                                                                           {"g", PlyRole::kGreen},
                                                                           {"b", PlyRole::kBlue}}};

PlyType read_type(TextScanner& scanner) {
  const std::string_view found = scanner.token();
  for (const auto& [type_name, type] : kTypeNames) {
    if (found == type_name) return type;
  }
  scanner.fail("unknown property type " + in_quotes(found));
}

PlyRole role_of(const PlyProperty& property, std::string_view element) {
  const std::string_view name = property.name;
  if (property.count_type) {
    const bool corners = element == "face" && (name == "vertex_indices" || name == "vertex_index");
    return corners ? PlyRole::kCorners : PlyRole::kSkipped;
  }
  if (element != "vertex" && element != "face") return PlyRole::kSkipped;
  if (element == "vertex") {
    if (name == "x") return PlyRole::kX;
    if (name == "y") return PlyRole::kY;
    if (name == "z") return PlyRole::kZ;
  }
  for (const auto& [color_name, role] : kColorNames) {
    if (name == color_name) return role;
  }
  return PlyRole::kSkipped;
}

PlyEncoding read_encoding(TextScanner& scanner) {
  const std::string_view format = scanner.token();
  const std::string_view version = scanner.token();
  if (version != "1.0") scanner.fail("unknown version of the format: " + in_quotes(version));
  if (format == "ascii") return PlyEncoding::kText;
  if (format == "binary_little_endian") return PlyEncoding::kLittleEndian;
  if (format == "binary_big_endian") return PlyEncoding::kBigEndian;
  scanner.fail("unknown format " + in_quotes(format) + "; known are ascii, binary_little_endian and binary_big_endian");
}

void read_element(TextScanner& scanner, PlyHeader& header) {
  PlyElement element;
  element.name = scanner.token();
  element.line = scanner.line_number();
  element.count = scanner.integer("the number of elements");
  if (element.count < 0) scanner.fail(fmt::format("element {} has a negative count", in_quotes(element.name)));
  for (const PlyElement& other : header.elements) {
    if (other.name == element.name) scanner.fail(fmt::format("element {} appears twice", in_quotes(element.name)));
  }
  if (element.name == "tristrips" && element.count > 0) {
    scanner.fail("triangle strips are not supported; write the mesh with an element 'face'");
  }
  header.elements.push_back(std::move(element));
}

void read_property(TextScanner& scanner, PlyHeader& header) {
  if (header.elements.empty()) scanner.fail("a property before the first element");
  PlyElement& element = header.elements.back();
  PlyProperty property;
  if (scanner.peek() == "list") {
    scanner.token();
    property.count_type = read_type(scanner);
    if (is_real(*property.count_type)) scanner.fail("the length of a list must have an integer type");
  }
  property.type = read_type(scanner);
  property.name = scanner.token();
  if (property.name.empty()) scanner.fail("a property without a name");
  property.role = role_of(property, element.name);
  if (property.role == PlyRole::kCorners && is_real(property.type)) {
    scanner.fail("the vertex indices of faces must have an integer type");
  }
  if (property.role != PlyRole::kSkipped && element.has(property.role)) {
    scanner.fail(
        fmt::format("property {} of element {} appears twice", in_quotes(property.name), in_quotes(element.name)));
  }
  element.properties.push_back(std::move(property));
}

void require(const PlyHeader& header, std::string_view name, std::string_view element, PlyRole role,
             std::string_view property) {
  const auto found = std::ranges::find(header.elements, element, &PlyElement::name);
  if (found == header.elements.end())
    throw InputError(fmt::format("{}: the header has no element '{}'", name, element));
  if (found->has(role)) return;
  throw InputError(name, fmt::format("line {}", found->line),
                   fmt::format("element '{}' has no property '{}'", element, property));
}

}  // namespace

std::size_t size_of(PlyType type) {
  switch (type) {
    case PlyType::kInt8:
    case PlyType::kUint8:
      return 1;
    case PlyType::kInt16:
    case PlyType::kUint16:
      return 2;
    case PlyType::kInt32:
    case PlyType::kUint32:
    case PlyType::kFloat32:
      return 4;
    case PlyType::kFloat64:
      return 8;
  }
  return 0;
}

bool PlyElement::has(PlyRole role) const {
  return std::ranges::find(properties, role, &PlyProperty::role) != properties.end();
}

std::size_t PlyElement::smallest_size() const {
  std::size_t size = 0;
  for (const PlyProperty& property : properties) size += size_of(property.count_type.value_or(property.type));
  return size;
}

PlyHeader parse_ply_header(std::string_view bytes, std::string_view name) {
  TextScanner scanner(bytes, name);
  if (!scanner.next_line() || scanner.rest() != "ply")
    scanner.fail("this is no PLY file: it does not begin with 'ply'");
  PlyHeader header;
  bool has_format = false;
  for (;;) {
    if (!scanner.next_line()) scanner.fail("the file ends before 'end_header'");
    const std::string_view keyword = scanner.token();
    if (keyword == "end_header") break;
    if (keyword == "format") {
      header.encoding = read_encoding(scanner);
      has_format = true;
    } else if (keyword == "element") {
      read_element(scanner, header);
    } else if (keyword == "property") {
      read_property(scanner, header);
    } else if (keyword != "comment" && keyword != "obj_info" && !keyword.empty()) {
      scanner.fail("unknown statement " + in_quotes(keyword));
    }
  }
  header.size = scanner.offset();
  header.lines = scanner.line_number();
  if (!has_format) scanner.fail("the header does not say the format");
  require(header, name, "vertex", PlyRole::kX, "x");
  require(header, name, "vertex", PlyRole::kY, "y");
  require(header, name, "vertex", PlyRole::kZ, "z");
  require(header, name, "face", PlyRole::kCorners, "vertex_indices");
  return header;
}

}  // namespace voxcarve::mesh_io
