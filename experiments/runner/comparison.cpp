#include "experiments/runner/comparison.h"

#include <algorithm>
#include <chrono>

#include "common/run/errors.h"
#include "common/run/text.h"

namespace voxcarve {

namespace {

/// Calls `work`; an error that it throws becomes the row's failure, only Cancelled leaves.
template <class Work>
void attempt(ComparisonRow& row, const std::string& prefix, const Work& work) {
  try {
    work();
  } catch (const Cancelled&) {
    throw;
  } catch (const Error& error) {
    row.status = RunStatus::kFailed;
    row.reason = prefix + error.what();
  } catch (const std::bad_alloc&) {
    row.status = RunStatus::kFailed;
    row.reason = prefix + "memory ran out";
  }
}

/// Runs one entry, without measuring.
void run_method(const Model& model, const PlannedRun& planned, std::int64_t triangles, RunContext& context,
                ComparisonRow& row) {
  if (const auto reason = planned.method->unsupported(model, planned.parameters)) {
    row.status = RunStatus::kSkipped;
    row.reason = reason->text;
    return;
  }
  const auto start = std::chrono::steady_clock::now();
  attempt(row, "", [&] {
    const MethodResult result = planned.method->run(model, planned.parameters, context);
    row.surface = level_for_budget(result, triangles).surface;
    if (row.surface.empty()) throw MethodFailure("nothing of " + model.name + " is left");
    row.timings = result.timings;
    row.notices = result.notices;
  });
  // What a run remarked before it failed often says why.
  if (row.status == RunStatus::kFailed) row.notices = context.notices();
  row.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// A value for the terminal: counts with thousands, reals with four digits, a dash for what is undefined.
std::string short_text(const MetricValue& value, double scale = 1) {
  if (const auto* flag = std::get_if<bool>(&value)) return *flag ? "yes" : "no";
  if (const auto* count = std::get_if<std::int64_t>(&value)) return with_thousands(*count);
  if (const auto* real = std::get_if<double>(&value)) return rounded(*real * scale, 4);
  return "-";
}

}  // namespace

std::string_view to_string(RunStatus status) {
  switch (status) {
    case RunStatus::kDone:
      return "done";
    case RunStatus::kSkipped:
      return "skipped";
    case RunStatus::kFailed:
      return "failed";
  }
  return "";
}

Parameters parameters_for_budget(const Method& method, std::int64_t triangles, std::vector<std::string> settings) {
  const ParameterSchema& schema = method.info().parameters;
  if (triangles > 0 && schema.find("triangles") != nullptr)
    settings.insert(settings.begin(), "triangles=" + std::to_string(triangles));
  return Parameters::parse(schema, settings, method.info().name);
}

ChosenLevel level_for_budget(const MethodResult& result, std::int64_t triangles) {
  std::int64_t index = result.levels->size() - 1;
  while (index > 0 && triangles > 0 && result.levels->counts(index).triangles > triangles) --index;
  return {index, result.levels->extract(index)};
}

std::string missed_budget(const TriangleSoup& surface, std::int64_t triangles, std::int64_t vertices) {
  if (triangles > 0 && std::ssize(surface.triangles) > triangles) {
    return "the result has " + std::to_string(surface.triangles.size()) + " triangles, more than the budget of " +
           std::to_string(triangles);
  }
  if (vertices == 0) return "";
  const std::int64_t distinct = std::ssize(merge_equal_positions(surface).positions);
  if (distinct <= vertices) return "";
  return "even the coarsest level has " + std::to_string(distinct) + " distinct vertices, more than the " +
         std::to_string(vertices) + " asked for";
}

std::vector<ComparisonRow> compare_methods(const Model& model, const TriangleSoup& reference,
                                           const std::vector<PlannedRun>& plan, std::int64_t triangles,
                                           const MetricOptions& options, RunContext& context,
                                           const std::function<void(const std::string&)>& announce) {
  std::vector<ComparisonRow> rows;
  for (const PlannedRun& planned : plan) {
    ComparisonRow row;
    row.method = planned.method->info().name;
    row.parameters = planned.parameters.canonical();
    announce(row.method);
    run_method(model, planned, triangles, context, row);
    if (row.status == RunStatus::kDone) {
      attempt(row, "could not be measured: ", [&] {
        row.measurements = measure_shape(row.surface, options, context);
        std::ranges::move(measure_pair(reference, row.surface, options, context), std::back_inserter(row.measurements));
      });
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

std::string exact_text(const MetricValue& value) {
  if (const auto* flag = std::get_if<bool>(&value)) return *flag ? "true" : "false";
  if (const auto* count = std::get_if<std::int64_t>(&value)) return std::to_string(*count);
  if (const auto* real = std::get_if<double>(&value)) return format_real(*real);
  return "undefined: " + std::get<Undefined>(value).reason;
}

Table summary_table(const std::vector<ComparisonRow>& rows) {
  Table table;
  table.header = {"method",    "triangles",        "components",       "genus",  "closed",
                  "self-int.", "Hausdorff % diag", "sym. diff. % vol", "seconds"};
  for (const ComparisonRow& row : rows) {
    if (row.status != RunStatus::kDone) {
      table.rows.push_back({row.method, std::string(to_string(row.status)), "", "", "", "", "", "", ""});
      continue;
    }
    const auto text = [&](std::string_view key, double scale = 1) {
      return short_text(value_of(row.measurements, key), scale);
    };
    table.rows.push_back({row.method, text("triangles"), text("components"), text("genus"), text("closed"),
                          text("self_intersections"), text("hausdorff.relative_upper", 100),
                          text("symmetric_difference.relative", 100), rounded(row.seconds, 3)});
  }
  return table;
}

Table full_table(const std::string& model, const std::vector<ComparisonRow>& rows) {
  Table table;
  table.header = {"model", "method", "status", "parameters"};
  std::vector<std::string> keys;
  for (const auto* columns : {&shape_columns(), &pair_columns()}) {
    for (const MetricColumn& column : *columns) keys.push_back(column.key);
  }
  table.header.insert(table.header.end(), keys.begin(), keys.end());
  table.header.emplace_back("seconds");
  for (const ComparisonRow& row : rows) {
    const std::string status = std::string(to_string(row.status)) + (row.reason.empty() ? "" : ": " + row.reason);
    std::vector<std::string> cells = {model, row.method, status, row.parameters};
    for (const std::string& key : keys) {
      cells.push_back(row.status == RunStatus::kDone ? exact_text(value_of(row.measurements, key))
                                                     : "undefined: " + std::string(to_string(row.status)));
    }
    cells.push_back(format_real(row.seconds));
    table.rows.push_back(std::move(cells));
  }
  return table;
}

}  // namespace voxcarve
