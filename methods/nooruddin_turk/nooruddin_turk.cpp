// Based on [NT03]: voxelization (3), morphology (4), isosurface and triangle reduction (5).
#include "methods/nooruddin_turk/nooruddin_turk.h"

#include <algorithm>
#include <array>

#include "common/mesh/reduction.h"
#include "common/run/errors.h"
#include "common/volume/isosurface.h"
#include "common/volume/morphology.h"
#include "common/volume/voxel_parameters.h"

namespace voxcarve {

namespace {

MethodInfo make_info() {
  MethodInfo info;
  info.name = "nooruddin-turk";
  info.summary = "voxelize, open or close by a ball, extract a manifold isosurface, reduce by quadric edge collapse";
  info.citation = "NT03";
  info.accepts = {ModelKind::kSoup, ModelKind::kScalarVolume, ModelKind::kBinaryVolume};
  info.closed_manifold = true;
  info.gives_volume = true;
  info.parameters.specs = voxelization_parameters();
  auto& specs = info.parameters.specs;
  specs.push_back(ParameterSpec::choice(
      "morphology", {"none", "dilate", "erode", "open", "close"}, "none",
      "operator on the volume: none is repair, close fills holes and joins parts, open removes thin parts"));
  specs.push_back(ParameterSpec::real("distance", "voxels", 0, 1000, 3, "radius of the ball of the morphology"));
  specs.push_back(
      ParameterSpec::integer("triangles", "triangles", 0, std::int64_t{1} << 32, 0,
                             "reduce the surface to at most this many triangles; 0 leaves it as extracted"));
  return info;
}

/// Which operator to apply: a name of the parameter `morphology`.
BinaryVolume apply_morphology(const BinaryVolume& volume, const std::string& morphology, double distance,
                              RunContext& context) {
  Stage stage(context, morphology, volume.frame.voxels());
  if (morphology == "dilate") return dilate(volume, distance, context);
  if (morphology == "erode") return erode(volume, distance, context);
  if (morphology == "open") return open(volume, distance, context);
  return close(volume, distance, context);
}

BinaryVolume thresholded(const ScalarVolume& scalar) {
  BinaryVolume volume(scalar.grid.frame);
  std::ranges::transform(scalar.grid.values, volume.values.begin(),
                         [&](float value) { return static_cast<std::uint8_t>(value >= scalar.iso_value); });
  return volume;
}

class NooruddinTurk final : public Method {
 public:
  const MethodInfo& info() const override { return info_; }

 protected:
  MethodResult do_run(const Model& model, const Parameters& parameters, RunContext& context) const override {
    const std::string& morphology = parameters.choice("morphology");
    const auto* scalar = std::get_if<ScalarVolume>(&model.shape);
    TriangleSoup surface;
    MethodResult result;
    if (scalar != nullptr && morphology == "none") {
      surface = scalar_isosurface(scalar->grid, scalar->iso_value, context);
      if (surface.empty())
        throw MethodFailure("nothing of " + model.name + " lies at or above its iso-value; choose another one");
      result.volumes.push_back({"result", thresholded(*scalar)});
    } else {
      BinaryVolume volume = interior(model, parameters, context);
      if (count_interior(volume) == 0) {
        if (model.soup() == nullptr) throw MethodFailure("no voxel of " + model.name + " is interior");
        throw MethodFailure("no voxel centre lies inside " + model.name +
                            " at this resolution; raise it, or use another classifier or number of directions");
      }
      if (morphology != "none") {
        volume = apply_morphology(volume, morphology, parameters.real("distance"), context);
        if (count_interior(volume) == 0)
          throw MethodFailure("the " + morphology + " removed every voxel of " + model.name +
                              "; lower distance or raise resolution");
      }
      surface = isosurface(volume, context);
      result.volumes.push_back({"result", std::move(volume)});
    }
    const std::int64_t triangles = parameters.integer("triangles");
    if (triangles > 0) surface = reduce_openmesh(surface, triangles, context);
    std::vector<TriangleSoup> levels;
    levels.push_back(std::move(surface));
    result.levels = make_levels(std::move(levels));
    return result;
  }

 private:
  static BinaryVolume interior(const Model& model, const Parameters& parameters, RunContext& context) {
    if (const auto* soup = model.soup()) return voxelize_model(*soup, parameters, context);
    if (const auto* scalar = std::get_if<ScalarVolume>(&model.shape)) return thresholded(*scalar);
    return std::get<BinaryVolume>(model.shape);
  }

  MethodInfo info_ = make_info();
};

}  // namespace

std::unique_ptr<Method> make_nooruddin_turk() {
  return std::make_unique<NooruddinTurk>();
}

}  // namespace voxcarve
