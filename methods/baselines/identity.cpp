#include "common/model_source.h"
#include "methods/baselines/baselines.h"

namespace voxcarve {

namespace {

class Identity final : public Method {
 public:
  const MethodInfo& info() const override { return info_; }

 protected:
  MethodResult do_run(const Model& model, const Parameters&, RunContext& context) const override {
    MethodResult result;
    result.levels = make_levels({reference_surface(model, context)});
    return result;
  }

 private:
  static MethodInfo make_info() {
    MethodInfo info;
    info.name = "identity";
    info.summary = "the input's own surface, unchanged: what every other row is measured against";
    info.accepts = {ModelKind::kSoup, ModelKind::kScalarVolume, ModelKind::kBinaryVolume};
    info.baseline = true;
    return info;
  }
  MethodInfo info_ = make_info();
};

}  // namespace

std::unique_ptr<Method> make_identity() {
  return std::make_unique<Identity>();
}

}  // namespace voxcarve
