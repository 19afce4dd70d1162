// The registry of columns, and the two measurements that fill them.
#include "metrics/metric.h"

#include <algorithm>
#include <cmath>

#include "common/mesh/topology.h"
#include "metrics/hausdorff.h"
#include "metrics/self_intersections.h"
#include "metrics/shape_measures.h"
#include "metrics/symmetric_difference.h"

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

void append_hausdorff(const std::variant<HausdorffDistances, Undefined>& distances, const TriangleSoup& reference,
                      std::vector<Measurement>& out) {
  if (const auto* reason = std::get_if<Undefined>(&distances)) {
    for (const MetricColumn& column : pair_columns()) {
      if (column.key.starts_with("hausdorff.")) out.push_back({column.key, *reason});
    }
    return;
  }
  const auto& d = std::get<HausdorffDistances>(distances);
  const auto optional_value = [](const std::optional<double>& value) {
    return value ? finite_value(*value) : MetricValue(Undefined{"a shape has no area to sample"});
  };
  out.push_back({"hausdorff.lower", finite_value(d.symmetric.lower)});
  out.push_back({"hausdorff.upper", finite_value(d.symmetric.upper)});
  out.push_back({"hausdorff.mean", optional_value(d.mean)});
  out.push_back({"hausdorff.rms", optional_value(d.rms)});
  out.push_back({"hausdorff.relative_upper",
                 share_of(d.symmetric.upper, bounds(reference).diagonal(), "the input's bounding box is a point")});
  out.push_back({"hausdorff.a_to_b.lower", finite_value(d.a_to_b.lower)});
  out.push_back({"hausdorff.a_to_b.upper", finite_value(d.a_to_b.upper)});
  out.push_back({"hausdorff.b_to_a.lower", finite_value(d.b_to_a.lower)});
  out.push_back({"hausdorff.b_to_a.upper", finite_value(d.b_to_a.upper)});
}

void append_symmetric_difference(const std::variant<SymmetricDifference, Undefined>& difference,
                                 std::vector<Measurement>& out) {
  if (const auto* reason = std::get_if<Undefined>(&difference)) {
    for (const MetricColumn& column : pair_columns()) {
      if (column.key.starts_with("symmetric_difference.")) out.push_back({column.key, *reason});
    }
    return;
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
  append_hausdorff(
      hausdorff_distances(reference, shape, {.error = options.hausdorff_error, .samples = options.distance_samples},
                          context),
      reference, values);
  append_symmetric_difference(
      symmetric_difference(reference, shape, {.rays = options.rays, .replicates = options.replicates}, context),
      values);
  return in_column_order(pair_columns(), values);
}

}  // namespace voxcarve
