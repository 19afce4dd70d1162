// Panels of `voxcarve render` that show a hierarchy which `voxcarve run --levels` wrote.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "common/run/context.h"
#include "experiments/render/render.h"

namespace CLI {
class App;
}

namespace voxcarve {

/// A panel and what --json says of it.
struct Panel {
  RenderItem item;
  nlohmann::ordered_json description;
};

struct HierarchyOptions {
  std::optional<std::int64_t> level;
  bool layered = false;
  std::string assembly;  ///< "" for none, "N" or "COLUMNSxROWS"
  std::optional<double> assembly_pixels;
};

/// Adds --level, --layered and those of assemblies.
void add_hierarchy_options(CLI::App& command, HierarchyOptions& options);

/// Throws ParameterError for options that exclude each other or have nothing to act on. `indices` of the `shapes` are
/// indices of levels.
void check_hierarchy_options(const HierarchyOptions& options, std::size_t shapes, std::size_t indices);

/// One level, or its layers. Throws InputError and ParameterError.
Panel level_panel(const std::string& input, const HierarchyOptions& options, RunContext& context);

/// The assembly, for which `render` gets its frame. The caption has to be known before, since it takes of the scene's
/// height; where there is none the panel brings its own. Throws InputError and ParameterError.
Panel assembly_panel(const std::string& input, const HierarchyOptions& options,
                     const std::optional<std::string>& caption, RenderOptions& render, RunContext& context);

/// What the terminal shows of an assembly.
std::string assembly_text(const nlohmann::ordered_json& description);

}  // namespace voxcarve
