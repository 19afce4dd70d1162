// Based on [He95]: volume sampling of the original at every level (2), marching cubes, multi-layered surfaces (3),
// volumes filtered directly (4) and in-between levels (5). Differs in what the README beside this file lists.
#include "methods/he_lowpass/he_lowpass.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>

#include "common/mesh/reduction_parameters.h"
#include "common/run/errors.h"
#include "common/run/text.h"
#include "common/volume/isosurface.h"
#include "common/volume/voxel_parameters.h"
#include "methods/he_lowpass/hierarchy.h"
#include "methods/he_lowpass/in_between.h"
#include "methods/he_lowpass/low_pass.h"
#include "methods/he_lowpass/surface_layers.h"
#include "methods/he_lowpass/value_filter.h"

namespace voxcarve {

namespace {

MethodInfo make_info() {
  MethodInfo info;
  info.name = "he-lowpass";
  info.summary = "hierarchies of low-pass filtered volumes, whose surfaces lose their details and handles";
  info.citation = "He95";
  info.accepts = {ModelKind::kSoup, ModelKind::kScalarVolume, ModelKind::kBinaryVolume, ModelKind::kImplicitSolid};
  info.parameters.specs = hierarchy_parameters();
  auto& specs = info.parameters.specs;
  specs.push_back(ParameterSpec::choice("filter", {"gaussian", "hyper-cone", "box"}, "gaussian",
                                        "the low-pass filter; radially symmetric, 0 beyond its support"));
  specs.push_back(ParameterSpec::real("sigma_ratio", "support", 0.01, 100, 0.4,
                                      "standard deviation of the Gaussian, as a share of its support's radius"));
  specs.push_back(ParameterSpec::integer("taps", "samples", 3, 256, 24,
                                         "samples of the solid across the support, at least (the paper: 11)"));
  specs.push_back(ParameterSpec::choice("tap_weights", {"cell", "point"}, "cell",
                                        "weigh a sample by the filter's mean over its cell, or as the paper by the "
                                        "filter's value there"));
  specs.push_back(ParameterSpec::choice("source", {"solid", "values"}, "solid",
                                        "filter the inside test, or directly the values of a scalar volume"));
  specs.push_back(ParameterSpec::real("iso_value", "density", 1e-6, 1 - 1e-6, 0.5,
                                      "density at the surface; with source=values volumes bring their own"));
  specs.push_back(ParameterSpec::integer("layers", "surfaces", 0, 1000, 0,
                                         "also make so many translucent layers of every level, from the surface "
                                         "outward; 0: none"));
  specs.push_back(ParameterSpec::real("layer_error", "density", 0, 1, 0,
                                      "also make the fewest layers with at most this error of eq. 6; 0: none"));
  specs.push_back(
      ParameterSpec::integer("between", "levels", 0, 1000, 0, "put so many interpolated levels between every two"));
  for (ParameterSpec& spec : voxelization_parameters()) {
    if (spec.name == "resolution" || spec.name == "supersampling" || spec.name == "kernel") continue;
    specs.push_back(std::move(spec));
  }
  std::ranges::move(reduction_parameters(0, 0, "reduce each surface to at most this many triangles; 0 leaves it"),
                    std::back_inserter(specs));
  info.parameters.check = [](const Parameters& parameters) {
    check_hierarchy(parameters);
    if (parameters.integer("layers") > 0 && parameters.real("layer_error") > 0)
      throw ParameterError("set layers or layer_error, not both");
    const bool has_layers = parameters.integer("layers") > 0 || parameters.real("layer_error") > 0;
    if (has_layers && parameters.choice("source") == "values")
      throw ParameterError("layers need densities: source=values has none");
  };
  info.closed_manifold = true;
  info.gives_volume = true;
  return info;
}

RadialFilter filter_of(const Parameters& parameters) {
  return {radial_shape_from(parameters.choice("filter")), parameters.real("sigma_ratio")};
}

std::vector<SurfaceLayer> layers_of(const Parameters& parameters) {
  if (parameters.integer("layers") > 0) return best_layers(filter_of(parameters), parameters.integer("layers")).layers;
  if (parameters.real("layer_error") > 0)
    return fewest_layers(filter_of(parameters), parameters.real("layer_error")).layers;
  return {};
}

/// One level's field, and how its surface is taken.
struct FilteredLevel {
  DensityVolume volume;
  float iso_value = 0.5F;
  bool is_density = true;  ///< 0 beyond the grid
};

/// The grid of a level with a margin beyond which no density reaches `lowest`: a point at distance x from the box,
/// which lies on one side of a plane there, sees at most the density of a half-space.
GridFrame filtered_frame(const HierarchyLevel& level, const RadialFilter& filter, double lowest) {
  const double reach = lowest < 0.5 ? filter.plane_distance(lowest) * level.support : 0;
  return padded(level.frame, static_cast<std::int64_t>(std::ceil(reach / level.frame.voxel_size)) + 1);
}

/// Filters the levels of one model.
class LevelFilter {
 public:
  LevelFilter(const Model& model, const Parameters& parameters)
      : model_(model), parameters_(parameters), sampler_(make_sampler(model, voxelize_options(parameters))) {
    for (const SurfaceLayer& layer : layers_of(parameters)) lowest_ = std::min(lowest_, layer.iso_density);
  }

  std::vector<HierarchyLevel> levels() const {
    return hierarchy_levels(parameters_, grid_box(parameters_, sampler_->box()));
  }

  FilteredLevel filter(const HierarchyLevel& level, std::uint64_t held, RunContext& context) const {
    context.require_memory(held, "the levels before");
    FilteredLevel filtered;
    if (parameters_.choice("source") == "values") {
      const auto& scalar = std::get<ScalarVolume>(model_.shape);
      filtered.volume = filter_values(scalar.grid, level.frame, filter_of(parameters_), level.support, context);
      filtered.iso_value = scalar.iso_value;
      filtered.is_density = false;
      return filtered;
    }
    LowPassOptions options;
    options.filter = filter_of(parameters_);
    const GridFrame frame = filtered_frame(level, options.filter, lowest_);
    options.support = level.support / frame.voxel_size;
    options.taps = static_cast<double>(parameters_.integer("taps"));
    options.rule = parameters_.choice("tap_weights") == "point" ? TapRule::kPoint : TapRule::kCell;
    filtered.volume = low_pass(*sampler_, frame, options, context);
    filtered.iso_value = static_cast<float>(parameters_.real("iso_value"));
    return filtered;
  }

 private:
  const Model& model_;
  const Parameters& parameters_;
  std::unique_ptr<SolidSampler> sampler_;
  double lowest_ = parameters_.real("iso_value");  ///< of the densities that surfaces are made of
};

std::string level_text(const HierarchyLevel& level) {
  return "resolution " + std::to_string(level.resolution);
}

std::uint64_t bytes_of(const TriangleSoup& soup) {
  return soup.positions.size() * sizeof(Point) + soup.triangles.size() * sizeof(Triangle);
}

/// What is listed of a level. Of an interpolated one `share` is the way from the coarser neighbour to the finer one,
/// whose grid it has, and the support the mean of theirs.
std::vector<LevelProperty> properties_of(const HierarchyLevel& level, double finest_voxel) {
  return {{"resolution", static_cast<double>(level.resolution)},
          {"voxel_size", level.frame.voxel_size},
          {"support", level.support},
          {"support_voxels", level.support / finest_voxel}};
}

std::vector<LevelProperty> properties_between(const HierarchyLevel& coarse, const HierarchyLevel& fine, double share,
                                              double finest_voxel) {
  HierarchyLevel level = fine;
  level.support = coarse.support + share * (fine.support - coarse.support);
  std::vector<LevelProperty> properties = properties_of(level, finest_voxel);
  properties.push_back({"share", share});
  return properties;
}

/// Collects what the levels leave.
class Collector {
 public:
  Collector(const Model& model, const Parameters& parameters, RunContext& context)
      : parameters_(parameters), context_(context), layers_(layers_of(parameters)), held_(shape_bytes(model)) {}

  std::uint64_t held() const { return held_; }

  /// `what` names the level in notices.
  void add(const FilteredLevel& level, const std::string& what, std::vector<LevelProperty> properties) {
    const auto index = static_cast<std::int64_t>(levels_.size());
    TriangleSoup surface;
    if (context_.surfaces) {
      surface = level.is_density ? isosurface(level.volume, level.iso_value, context_)
                                 : scalar_isosurface(level.volume, level.iso_value, context_);
      if (surface.empty()) context_.notice(what + ": nothing reaches the iso-value, the level is empty");
      surface = reduce(std::move(surface), parameters_, context_);
      for (const SurfaceLayer& layer : layers_) {
        const auto density = static_cast<float>(layer.iso_density);
        result_.layers.push_back({index, layer.iso_density, layer.opacity,
                                  reduce(isosurface(level.volume, density, context_), parameters_, context_)});
        held_ += bytes_of(result_.layers.back().surface);
      }
    }
    any_ = any_ || !surface.empty() || !context_.surfaces;
    held_ += bytes_of(surface) + level.volume.values.size() * sizeof(float);
    levels_.push_back(std::move(surface));
    result_.level_properties.push_back(std::move(properties));
    result_.volumes.push_back({"result", level.volume, index});
  }

  MethodResult take(const Model& model) {
    if (!any_) {
      throw MethodFailure("nothing of " + model.name +
                          " is left at any level; raise the resolution, or lower the support or the iso-value");
    }
    result_.levels = make_levels(std::move(levels_));
    return std::move(result_);
  }

 private:
  const Parameters& parameters_;
  RunContext& context_;
  std::vector<SurfaceLayer> layers_;
  std::uint64_t held_;
  bool any_ = false;
  std::vector<TriangleSoup> levels_;
  MethodResult result_;
};

class HeLowpass final : public Method {
 public:
  const MethodInfo& info() const override { return info_; }

 protected:
  std::optional<SkipReason> unsupported_shape(const Model& model, const Parameters& parameters) const override {
    if (parameters.choice("source") == "values" && !std::holds_alternative<ScalarVolume>(model.shape))
      return SkipReason{"source=values filters scalar volumes; " + model.name + " is none"};
    return std::nullopt;
  }

  MethodResult do_run(const Model& model, const Parameters& parameters, RunContext& context) const override {
    const LevelFilter filter(model, parameters);
    Collector collector(model, parameters, context);
    const std::vector<HierarchyLevel> levels = filter.levels();
    const double finest_voxel = levels.back().frame.voxel_size;
    const auto between = static_cast<std::size_t>(parameters.integer("between"));
    std::optional<FilteredLevel> before;
    for (std::size_t i = 0; i < levels.size(); ++i) {
      FilteredLevel filtered = filter.filter(levels[i], collector.held(), context);
      if (before && between > 0) {
        std::vector<std::vector<LevelProperty>> properties;
        for (std::size_t k = 1; k <= between; ++k) {
          const double share = static_cast<double>(k) / static_cast<double>(between + 1);
          properties.push_back(properties_between(levels[i - 1], levels[i], share, finest_voxel));
        }
        add_between(*before, filtered, std::move(properties), collector, context);
      }
      collector.add(filtered, level_text(levels[i]), properties_of(levels[i], finest_voxel));
      before = std::move(filtered);
    }
    return collector.take(model);
  }

  /// Densities are shares, and each level is what it is when it is made alone.
  std::vector<InvariantCheck> own_invariants(const Model& model, const Parameters& parameters,
                                             const MethodResult& result, RunContext& context) const override {
    const LevelFilter filter(model, parameters);
    const std::vector<HierarchyLevel> levels = filter.levels();
    InvariantCheck shares{"densities lie in [0, 1]", true, ""};
    InvariantCheck alone{"no error accumulates: every level is that of the original, filtered alone", true, ""};
    const std::int64_t step = parameters.integer("between") + 1;
    for (const NamedVolume& named : result.volumes) {
      const auto& volume = std::get<DensityVolume>(named.volume);
      shares.holds =
          shares.holds && std::ranges::all_of(volume.values, [](float value) { return value >= 0 && value <= 1; });
      if (named.level % step != 0) continue;  // an interpolated one
      const HierarchyLevel& level = levels[static_cast<std::size_t>(named.level / step)];
      if (filter.filter(level, 0, context).volume == volume) continue;
      alone.holds = false;
      alone.detail = level_text(level) + " differs";
    }
    if (alone.holds) alone.detail = std::to_string(levels.size()) + " levels, byte for byte";
    shares.detail = std::to_string(result.volumes.size()) + " volumes";
    if (parameters.choice("source") == "values") return {std::move(alone)};  // of any size
    return {std::move(shares), std::move(alone)};
  }

 private:
  /// One level a list of `properties`, of which the last is its share.
  static void add_between(const FilteredLevel& coarse, const FilteredLevel& fine,
                          std::vector<std::vector<LevelProperty>> properties, Collector& collector,
                          RunContext& context) {
    const InBetween between(coarse.volume, fine.volume, fine.iso_value, context);
    for (std::size_t i = 0; i < properties.size(); ++i) {
      FilteredLevel level;
      level.volume = between.at(properties[i].back().value, context);
      level.iso_value = fine.iso_value;
      level.is_density = fine.is_density;
      collector.add(level, "in-between level " + std::to_string(i + 1), std::move(properties[i]));
    }
    context.notice("between two levels " + std::to_string(between.touched_cells()) + " of " +
                   std::to_string(between.cells()) + " cells can hold the surface, and their densities differ by at " +
                   "most " + format_real(between.largest_difference()));
  }

  MethodInfo info_ = make_info();
};

}  // namespace

std::unique_ptr<Method> make_he_lowpass() {
  return std::make_unique<HeLowpass>();
}

}  // namespace voxcarve
