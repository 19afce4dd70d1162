#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/mesh/io/mesh_io.h"
#include "common/mesh/topology.h"
#include "common/run/errors.h"
#include "common/run/text.h"
#include "experiments/cli/checks.h"
#include "experiments/cli/commands.h"
#include "experiments/cli/json_text.h"
#include "experiments/cli/session.h"
#include "experiments/runner/comparison.h"
#include "methods/hagbi_elsana/solid_distance.h"
#include "methods/hagbi_elsana/stream_file.h"
#include "methods/registry.h"

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
  std::uint32_t closed_components = 0;
};

Extracted extract(const CarvingStream& stream, std::uint32_t step, const RunContext& context) {
  Extracted result{step, stream.extract(step, &context), {}, 0};
  result.topology = analyze_topology(result.surface);
  return result;
}

/// Handles of a closed, oriented 2-manifold whose every vertex is used, as levels are: by Euler's formula, where each
/// triangle has three halves of an edge.
std::int64_t handles(const TriangleSoup& level) {
  DisjointSets components(level.positions.size());
  for (const Triangle& t : level.triangles) {
    components.join(t[0], t[1]);
    components.join(t[0], t[2]);
  }
  std::int64_t count = 0;
  for (std::uint32_t v = 0; v < level.positions.size(); ++v) count += components.find(v) == v;
  const std::int64_t characteristic = std::ssize(level.positions) - std::ssize(level.triangles) / 2;
  return count - characteristic / 2;
}

/// The finest level within all bounds, or the hull. Vertices, triangles and components of the closed set are known of
/// every level; genus rises and falls along the stream, so levels are looked at from the finest of the others on down.
Extracted finest_within(const CarvingStream& stream, const ExtractOptions& options, RunContext& context) {
  const std::vector<std::uint32_t> components = stream.closed_components(context);
  std::vector<std::uint32_t> candidates;
  for (const std::uint32_t step : stream.levels()) {
    if ((options.vertices == 0 || stream.vertices(step) <= options.vertices) &&
        (options.triangles == 0 || stream.triangles(step) <= options.triangles) &&
        (options.components == 0 || components[step] <= options.components)) {
      candidates.push_back(step);
    }
  }
  std::ranges::reverse(candidates);
  if (options.genus < 0 && !candidates.empty()) return extract(stream, candidates.front(), context);
  Stage stage(context, "levels", std::ssize(candidates));
  const std::int64_t together = 8 * std::max(context.threads, 1);
  for (std::int64_t first = 0; first < std::ssize(candidates); first += together) {
    const std::int64_t last = std::min(first + together, std::ssize(candidates));
    std::vector<std::uint8_t> fits(static_cast<std::size_t>(last - first), 0);
    parallel_for(context, first, last, 1, [&](std::int64_t i, std::int64_t) {
      const TriangleSoup level = stream.extract(candidates[static_cast<std::size_t>(i)]);
      fits[static_cast<std::size_t>(i - first)] = handles(level) <= options.genus;
    });
    const auto found = std::ranges::find(fits, 1);
    if (found != fits.end()) {
      return extract(stream, candidates[static_cast<std::size_t>(first + (found - fits.begin()))], context);
    }
    stage.advance(last - first);
  }
  return extract(stream, 0, context);
}

/// The parameters of the run that made a stream, as `run --json` shows them; what is none of this program's stays text.
Json parameters_of(const CarvingStream& stream) {
  const std::vector<std::string> assignments = split(stream.provenance(), ' ');
  try {
    const ParameterSchema& schema = find_method("hagbi-elsana").info().parameters;
    const Parameters parameters = Parameters::parse(schema, assignments, "the stream");
    Json json = Json::object();
    for (const std::string& assignment : assignments) {
      const std::string name = assignment.substr(0, assignment.find('='));
      json[name] = to_json(parameters.values().at(name));
    }
    return json;
  } catch (const ParameterError&) {
    return stream.provenance();
  }
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
  require_folder(options.output);
  Session session(options.common);
  session.announce("extract");
  const CarvingStream stream = read_stream(options.stream, session.context());
  Extracted level = choose(stream, options, session.context());
  level.closed_components = stream.closed_components(session.context())[level.step];
  if (!options.output.empty()) write_mesh(level.surface, options.output);
  const auto last = stream.last_step();
  Json report = {{"program", "voxcarve " + version()},
                 {"stream", options.stream},
                 {"parameters", parameters_of(stream)},
                 {"steps", last},
                 {"levels", stream.levels().size()},
                 {"hull", {{"vertices", stream.vertices(0)}, {"triangles", stream.triangles(0)}}},
                 {"model", {{"vertices", stream.vertices(last)}, {"triangles", stream.triangles(last)}}},
                 {"step", level.step},
                 {"vertices", stream.vertices(level.step)},
                 {"triangles", level.surface.triangles.size()},
                 {"components", level.topology.components},
                 {"closed_components", level.closed_components},
                 {"genus", level.topology.genus ? Json(*level.topology.genus) : Json(level.topology.genus_reason)}};
  // The hull, of one component and genus 0, misses no other bound.
  std::vector<std::string> notices;
  const std::string missed = missed_budget(level.surface, options.triangles, options.vertices);
  if (!missed.empty()) notices.push_back(missed);
  report["notices"] = notices;
  if (!options.output.empty()) report["output"] = options.output;
  session.print_notices(notices);
  session.print_timings(session.context().timings());
  if (options.common.json) {
    print_json(report);
    return;
  }
  fmt::print("step {} of {}: {} distinct vertices, {} triangles, {} solid{} in {} surface component{}, genus {}{}\n",
             level.step, last, with_thousands(stream.vertices(level.step)),
             with_thousands(static_cast<std::int64_t>(level.surface.triangles.size())), level.closed_components,
             level.closed_components == 1 ? "" : "s", level.topology.components,
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
      command
          ->add_option("--vertices", options->vertices,
                       "the finest level with at most this many distinct vertices (where there is none: the hull)")
          ->check(in_range(1, kLargestCount));
  CLI::Option* triangles =
      command->add_option("--triangles", options->triangles, "... with at most this many triangles")
          ->check(in_range(1, kLargestCount));
  CLI::Option* genus = command->add_option("--genus", options->genus, "... with at most this many handles in all")
                           ->check(in_range(0, kLargestCount));
  CLI::Option* components =
      command
          ->add_option("--components", options->components,
                       "... whose solid has at most this many components (what touches in a point is one)")
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
