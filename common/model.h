// What a method is run on.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <variant>

#include "common/mesh/triangle_soup.h"
#include "common/volume/grid.h"

namespace voxcarve {

/// A scalar field whose solid is {value >= iso_value}.
struct ScalarVolume {
  Grid<float> grid;
  float iso_value = 0.5F;
};

/// A point-membership function with a box that holds the whole solid. `inside` must be callable from several threads.
struct ImplicitSolid {
  std::function<bool(const Point&)> inside;
  Box box;
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

/// Bytes that the shape holds.
std::uint64_t shape_bytes(const Model& model);

/// Throws InputError when the shape is empty, has no extent, or holds a value that is not finite.
void validate(const Model& model);

}  // namespace voxcarve
