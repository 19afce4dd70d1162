// Stereolithography files, text and binary. They hold no shared vertices: equal positions become one vertex.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "common/mesh/io/formats.h"
#include "common/run/byte_order.h"
#include "common/run/errors.h"
#include "common/run/text.h"
#include "common/run/text_scanner.h"

namespace voxcarve::mesh_io {

namespace {

constexpr std::size_t kHeaderBytes = 80;
constexpr std::size_t kCountEnd = kHeaderBytes + 4;
constexpr std::size_t kFacetBytes = 50;  // normal and corners, 12 floats, and two bytes of attributes

std::uint64_t binary_size(std::string_view bytes) {
  return kCountEnd + std::uint64_t{kFacetBytes} * load<std::uint32_t>(bytes.data() + kHeaderBytes, std::endian::little);
}

/// A text begins with "solid", and so do many binary files. What follows the name in a text is "facet" or "endsolid",
/// and no byte is 0, as the count's upper bytes and most headers are.
bool looks_like_text(std::string_view bytes) {
  if (bytes.substr(0, 512).find('\0') != std::string_view::npos) return false;
  TextScanner scanner(bytes, "");
  if (to_lower(scanner.stream_token()) != "solid") return false;
  scanner.rest();
  const std::string next = to_lower(scanner.stream_token().substr(0, 8));
  return next.empty() || next == "facet" || next == "endsolid";
}

TriangleSoup parse_binary(std::string_view bytes, std::string_view name) {
  const std::uint64_t count = (binary_size(bytes) - kCountEnd) / kFacetBytes;
  if (binary_size(bytes) != bytes.size()) {
    throw InputError(name, fmt::format("byte {}", kHeaderBytes),
                     fmt::format("{} facets announced, which take {} bytes, but the file holds {}", count,
                                 binary_size(bytes), bytes.size()));
  }
  TriangleSoup soup;
  soup.positions.reserve(3 * count);
  soup.triangles.reserve(count);
  for (std::uint64_t facet = 0; facet < count; ++facet) {
    const std::size_t begin = kCountEnd + kFacetBytes * facet + 3 * sizeof(float);  // past the normal
    const auto first = static_cast<std::uint32_t>(soup.positions.size());
    for (std::size_t corner = 0; corner < 3; ++corner) {
      Point position;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t offset = begin + (3 * corner + axis) * sizeof(float);
        const auto coordinate = load<float>(bytes.data() + offset, std::endian::little);
        if (!std::isfinite(coordinate))
          throw InputError(name, fmt::format("byte {}", offset), "a coordinate is not finite");
        position[static_cast<Eigen::Index>(axis)] = coordinate;
      }
      soup.positions.push_back(position);
    }
    soup.triangles.push_back({first, first + 1, first + 2});
  }
  return soup;
}

class TextReader {
 public:
  TextReader(std::string_view bytes, std::string_view name) : scanner_(bytes, name) {}

  /// One or more solids.
  TriangleSoup run() {
    for (std::string word = next(); !word.empty(); word = next()) {
      if (word != "solid") scanner_.fail("expected 'solid', found " + in_quotes(word));
      scanner_.rest();  // its name
      for (word = next(); word != "endsolid"; word = next()) {
        if (word != "facet") refuse("facet' or 'endsolid", word);
        read_facet();
      }
      scanner_.rest();
    }
    return std::move(soup_);
  }

 private:
  std::string next() { return to_lower(scanner_.stream_token().substr(0, 64)); }

  [[noreturn]] void refuse(std::string_view expected, std::string_view found) const {
    if (found.empty()) scanner_.fail(fmt::format("the file ends where '{}' is expected; it is truncated", expected));
    scanner_.fail(fmt::format("expected '{}', found {}", expected, in_quotes(found)));
  }

  void expect(std::string_view keyword) {
    const std::string word = next();
    if (word != keyword) refuse(keyword, word);
  }

  double number(std::string_view what) {
    const std::string_view token = scanner_.stream_token();
    const std::optional<double> value = parse_real(token);
    if (token.empty()) refuse(what, token);
    if (!value) scanner_.fail(fmt::format("{} is not a number: {}", what, in_quotes(token)));
    return *value;
  }

  void read_facet() {
    expect("normal");
    for (int axis = 0; axis < 3; ++axis) number("a normal's coordinate");  // often 0 or not a number; not used
    expect("outer");
    expect("loop");
    const auto first = static_cast<std::uint32_t>(soup_.positions.size());
    for (int corner = 0; corner < 3; ++corner) {
      expect("vertex");
      Point position;
      for (double& coordinate : position) {
        coordinate = number("a coordinate");
        if (!std::isfinite(coordinate)) scanner_.fail("a coordinate is not finite");
      }
      soup_.positions.push_back(position);
    }
    expect("endloop");
    expect("endfacet");
    soup_.triangles.push_back({first, first + 1, first + 2});
  }

  TextScanner scanner_;
  TriangleSoup soup_;
};

/// The unit normal, or zero for a triangle without area.
Point unit_normal(const TriangleSoup& soup, const Triangle& triangle) {
  const Point normal = area_vector(soup, triangle).stableNormalized();
  return normal.allFinite() ? normal : Point(Point::Zero());
}

std::string serialize_binary(const TriangleSoup& soup) {
  if (soup.triangles.size() > std::numeric_limits<std::uint32_t>::max()) {
    throw InputError(fmt::format("{} triangles exceed what binary STL can count", soup.triangles.size()));
  }
  std::string bytes = "voxcarve, binary STL";  // must not begin with "solid"
  bytes.resize(kHeaderBytes, '\0');
  bytes.reserve(kCountEnd + kFacetBytes * soup.triangles.size());
  append_little_endian(bytes, static_cast<std::uint32_t>(soup.triangles.size()));
  const auto append_vector = [&bytes](const Point& vector) {
    for (const double value : vector) append_little_endian(bytes, static_cast<float>(value));
  };
  for (const Triangle& triangle : soup.triangles) {
    append_vector(unit_normal(soup, triangle));
    for (const std::uint32_t vertex : triangle) {
      const Point& position = soup.positions[vertex];
      if ((position.cwiseAbs().array() > std::numeric_limits<float>::max()).any()) {
        throw InputError(
            fmt::format("vertex {} exceeds the single precision of binary STL; write text or another format", vertex));
      }
      append_vector(position);
    }
    append_little_endian(bytes, std::uint16_t{0});
  }
  return bytes;
}

std::string serialize_text(const TriangleSoup& soup) {
  std::string text = "solid voxcarve\n";
  for (const Triangle& triangle : soup.triangles) {
    append_point(text += "facet normal ", unit_normal(soup, triangle));
    text += "\nouter loop\n";
    for (const std::uint32_t vertex : triangle) {
      append_point(text += "vertex ", soup.positions[vertex]);
      text += '\n';
    }
    text += "endloop\nendfacet\n";
  }
  return text + "endsolid voxcarve\n";
}

}  // namespace

TriangleSoup parse_stl(std::string_view bytes, std::string_view name) {
  if (bytes.empty()) throw InputError(std::string(name) + ": the file is empty");
  // The size decides first: many binary files begin with "solid".
  const bool sizes_agree = bytes.size() >= kCountEnd && binary_size(bytes) == bytes.size();
  const bool text = !sizes_agree && looks_like_text(bytes);
  if (!text && bytes.size() < kCountEnd) {
    throw InputError(name, fmt::format("byte {}", bytes.size()),
                     "the file is neither text nor long enough for binary STL");
  }
  const TriangleSoup soup = text ? TextReader(bytes, name).run() : parse_binary(bytes, name);
  if (soup.empty()) throw InputError(std::string(name) + ": the mesh has no triangle");
  return merge_equal_positions(soup);
}

std::string serialize_stl(const TriangleSoup& soup, bool binary) {
  return binary ? serialize_binary(soup) : serialize_text(soup);
}

}  // namespace voxcarve::mesh_io
