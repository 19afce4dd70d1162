// The Object File Format of Geomview: http://www.geomview.org/docs/html/OFF.html. One vertex or face a line; comments
// may stand anywhere. Vertex colours are read whether or not the header announces them.
#include <fmt/format.h>

#include <array>
#include <optional>
#include <vector>

#include "common/mesh/io/formats.h"
#include "common/mesh/io/soup_builder.h"
#include "common/run/errors.h"
#include "common/run/text.h"
#include "common/run/text_scanner.h"

namespace voxcarve::mesh_io {

namespace {

struct OffHeader {
  bool normals = false;
  std::int64_t texture_values = 0;
  std::int64_t vertices = 0;
  std::int64_t faces = 0;
};

/// Takes "[ST][C][N]OFF" apart; dimensions other than three are refused.
void read_keyword(TextScanner& scanner, std::string_view keyword, OffHeader& header) {
  std::string_view prefix = keyword.substr(0, keyword.size() - 3);
  if (prefix.starts_with("ST")) {
    header.texture_values = 2;
    prefix.remove_prefix(2);
  }
  if (prefix.starts_with('C')) prefix.remove_prefix(1);
  if (prefix.starts_with('N')) {
    header.normals = true;
    prefix.remove_prefix(1);
  }
  if (!prefix.empty()) {
    scanner.fail("unsupported kind of OFF: " + in_quotes(keyword) +
                 "; only three-dimensional OFF, COFF, NOFF and STOFF are read");
  }
}

OffHeader read_header(TextScanner& scanner) {
  OffHeader header;
  if (!scanner.next_content_line('#')) throw InputError(std::string(scanner.name()) + ": the file is empty");
  const std::string_view first = scanner.peek();
  if (first.ends_with("OFF")) {
    read_keyword(scanner, scanner.token(), header);
    if (to_lower(scanner.peek()) == "binary") scanner.fail("binary OFF is not supported; convert it to text or to PLY");
    if (scanner.peek().empty() && !scanner.next_content_line('#')) scanner.fail("the file ends before the counts");
  } else if (!parse_integer(first)) {
    // The keyword is optional in the format, so that only a number may stand here instead.
    scanner.fail("this is no OFF file: it begins with " + in_quotes(first));
  }
  header.vertices = scanner.integer("the number of vertices");
  header.faces = scanner.integer("the number of faces");
  if (!scanner.peek().empty()) scanner.integer("the number of edges");
  if (!scanner.peek().empty()) scanner.fail("unexpected " + in_quotes(scanner.peek()) + " after the counts");
  scanner.require_items(header.vertices, 3, "vertices");
  scanner.require_items(header.faces, 1, "faces");
  return header;
}

/// The rest of a line: nothing, or a colour of three or four channels. `bytes` is set when alpha exceeds 1.
std::optional<Color> read_color(TextScanner& scanner, bool color_map_allowed, bool& bytes) {
  std::array<double, 4> values{};
  std::size_t count = 0;
  while (count < 4 && !scanner.peek().empty()) values[count++] = scanner.finite("a colour channel");
  if (!scanner.peek().empty()) scanner.fail("unexpected " + in_quotes(scanner.peek()) + " at the end of the line");
  if (count == 0 || (count == 1 && color_map_allowed)) return std::nullopt;
  if (count < 3) scanner.fail(fmt::format("{} values at the end of the line where a colour has 3 or 4", count));
  if (values[3] > 1) bytes = true;
  return make_color(values[0], values[1], values[2]);
}

void read_vertex(TextScanner& scanner, const OffHeader& header, SoupBuilder& builder) {
  Point position;
  for (double& coordinate : position) coordinate = scanner.finite("a coordinate");
  for (int skipped = 0; header.normals && skipped < 3; ++skipped) scanner.real("a normal's coordinate");
  if (header.texture_values == 0) {
    builder.add_vertex(position, read_color(scanner, false, builder.vertex_colors_are_bytes));
    return;
  }
  // Texture coordinates stand at the end of the line, after a colour of three or four channels, or none.
  std::vector<std::string_view> values;
  for (std::string_view token = scanner.token(); !token.empty(); token = scanner.token()) values.push_back(token);
  if (values.size() < 2) scanner.fail("a texture coordinate is missing; the file may be truncated");
  const char* const color_begin = values.front().data();
  scanner.set_line({color_begin, static_cast<std::size_t>(values[values.size() - 2].data() - color_begin)});
  builder.add_vertex(position, read_color(scanner, false, builder.vertex_colors_are_bytes));
}

void read_face(TextScanner& scanner, SoupBuilder& builder) {
  const std::int64_t corners = scanner.integer("the number of corners");
  if (corners < 0) scanner.fail(fmt::format("a face with {} corners", corners));
  const std::size_t line = scanner.line_number();
  for (std::int64_t corner = 0; corner < corners; ++corner) {
    builder.add_corner(scanner.integer("a vertex index"), line);
  }
  builder.end_face(line, read_color(scanner, true, builder.face_colors_are_bytes));
}

}  // namespace

TriangleSoup parse_off(std::string_view bytes, std::string_view name) {
  TextScanner scanner(bytes, name);
  const OffHeader header = read_header(scanner);
  SoupBuilder builder(name, "line", 0);
  builder.reserve_vertices(static_cast<std::size_t>(header.vertices));
  for (std::int64_t vertex = 0; vertex < header.vertices; ++vertex) {
    if (!scanner.next_content_line('#')) {
      scanner.fail(fmt::format("the file ends after {} of {} vertices", vertex, header.vertices));
    }
    read_vertex(scanner, header, builder);
  }
  for (std::int64_t face = 0; face < header.faces; ++face) {
    if (!scanner.next_content_line('#')) {
      scanner.fail(fmt::format("the file ends after {} of {} faces", face, header.faces));
    }
    read_face(scanner, builder);
  }
  if (scanner.next_content_line('#')) scanner.fail("unexpected " + in_quotes(scanner.peek()) + " after the last face");
  return builder.finish();
}

std::string serialize_off(const TriangleSoup& soup) {
  // Alpha says that channels lie in [0, 255] even where all of them are 0 or 1.
  const auto append_color = [](std::string& text, const Color& color) {
    const auto [red, green, blue] = to_bytes(color);
    fmt::format_to(std::back_inserter(text), " {} {} {} 255", red, green, blue);
  };
  std::string text = soup.vertex_colors.empty() ? "OFF\n" : "COFF\n";
  fmt::format_to(std::back_inserter(text), "{} {} 0\n", soup.positions.size(), soup.triangles.size());
  for (std::size_t vertex = 0; vertex < soup.positions.size(); ++vertex) {
    append_point(text, soup.positions[vertex]);
    if (!soup.vertex_colors.empty()) append_color(text, soup.vertex_colors[vertex]);
    text += '\n';
  }
  for (std::size_t triangle = 0; triangle < soup.triangles.size(); ++triangle) {
    const Triangle& t = soup.triangles[triangle];
    fmt::format_to(std::back_inserter(text), "3 {} {} {}", t[0], t[1], t[2]);
    if (!soup.triangle_colors.empty()) append_color(text, soup.triangle_colors[triangle]);
    text += '\n';
  }
  return text;
}

}  // namespace voxcarve::mesh_io
