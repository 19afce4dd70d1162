#include "common/model.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/run/errors.h"

namespace voxcarve {

std::string_view to_string(ModelKind kind) {
  switch (kind) {
    case ModelKind::kSoup:
      return "soup";
    case ModelKind::kScalarVolume:
      return "scalar volume";
    case ModelKind::kBinaryVolume:
      return "binary volume";
    case ModelKind::kImage:
      return "image";
    case ModelKind::kImplicitSolid:
      return "implicit solid";
  }
  return "";
}

ModelKind Model::kind() const {
  if (std::holds_alternative<TriangleSoup>(shape)) return ModelKind::kSoup;
  if (std::holds_alternative<ScalarVolume>(shape)) return ModelKind::kScalarVolume;
  if (const auto* volume = std::get_if<BinaryVolume>(&shape)) {
    return volume->frame.is_image() ? ModelKind::kImage : ModelKind::kBinaryVolume;
  }
  return ModelKind::kImplicitSolid;
}

std::uint64_t shape_bytes(const Model& model) {
  if (const auto* soup = model.soup()) {
    return soup->positions.size() * sizeof(Point) + soup->triangles.size() * sizeof(Triangle) +
           (soup->vertex_colors.size() + soup->triangle_colors.size()) * sizeof(Color);
  }
  if (const auto* scalar = std::get_if<ScalarVolume>(&model.shape)) return scalar->grid.values.size() * sizeof(float);
  if (const auto* binary = std::get_if<BinaryVolume>(&model.shape)) return binary->values.size();
  return sizeof(ImplicitSolid);
}

namespace {

/// Voxels must be larger than the last digits of their coordinates.
void validate_frame(const GridFrame& frame, const std::string& name) {
  const Point far_corner = frame.center(frame.dims);
  const double largest = std::max(frame.origin.cwiseAbs().maxCoeff(), far_corner.cwiseAbs().maxCoeff());
  constexpr double kDigits = 8 * std::numeric_limits<double>::epsilon();
  if (!(frame.voxel_size > 0) || !std::isfinite(largest) || frame.voxel_size < largest * kDigits) {
    throw InputError(name +
                     ": its voxels are smaller than the last digits of their coordinates; move the origin nearer to 0");
  }
}

void validate_implicit(const ImplicitSolid& solid, const std::string& name) {
  if (!solid.inside) throw InputError(name + " has no membership function");
  if (solid.box.empty()) throw InputError(name + " has an empty box");
  const double diagonal = solid.box.diagonal();
  if (!(diagonal > 0)) throw InputError(name + " has no extent: its box is one point");
  if (!std::isfinite(diagonal)) throw InputError(name + ": its box is not finite");
}

}  // namespace

void validate(const Model& model) {
  if (const auto* soup = model.soup()) {
    validate(*soup, model.name);
    const double diagonal = bounds(*soup).diagonal();
    if (!(diagonal > 0)) throw InputError(model.name + " has no extent: all its triangles lie in one point");
    if (!std::isfinite(diagonal)) throw InputError(model.name + ": the extent overflows; scale the model down");
  } else if (const auto* scalar = std::get_if<ScalarVolume>(&model.shape)) {
    if (scalar->grid.values.empty()) throw InputError(model.name + " has no voxel");
    if (!std::ranges::all_of(scalar->grid.values, [](float value) { return std::isfinite(value); })) {
      throw InputError(model.name + " holds a value that is not finite");
    }
    validate_frame(scalar->grid.frame, model.name);
  } else if (const auto* binary = std::get_if<BinaryVolume>(&model.shape)) {
    if (binary->values.empty()) throw InputError(model.name + " has no voxel");
    validate_frame(binary->frame, model.name);
  } else {
    validate_implicit(std::get<ImplicitSolid>(model.shape), model.name);
  }
}

}  // namespace voxcarve
