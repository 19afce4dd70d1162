// All methods on one input at one triangle budget: the main job.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/model.h"
#include "common/run/context.h"
#include "experiments/runner/table.h"
#include "methods/method.h"
#include "metrics/metric.h"

namespace voxcarve {

/// One cell of the plan: a method with its parameters.
struct PlannedRun {
  const Method* method = nullptr;
  Parameters parameters;
};

enum class RunStatus { kDone, kSkipped, kFailed };

/// What one method made of the input.
struct ComparisonRow {
  std::string method;
  std::string parameters;  ///< canonical
  RunStatus status = RunStatus::kDone;
  std::string reason;  ///< of a skip or a failure
  TriangleSoup surface;
  std::vector<Measurement> measurements;  ///< of the surface, then of the pair (input, surface)
  std::vector<StageTiming> timings;
  std::vector<std::string> notices;
  double seconds = 0;  ///< of the run, measuring apart
};

/// "done", "skipped", "failed".
std::string_view to_string(RunStatus status);

/// Parameters of a method for a triangle budget: `triangles` is set where the method has it and `settings` do not.
/// Throws ParameterError.
Parameters parameters_for_budget(const Method& method, std::int64_t triangles, std::vector<std::string> settings);

/// A level of a result.
struct ChosenLevel {
  std::int64_t index = 0;
  TriangleSoup surface;
};

/// The level that meets the budget: the finest with at most `triangles` triangles, or the coarsest. 0 asks for the
/// finest.
ChosenLevel level_for_budget(const MethodResult& result, std::int64_t triangles);

/// What a result that is the best there is says of a budget that it does not meet: more triangles, or more distinct
/// vertices, than asked for. "" where it meets both; 0 asks for nothing.
std::string missed_budget(const TriangleSoup& surface, std::int64_t triangles, std::int64_t vertices);

/// Runs and measures every entry of the plan. A method that does not apply is skipped, one that fails is a row with
/// its reason; only Cancelled leaves. `reference` is the surface that results are measured against.
std::vector<ComparisonRow> compare_methods(const Model& model, const TriangleSoup& reference,
                                           const std::vector<PlannedRun>& plan, std::int64_t triangles,
                                           const MetricOptions& options, RunContext& context,
                                           const std::function<void(const std::string&)>& announce);

/// The text of a value for tables that are kept: shortest exact decimals, "undefined: reason".
std::string exact_text(const MetricValue& value);

/// A few columns for a terminal.
Table summary_table(const std::vector<ComparisonRow>& rows);

/// Every metric, one row a method, cells exact, timings last: columns as listed in results/README.md.
Table full_table(const std::string& model, const std::vector<ComparisonRow>& rows);

}  // namespace voxcarve
