#include "common/mesh/alpha_wrap.h"

#include <algorithm>
#include <iterator>

#include "common/mesh/reduction_parameters.h"
#include "common/model_source.h"
#include "common/run/errors.h"
#include "methods/baselines/baselines.h"

namespace voxcarve {

namespace {

class AlphaWrap final : public Method {
 public:
  const MethodInfo& info() const override { return info_; }

 protected:
  MethodResult do_run(const Model& model, const Parameters& parameters, RunContext& context) const override {
    TriangleSoup surface =
        alpha_wrap(reference_surface(model, context), parameters.real("alpha"), parameters.real("offset"), context);
    if (surface.empty()) throw MethodFailure("alpha-wrap left nothing of " + model.name);
    MethodResult result;
    result.levels = make_levels({reduce(std::move(surface), parameters, context)});
    return result;
  }

 private:
  static MethodInfo make_info() {
    MethodInfo info;
    info.name = "alpha-wrap";
    info.summary = "CGAL's shrink-wrapped offset surface, reduced: what a user would pick today";
    info.citation = "AW22";
    info.accepts = {ModelKind::kSoup, ModelKind::kScalarVolume, ModelKind::kBinaryVolume};
    info.parameters.specs = {
        ParameterSpec::real("alpha", "diag", 0.001, 1, 0.02, "openings smaller than this are not entered"),
        ParameterSpec::real("offset", "diag", 0.0001, 0.5, 0.001, "distance of the wrap from the input")};
    std::ranges::move(reduction_parameters(0, 0, "reduce the wrap to at most this many triangles; 0 leaves it"),
                      std::back_inserter(info.parameters.specs));
    info.closed_manifold = true;
    info.baseline = true;
    return info;
  }
  MethodInfo info_ = make_info();
};

}  // namespace

std::unique_ptr<Method> make_alpha_wrap() {
  return std::make_unique<AlphaWrap>();
}

}  // namespace voxcarve
