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
#include "common/volume/grid_passes.h"
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
    specs.push_back(
        ParameterSpec::toggle("maps", false,
                              "also make the volumes core, mortar and anticore of every radius, stability up to the "
                              "largest one, and first_mortar (voxcarve run --volume NAME)"));
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
  if (const auto* scalar = std::get_if<ScalarVolume>(&model.shape))
    return thresholded(scalar->grid, scalar->iso_value, context);
  return std::get<BinaryVolume>(model.shape);
}

TieRule tie_of(const Parameters& parameters) {
  return parameters.has("tie") && parameters.choice("tie") == "self-dual" ? TieRule::kSelfDual : TieRule::kPaper;
}

std::string radius_text(double radius) {
  return "radius " + format_real(radius);
}

/// The shape in bits, with room for the ball.
struct PaddedShape {
  BitVolume bits;
  GridFrame frame;
  Index3 margin = Index3::Zero();
};

/// The margin that a filter needs on the shape's grid: what only shrinks needs none.
std::int64_t margin_of(MorphologicalFilter filter, const GridFrame& frame, double radius) {
  const bool shrinks = filter == MorphologicalFilter::kErode || filter == MorphologicalFilter::kRound;
  return shrinks ? 0 : ball_margin(frame.dims, radius)[0];
}

/// `held` are the bytes that are held beside the result.
PaddedShape pad(const BinaryVolume& shape, std::int64_t margin, std::uint64_t held, RunContext& context) {
  PaddedShape result;
  result.frame = padded(shape.frame, margin);
  result.margin = (result.frame.dims - shape.frame.dims) / 2;
  context.require_memory(held + BitVolume::memory(result.frame.dims), "the padded volume");
  result.bits = packed(shape, result.margin, false, context);
  return result;
}

bool makes_maps(const Parameters& parameters) {
  return parameters.has("maps") && parameters.toggle("maps");
}

class Regularization final : public Method {
 public:
  explicit Regularization(const Operator& op) : operator_(op), info_(make_info(op)) {}
  const MethodInfo& info() const override { return info_; }

 protected:
  MethodResult do_run(const Model& model, const Parameters& parameters, RunContext& context) const override {
    const BinaryVolume shape = shape_of(model, parameters, context);
    if (model.soup() != nullptr && count_interior(shape, context) == 0) {
      throw MethodFailure("no voxel centre lies inside " + model.name +
                          " at this resolution; raise it, or use another classifier or number of directions");
    }
    const std::vector<double> radii = radii_of(parameters);
    MethodResult result;
    std::vector<TriangleSoup> levels;
    std::uint64_t held = shape_bytes(model) + shape.values.size();
    const auto keep = [&](const char* name, auto volume, std::int64_t level) {
      held += volume.values.size() * sizeof(volume.values[0]);
      result.volumes.push_back({name, std::move(volume), level});
    };
    if (makes_maps(parameters)) {
      Stage stage(context, "stability", shape.frame.voxels());
      keep("stability",
           stability_radii(squared_stability(shape, radii.front(), false, context, held), radii.front(), context, held),
           0);
      const std::vector<double> increasing(radii.rbegin(), radii.rend());
      keep("first_mortar", first_mortar(shape, increasing, false, context, held), 0);
    }
    bool empty = true;
    for (const double radius : radii) {
      const auto level = static_cast<std::int64_t>(levels.size());
      Filtered filtered = filter(shape, radius, parameters, held, context);
      for (auto& [name, map] : filtered.maps) keep(name, std::move(map), level);
      const bool nothing = count_interior(filtered.volume, context) == 0;
      empty = empty && nothing;
      if (nothing) context.notice(radius_text(radius) + ": nothing of " + model.name + " is left, the result is empty");
      const double voxel = shape.frame.voxel_size;
      result.level_properties.push_back({{"radius", radius}, {"radius_model", radius * voxel}, {"voxel_size", voxel}});
      levels.push_back(context.surfaces && !nothing
                           ? surface_of(shape, filtered.volume, radius, parameters, held, context)
                           : TriangleSoup{});
      held += levels.back().positions.size() * sizeof(Point) + levels.back().triangles.size() * sizeof(Triangle);
      keep("result", std::move(filtered.volume), level);
    }
    // An empty volume is a result; who put a mesh in waits for one.
    if (empty && model.soup() != nullptr)
      throw MethodFailure("nothing of " + model.name + " is left; lower the radius or raise the resolution");
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
      // Theorems are about all of the filters, so there is room for what grows.
      const PaddedShape padded_shape =
          pad(shape, ball_margin(shape.frame.dims, radius)[0], shape_bytes(model) + 2 * shape.values.size(), context);
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
  struct Filtered {
    BinaryVolume volume;
    std::vector<std::pair<const char*, BinaryVolume>> maps;
  };

  /// The filtered volume, on the grid of `shape` unless it grows, and the maps of this radius. `held` are the bytes
  /// that are held beside them.
  Filtered filter(const BinaryVolume& shape, double radius, const Parameters& parameters, std::uint64_t held,
                  RunContext& context) const {
    const std::int64_t voxels = shape.frame.voxels();
    Stage stage(context, info_.name, voxels);
    const std::int64_t reach = squared_reach(radius);
    const PaddedShape room = pad(shape, margin_of(operator_.filter, shape.frame, radius), held, context);
    // The shape, R, F, RF, FR and two more in the making, and the result or the maps in bytes.
    const bool grows = operator_.filter == MorphologicalFilter::kDilate;
    const auto result_bytes = static_cast<std::uint64_t>(grows ? room.frame.voxels() : voxels);
    held += 7 * BitVolume::memory(room.frame.dims);
    context.require_memory(
        held + morphology_memory(room.frame.dims, reach) + result_bytes * (makes_maps(parameters) ? 4 : 1), info_.name);
    RegularFilters filters(room.bits, reach, false, context);
    Filtered filtered;
    if (makes_maps(parameters)) {
      const auto add = [&](const char* name, const BitVolume& bits) {
        filtered.maps.emplace_back(name, expanded(bits, shape.frame, room.margin, context));
      };
      add("core", filters.rounded());
      add("mortar", filters.mortar());
      add("anticore", complement(filters.filleted(), context));
    }
    MasonCounts counts;
    if (operator_.filter == MorphologicalFilter::kMason) {
      for (const auto& make : {&RegularFilters::rounded, &RegularFilters::fr, &RegularFilters::filleted}) {
        (filters.*make)();
        stage.advance(voxels / 4);
      }
    }
    const BitVolume result = std::move(filters).apply(operator_.filter, tie_of(parameters), &counts, held);
    if (operator_.filter == MorphologicalFilter::kMason) {
      context.notice(radius_text(radius) + ": " + std::to_string(counts.mortar_components) +
                     " components of the mortar, " + std::to_string(counts.by_fr) + " changed less by FR, " +
                     std::to_string(counts.by_rf) + " by RF, " + std::to_string(counts.ties) + " alike");
    }
    filtered.volume =
        grows ? expanded(result, room.frame, context) : expanded(result, shape.frame, room.margin, context);
    return filtered;
  }

  TriangleSoup surface_of(const BinaryVolume& shape, const BinaryVolume& filtered, double radius,
                          const Parameters& parameters, std::uint64_t held, RunContext& context) const {
    const bool binary = parameters.choice("surface") == "binary";
    TriangleSoup surface =
        binary ? isosurface(filtered, context) : distance_surface(shape, radius, parameters, held, context);
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
                                std::uint64_t held, RunContext& context) const {
    // One voxel more of exterior than the ball reaches, so that distances to it are seen.
    const PaddedShape room = pad(shape, ball_margin(shape.frame.dims, radius)[0] + 1, held, context);
    Grid<float> field;
    {
      Stage stage(context, "distance field", room.frame.voxels());
      field = distance_field(room.bits, room.frame, squared_reach(radius), operator_.filter, tie_of(parameters),
                             held + BitVolume::memory(room.frame.dims), context);
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
  return make(
      "mason", MorphologicalFilter::kMason,
      "round and fillet by a ball, in the order that changes each irregular region less (self-dual but for ties)");
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
