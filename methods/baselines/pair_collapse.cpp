// Based on [GH97] with its vertex pairs; the parameters of common/mesh/pair_collapse.h.
#include "common/mesh/pair_collapse.h"

#include "common/model_source.h"
#include "common/run/errors.h"
#include "methods/baselines/baselines.h"

namespace voxcarve {

namespace {

class PairCollapseMethod final : public Method {
 public:
  const MethodInfo& info() const override { return info_; }

 protected:
  MethodResult do_run(const Model& model, const Parameters& parameters, RunContext& context) const override {
    PairCollapseOptions options;
    options.triangles = parameters.integer("triangles");
    options.threshold = parameters.real("threshold");
    options.boundary_weight = parameters.real("boundary_weight");
    options.plane_weight = parameters.choice("plane_weight") == "area" ? PlaneWeight::kArea : PlaneWeight::kUniform;
    // Files without shared vertices would fall apart into triangles that have no edge in common.
    const TriangleSoup welded = merge_equal_positions(reference_surface(model, context));
    TriangleSoup surface = collapse_pairs(welded, options, context);
    if (surface.empty())
      throw MethodFailure("pair-collapse left nothing of " + model.name +
                          ": its last triangles vanished together; raise triangles");
    MethodResult result;
    result.levels = make_levels({std::move(surface)});
    return result;
  }

 private:
  static MethodInfo make_info() {
    const PairCollapseOptions defaults;
    MethodInfo info;
    info.name = "pair-collapse";
    info.summary = "contraction of vertex pairs by quadric error, which joins parts and tears others";
    info.citation = "GH97";
    info.accepts = {ModelKind::kSoup, ModelKind::kScalarVolume, ModelKind::kBinaryVolume};
    info.parameters.specs = {
        ParameterSpec::integer("triangles", "triangles", 4, std::int64_t{1} << 32, 1000,
                               "contract pairs until at most this many triangles are left"),
        ParameterSpec::real("threshold", "diag", 0, 1, defaults.threshold,
                            "vertices that are nearer than this may merge though no edge joins them; 0 collapses edges "
                            "only; memory grows with the pairs"),
        ParameterSpec::choice("plane_weight", {"area", "uniform"}, "area",
                              "a triangle's plane weighs its area, or 1 as in the paper"),
        ParameterSpec::real("boundary_weight", "", 0, 1e6, defaults.boundary_weight,
                            "what a plane through a boundary edge weighs; 0 lets boundaries go")};
    info.baseline = true;
    return info;
  }
  MethodInfo info_ = make_info();
};

}  // namespace

std::unique_ptr<Method> make_pair_collapse() {
  return std::make_unique<PairCollapseMethod>();
}

}  // namespace voxcarve
