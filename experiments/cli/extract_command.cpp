#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "common/mesh/io/mesh_io.h"
#include "common/mesh/topology.h"
#include "common/run/errors.h"
#include "common/run/text.h"
#include "experiments/cli/checks.h"
#include "experiments/cli/commands.h"
#include "experiments/cli/session.h"
#include "methods/hagbi_elsana/solid_distance.h"
#include "methods/hagbi_elsana/stream_file.h"

namespace voxcarve {

namespace {

using Json = nlohmann::ordered_json;

struct ExtractOptions {
  CommonOptions common;
  std::string stream;
  std::string output;
  std::int64_t vertices = 0;
  std::int64_t triangles = 0;
  std::int64_t genus = -1;
  std::int64_t components = 0;
  std::int64_t step = -1;
  std::int64_t level = -1;
  double distance = -1;
};

struct Extracted {
  std::uint32_t step = 0;
  TriangleSoup surface;
  SurfaceTopology topology;
};

Extracted extract(const CarvingStream& stream, std::uint32_t step, const RunContext& context) {
  Extracted result{step, stream.extract(step, &context), {}};
  result.topology = analyze_topology(result.surface);
  return result;
}

/// The finest level within all bounds. Genus and components rise and fall along the stream: every level is looked at,
/// from the finest that the counts allow on down.
Extracted finest_within(const CarvingStream& stream, const ExtractOptions& options, RunContext& context) {
  const auto& levels = stream.levels();
  const auto fits = [&](std::uint32_t step) {
    return (options.vertices == 0 || stream.vertices(step) <= options.vertices) &&
           (options.triangles == 0 || stream.triangles(step) <= options.triangles);
  };
  Stage stage(context, "levels", std::ssize(levels));
  for (auto level = levels.rbegin(); level != levels.rend(); ++level) {
    stage.advance(1);
    if (!fits(*level)) continue;
    if (options.genus < 0 && options.components == 0) return extract(stream, *level, context);
    Extracted candidate = extract(stream, *level, context);
    const SurfaceTopology& topology = candidate.topology;
    if ((options.genus < 0 || (topology.genus && *topology.genus <= options.genus)) &&
        (options.components == 0 || topology.components <= options.components)) {
      return candidate;
    }
  }
  throw MethodFailure("no level of the stream is within these bounds: the first has " +
                      with_thousands(stream.vertices(0)) + " vertices and " + with_thousands(stream.triangles(0)) +
                      " triangles");
}

Extracted choose(const CarvingStream& stream, const ExtractOptions& options, RunContext& context) {
  if (options.step >= 0) {
    if (options.step > stream.last_step()) {
      throw ParameterError("there is no step " + std::to_string(options.step) + ": the last is " +
                           std::to_string(stream.last_step()));
    }
    return extract(stream, static_cast<std::uint32_t>(options.step), context);
  }
  if (options.level >= 0) {
    if (options.level >= std::ssize(stream.levels())) {
      throw ParameterError("there is no level " + std::to_string(options.level) + ": the stream has " +
                           std::to_string(stream.levels().size()) + ", numbered from 0, the hull");
    }
    return extract(stream, stream.levels()[static_cast<std::size_t>(options.level)], context);
  }
  if (options.distance >= 0) {
    const TriangleSoup last = stream.extract(stream.last_step(), &context);
    const auto step = step_within(stream, options.distance * bounds(last).diagonal(), context);
    if (!step) throw MethodFailure("voids that were left shut reach farther from the model than that");
    return extract(stream, *step, context);
  }
  return finest_within(stream, options, context);
}

void run(const ExtractOptions& options) {
  if (!options.output.empty() && !mesh_format(options.output)) {
    throw ParameterError(options.output + ": its extension names no mesh format; use PLY, OBJ, OFF or STL");
  }
  Session session(options.common);
  session.announce("extract");
  const CarvingStream stream = read_stream(options.stream, session.context());
  const Extracted level = choose(stream, options, session.context());
  if (!options.output.empty()) write_mesh(level.surface, options.output);
  const auto last = stream.last_step();
  Json report = {{"program", "voxcarve " + version()},
                 {"stream", options.stream},
                 {"parameters", stream.provenance()},
                 {"steps", last},
                 {"levels", stream.levels().size()},
                 {"hull", {{"vertices", stream.vertices(0)}, {"triangles", stream.triangles(0)}}},
                 {"model", {{"vertices", stream.vertices(last)}, {"triangles", stream.triangles(last)}}},
                 {"step", level.step},
                 {"vertices", stream.vertices(level.step)},
                 {"triangles", level.surface.triangles.size()},
                 {"components", level.topology.components},
                 {"genus", level.topology.genus ? Json(*level.topology.genus) : Json(level.topology.genus_reason)}};
  if (!options.output.empty()) report["output"] = options.output;
  session.print_timings(session.context().timings());
  if (options.common.json) {
    print_json(report);
    return;
  }
  fmt::print("step {} of {}: {} distinct vertices, {} triangles, {} component{}, genus {}{}\n", level.step, last,
             with_thousands(stream.vertices(level.step)),
             with_thousands(static_cast<std::int64_t>(level.surface.triangles.size())), level.topology.components,
             level.topology.components == 1 ? "" : "s",
             level.topology.genus ? std::to_string(*level.topology.genus) : level.topology.genus_reason,
             options.output.empty() ? "" : " -> " + options.output);
}

}  // namespace

void add_extract_command(CLI::App& app) {
  auto options = std::make_shared<ExtractOptions>();
  CLI::App* command = app.add_subcommand("extract", "take a level out of a carving stream");
  command->add_option("STREAM", options->stream, "a .vcs file that `voxcarve run hagbi-elsana -o` wrote")->required();
  command->add_option("-o,--output", options->output,
                      "file for the level: PLY, OBJ, OFF or STL (without it, the level is only described)");
  CLI::Option* vertices =
      command->add_option("--vertices", options->vertices, "the finest level with at most this many distinct vertices")
          ->check(in_range(1, kLargestCount));
  CLI::Option* triangles =
      command->add_option("--triangles", options->triangles, "... with at most this many triangles")
          ->check(in_range(1, kLargestCount));
  CLI::Option* genus = command->add_option("--genus", options->genus, "... with at most this many handles in all")
                           ->check(in_range(0, kLargestCount));
  CLI::Option* components =
      command->add_option("--components", options->components, "... with at most this many surface components")
          ->check(in_range(1, kLargestCount));
  CLI::Option* distance =
      command
          ->add_option("--distance", options->distance,
                       "the coarsest level whose solid lies within this distance of the model, as a share of the "
                       "model's diagonal")
          ->check(in_range(0, 10));
  CLI::Option* step = command->add_option("--step", options->step, "the solid after this step; 0 is the hull")
                          ->check(in_range(0, kLargestCount));
  CLI::Option* level = command->add_option("--level", options->level, "the level of this number; 0 is the hull")
                           ->check(in_range(0, kLargestCount));
  for (CLI::Option* bound : {vertices, triangles, genus, components}) {
    bound->excludes(distance)->excludes(step)->excludes(level);
  }
  distance->excludes(step)->excludes(level);
  step->excludes(level);
  add_common_options(*command, options->common);
  command->callback([options] { run(*options); });
}

}  // namespace voxcarve
