// Based on [NT03, 4]; an opening or closing and nothing else, so that a table shows what the operator alone does.
#include <algorithm>
#include <iterator>

#include "common/mesh/reduction_parameters.h"
#include "common/mesh/smoothing.h"
#include "common/run/errors.h"
#include "common/volume/isosurface.h"
#include "common/volume/morphology.h"
#include "common/volume/voxel_parameters.h"
#include "methods/baselines/baselines.h"

namespace voxcarve {

namespace {

enum class Operator { kOpen, kClose };

class Morphology final : public Method {
 public:
  explicit Morphology(Operator which) : operator_(which), info_(make_info(which)) {}
  const MethodInfo& info() const override { return info_; }

 protected:
  MethodResult do_run(const Model& model, const Parameters& parameters, RunContext& context) const override {
    BinaryVolume volume = interior(model, parameters, context);
    if (count_interior(volume) == 0) throw MethodFailure("no voxel of " + model.name + " is interior");
    {
      Stage stage(context, info_.name, volume.frame.voxels());
      const double radius = parameters.real("radius");
      volume = operator_ == Operator::kOpen ? open(volume, radius, context) : close(volume, radius, context);
    }
    if (count_interior(volume) == 0) {
      throw MethodFailure("the opening removed every voxel of " + model.name + "; lower radius or raise resolution");
    }
    TriangleSoup surface = isosurface(volume, context);
    TaubinOptions smoothing;
    smoothing.iterations = static_cast<int>(parameters.integer("smoothing"));
    if (smoothing.iterations > 0) taubin_smooth(surface, smoothing, context);
    MethodResult result;
    result.volumes.push_back({"result", std::move(volume)});
    result.levels = make_levels({reduce(std::move(surface), parameters, context)});
    return result;
  }

 private:
  static BinaryVolume interior(const Model& model, const Parameters& parameters, RunContext& context) {
    if (const auto* soup = model.soup()) return voxelize_model(*soup, parameters, 0.5, context);
    if (const auto* scalar = std::get_if<ScalarVolume>(&model.shape))
      return thresholded(scalar->grid, scalar->iso_value);
    return std::get<BinaryVolume>(model.shape);
  }

  static MethodInfo make_info(Operator which) {
    MethodInfo info;
    const bool opens = which == Operator::kOpen;
    info.name = opens ? "open" : "close";
    info.summary = opens
                       ? "opening of the voxelized model by a ball: removes what the ball does not fit into"
                       : "closing of the voxelized model by a ball: fills what the ball does not fit into from outside";
    info.citation = "NT03";
    info.accepts = {ModelKind::kSoup, ModelKind::kScalarVolume, ModelKind::kBinaryVolume};
    info.parameters.specs = voxelization_parameters();
    auto& specs = info.parameters.specs;
    specs.push_back(ParameterSpec::real("radius", "voxels", 0, 1000, 1, "radius of the ball"));
    specs.push_back(ParameterSpec::integer("smoothing", "iterations", 0, 1000, TaubinOptions{}.iterations,
                                           "Taubin smoothing of the isosurface"));
    std::ranges::move(reduction_parameters(0, 0, "reduce the surface to at most this many triangles; 0 leaves it"),
                      std::back_inserter(specs));
    info.closed_manifold = true;
    info.gives_volume = true;
    info.baseline = true;
    return info;
  }

  Operator operator_;
  MethodInfo info_;
};

}  // namespace

std::unique_ptr<Method> make_open() {
  return std::make_unique<Morphology>(Operator::kOpen);
}

std::unique_ptr<Method> make_close() {
  return std::make_unique<Morphology>(Operator::kClose);
}

}  // namespace voxcarve
