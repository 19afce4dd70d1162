// Based on [NT03]: voxelization (3), repair (3.3), morphology (4), isosurface, colour and triangle reduction (5).
// Differs in what the README beside this file lists.
#include "methods/nooruddin_turk/nooruddin_turk.h"

#include <algorithm>
#include <optional>
#include <span>
#include <utility>

#include "common/mesh/reduction_parameters.h"
#include "common/mesh/smoothing.h"
#include "common/mesh/stitching.h"
#include "common/run/errors.h"
#include "common/volume/isosurface.h"
#include "common/volume/morphology.h"
#include "common/volume/surface_voxels.h"
#include "common/volume/voxel_parameters.h"

namespace voxcarve {

namespace {

constexpr const char* kThinShell = "thin-shell";
constexpr std::int64_t kSmoothAfterMorphology = -1;

TaubinOptions smoothing_options(const Parameters& parameters) {
  TaubinOptions options;
  options.lambda = parameters.real("smoothing_lambda");
  options.mu = parameters.real("smoothing_mu");
  const std::int64_t asked = parameters.integer("smoothing");
  if (asked != kSmoothAfterMorphology) {
    options.iterations = static_cast<int>(asked);
  } else if (parameters.choice("morphology") == "none") {
    options.iterations = 0;
  }
  return options;
}

MethodInfo make_info() {
  MethodInfo info;
  info.name = "nooruddin-turk";
  info.summary = "voxelize, open or close by a ball, extract a manifold isosurface, reduce by quadric edge collapse";
  info.citation = "NT03";
  info.accepts = {ModelKind::kSoup, ModelKind::kScalarVolume, ModelKind::kBinaryVolume};
  info.closed_manifold = true;
  info.gives_volume = true;
  auto& specs = info.parameters.specs;
  specs.push_back(ParameterSpec::toggle("stitch", false,
                                        "close cracks and holes of the polygons first: for models that also have parts "
                                        "cutting through each other, before stabbing"));
  specs.push_back(
      ParameterSpec::real("stitch_tolerance", "diag", 0, 0.1, 0.002, "stitch: borders up to so far apart are closed"));
  for (ParameterSpec& spec : voxelization_parameters()) {
    if (spec.name == "classifier") {
      spec.choices.emplace_back(kThinShell);
      spec.help += ", or thin-shell: voxels near the surface, without an inside (for comparison)";
    }
    specs.push_back(std::move(spec));
  }
  specs.push_back(ParameterSpec::choice(
      "morphology", {"none", "dilate", "erode", "open", "close"}, "none",
      "operator on the volume: none is repair, close fills holes and joins parts, open removes thin parts"));
  specs.push_back(ParameterSpec::real("distance", "voxels", 0, 1000, 3, "radius of the ball of the morphology"));
  specs.push_back(ParameterSpec::choice("distance_map", {"exact", "danielsson-4sed"}, "exact",
                                        "the map that morphology thresholds: exact Euclidean, or the paper's own"));
  specs.push_back(ParameterSpec::real("threshold", "density", 1e-6, 1, 0.5,
                                      "density from which on a voxel takes part in the morphology"));
  specs.push_back(ParameterSpec::real("iso_value", "density", 1e-6, 1 - 1e-6, 0.5,
                                      "density at the surface, without morphology; volumes bring their own"));
  specs.push_back(ParameterSpec::integer("smoothing", "iterations", kSmoothAfterMorphology, 1000,
                                         kSmoothAfterMorphology,
                                         "Taubin smoothing of the isosurface; -1: 10 after morphology, else none"));
  specs.push_back(ParameterSpec::real("smoothing_lambda", "", 0.01, 0.99, TaubinOptions{}.lambda,
                                      "Taubin smoothing: share of the way to the neighbours' mean"));
  specs.push_back(ParameterSpec::real("smoothing_mu", "", -1.5, -0.01, TaubinOptions{}.mu,
                                      "Taubin smoothing: the step back, below -smoothing_lambda"));
  specs.push_back(ParameterSpec::toggle("color", true, "keep the colours of a model that has some"));
  std::ranges::move(reduction_parameters(0, 0, "reduce the surface to at most this many triangles; 0 leaves it"),
                    std::back_inserter(specs));
  info.parameters.check = [](const Parameters& parameters) {
    if (parameters.real("smoothing_mu") >= -parameters.real("smoothing_lambda"))
      throw ParameterError("smoothing_mu must lie below -smoothing_lambda, or the smoothing shrinks the surface");
    check_options(smoothing_options(parameters));
  };
  return info;
}

/// Volume and colours of the stages before the isosurface.
struct Voxels {
  std::variant<BinaryVolume, DensityVolume> volume;
  float iso_value = 0.5F;
  bool closes_at_border = false;  ///< a scalar volume of values of any size
};

BinaryVolume apply_morphology(const BinaryVolume& volume, const Parameters& parameters, RunContext& context) {
  const std::string& morphology = parameters.choice("morphology");
  const double distance = parameters.real("distance");
  const DistanceMap map =
      parameters.choice("distance_map") == "exact" ? DistanceMap::kExact : DistanceMap::kDanielsson4sed;
  Stage stage(context, morphology, volume.frame.voxels());
  if (morphology == "dilate") return dilate(volume, distance, context, map);
  if (morphology == "erode") return erode(volume, distance, context, map);
  if (morphology == "open") return open(volume, distance, context, map);
  return close(volume, distance, context, map);
}

/// Voxels along the longest side of the interior's box; 0 without an interior.
std::int64_t extent_of(const BinaryVolume& volume) {
  Index3 low = volume.frame.dims;
  Index3 high = Index3::Constant(-1);
  for (std::int64_t k = 0; k < volume.nz(); ++k) {
    for (std::int64_t j = 0; j < volume.ny(); ++j) {
      const auto row =
          std::span(volume.values)
              .subspan(static_cast<std::size_t>(volume.index(0, j, k)), static_cast<std::size_t>(volume.nx()));
      const auto is_interior = [](std::uint8_t value) { return value != 0; };
      const auto first = std::ranges::find_if(row, is_interior);
      if (first == row.end()) continue;
      const auto last = std::find_if(row.rbegin(), row.rend(), is_interior);
      low = low.cwiseMin(Index3(first - row.begin(), j, k));
      high = high.cwiseMax(Index3(row.rend() - last - 1, j, k));
    }
  }
  return std::max<std::int64_t>(0, (high - low).maxCoeff() + 1);
}

/// The paper advises a resolution of about ten times the distance [NT03, 4]. `resolution`: of the voxelization, or what
/// a volume fills of its grid.
void advise_resolution(std::int64_t resolution, const Parameters& parameters, RunContext& context) {
  const double distance = parameters.real("distance");
  if (static_cast<double>(resolution) >= 10 * distance) return;
  context.notice("the resolution of " + std::to_string(resolution) + " voxels is below 10 times the distance of " +
                 to_string(ParameterValue(distance)) + " that the paper advises; raise it, or lower the distance");
}

bool has_colors(const TriangleSoup& soup) {
  return !soup.vertex_colors.empty() || !soup.triangle_colors.empty();
}

const GridFrame& frame_of(const Voxels& voxels) {
  return std::visit([](const auto& volume) -> const GridFrame& { return volume.frame; }, voxels.volume);
}

class NooruddinTurk final : public Method {
 public:
  const MethodInfo& info() const override { return info_; }

 protected:
  MethodResult do_run(const Model& model, const Parameters& parameters, RunContext& context) const override {
    const TriangleSoup* soup = model.soup();
    TriangleSoup stitched;
    if (soup != nullptr && parameters.toggle("stitch")) {
      const double diagonal = bounds(*soup).diagonal();
      stitched = stitch(*soup, {.tolerance = parameters.real("stitch_tolerance") * diagonal}, context);
      if (stitched.empty()) throw MethodFailure("stitching left nothing of " + model.name + ": it has no area");
      soup = &stitched;
    }
    SurfaceColors colors;
    if (soup != nullptr && parameters.toggle("color") && has_colors(*soup)) {
      colors = record_surface_colors(*soup, voxel_frame(bounds(*soup), parameters.integer("resolution")), context);
    }
    Voxels voxels = voxels_of(model, soup, parameters, context);
    if (parameters.choice("morphology") != "none") operate(model, parameters, voxels, context);

    TriangleSoup surface = extract(model, voxels, context);
    if (!colors.empty()) {
      interpolate_colors(surface, NearestColors(colors, frame_of(voxels), context), context);
    }
    MethodResult result;
    result.volumes.push_back({"result", as_result(std::move(voxels))});
    const TaubinOptions smoothing = smoothing_options(parameters);
    if (smoothing.iterations > 0) taubin_smooth(surface, smoothing, context);
    result.levels = make_levels({reduce(std::move(surface), parameters, context)});
    return result;
  }

 private:
  /// The volume that a model brings, or that the voxelization makes of the soup (of `model`, stitched or not).
  static Voxels voxels_of(const Model& model, const TriangleSoup* soup, const Parameters& parameters,
                          RunContext& context) {
    if (const auto* binary = std::get_if<BinaryVolume>(&model.shape)) return {*binary, 0.5F, false};
    if (const auto* scalar = std::get_if<ScalarVolume>(&model.shape)) return {scalar->grid, scalar->iso_value, true};
    const auto iso_value = static_cast<float>(parameters.real("iso_value"));
    if (parameters.choice("classifier") == kThinShell) {
      // Wide enough that the shell has no holes: centres within one voxel of the surface, more than half a diagonal.
      constexpr std::int64_t kReach = 2;
      const GridFrame frame = padded(voxel_frame(bounds(*soup), parameters.integer("resolution")), kReach);
      return {thin_shell(*soup, frame, static_cast<double>(kReach), context), iso_value, false};
    }
    if (is_binary(supersampling_options(parameters)) && iso_value == 0.5F)
      return {voxelize_model(*soup, parameters, 0.5, context), iso_value, false};
    return {voxelize_model_density(*soup, parameters, context), iso_value, false};
  }

  /// Replaces `voxels` by the morphology's result.
  static void operate(const Model& model, const Parameters& parameters, Voxels& voxels, RunContext& context) {
    if (const auto* field = std::get_if<DensityVolume>(&voxels.volume)) {
      const auto threshold = static_cast<float>(parameters.real("threshold"));
      voxels.volume = thresholded(*field, voxels.closes_at_border ? voxels.iso_value : threshold);
    }
    voxels.iso_value = 0.5F;
    voxels.closes_at_border = false;
    auto& volume = std::get<BinaryVolume>(voxels.volume);
    if (count_interior(volume) == 0) fail_empty(model);
    advise_resolution(model.soup() != nullptr ? parameters.integer("resolution") : extent_of(volume), parameters,
                      context);
    volume = apply_morphology(volume, parameters, context);
    if (count_interior(volume) == 0) {
      throw MethodFailure("the " + parameters.choice("morphology") + " removed every voxel of " + model.name +
                          "; lower distance or raise resolution");
    }
  }

  static TriangleSoup extract(const Model& model, const Voxels& voxels, RunContext& context) {
    TriangleSoup surface;
    if (const auto* binary = std::get_if<BinaryVolume>(&voxels.volume)) {
      surface = isosurface(*binary, context);
    } else {
      const auto& field = std::get<DensityVolume>(voxels.volume);
      surface = voxels.closes_at_border ? scalar_isosurface(field, voxels.iso_value, context)
                                        : isosurface(field, voxels.iso_value, context);
    }
    if (surface.empty()) fail_empty(model);
    return surface;
  }

  [[noreturn]] static void fail_empty(const Model& model) {
    if (std::holds_alternative<ScalarVolume>(model.shape))
      throw MethodFailure("nothing of " + model.name + " lies at or above its iso-value; choose another one");
    if (model.soup() == nullptr) throw MethodFailure("no voxel of " + model.name + " is interior");
    throw MethodFailure("no voxel centre lies inside " + model.name +
                        " at this resolution; raise it, or use another classifier or number of directions");
  }

  /// The volume as it is stored with the result: of a field with values of any size, its solid.
  static std::variant<BinaryVolume, DensityVolume> as_result(Voxels voxels) {
    if (voxels.closes_at_border) return thresholded(std::get<DensityVolume>(voxels.volume), voxels.iso_value);
    return std::move(voxels.volume);
  }

  MethodInfo info_ = make_info();
};

}  // namespace

std::unique_ptr<Method> make_nooruddin_turk() {
  return std::make_unique<NooruddinTurk>();
}

}  // namespace voxcarve
