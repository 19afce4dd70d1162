// What a method is run on.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <variant>

#include "common/mesh/implicit_solid.h"
#include "common/mesh/triangle_soup.h"
#include "common/volume/grid.h"

namespace voxcarve {

/// A scalar field whose solid is {value >= iso_value}.
struct ScalarVolume {
  Grid<float> grid;
  float iso_value = 0.5F;
};

enum class ModelKind { kSoup, kScalarVolume, kBinaryVolume, kImage, kImplicitSolid };

/// "soup", "scalar volume", "binary volume", "image", "implicit solid".
std::string_view to_string(ModelKind kind);

/// A shape and the name it goes by in tables. A binary volume with one slice is an image.
struct Model {
  std::string name;
  std::variant<TriangleSoup, ScalarVolume, BinaryVolume, ImplicitSolid> shape;

  ModelKind kind() const;
  const TriangleSoup* soup() const { return std::get_if<TriangleSoup>(&shape); }
};

/// Bytes that the shape holds. What the functions of an implicit solid hold is not known and not counted.
std::uint64_t shape_bytes(const Model& model);

/// Throws InputError when the shape is empty, has no extent, or holds a value that is not finite, and when an implicit
/// solid has no membership function.
void validate(const Model& model);

}  // namespace voxcarve
