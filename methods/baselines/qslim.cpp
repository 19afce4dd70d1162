// Based on [GH97], edges only; a soup that is no manifold is cut to one first.
#include "common/mesh/reduction_parameters.h"
#include "common/model_source.h"
#include "methods/baselines/baselines.h"

namespace voxcarve {

namespace {

class QSlim final : public Method {
 public:
  const MethodInfo& info() const override { return info_; }

 protected:
  MethodResult do_run(const Model& model, const Parameters& parameters, RunContext& context) const override {
    // Files without shared vertices would fall apart into triangles that nothing can be collapsed in.
    const TriangleSoup welded = merge_equal_positions(reference_surface(model, context));
    MethodResult result;
    result.levels = make_levels({reduce(welded, parameters, context)});
    return result;
  }

 private:
  static MethodInfo make_info() {
    MethodInfo info;
    info.name = "qslim";
    info.summary = "quadric edge collapse alone, which keeps the topology";
    info.citation = "GH97";
    info.accepts = {ModelKind::kSoup, ModelKind::kScalarVolume, ModelKind::kBinaryVolume};
    info.parameters.specs = reduction_parameters(4, 1000, "collapse edges until at most this many triangles are left");
    info.baseline = true;
    return info;
  }
  MethodInfo info_ = make_info();
};

}  // namespace

std::unique_ptr<Method> make_qslim() {
  return std::make_unique<QSlim>();
}

}  // namespace voxcarve
