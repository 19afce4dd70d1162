#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "common/run/errors.h"
#include "common/run/text.h"
#include "experiments/cli/checks.h"
#include "experiments/cli/commands.h"
#include "experiments/cli/hierarchy_panels.h"
#include "experiments/cli/level_files.h"
#include "experiments/cli/session.h"
#include "experiments/render/irregularity.h"
#include "experiments/render/render.h"
#include "experiments/runner/table.h"

namespace voxcarve {

namespace {

using Json = nlohmann::ordered_json;

struct Options {
  CommonOptions common;
  std::vector<std::string> shapes;
  std::vector<std::string> captions;
  std::string output;
  bool separate = false;
  RenderOptions render;

  bool volume = false;
  std::string slice;
  bool distance = false;
  std::string map;             ///< "grey", "cyclic" or "", which chooses
  std::vector<double> window;  ///< two values or none
  double period = 0;           ///< 0: the default
  bool contour = false;
  std::optional<double> irregular;  ///< radius in voxels

  HierarchyOptions hierarchy;
  std::optional<double> view_angle;  ///< degrees
};

constexpr double kAssemblyViewAngle = 50;  ///< degrees; rows that go away want perspective

/// Refuses options that have nothing to act on, before anything is opened.
void check_options(const Options& options) {
  if (options.captions.size() > options.shapes.size()) throw ParameterError("there are more captions than shapes");
  const bool slice = !options.slice.empty() || options.irregular;
  const auto indices = std::ranges::count_if(options.shapes, is_levels_index);
  check_hierarchy_options(options.hierarchy, options.shapes.size(), static_cast<std::size_t>(indices));
  if (indices > 0 && slice) throw ParameterError("an index of levels has no voxels to slice");
  if (options.hierarchy.layered && options.render.wireframe)
    throw ParameterError("--layered draws no edges; leave out --wireframe");
  if (slice && options.volume) throw ParameterError("--slice and --volume exclude each other; draw two pictures");
  const bool cyclic = options.map == "cyclic" || (options.map.empty() && options.distance);
  const auto only_with = [](bool given, bool sensible, const char* option, const char* with) {
    if (given && !sensible) throw ParameterError(std::string(option) + " has a meaning with " + with + " only");
  };
  only_with(options.distance, slice, "--distance", "--slice");
  only_with(!options.map.empty(), slice, "--map", "--slice");
  only_with(!options.window.empty(), slice, "--window", "--slice");
  only_with(options.period > 0, slice, "--period", "--slice");
  only_with(options.contour, slice, "--contour", "--slice");
  if (options.irregular && (options.distance || !options.map.empty() || !options.window.empty()))
    throw ParameterError("--irregular has colours of its own; leave out --distance, --map and --window");
  only_with(slice && !options.window.empty(), !cyclic, "--window", "--map grey");
  only_with(slice && options.period > 0, cyclic, "--period", "--map cyclic");
  if (options.window.size() == 2 && !(options.window[0] < options.window[1]))
    throw ParameterError("--window: the first value must be less than the second");
}

std::string dims_text(const GridFrame& frame) {
  return with_thousands(frame.dims[0]) + " x " + with_thousands(frame.dims[1]) + " x " + with_thousands(frame.dims[2]);
}

Json dims_json(const GridFrame& frame) {
  return {frame.dims[0], frame.dims[1], frame.dims[2]};
}

/// Names a method that makes a volume of it.
[[noreturn]] void refuse_without_voxels(const Model& model, const std::string& input) {
  const char* method = model.kind() == ModelKind::kImplicitSolid ? "he-lowpass" : "nooruddin-turk";
  throw ParameterError(model.name + " is " + with_article(to_string(model.kind())) +
                       ", which has no voxels to slice; make a volume of it first: voxcarve run " + method + " '" +
                       input + "' -o VOLUME.nrrd");
}

/// The volume as a binary one: the model's own, or its threshold.
BinaryVolume thresholded(const ScalarVolume& volume) {
  BinaryVolume binary(volume.grid.frame);
  std::ranges::transform(volume.grid.values, binary.values.begin(),
                         [&](float value) { return static_cast<std::uint8_t>(value >= volume.iso_value); });
  return binary;
}

/// What slices are taken, and where: in one plane for all volumes, the first one's, unless they are separate.
struct SliceRequest {
  SlicePosition position;
  std::optional<double> plane;  ///< model units; once the first volume is there

  std::int64_t index_in(const GridFrame& frame, const std::string& name, bool separate) {
    if (plane && !separate) return slice_at(position.axis, *plane, frame, name);
    const std::int64_t index = slice_index(position, frame, name);
    plane = frame.center(Index3::Constant(index))[position.axis];
    return index;
  }
};

Panel slice_panel(const Model& model, const std::string& input, const Options& options, SliceRequest& request,
                  RunContext& context) {
  const SlicePosition& position = request.position;
  const auto* binary = std::get_if<BinaryVolume>(&model.shape);
  const auto* scalar = std::get_if<ScalarVolume>(&model.shape);
  if (binary == nullptr && scalar == nullptr) refuse_without_voxels(model, input);
  const GridFrame& frame = binary != nullptr ? binary->frame : scalar->grid.frame;
  const std::int64_t index = request.index_in(frame, model.name, options.separate);
  const SliceField shape = binary != nullptr ? extract_slice(*binary, position.axis, index)
                                             : extract_slice(scalar->grid, position.axis, index);
  const double iso_value = binary != nullptr ? 0.5 : static_cast<double>(scalar->iso_value);

  SliceField field = shape;
  SliceColors colors;
  if (options.distance) {
    field =
        distance_slice(binary != nullptr ? *binary : thresholded(*scalar), position.axis, index, model.name, context);
    colors.map = ColorMap::kCyclic;
    colors.mark_zero = true;
    colors.high = static_cast<double>(std::ranges::max(field.values));
  } else if (scalar != nullptr) {
    const auto [low, high] = std::ranges::minmax(scalar->grid.values);
    colors.low = static_cast<double>(low);
    colors.high = static_cast<double>(high);
  }
  if (!options.map.empty()) colors.map = options.map == "grey" ? ColorMap::kGrey : ColorMap::kCyclic;
  if (!options.window.empty()) std::tie(colors.low, colors.high) = std::pair(options.window[0], options.window[1]);
  if (options.period > 0) colors.period = options.period;
  SlicePicture picture = options.irregular ? irregularity_slice(binary != nullptr ? *binary : thresholded(*scalar),
                                                                position.axis, index, *options.irregular, context)
                                           : color_slice(field, colors);
  if (options.contour) add_contour(picture, shape, iso_value);

  const std::string axis(1, "xyz"[position.axis]);
  Json description = {{"input", input},
                      {"kind", "slice"},
                      {"shows", options.irregular  ? "irregularity"
                                : options.distance ? "distance"
                                                   : "values"},
                      {"axis", axis},
                      {"index", index},
                      {"slices", frame.dims[position.axis]},
                      {"voxels", dims_json(frame)}};
  if (options.irregular) {
    description["radius"] = *options.irregular;
  } else if (colors.map == ColorMap::kGrey) {
    description["map"] = "grey";
    description["window"] = {colors.low, colors.high};
  } else {
    description["map"] = "cyclic";
    description["period"] = colors.period;
  }
  if (options.contour || options.distance) description["iso_value"] = iso_value;
  const std::string caption =
      model.name + "\n" + (options.distance ? "distance, " : "") +
      (options.irregular ? "irregular at radius " + format_real(*options.irregular) + ", " : "") + "slice " + axis +
      " = " + std::to_string(index) + " of " + std::to_string(frame.dims[position.axis]);
  return {{std::move(picture), caption}, std::move(description)};
}

Panel volume_panel(Model model, const std::string& input, RunContext& context) {
  if (model.kind() == ModelKind::kImage)
    throw ParameterError(model.name + " is an image, which --volume cannot draw; use --slice z");
  const auto panel = [&](auto volume, const GridFrame& frame, double iso_value) {
    context.require_memory(static_cast<std::uint64_t>(kRayCastBytes * frame.voxels()), "drawing " + model.name);
    Json description = {{"input", input}, {"kind", "volume"}, {"voxels", dims_json(frame)}, {"iso_value", iso_value}};
    const std::string caption = model.name + "\n" + dims_text(frame) + " voxels";
    return Panel{{std::move(volume), caption}, std::move(description)};
  };
  if (auto* binary = std::get_if<BinaryVolume>(&model.shape)) {
    const GridFrame frame = binary->frame;
    return panel(std::move(*binary), frame, 0.5);
  }
  auto& scalar = std::get<ScalarVolume>(model.shape);
  const GridFrame frame = scalar.grid.frame;
  const auto iso_value = static_cast<double>(scalar.iso_value);
  return panel(std::move(scalar), frame, iso_value);
}

Panel mesh_panel(const Model& model, const std::string& input, RunContext& context) {
  TriangleSoup surface = reference_surface(model, context);
  const auto triangles = static_cast<long long>(surface.triangles.size());
  Json description = {{"input", input}, {"kind", "mesh"}, {"triangles", triangles}};
  return {{std::move(surface), model.name + "\n" + with_thousands(triangles) + " triangles"}, std::move(description)};
}

Panel make_panel(const std::string& input, const Options& options, RenderOptions& how, SliceRequest& request,
                 Session& session) {
  if (is_levels_index(input)) {
    if (options.hierarchy.assembly.empty()) return level_panel(input, options.hierarchy, session.context());
    const auto caption = options.captions.empty() ? std::nullopt : std::optional(options.captions.front());
    return assembly_panel(input, options.hierarchy, caption, how, session.context());
  }
  Model model = session.open(input);
  const bool image = model.kind() == ModelKind::kImage && !options.volume;
  if (!options.slice.empty() || options.irregular || image)
    return slice_panel(model, input, options, request, session.context());
  const bool has_voxels = model.kind() != ModelKind::kSoup && model.kind() != ModelKind::kImplicitSolid;
  if (options.volume && has_voxels) return volume_panel(std::move(model), input, session.context());
  return mesh_panel(model, input, session.context());
}

void render(const Options& options) {
  check_options(options);
  SliceRequest request;
  if (!options.slice.empty()) request.position = parse_slice(options.slice);
  Session session(options.common);
  std::vector<RenderItem> items;
  Json panels = Json::array();
  bool draws_volume = false;
  RenderOptions how = options.render;
  how.common_camera = !options.separate;
  how.cancellation = session.context().cancellation;
  how.view_angle =
      options.view_angle.value_or(options.hierarchy.assembly.empty() ? how.view_angle : kAssemblyViewAngle);
  for (std::size_t index = 0; index < options.shapes.size(); ++index) {
    Panel panel = make_panel(options.shapes[index], options, how, request, session);
    if (index < options.captions.size()) panel.item.caption = options.captions[index];
    draws_volume |= panel.description["kind"] == "volume";
    items.push_back(std::move(panel.item));
    panels.push_back(std::move(panel.description));
  }
  if (options.volume && !draws_volume)
    throw ParameterError("--volume: none of the shapes is a volume; make one of a mesh with voxcarve run");
  if (!options.slice.empty() && !captions_available())
    session.print_notices({"this build has no rendering, so the slices have no captions"});
  render_meshes(items, how, options.output);
  session.print_timings(session.context().timings());
  if (options.common.json) {
    print_json({{"output", options.output}, {"shapes", options.shapes}, {"panels", panels}});
  } else {
    if (!options.hierarchy.assembly.empty()) fmt::print("{}", assembly_text(panels.front()));
    fmt::print("{} shape{} -> {}\n", items.size(), items.size() == 1 ? "" : "s", options.output);
  }
}

void add_volume_options(CLI::App& command, Options& options) {
  command.add_option(
      "--slice", options.slice,
      "draw a slice of volumes instead (images always are): x, y or z, with a voxel index from 0 or a share of the "
      "extent: "
      "z=12, z=50% (default 50%), of the first volume; others in the same plane, or with --separate each "
      "by itself. Seen from +x, -y, +z; high values are light, interior white");
  command
      .add_option("--window", options.window,
                  "slice: values that are black and white, as LOW,HIGH in the volume's "
                  "units (default: its least and greatest, 0 and 1 of a binary one)")
      ->delimiter(',')
      ->expected(2)
      ->check(in_range(-3e38, 3e38));
  command.add_flag("--distance", options.distance,
                   "slice: show the exact Euclidean distance of exterior voxels to the interior, in voxels; the "
                   "interior is dark grey");
  command
      .add_option("--map", options.map,
                  "slice: colours, grey or cyclic: blue over green to red, once a period (default: cyclic with "
                  "--distance, else grey)")
      ->check(CLI::IsMember({"grey", "cyclic"}));
  command
      .add_option("--period", options.period,
                  "slice: of the cyclic colours, in voxels with --distance, else in the volume's units (default 16)")
      ->check(in_range(1e-30, 3e38));
  command.add_flag("--contour", options.contour, "slice: draw the line where the volume crosses its iso-value");
  command
      .add_option("--irregular", options.irregular,
                  "slice (default z): show what is irregular for a ball of this radius in voxels: the core black, the "
                  "anticore white, inner-irregular voxels red, outer-irregular ones green")
      ->check(in_range(0, 1000));
  command.add_flag("--volume", options.volume,
                   "draw volumes by casting rays into their voxels, opaque from the iso-value on (--iso; 0.5 of a "
                   "binary one), instead of their isosurface; meshes beside them stay meshes");
}

}  // namespace

void add_render_command(CLI::App& app) {
  auto options = std::make_shared<Options>();
  CLI::App* command =
      app.add_subcommand("render", "draw meshes, volumes and slices side by side, without a window system");
  command
      ->add_option("SHAPE", options->shapes,
                   "mesh or volume files, model:NAME, or the index.json of voxcarve run --levels")
      ->required();
  command->add_option("-o,--output", options->output, "PNG file")->required();
  command->add_option("--caption", options->captions,
                      "text under a panel, one a shape in their order (default: its name and size)");
  command->add_flag("--wireframe", options->render.wireframe, "draw the triangles' edges");
  command->add_flag("--separate", options->separate,
                    "frame every shape by itself (default: one camera, or one plane and scale of slices, for all)");
  command->add_option("--columns", options->render.columns, "panels in a row (default: chosen by their number)")
      ->check(in_range(1, 100));
  command->add_option("--size", options->render.panel_width, "width and height of a panel in pixels (default 800)");
  command
      ->add_option("--crease", options->render.crease_angle,
                   "dihedral angle in degrees above which an edge is sharp (default 40)")
      ->check(in_range(0, 180));
  command->add_option("--azimuth", options->render.azimuth, "camera: degrees from the front (default 30)");
  command->add_option("--elevation", options->render.elevation, "camera: degrees above the ground (default 20)")
      ->check(in_range(-90, 90));
  command
      ->add_option("--view-angle", options->view_angle,
                   "camera: vertical opening in degrees (default 24, little perspective; 50 with --assembly)")
      ->check(in_range(1, 120));
  command->add_flag("--aliased", options->render.aliased,
                    "take one sample a pixel of meshes and volumes, not the mean of four");
  command
      ->add_option("--magnify", options->render.magnification,
                   "draw meshes and volumes so many times smaller and every pixel as a square (default 1)")
      ->check(in_range(1, kMaxMagnification));
  command->add_option("--up", options->render.up_axis, "axis that points up: y or z (default y)")
      ->check(CLI::IsMember({"y", "z"}));
  add_volume_options(*command, *options);
  add_hierarchy_options(*command, options->hierarchy);
  add_common_options(*command, options->common);
  command->callback([options] {
    options->render.panel_height = options->render.panel_width;
    render(*options);
  });
}

}  // namespace voxcarve
