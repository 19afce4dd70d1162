// Wavefront OBJ and its material library: polygons with optional colours after the position, and diffuse colours of
// materials. Free-form surfaces, lines and points are skipped, as are statements that are not known.
#include <fmt/format.h>

#include <array>
#include <charconv>
#include <map>
#include <optional>
#include <vector>

#include "common/mesh/io/formats.h"
#include "common/mesh/io/soup_builder.h"
#include "common/run/text_scanner.h"

namespace voxcarve::mesh_io {

namespace {

using Materials = std::map<std::string, Color, std::less<>>;

/// Adds the diffuse colours of a material library. What is not a colour of three numbers (spectra, for instance) is no
/// error: a material without a colour is then left out.
void read_materials(std::string_view bytes, std::string_view name, Materials& materials) {
  TextScanner scanner(bytes, name);
  std::string material;
  while (scanner.next_line()) {
    const std::string_view keyword = scanner.token();
    if (keyword == "newmtl") material = scanner.rest();
    if (keyword != "Kd") continue;
    Color color;
    bool valid = true;
    for (float& channel : color) {
      const std::optional<double> value = parse_real(scanner.token());
      valid = valid && value && *value == *value;
      if (valid) channel = static_cast<float>(std::clamp(*value, 0.0, 1.0));
    }
    if (valid) materials.insert_or_assign(material, color);
  }
}

class ObjReader {
 public:
  ObjReader(std::string_view bytes, std::string_view name, const MaterialLoader& loader)
      : scanner_(bytes, name), builder_(name, "line", 1), loader_(loader) {}

  TriangleSoup run() {
    while (next_statement()) {
      const std::string_view keyword = scanner_.token();
      if (keyword == "v") {
        read_vertex();
      } else if (keyword == "f") {
        read_face();
      } else if (keyword == "usemtl") {
        const auto found = materials_.find(scanner_.rest());
        color_ = found == materials_.end() ? std::nullopt : std::optional<Color>(found->second);
      } else if (keyword == "mtllib") {
        load_materials(scanner_.rest());
      }
    }
    return builder_.finish();
  }

 private:
  /// Moves to the next line and joins what follows a backslash at its end; comments do not go on.
  bool next_statement() {
    if (!scanner_.next_line()) return false;
    line_number_ = scanner_.line_number();
    if (!scanner_.line().ends_with('\\') || scanner_.peek().starts_with('#')) return true;
    joined_ = scanner_.line();
    while (joined_.ends_with('\\')) {
      joined_.back() = ' ';
      if (!scanner_.next_line()) break;
      joined_ += scanner_.line();
    }
    scanner_.set_line(joined_);
    return true;
  }

  bool at_end() const {
    const std::string_view next = scanner_.peek();
    return next.empty() || next.front() == '#';
  }

  /// "v x y z", then nothing, a weight, or three or four channels of a colour.
  void read_vertex() {
    Point position;
    for (double& coordinate : position) coordinate = scanner_.finite("a coordinate");
    std::array<double, 4> extra{};
    std::size_t count = 0;
    while (count < 4 && !at_end()) extra[count++] = scanner_.finite("a value after the position");
    if (count == 2 || !at_end())
      scanner_.fail("a vertex has 3 coordinates, then nothing, a weight, or a colour of 3 or 4 channels");
    if (count < 3) {
      builder_.add_vertex(position);
    } else {
      builder_.add_vertex(position, make_color(extra[0], extra[1], extra[2]));
    }
  }

  /// One of "v", "v/vt", "v//vn", "v/vt/vn"; the vertex counts from 1, or backwards from -1.
  std::int64_t read_corner(std::string_view token) {
    const char* begin = token.data();
    const char* const end = begin + token.size();
    std::int64_t vertex = 0;
    auto [rest, error] = std::from_chars(begin + (*begin == '+' ? 1 : 0), end, vertex);
    if (error != std::errc{}) scanner_.fail("a vertex index is not a number: " + in_quotes(token));
    for (int part = 0; part < 2 && rest != end && *rest == '/'; ++part) {
      // The numbers of texture coordinates and normals are not used; "1//2" and "1/" leave one out.
      std::int64_t unused = 0;
      rest = std::from_chars(rest + 1, end, unused).ptr;
    }
    if (rest != end) scanner_.fail("a face corner is not of the form v/vt/vn: " + in_quotes(token));
    if (vertex == 0) scanner_.fail("vertex index 0; indices count from 1");
    if (vertex > 0) return vertex - 1;
    const auto count = static_cast<std::int64_t>(builder_.vertex_count());
    if (vertex < -count) {
      scanner_.fail(fmt::format("a face refers to vertex {}, but only {} come before it", vertex, count));
    }
    return count + vertex;
  }

  void read_face() {
    for (std::string_view token = scanner_.token(); !token.empty() && token[0] != '#'; token = scanner_.token()) {
      builder_.add_corner(read_corner(token), line_number_);
    }
    builder_.end_face(line_number_, color_);
  }

  /// A library's name may hold blanks, and a statement may list several: whole first, then word by word.
  void load_materials(std::string_view names) {
    if (!loader_ || load_library(names)) return;
    TextScanner words(names, scanner_.name());
    for (std::string_view word = words.stream_token(); !word.empty(); word = words.stream_token()) load_library(word);
  }

  bool load_library(std::string_view file) {
    const std::optional<std::string> bytes = loader_(file);
    if (bytes) read_materials(*bytes, file, materials_);
    return bytes.has_value();
  }

  TextScanner scanner_;
  SoupBuilder builder_;
  const MaterialLoader& loader_;
  Materials materials_;
  std::optional<Color> color_;  // of the current material
  std::string joined_;          // a line with those that continue it
  std::size_t line_number_ = 0;
};

std::string material_name(const Color& color) {
  const auto [red, green, blue] = to_bytes(color);
  return fmt::format("color_{:02x}{:02x}{:02x}", red, green, blue);
}

}  // namespace

TriangleSoup parse_obj(std::string_view bytes, std::string_view name, const MaterialLoader& materials) {
  return ObjReader(bytes, name, materials).run();
}

std::string serialize_obj(const TriangleSoup& soup, std::string_view material_library) {
  const bool materials = !soup.triangle_colors.empty() && !material_library.empty();
  std::string text = materials ? fmt::format("mtllib {}\n", material_library) : "";
  for (std::size_t vertex = 0; vertex < soup.positions.size(); ++vertex) {
    text += "v ";
    append_point(text, soup.positions[vertex]);
    if (!soup.vertex_colors.empty()) {
      for (const float channel : soup.vertex_colors[vertex])
        append_number(text += ' ', std::clamp(channel, 0.0F, 1.0F));
    }
    text += '\n';
  }
  std::string current;
  for (std::size_t triangle = 0; triangle < soup.triangles.size(); ++triangle) {
    if (materials) {
      std::string next = material_name(soup.triangle_colors[triangle]);
      if (next != current) fmt::format_to(std::back_inserter(text), "usemtl {}\n", next);
      current = std::move(next);
    }
    const Triangle& t = soup.triangles[triangle];
    fmt::format_to(std::back_inserter(text), "f {} {} {}\n", std::uint64_t{t[0]} + 1, std::uint64_t{t[1]} + 1,
                   std::uint64_t{t[2]} + 1);
  }
  return text;
}

}  // namespace voxcarve::mesh_io

namespace voxcarve {

std::string serialize_materials(const TriangleSoup& soup) {
  std::map<std::string, Color> materials;
  for (const Color& color : soup.triangle_colors) materials.try_emplace(mesh_io::material_name(color), color);
  std::string text;
  for (const auto& [name, color] : materials) {
    fmt::format_to(std::back_inserter(text), "newmtl {}\nKd", name);
    for (const std::uint8_t channel : mesh_io::to_bytes(color))
      append_number(text += ' ', static_cast<float>(channel) / 255.0F);
    text += '\n';
  }
  return text;
}

}  // namespace voxcarve
