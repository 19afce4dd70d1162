#include "methods/method.h"

#include <algorithm>
#include <iterator>

#include "common/mesh/topology.h"
#include "common/run/errors.h"
#include "common/run/text.h"

namespace voxcarve {

namespace {

class StoredLevels final : public LevelSequence {
 public:
  explicit StoredLevels(std::vector<TriangleSoup> levels) : levels_(std::move(levels)) {}
  std::int64_t size() const override { return static_cast<std::int64_t>(levels_.size()); }
  TriangleSoup extract(std::int64_t index) const override { return levels_.at(static_cast<std::size_t>(index)); }

 private:
  std::vector<TriangleSoup> levels_;
};

}  // namespace

LevelCounts LevelSequence::counts(std::int64_t index) const {
  const TriangleSoup level = extract(index);
  return {std::ssize(level.triangles), std::ssize(merge_equal_positions(level).positions)};
}

std::shared_ptr<const LevelSequence> make_levels(std::vector<TriangleSoup> coarse_to_fine) {
  return std::make_shared<StoredLevels>(std::move(coarse_to_fine));
}

std::optional<SkipReason> Method::unsupported(const Model& model, const Parameters& parameters) const {
  const std::vector<ModelKind>& kinds = info().accepts;
  if (std::ranges::find(kinds, model.kind()) == kinds.end()) {
    std::vector<std::string> names;
    for (const ModelKind kind : kinds) names.push_back(with_article(to_string(kind)));
    return SkipReason{info().name + " takes " + join(names, " or ") + ", not " + with_article(to_string(model.kind()))};
  }
  return unsupported_shape(model, parameters);
}

std::optional<SkipReason> Method::unsupported_shape(const Model&, const Parameters&) const {
  return std::nullopt;
}

std::vector<InvariantCheck> Method::own_invariants(const Model&, const Parameters&, const MethodResult&,
                                                   RunContext&) const {
  return {};
}

std::vector<InvariantCheck> Method::check_invariants(const Model& model, const Parameters& parameters,
                                                     const MethodResult& result, RunContext& context) const {
  std::vector<InvariantCheck> checks;
  if (info().closed_manifold) {
    InvariantCheck check{"closed, oriented 2-manifold", true, ""};
    const std::int64_t levels = result.levels->size();
    const std::int64_t checked = std::min(levels, kCheckedLevels);
    for (std::int64_t i = 0; i < checked && check.holds; ++i) {
      context.check_cancelled();
      const std::int64_t level = checked == 1 ? 0 : i * (levels - 1) / (checked - 1);
      const SurfaceTopology topology = analyze_topology(result.levels->extract(level));
      check.holds = topology.closed && topology.oriented && topology.nonmanifold_vertices == 0;
      if (check.holds) continue;
      check.detail = "level " + std::to_string(level) + " has " + std::to_string(topology.boundary_edges) +
                     " boundary edges, " + std::to_string(topology.nonmanifold_edges) + " non-manifold edges, " +
                     std::to_string(topology.nonmanifold_vertices) + " non-manifold vertices";
    }
    if (check.holds && checked > 1)
      check.detail = std::to_string(checked) + " of " + std::to_string(levels) + " levels";
    checks.push_back(std::move(check));
  }
  std::ranges::move(own_invariants(model, parameters, result, context), std::back_inserter(checks));
  return checks;
}

MethodResult Method::run(const Model& model, const Parameters& parameters, RunContext& context) const {
  validate(model);
  if (const auto reason = unsupported(model, parameters)) throw InputError(reason->text);
  context.clear_log();
  context.check_cancelled();
  context.require_memory(shape_bytes(model), "the input itself");
  MethodResult result = do_run(model, parameters, context);
  if (!result.levels || result.levels->size() == 0) {
    throw MethodFailure(info().name + " left nothing of " + model.name);
  }
  result.timings = context.timings();
  result.notices = context.notices();
  return result;
}

}  // namespace voxcarve
