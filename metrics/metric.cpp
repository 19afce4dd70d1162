// The registry of columns, and the two measurements that fill them.
#include "metrics/metric.h"

#include <algorithm>
#include <cmath>

#include "common/mesh/topology.h"
#include "metrics/hausdorff.h"
#include "metrics/normal_deviation.h"
#include "metrics/self_intersections.h"
#include "metrics/shape_measures.h"
#include "metrics/surface_pair.h"
#include "metrics/symmetric_difference.h"
#include "metrics/visibility.h"

namespace voxcarve {

const std::vector<MetricColumn>& shape_columns() {
  constexpr auto kNone = Direction::kNone;
  constexpr auto kLower = Direction::kLowerIsBetter;
  constexpr auto kHigher = Direction::kHigherIsBetter;
  static const std::vector<MetricColumn> columns = {
      {"vertices", "", kNone, "vertices used by triangles"},
      {"triangles", "", kNone, "triangles, degenerate ones included"},
      {"components", "", kNone, "surface components connected through shared vertices"},
      {"closed", "", kNone, "every edge has exactly two triangles"},
      {"oriented", "", kNone, "no edge is used twice in one direction"},
      {"boundary_edges", "", kLower, "edges with one triangle"},
      {"boundary_loops", "", kLower, "closed chains of boundary edges"},
      {"nonmanifold_edges", "", kLower, "edges with three triangles or more"},
      {"nonmanifold_vertices", "", kLower, "vertices whose link is not one path or cycle"},
      {"euler_characteristic", "", kNone, "vertices - edges + triangles"},
      {"genus", "", kNone, "sum over components, for closed orientable 2-manifolds"},
      {"degenerate_triangles", "", kLower, "triangles without area"},
      {"self_intersections", "", kLower, "pairs of triangles that cut through each other"},
      {"area", "model^2", kNone, "surface area"},
      {"volume", "model^3", kNone, "signed volume, for closed oriented surfaces"},
      {"bbox_diagonal", "model", kNone, "diagonal of the bounding box"},
      {"bbox.x_min", "model", kNone, "bounding box, lower x"},
      {"bbox.x_max", "model", kNone, "bounding box, upper x"},
      {"bbox.y_min", "model", kNone, "bounding box, lower y"},
      {"bbox.y_max", "model", kNone, "bounding box, upper y"},
      {"bbox.z_min", "model", kNone, "bounding box, lower z"},
      {"bbox.z_max", "model", kNone, "bounding box, upper z"},
      {"edge_length.min", "model", kNone, "shortest edge"},
      {"edge_length.mean", "model", kNone, "mean edge length"},
      {"edge_length.max", "model", kNone, "longest edge"},
      {"quality.min", "", kHigher, "least triangle quality, 2 x inradius / circumradius"},
      {"quality.mean", "", kHigher, "mean triangle quality, 1 for equilateral triangles"},
      {"solid.b0", "", kNone, "components of the solid"},
      {"solid.b1", "", kNone, "tunnels of the solid"},
      {"solid.b2", "", kNone, "voids of the solid"},
  };
  return columns;
}

const std::vector<MetricColumn>& pair_columns() {
  constexpr auto kNone = Direction::kNone;
  constexpr auto kLower = Direction::kLowerIsBetter;
  static const std::vector<MetricColumn> columns = {
      {"hausdorff.lower", "model", kLower, "symmetric Hausdorff distance, certified lower end"},
      {"hausdorff.upper", "model", kLower, "symmetric Hausdorff distance, certified upper end"},
      {"hausdorff.mean", "model", kLower, "mean distance, average of both directions, area-uniform samples"},
      {"hausdorff.rms", "model", kLower, "root mean square distance over both directions, the same samples"},
      {"hausdorff.relative_upper", "share", kLower, "hausdorff.upper by the input's bounding-box diagonal"},
      {"hausdorff.a_to_b.lower", "model", kLower, "input to output, certified lower end"},
      {"hausdorff.a_to_b.upper", "model", kLower, "input to output, certified upper end"},
      {"hausdorff.b_to_a.lower", "model", kLower, "output to input, certified lower end"},
      {"hausdorff.b_to_a.upper", "model", kLower, "output to input, certified upper end"},
      {"visible_hausdorff.lower", "model", kLower, "the same from the visible parts to the whole surfaces, lower end"},
      {"visible_hausdorff.upper", "model", kLower, "from the visible parts to the whole surfaces, certified upper end"},
      {"visible_hausdorff.mean", "model", kLower, "mean distance, samples on the visible parts"},
      {"visible_hausdorff.rms", "model", kLower, "root mean square distance, samples on the visible parts"},
      {"visible_hausdorff.relative_upper", "share", kLower, "visible_hausdorff.upper by the input's diagonal"},
      {"visible_hausdorff.a_to_b.lower", "model", kLower, "visible input to output, certified lower end"},
      {"visible_hausdorff.a_to_b.upper", "model", kLower, "visible input to output, certified upper end"},
      {"visible_hausdorff.b_to_a.lower", "model", kLower, "visible output to input, certified lower end"},
      {"visible_hausdorff.b_to_a.upper", "model", kLower, "visible output to input, certified upper end"},
      {"visible_share.a", "share", kNone, "area of the input that is visible from outside"},
      {"visible_share.b", "share", kNone, "area of the output that is visible from outside"},
      {"normal_deviation.mean", "degrees", kLower, "mean angle between the planes at samples and their nearest points"},
      {"normal_deviation.rms", "degrees", kLower, "root mean square of that angle"},
      {"normal_deviation.above_30", "share", kLower, "samples that deviate by more than 30 degrees"},
      {"normal_deviation.a_to_b.mean", "degrees", kLower, "mean angle, input to output"},
      {"normal_deviation.a_to_b.rms", "degrees", kLower, "root mean square angle, input to output"},
      {"normal_deviation.b_to_a.mean", "degrees", kLower, "mean angle, output to input"},
      {"normal_deviation.b_to_a.rms", "degrees", kLower, "root mean square angle, output to input"},
      {"visible_normal_deviation.mean", "degrees", kLower,
       "mean angle between the planes at samples and their nearest points, visible parts"},
      {"visible_normal_deviation.rms", "degrees", kLower, "root mean square of that angle, visible parts"},
      {"visible_normal_deviation.above_30", "share", kLower,
       "samples that deviate by more than 30 degrees, visible parts"},
      {"visible_normal_deviation.a_to_b.mean", "degrees", kLower, "mean angle, input to output, visible parts"},
      {"visible_normal_deviation.a_to_b.rms", "degrees", kLower,
       "root mean square angle, input to output, visible parts"},
      {"visible_normal_deviation.b_to_a.mean", "degrees", kLower, "mean angle, output to input, visible parts"},
      {"visible_normal_deviation.b_to_a.rms", "degrees", kLower,
       "root mean square angle, output to input, visible parts"},
      {"symmetric_difference.volume", "model^3", kLower, "volume of input xor output, inside by nonzero winding"},
      {"symmetric_difference.standard_error", "model^3", kNone, "standard error of that volume over the replicates"},
      {"symmetric_difference.relative", "share", kLower, "symmetric_difference.volume by the input's volume"},
      {"symmetric_difference.a_minus_b", "model^3", kLower, "volume of the input outside of the output"},
      {"symmetric_difference.b_minus_a", "model^3", kLower, "volume of the output outside of the input"},
      {"symmetric_difference.volume_bias", "model^3", kNone, "volume of the output minus that of the input"},
  };
  return columns;
}

const MetricValue& value_of(const std::vector<Measurement>& measurements, std::string_view key) {
  static const MetricValue not_measured = Undefined{"not measured"};
  const auto found =
      std::find_if(measurements.begin(), measurements.end(), [key](const Measurement& m) { return m.key == key; });
  return found == measurements.end() ? not_measured : found->value;
}

namespace {

/// The values in the order of the columns.
std::vector<Measurement> in_column_order(const std::vector<MetricColumn>& columns,
                                         const std::vector<Measurement>& values) {
  std::vector<Measurement> result;
  result.reserve(columns.size());
  for (const MetricColumn& column : columns) result.push_back({column.key, value_of(values, column.key)});
  return result;
}

void append_solid(const std::variant<SolidTopology, Undefined>& solid, std::vector<Measurement>& out) {
  const auto value = [&solid](std::int64_t SolidTopology::*member) -> MetricValue {
    if (const auto* reason = std::get_if<Undefined>(&solid)) return *reason;
    return std::get<SolidTopology>(solid).*member;
  };
  out.push_back({"solid.b0", value(&SolidTopology::b0)});
  out.push_back({"solid.b1", value(&SolidTopology::b1)});
  out.push_back({"solid.b2", value(&SolidTopology::b2)});
}

/// A share of `whole`, or the reason why there is none.
MetricValue share_of(double part, double whole, const char* reason) {
  return whole > 0 ? finite_value(part / whole) : MetricValue(Undefined{reason});
}

/// Every column of the pair whose key begins with `prefix` is undefined for this reason.
void append_undefined(std::string_view prefix, const Undefined& reason, std::vector<Measurement>& out) {
  for (const MetricColumn& column : pair_columns()) {
    if (column.key.starts_with(prefix)) out.push_back({column.key, reason});
  }
}

/// `prefix` is "hausdorff." or "visible_hausdorff.".
void append_hausdorff(const std::string& prefix, const std::variant<HausdorffDistances, Undefined>& distances,
                      const TriangleSoup& reference, std::vector<Measurement>& out) {
  if (const auto* reason = std::get_if<Undefined>(&distances)) return append_undefined(prefix, *reason, out);
  const auto& d = std::get<HausdorffDistances>(distances);
  const auto optional_value = [](const std::optional<double>& value) {
    return value ? finite_value(*value) : MetricValue(Undefined{"a shape has no area to sample"});
  };
  out.push_back({prefix + "lower", finite_value(d.symmetric.lower)});
  out.push_back({prefix + "upper", finite_value(d.symmetric.upper)});
  out.push_back({prefix + "mean", optional_value(d.mean)});
  out.push_back({prefix + "rms", optional_value(d.rms)});
  out.push_back({prefix + "relative_upper",
                 share_of(d.symmetric.upper, bounds(reference).diagonal(), "the input's bounding box is a point")});
  out.push_back({prefix + "a_to_b.lower", finite_value(d.a_to_b.lower)});
  out.push_back({prefix + "a_to_b.upper", finite_value(d.a_to_b.upper)});
  out.push_back({prefix + "b_to_a.lower", finite_value(d.b_to_a.lower)});
  out.push_back({prefix + "b_to_a.upper", finite_value(d.b_to_a.upper)});
}

/// `prefix` is "normal_deviation." or "visible_normal_deviation.".
void append_normal_deviation(const std::string& prefix, const std::variant<NormalDeviation, Undefined>& deviation,
                             std::vector<Measurement>& out) {
  if (const auto* reason = std::get_if<Undefined>(&deviation)) return append_undefined(prefix, *reason, out);
  const auto& d = std::get<NormalDeviation>(deviation);
  out.push_back({prefix + "mean", d.mean});
  out.push_back({prefix + "rms", d.rms});
  out.push_back({prefix + "above_30", d.above_30});
  out.push_back({prefix + "a_to_b.mean", d.a_to_b.mean});
  out.push_back({prefix + "a_to_b.rms", d.a_to_b.rms});
  out.push_back({prefix + "b_to_a.mean", d.b_to_a.mean});
  out.push_back({prefix + "b_to_a.rms", d.b_to_a.rms});
}

void append_visible(const SurfacePair& pair, const TriangleSoup& reference, const TriangleSoup& shape,
                    const MetricOptions& options, RunContext& context, std::vector<Measurement>& out) {
  const VisibilityOptions visibility{.directions = options.view_directions};
  const SurfacePart part_a = visible_part(reference, visibility, context);
  const SurfacePart part_b = visible_part(shape, visibility, context);
  out.push_back({"visible_share.a", part_a.share});
  out.push_back({"visible_share.b", part_b.share});
  if (part_a.surface.empty() || part_b.surface.empty()) {
    const Undefined reason{part_a.surface.empty() ? "no part of the first shape is visible"
                                                  : "no part of the second shape is visible"};
    append_undefined("visible_hausdorff.", reason, out);
    append_undefined("visible_normal_deviation.", reason, out);
    return;
  }
  const MeasuredSurface from_a = pair.part_of_a(part_a);
  const MeasuredSurface from_b = pair.part_of_b(part_b);
  append_hausdorff(
      "visible_hausdorff.",
      hausdorff_distances(pair, from_a, from_b, {.error = options.hausdorff_error, .samples = options.distance_samples},
                          context),
      reference, out);
  append_normal_deviation("visible_normal_deviation.",
                          normal_deviation(pair, from_a, from_b, {.samples = options.distance_samples}, context), out);
}

/// Distances and angles between the surfaces.
void append_surface_metrics(const TriangleSoup& reference, const TriangleSoup& shape, const MetricOptions& options,
                            RunContext& context, std::vector<Measurement>& out) {
  const auto prepared = prepare_pair(reference, shape, context);
  if (const auto* reason = std::get_if<Undefined>(&prepared)) {
    for (const char* prefix : {"hausdorff.", "normal_deviation."}) append_undefined(prefix, *reason, out);
    append_undefined("visible_", options.visible ? *reason : Undefined{"not asked for"}, out);
    return;
  }
  const auto& pair = std::get<SurfacePair>(prepared);
  append_hausdorff(
      "hausdorff.",
      hausdorff_distances(pair, pair.a, pair.b, {.error = options.hausdorff_error, .samples = options.distance_samples},
                          context),
      reference, out);
  append_normal_deviation("normal_deviation.",
                          normal_deviation(pair, pair.a, pair.b, {.samples = options.distance_samples}, context), out);
  if (options.visible) {
    append_visible(pair, reference, shape, options, context, out);
  } else {
    append_undefined("visible_", {"not asked for"}, out);
  }
}

void append_symmetric_difference(const std::variant<SymmetricDifference, Undefined>& difference,
                                 std::vector<Measurement>& out) {
  if (const auto* reason = std::get_if<Undefined>(&difference)) {
    return append_undefined("symmetric_difference.", *reason, out);
  }
  const auto& d = std::get<SymmetricDifference>(difference);
  out.push_back({"symmetric_difference.volume", finite_value(d.volume)});
  out.push_back({"symmetric_difference.standard_error", finite_value(d.standard_error)});
  out.push_back({"symmetric_difference.relative", share_of(d.volume, d.volume_a, "the input has no volume")});
  out.push_back({"symmetric_difference.a_minus_b", finite_value(d.a_minus_b)});
  out.push_back({"symmetric_difference.b_minus_a", finite_value(d.b_minus_a)});
  out.push_back({"symmetric_difference.volume_bias", finite_value(d.b_minus_a - d.a_minus_b)});
}

}  // namespace

std::vector<Measurement> measure_shape(const TriangleSoup& shape, const MetricOptions&, RunContext& context) {
  context.check_cancelled();
  std::vector<Measurement> values;
  const SurfaceTopology topology = analyze_topology(shape);
  append_topology(topology, values);
  const auto degenerate = std::count_if(shape.triangles.begin(), shape.triangles.end(),
                                        [&shape](const Triangle& t) { return is_degenerate(shape, t); });
  values.push_back({"degenerate_triangles", static_cast<std::int64_t>(degenerate)});
  const MetricValue self_intersections = count_self_intersections(shape, context);
  values.push_back({"self_intersections", self_intersections});
  append_geometry(shape, topology, values);
  append_solid(solid_topology(shape, topology, self_intersections, context), values);
  return in_column_order(shape_columns(), values);
}

std::vector<Measurement> measure_pair(const TriangleSoup& reference, const TriangleSoup& shape,
                                      const MetricOptions& options, RunContext& context) {
  context.check_cancelled();
  std::vector<Measurement> values;
  append_surface_metrics(reference, shape, options, context, values);
  append_symmetric_difference(
      symmetric_difference(reference, shape, {.rays = options.rays, .replicates = options.replicates}, context),
      values);
  return in_column_order(pair_columns(), values);
}

}  // namespace voxcarve
