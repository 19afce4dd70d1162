#include "methods/he_lowpass/hierarchy.h"

#include <algorithm>
#include <cmath>

#include "common/run/errors.h"
#include "common/volume/voxelize.h"

namespace voxcarve {

namespace {

constexpr std::int64_t kCoarsest = 4;
constexpr double kFinest = 4096;

std::vector<double> resolutions_of(const Parameters& parameters) {
  std::vector<double> resolutions = parameters.reals("resolution");
  double resolution = resolutions.front();
  for (std::int64_t level = 1; level < parameters.integer("levels"); ++level) {
    resolution = resolutions.front() / std::pow(parameters.real("factor"), static_cast<double>(level));
    resolutions.push_back(std::ceil(resolution * (1 - 1e-12)));
  }
  return resolutions;
}

}  // namespace

std::vector<ParameterSpec> hierarchy_parameters() {
  return {
      ParameterSpec::reals("resolution", "voxels", 2, kFinest, {128},
                           "voxels along the longest side of the input's bounding box; several, separated by commas, "
                           "make a level each"),
      ParameterSpec::real("margin", "box", 0, 10, 0,
                          "grow the box of the grids, on every side, by this share of its longest side; voxels are "
                          "counted along the grown one"),
      ParameterSpec::choice("placement", {"voxels", "ends"}, "voxels",
                            "what resolution counts: voxels, sampled at their centres, or samples of which the first "
                            "and the last lie on the box"),
      ParameterSpec::integer("levels", "levels", 1, 20, 1, "make so many levels from a single resolution"),
      ParameterSpec::real("factor", "", 1.01, 64, 2, "with levels: from each resolution to the next coarser one"),
      ParameterSpec::reals("support", "voxels", 0, 1e6, {0},
                           "radius R of the filter, in voxels of the finest level; one for all levels grows with "
                           "their voxels; 0: a voxel of each level"),
      ParameterSpec::reals("support_model", "model", 0, 1e300, {0}, "the same in model units"),
  };
}

void check_hierarchy(const Parameters& parameters) {
  const std::vector<double>& resolutions = parameters.reals("resolution");
  const bool several = resolutions.size() > 1;
  if (several && parameters.integer("levels") > 1)
    throw ParameterError("levels goes with a single resolution; leave it out, or give only the finest");
  for (const double resolution : resolutions) {
    if (resolution != std::round(resolution)) throw ParameterError("resolution takes whole numbers of voxels");
  }
  for (const char* name : {"support", "support_model"}) {
    const std::size_t count = parameters.reals(name).size();
    if (count > 1 && count != resolutions.size()) {
      throw ParameterError(std::string(name) + " has " + std::to_string(count) + " values for " +
                           std::to_string(resolutions.size()) + " resolutions; give one, or one for each");
    }
  }
  const auto is_set = [&](const char* name) { return parameters.reals(name) != std::vector<double>{0}; };
  if (is_set("support") && is_set("support_model")) throw ParameterError("set support or support_model, not both");
  const std::vector<double> all = resolutions_of(parameters);
  if (all.size() > resolutions.size() && all.back() < static_cast<double>(kCoarsest)) {
    throw ParameterError("levels: " + std::to_string(all.size()) + " levels end below " + std::to_string(kCoarsest) +
                         " voxels; take fewer, or a smaller factor");
  }
}

std::vector<HierarchyLevel> hierarchy_levels(const Parameters& parameters, const Box& box) {
  const std::vector<double> resolutions = resolutions_of(parameters);
  const double finest = *std::ranges::max_element(resolutions);
  const double finest_voxel = level_frame(box, std::llround(finest), placement_of(parameters)).voxel_size;
  const bool in_model_units = parameters.reals("support_model") != std::vector<double>{0};
  const std::vector<double>& given = parameters.reals(in_model_units ? "support_model" : "support");
  std::vector<HierarchyLevel> levels;
  for (std::size_t i = 0; i < resolutions.size(); ++i) {
    const double growth = finest / resolutions[i];
    const bool own = given.size() > 1;
    double support = (own ? given[i] : given.front()) * (in_model_units ? 1 : finest_voxel);
    if (support == 0) support = finest_voxel * (own ? growth : 1);
    const std::int64_t resolution = std::llround(resolutions[i]);
    levels.push_back(
        {resolution, own ? support : support * growth, level_frame(box, resolution, placement_of(parameters))});
  }
  std::ranges::stable_sort(levels, {}, &HierarchyLevel::resolution);
  return levels;
}

Box grid_box(const Parameters& parameters, const Box& box) {
  const Point margin = Point::Constant(parameters.real("margin") * box.extent().maxCoeff());
  Box grown;
  grown.extend(box.lower - margin);
  grown.extend(box.upper + margin);
  return grown;
}

Placement placement_of(const Parameters& parameters) {
  return parameters.choice("placement") == "ends" ? Placement::kEnds : Placement::kVoxels;
}

GridFrame level_frame(const Box& box, std::int64_t resolution, Placement placement) {
  const std::int64_t last = placement == Placement::kEnds ? 1 : 0;  // a sample that begins no voxel of the box
  GridFrame frame = voxel_frame(box, resolution - last);            // refuses voxels without digits
  for (int axis = 0; axis < 3; ++axis) {
    const double voxels = box.extent()[axis] / frame.voxel_size;
    frame.dims[axis] = std::max<std::int64_t>(2, static_cast<std::int64_t>(std::ceil(voxels * (1 - 1e-9))) + last);
  }
  frame.origin = box.center() - 0.5 * frame.voxel_size * frame.dims.cast<double>();
  return frame;
}

}  // namespace voxcarve
