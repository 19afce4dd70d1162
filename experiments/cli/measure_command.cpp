#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/run/errors.h"
#include "experiments/cli/checks.h"
#include "experiments/cli/commands.h"
#include "experiments/cli/json_text.h"
#include "experiments/cli/session.h"
#include "experiments/runner/comparison.h"
#include "metrics/metric.h"
#include "metrics/volume.h"

namespace voxcarve {

namespace {

using Json = nlohmann::ordered_json;

struct MeasureOptions {
  CommonOptions common;
  std::string a;
  std::string b;
  MetricOptions metrics;
};

struct Measured {
  TriangleSoup surface;
  std::optional<BinaryVolume> volume;
  std::vector<Measurement> measurements;
};

void append(std::vector<Measurement>& all, const std::vector<Measurement>& more) {
  all.insert(all.end(), more.begin(), more.end());
}

Measured measure_one(Session& session, const std::string& input, const MetricOptions& options) {
  Model model = session.open(input);
  session.announce(model.name);
  Measured measured;
  if (model.kind() != ModelKind::kImage) {  // an image has no surface; its voxels are measured below
    measured.surface = reference_surface(model, session.context());
    measured.measurements = measure_shape(measured.surface, options, session.context());
  }
  if (auto* volume = std::get_if<BinaryVolume>(&model.shape)) {
    measured.volume = std::move(*volume);
  } else if (const auto* scalar = std::get_if<ScalarVolume>(&model.shape)) {
    measured.volume = thresholded(scalar->grid, scalar->iso_value);
  } else if (options.regularity_radius) {
    session.print_notices({"--radius counts voxels, and " + model.name + " has none"});
  }
  if (measured.volume) append(measured.measurements, measure_volume(*measured.volume, options, session.context()));
  return measured;
}

/// What can be said of a pair: of two volumes voxel by voxel, of two surfaces their distances.
std::vector<Measurement> measure_both(Session& session, const Measured& a, const Measured& b,
                                      const MeasureOptions& options) {
  std::vector<Measurement> pair;
  const bool volumes = a.volume && b.volume;
  if (volumes) pair = measure_volume_pair(*a.volume, *b.volume, session.context());
  if (!a.surface.empty() && !b.surface.empty()) {
    append(pair, measure_pair(a.surface, b.surface, options.metrics, session.context()));
  } else if (!volumes) {
    throw InputError("a pair needs two surfaces or two volumes; " + (a.surface.empty() ? options.a : options.b) +
                     " has no surface");
  }
  return pair;
}

std::string unit_of(const std::string& key) {
  for (const auto* columns : {&shape_columns(), &pair_columns(), &volume_columns(), &volume_pair_columns()}) {
    for (const MetricColumn& column : *columns) {
      if (column.key == key) return column.unit;
    }
  }
  return "";
}

void add_rows(Table& table, const std::vector<Measurement>& measurements, const std::string& prefix) {
  for (const Measurement& measurement : measurements) {
    const std::string unit = unit_of(measurement.key);
    table.rows.push_back({prefix + measurement.key, exact_text(measurement.value), unit});
  }
}

void measure(const MeasureOptions& options) {
  Session session(options.common);
  const Measured a = measure_one(session, options.a, options.metrics);
  Json json = {{"a", to_json(a.measurements)}};
  Table table{{"metric", "value", "unit"}, {}};
  add_rows(table, a.measurements, options.b.empty() ? "" : "a.");
  if (!options.b.empty()) {
    const Measured b = measure_one(session, options.b, options.metrics);
    session.announce("pair");
    const std::vector<Measurement> pair = measure_both(session, a, b, options);
    json["b"] = to_json(b.measurements);
    json.update(to_json(pair));
    add_rows(table, b.measurements, "b.");
    add_rows(table, pair, "");
  }
  if (options.common.json) {
    print_json(json);
  } else {
    fmt::print("{}", to_text(table));
  }
}

}  // namespace

void add_measure_command(CLI::App& app) {
  auto options = std::make_shared<MeasureOptions>();
  CLI::App* command =
      app.add_subcommand("measure", "metrics of one shape, or of a pair: A is the reference (the input), B the result");
  command->add_option("A", options->a, "a shape: a file or model:NAME")->required();
  command->add_option("B", options->b, "a second shape to measure against A");
  command
      ->add_option("--error", options->metrics.hausdorff_error,
                   "width of the certified Hausdorff interval, as a share of A's diagonal (default 1e-3)")
      ->check(in_range(1e-9, 1.0));
  command->add_flag("!--no-visible", options->metrics.visible,
                    "leave out the distances of the visible surface, which cost seconds where much is hidden");
  command
      ->add_option("--view-directions", options->metrics.view_directions,
                   "directions that visibility is decided from (default 128)")
      ->check(in_range(2, 100000));
  command
      ->add_option("--radius", options->metrics.regularity_radius,
                   "voxels: also count the voxels of volumes and images that are irregular for a ball of this radius")
      ->check(in_range(0, 1000));
  command->add_option("--rays", options->metrics.rays, "rays of the symmetric difference (default 16384)")
      ->check(in_range(64, 1 << 30));
  command
      ->add_option("--samples", options->metrics.distance_samples,
                   "samples a side for mean and RMS distance (default 20000)")
      ->check(in_range(1, 1 << 30));
  add_common_options(*command, options->common);
  command->callback([options] { measure(*options); });
}

}  // namespace voxcarve
