// Based on [WR05]: Mason (4), rounding and filleting (3.2), stability, core, mortar and anticore (3.3), in 2D and 3D.
// Differs in what the README beside this file lists.
#include "methods/mason/mason.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "common/mesh/reduction_parameters.h"
#include "common/mesh/smoothing.h"
#include "common/run/errors.h"
#include "common/run/text.h"
#include "common/volume/bit_morphology.h"
#include "common/volume/isosurface.h"
#include "common/volume/stability.h"
#include "common/volume/voxel_parameters.h"
#include "methods/mason/distance_surface.h"
#include "methods/mason/invariants.h"
#include "methods/mason/regular_filters.h"

namespace voxcarve {

namespace {

/// A filter under a name.
struct Operator {
  const char* name;
  const char* summary;
  const char* citation;
  MorphologicalFilter filter;
};

constexpr std::int64_t kSmoothBinary = -1;

MethodInfo make_info(const Operator& op) {
  const bool is_mason = op.filter == MorphologicalFilter::kMason;
  MethodInfo info;
  info.name = op.name;
  info.summary = op.summary;
  info.citation = op.citation;
  info.accepts = {ModelKind::kSoup, ModelKind::kScalarVolume, ModelKind::kBinaryVolume, ModelKind::kImage};
  info.parameters.specs = voxelization_parameters();
  auto& specs = info.parameters.specs;
  specs.push_back(ParameterSpec::reals("radius", "voxels", 0, 1000, {1},
                                       "radius of the ball; several, separated by commas, make a level each"));
  if (is_mason) {
    specs.push_back(ParameterSpec::choice("tie", {"paper", "self-dual"}, "paper",
                                          "components that both filters change alike: RF, or what treats interior and "
                                          "exterior the same way"));
    specs.push_back(ParameterSpec::toggle("maps", false,
                                          "also make the volumes core, mortar and anticore of every radius, and the "
                                          "stability in voxels up to the largest one (voxcarve run --volume NAME)"));
  }
  specs.push_back(ParameterSpec::choice("surface", {"binary", "distance"}, "binary",
                                        "extract the surface from the voxels, or from the distance field of the last "
                                        "step, where the balls show"));
  specs.push_back(ParameterSpec::integer("smoothing", "iterations", kSmoothBinary, 1000, kSmoothBinary,
                                         "Taubin smoothing of the surface; -1: 10 for surface=binary, else none"));
  std::ranges::move(reduction_parameters(0, 0, "reduce each surface to at most this many triangles; 0 leaves it"),
                    std::back_inserter(specs));
  info.closed_manifold = true;
  info.gives_volume = true;
  info.baseline = !is_mason;
  return info;
}

/// Radii from the coarsest level to the finest, each once.
std::vector<double> radii_of(const Parameters& parameters) {
  std::vector<double> radii = parameters.reals("radius");
  std::ranges::sort(radii, std::ranges::greater());
  const auto [first, last] = std::ranges::unique(radii);
  radii.erase(first, last);
  return radii;
}

BinaryVolume shape_of(const Model& model, const Parameters& parameters, RunContext& context) {
  if (const auto* soup = model.soup()) return voxelize_model(*soup, parameters, 0.5, context);
  if (const auto* scalar = std::get_if<ScalarVolume>(&model.shape)) return thresholded(scalar->grid, scalar->iso_value);
  return std::get<BinaryVolume>(model.shape);
}

TieRule tie_of(const Parameters& parameters) {
  return parameters.has("tie") && parameters.choice("tie") == "self-dual" ? TieRule::kSelfDual : TieRule::kPaper;
}

std::string radius_text(double radius) {
  return "radius " + format_real(radius);
}

/// A filter may well leave nothing of a volume, and an empty volume says so; who asked for a mesh of a mesh gets none.
void report_empty(const Model& model, double radius, RunContext& context) {
  const std::string what = radius_text(radius) + ": nothing of " + model.name + " is left";
  if (model.soup() != nullptr) throw MethodFailure(what + "; lower the radius or raise the resolution");
  context.notice(what + ", the result is empty");
}

/// The shape in bits, with room for the ball.
struct PaddedShape {
  BitVolume bits;
  GridFrame frame;
  Index3 margin = Index3::Zero();
};

PaddedShape pad_for_ball(const BinaryVolume& shape, double radius, std::int64_t more, RunContext& context) {
  PaddedShape result;
  const auto margin = ball_margin(shape.frame.dims, radius)[0] + more;
  result.frame = padded(shape.frame, margin);
  result.margin = (result.frame.dims - shape.frame.dims) / 2;
  context.require_memory(shape.values.size() + BitVolume::memory(result.frame.dims), "the padded volume");
  result.bits = packed(shape, result.margin, false, context);
  return result;
}

class Regularization final : public Method {
 public:
  explicit Regularization(const Operator& op) : operator_(op), info_(make_info(op)) {}
  const MethodInfo& info() const override { return info_; }

 protected:
  MethodResult do_run(const Model& model, const Parameters& parameters, RunContext& context) const override {
    const BinaryVolume shape = shape_of(model, parameters, context);
    if (model.soup() != nullptr && count_interior(shape) == 0) {
      throw MethodFailure("no voxel centre lies inside " + model.name +
                          " at this resolution; raise it, or use another classifier or number of directions");
    }
    const std::vector<double> radii = radii_of(parameters);
    MethodResult result;
    std::vector<TriangleSoup> levels;
    if (parameters.has("maps") && parameters.toggle("maps")) {
      Stage stage(context, "stability", shape.frame.voxels());
      result.volumes.push_back({"stability", stability_radii(squared_stability(shape, radii.front(), false, context))});
    }
    for (const double radius : radii) {
      const auto level = static_cast<std::int64_t>(levels.size());
      BinaryVolume filtered = filter(shape, radius, level, parameters, result, context);
      if (count_interior(filtered) == 0) report_empty(model, radius, context);
      levels.push_back(surface_of(shape, filtered, radius, parameters, context));
      result.volumes.push_back({"result", std::move(filtered), level});
    }
    result.levels = make_levels(std::move(levels));
    return result;
  }

  std::vector<InvariantCheck> own_invariants(const Model& model, const Parameters& parameters,
                                             const MethodResult& result, RunContext& context) const override {
    const BinaryVolume shape = shape_of(model, parameters, context);
    const std::vector<double> radii = radii_of(parameters);
    std::vector<InvariantCheck> checks;
    for (const NamedVolume& volume : result.volumes) {
      if (volume.name != "result") continue;
      const double radius = radii[static_cast<std::size_t>(volume.level)];
      const PaddedShape padded_shape = pad_for_ball(shape, radius, 0, context);
      const auto& filtered = std::get<BinaryVolume>(volume.volume);
      const Index3 margin = (padded_shape.frame.dims - filtered.frame.dims) / 2;
      for (InvariantCheck& check :
           check_theorems(padded_shape.bits, packed(filtered, margin, false, context), squared_reach(radius),
                          operator_.filter, tie_of(parameters), context)) {
        check.name = radius_text(radius) + ": " + check.name;
        checks.push_back(std::move(check));
      }
    }
    return checks;
  }

 private:
  /// The filtered volume, on the grid of `shape` unless it has grown. Adds the maps of this radius to `result`.
  BinaryVolume filter(const BinaryVolume& shape, double radius, std::int64_t level, const Parameters& parameters,
                      MethodResult& result, RunContext& context) const {
    Stage stage(context, info_.name, shape.frame.voxels());
    const PaddedShape room = pad_for_ball(shape, radius, 0, context);
    RegularFilters filters(room.bits, squared_reach(radius), false, context);
    if (parameters.has("maps") && parameters.toggle("maps")) {
      const auto add = [&](const char* name, const BitVolume& bits) {
        result.volumes.push_back({name, expanded(bits, shape.frame, room.margin, context), level});
      };
      add("core", filters.rounded());
      add("mortar", filters.mortar());
      add("anticore", complement(filters.filleted(), context));
    }
    MasonCounts counts;
    const BitVolume filtered = std::move(filters).apply(operator_.filter, tie_of(parameters), &counts);
    if (operator_.filter == MorphologicalFilter::kMason) {
      context.notice(radius_text(radius) + ": " + std::to_string(counts.mortar_components) +
                     " components of the mortar, " + std::to_string(counts.by_fr) + " changed less by FR, " +
                     std::to_string(counts.by_rf) + " by RF, " + std::to_string(counts.ties) + " alike");
    }
    context.require_memory(BitVolume::memory(room.frame.dims) + static_cast<std::uint64_t>(room.frame.voxels()),
                           "the filtered volume");
    if (operator_.filter == MorphologicalFilter::kDilate) return expanded(filtered, room.frame, context);
    return expanded(filtered, shape.frame, room.margin, context);
  }

  TriangleSoup surface_of(const BinaryVolume& shape, const BinaryVolume& filtered, double radius,
                          const Parameters& parameters, RunContext& context) const {
    const bool binary = parameters.choice("surface") == "binary";
    TriangleSoup surface =
        binary ? isosurface(filtered, context) : distance_surface(shape, radius, parameters, context);
    const std::int64_t asked = parameters.integer("smoothing");
    TaubinOptions smoothing;
    if (asked != kSmoothBinary) {
      smoothing.iterations = static_cast<int>(asked);
    } else if (!binary) {
      smoothing.iterations = 0;
    }
    if (smoothing.iterations > 0 && !surface.empty()) taubin_smooth(surface, smoothing, context);
    return surface.empty() ? surface : reduce(std::move(surface), parameters, context);
  }

  TriangleSoup distance_surface(const BinaryVolume& shape, double radius, const Parameters& parameters,
                                RunContext& context) const {
    const PaddedShape room = pad_for_ball(shape, radius, 1, context);
    Grid<float> field;
    {
      Stage stage(context, "distance field", room.frame.voxels());
      field =
          distance_field(room.bits, room.frame, squared_reach(radius), operator_.filter, tie_of(parameters), context);
    }
    return scalar_isosurface(field, 0, context);
  }

  Operator operator_;
  MethodInfo info_;
};

std::unique_ptr<Method> make(const char* name, MorphologicalFilter filter, const char* summary,
                             const char* citation = "WR05") {
  return std::make_unique<Regularization>(Operator{name, summary, citation, filter});
}

}  // namespace

std::unique_ptr<Method> make_mason() {
  return make("mason", MorphologicalFilter::kMason,
              "round and fillet by a ball, in the order that changes each irregular region less (self-dual)");
}
std::unique_ptr<Method> make_dilate() {
  return make("dilate", MorphologicalFilter::kDilate, "the voxelized model grown by a ball");
}
std::unique_ptr<Method> make_erode() {
  return make("erode", MorphologicalFilter::kErode, "the voxelized model shrunk by a ball");
}
std::unique_ptr<Method> make_round() {
  return make("round", MorphologicalFilter::kRound, "rounding, an opening: removes what the ball does not fit into");
}
std::unique_ptr<Method> make_fillet() {
  return make("fillet", MorphologicalFilter::kFillet,
              "filleting, a closing: fills what the ball does not fit into from outside");
}
std::unique_ptr<Method> make_open() {
  return make("open", MorphologicalFilter::kRound, "opening by a ball (the same as round)", "NT03");
}
std::unique_ptr<Method> make_close() {
  return make("close", MorphologicalFilter::kFillet, "closing by a ball (the same as fillet)", "NT03");
}
std::unique_ptr<Method> make_rf() {
  return make("rf", MorphologicalFilter::kRf, "filleted, then rounded: fills irregular regions first");
}
std::unique_ptr<Method> make_fr() {
  return make("fr", MorphologicalFilter::kFr, "rounded, then filleted: clears irregular regions first");
}

}  // namespace voxcarve
