#include "common/volume/voxel_parameters.h"

#include <string>

#include "common/run/errors.h"
#include "common/volume/grid_passes.h"

namespace voxcarve {

std::vector<ParameterSpec> voxelization_parameters() {
  constexpr std::int64_t kFinest = 4096;
  return {
      ParameterSpec::integer("resolution", "voxels", 2, kFinest, 128,
                             "voxels along the longest side of the input's bounding box"),
      ParameterSpec::choice("classifier", {"parity", "stabbing"}, "parity",
                            "parity count (for holes and cracks) or ray stabbing (for parts that overlap; keeps the "
                            "intersection of the directions' line hulls)"),
      ParameterSpec::choice(
          "directions", {"1", "3", "13"}, "3",
          "ray directions: one axis, the three axes, or the axes and the ten face normals of the icosahedron"),
      ParameterSpec::choice("axis", {"x", "y", "z"}, "y", "the axis of the rays when directions=1"),
      ParameterSpec::integer("settle_sweeps", "sweeps", 0, 1000, 4,
                             "parity: how often voxels with split votes, fewer than half of the directions for either "
                             "class, take the class of most neighbours; 0 is the paper's rule alone"),
      ParameterSpec::toggle("stab_validity", false,
                            "stabbing: rays with an odd number of crossings do not vote (a test that Kolb and John "
                            "ascribe to the method)"),
      ParameterSpec::integer("supersampling", "samples", 1, 3, 1,
                             "samples along each side of a voxel; more give smoother densities, and cost their cube"),
      ParameterSpec::choice("kernel", {"box", "gaussian"}, "box",
                            "how samples become a density: the mean over the voxel, or a Gaussian of standard "
                            "deviation 0.7 voxels that reaches 2 voxels"),
  };
}

VoxelizeOptions voxelize_options(const Parameters& parameters) {
  VoxelizeOptions options;
  options.classifier = classifier_from(parameters.choice("classifier"));
  options.directions = std::stoi(parameters.choice("directions"));
  options.settle_sweeps = static_cast<int>(parameters.integer("settle_sweeps"));
  options.axis = parameters.choice("axis")[0] - 'x';
  options.stab_validity = parameters.toggle("stab_validity");
  return options;
}

SupersamplingOptions supersampling_options(const Parameters& parameters) {
  return {static_cast<int>(parameters.integer("supersampling")), filter_kernel_from(parameters.choice("kernel"))};
}

bool is_binary(const SupersamplingOptions& options) {
  return options.samples == 1 && options.kernel == FilterKernel::kBox;
}

namespace {

void add_notices(const VoxelizeReport& report, RunContext& context) {
  for (const VoxelizeReport::Axis& axis : report.axes) {
    if (axis.invalid_columns == 0) continue;
    context.notice(std::string("along ") + "xyz"[axis.axis] + ", " + std::to_string(axis.invalid_columns) + " of " +
                   std::to_string(axis.columns) +
                   " voxel columns that meet the surface cross it an odd number of times and do not vote");
  }
  if (report.settled_voxels > 0) {
    context.notice(std::to_string(report.settled_voxels) +
                   " voxels with few and split votes took the class of most of their neighbours");
  }
}

}  // namespace

DensityVolume voxelize_model_density(const TriangleSoup& soup, const Parameters& parameters, RunContext& context) {
  const GridFrame frame = voxel_frame(bounds(soup), parameters.integer("resolution"));
  VoxelizeReport report;
  DensityVolume volume =
      voxelize_density(soup, frame, voxelize_options(parameters), supersampling_options(parameters), context, &report);
  add_notices(report, context);
  return volume;
}

BinaryVolume voxelize_model(const TriangleSoup& soup, const Parameters& parameters, double threshold,
                            RunContext& context) {
  if (!is_binary(supersampling_options(parameters)))
    return thresholded(voxelize_model_density(soup, parameters, context), static_cast<float>(threshold), context);
  const GridFrame frame = voxel_frame(bounds(soup), parameters.integer("resolution"));
  VoxelizeReport report;
  BinaryVolume volume = voxelize(soup, frame, voxelize_options(parameters), context, &report);
  add_notices(report, context);
  return volume;
}

}  // namespace voxcarve
