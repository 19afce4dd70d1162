// Writes PLY: positions as doubles, so that they read back exactly, and colours as bytes.
#include <fmt/format.h>

#include <limits>

#include "common/mesh/io/formats.h"
#include "common/run/byte_order.h"
#include "common/run/text_scanner.h"

namespace voxcarve::mesh_io {

namespace {

constexpr std::string_view kColorProperties = "property uchar red\nproperty uchar green\nproperty uchar blue\n";

bool indices_fit_int(const TriangleSoup& soup) {
  return soup.positions.size() <= static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max());
}

std::string header(const TriangleSoup& soup, bool binary) {
  std::string text = fmt::format("ply\nformat {} 1.0\ncomment voxcarve\n", binary ? "binary_little_endian" : "ascii");
  fmt::format_to(std::back_inserter(text),
                 "element vertex {}\nproperty double x\nproperty double y\nproperty double z\n", soup.positions.size());
  if (!soup.vertex_colors.empty()) text += kColorProperties;
  // Many readers know signed indices only.
  fmt::format_to(std::back_inserter(text), "element face {}\nproperty list uchar {} vertex_indices\n",
                 soup.triangles.size(), indices_fit_int(soup) ? "int" : "uint");
  if (!soup.triangle_colors.empty()) text += kColorProperties;
  return text += "end_header\n";
}

void append_text(std::string& text, const TriangleSoup& soup) {
  const auto append_color = [&text](const Color& color) {
    for (const std::uint8_t channel : to_bytes(color)) append_number(text += ' ', std::int64_t{channel});
  };
  for (std::size_t vertex = 0; vertex < soup.positions.size(); ++vertex) {
    append_point(text, soup.positions[vertex]);
    if (!soup.vertex_colors.empty()) append_color(soup.vertex_colors[vertex]);
    text += '\n';
  }
  for (std::size_t triangle = 0; triangle < soup.triangles.size(); ++triangle) {
    text += '3';
    for (const std::uint32_t vertex : soup.triangles[triangle]) append_number(text += ' ', std::int64_t{vertex});
    if (!soup.triangle_colors.empty()) append_color(soup.triangle_colors[triangle]);
    text += '\n';
  }
}

void append_binary(std::string& bytes, const TriangleSoup& soup) {
  const auto append_color = [&bytes](const Color& color) {
    for (const std::uint8_t channel : to_bytes(color)) append_little_endian(bytes, channel);
  };
  for (std::size_t vertex = 0; vertex < soup.positions.size(); ++vertex) {
    for (const double coordinate : soup.positions[vertex]) append_little_endian(bytes, coordinate);
    if (!soup.vertex_colors.empty()) append_color(soup.vertex_colors[vertex]);
  }
  for (std::size_t triangle = 0; triangle < soup.triangles.size(); ++triangle) {
    append_little_endian(bytes, std::uint8_t{3});
    for (const std::uint32_t vertex : soup.triangles[triangle]) append_little_endian(bytes, vertex);
    if (!soup.triangle_colors.empty()) append_color(soup.triangle_colors[triangle]);
  }
}

}  // namespace

std::string serialize_ply(const TriangleSoup& soup, bool binary) {
  std::string bytes = header(soup, binary);
  if (binary) {
    append_binary(bytes, soup);
  } else {
    append_text(bytes, soup);
  }
  return bytes;
}

}  // namespace voxcarve::mesh_io
