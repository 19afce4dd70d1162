#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "common/run/errors.h"
#include "experiments/cli/checks.h"
#include "experiments/cli/commands.h"
#include "experiments/cli/session.h"
#include "experiments/render/render.h"
#include "experiments/runner/table.h"

namespace voxcarve {

namespace {

struct Options {
  CommonOptions common;
  std::vector<std::string> shapes;
  std::vector<std::string> captions;
  std::string output;
  bool separate = false;
  RenderOptions render;
};

void render(const Options& options) {
  if (options.captions.size() > options.shapes.size()) throw ParameterError("there are more captions than shapes");
  Session session(options.common);
  std::vector<RenderItem> items;
  for (std::size_t index = 0; index < options.shapes.size(); ++index) {
    const Model model = session.open(options.shapes[index]);
    RenderItem item{reference_surface(model, session.context()), ""};
    item.caption =
        index < options.captions.size()
            ? options.captions[index]
            : model.name + "\n" + with_thousands(static_cast<long long>(item.shape.triangles.size())) + " triangles";
    items.push_back(std::move(item));
  }
  RenderOptions how = options.render;
  how.common_camera = !options.separate;
  render_meshes(items, how, options.output);
  if (options.common.json) {
    print_json({{"output", options.output}, {"shapes", options.shapes}});
  } else {
    fmt::print("{} shape{} -> {}\n", items.size(), items.size() == 1 ? "" : "s", options.output);
  }
}

}  // namespace

void add_render_command(CLI::App& app) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("render", "draw meshes side by side, without a window system");
  command->add_option("SHAPE", options->shapes, "mesh or volume files, or model:NAME")->required();
  command->add_option("-o,--output", options->output, "PNG file")->required();
  command->add_option("--caption", options->captions,
                      "text under a panel, one a shape in their order (default: name and triangle count)");
  command->add_flag("--wireframe", options->render.wireframe, "draw the triangles' edges");
  command->add_flag("--separate", options->separate, "frame every shape by itself (default: one camera for all)");
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
  command->add_option("--up", options->render.up_axis, "axis that points up: y or z (default y)")
      ->check(CLI::IsMember({"y", "z"}));
  add_common_options(*command, options->common);
  command->callback([options] {
    options->render.panel_height = options->render.panel_width;
    render(*options);
  });
}

}  // namespace voxcarve
