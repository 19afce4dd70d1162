// The readers and writers behind mesh_io.h, one pair a format.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "common/mesh/io/mesh_io.h"

namespace voxcarve::mesh_io {

TriangleSoup parse_ply(std::string_view bytes, std::string_view name);
TriangleSoup parse_obj(std::string_view bytes, std::string_view name, const MaterialLoader& materials);
TriangleSoup parse_off(std::string_view bytes, std::string_view name);
TriangleSoup parse_stl(std::string_view bytes, std::string_view name);

std::string serialize_ply(const TriangleSoup& soup, bool binary);
std::string serialize_obj(const TriangleSoup& soup, std::string_view material_library);
std::string serialize_off(const TriangleSoup& soup);
std::string serialize_stl(const TriangleSoup& soup, bool binary);

/// A colour in 8 bits a channel, rounded and clamped.
std::array<std::uint8_t, 3> to_bytes(const Color& color);

/// Appends "x y z" in the shortest text that reads back exactly.
void append_point(std::string& text, const Point& point);

}  // namespace voxcarve::mesh_io
