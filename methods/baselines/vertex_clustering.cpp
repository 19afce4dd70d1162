// Based on [RB93] and [Lin00]; differs in choosing the grid for a budget of triangles.
#include "common/mesh/vertex_clustering.h"

#include <string>
#include <utility>

#include "common/model_source.h"
#include "common/run/errors.h"
#include "methods/baselines/baselines.h"

namespace voxcarve {

namespace {

ClusterRepresentative representative_of(const std::string& name) {
  if (name == "mean") return ClusterRepresentative::kMean;
  if (name == "heaviest") return ClusterRepresentative::kHeaviest;
  return ClusterRepresentative::kQuadric;
}

class VertexClustering final : public Method {
 public:
  const MethodInfo& info() const override { return info_; }

 protected:
  MethodResult do_run(const Model& model, const Parameters& parameters, RunContext& context) const override {
    const TriangleSoup surface = reference_surface(model, context);
    const std::int64_t budget = parameters.integer("triangles");
    VertexClusteringOptions options;
    options.representative = representative_of(parameters.choice("representative"));
    options.cells = parameters.integer("cells");
    if (budget > 0) {
      options.cells = cluster_cells_for(surface, budget, context);
      if (options.cells == 0)
        throw MethodFailure("vertex-clustering found no grid that leaves some but at most " + std::to_string(budget) +
                            " triangles of " + model.name + "; raise triangles");
      context.notice("the grid has " + std::to_string(options.cells) + " cells along the longest side");
    }
    TriangleSoup clustered = cluster_vertices(surface, options, context);
    if (clustered.empty())
      throw MethodFailure("vertex-clustering left nothing of " + model.name + ": with " +
                          std::to_string(options.cells) +
                          " cells along the longest side no triangle has its corners in three of them; raise cells");
    MethodResult result;
    result.levels = make_levels({std::move(clustered)});
    return result;
  }

 private:
  static MethodInfo make_info() {
    MethodInfo info;
    info.name = "vertex-clustering";
    info.summary = "vertices merged in the cells of a uniform grid";
    info.citation = "RB93";
    info.accepts = {ModelKind::kSoup, ModelKind::kScalarVolume, ModelKind::kBinaryVolume};
    info.parameters.specs = {
        ParameterSpec::integer("triangles", "triangles", 0, std::int64_t{1} << 32, 0,
                               "take the finest grid that was found to leave at most this many; 0 takes cells"),
        ParameterSpec::integer("cells", "cells", 1, kMostClusterCells, VertexClusteringOptions{}.cells,
                               "cells along the longest side of the bounding box, where triangles is 0"),
        ParameterSpec::choice("representative", {"quadric", "mean", "heaviest"}, "quadric",
                              "where a cell's vertices go: the point of least quadric error in the cell, their mean, "
                              "or the one of the greatest weight")};
    info.baseline = true;
    return info;
  }
  MethodInfo info_ = make_info();
};

}  // namespace

std::unique_ptr<Method> make_vertex_clustering() {
  return std::make_unique<VertexClustering>();
}

}  // namespace voxcarve
