// From the seconds of single runs to the tables that `./dev bench` leaves: medians, ratios, and whether a goal is met.
// Nothing here knows Google Benchmark or any peer.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "experiments/runner/table.h"

namespace voxcarve::bench {

/// A goal is judged on so many runs of either side or not at all.
inline constexpr std::size_t kFewestRuns = 5;

/// The middle value, or the mean of the two middle ones. `values` is not empty.
double median(std::vector<double> values);

/// Ours and one peer on the same work, with the same number of threads. Seconds are those of single runs.
struct RatioRow {
  std::string stage;
  std::string work;
  int threads = 1;
  std::vector<double> ours_seconds;
  std::string peer;          ///< empty: a figure of ours alone
  bool peer_present = true;  ///< false when the benchmark was built without the peer
  std::vector<double> peer_seconds;
  std::optional<double> goal;  ///< the ratio to reach; none: reported, not judged
  std::string note;            ///< printed, not written

  /// Median of the peer's seconds over the median of ours: above 1, ours is faster. None unless both have run.
  std::optional<double> ratio() const;
  /// "yes" or "no"; empty without a goal. A goal that cannot be judged says why: "no peer" (not built in), "not run"
  /// (filtered out, or failed) or "too few runs".
  std::string met() const;
};

/// The columns stage,work,threads,ours_seconds,peer,peer_seconds,ratio,goal,met.
Table ratio_csv(std::span<const RatioRow> rows);
/// The same for a terminal, with the spread of the runs (half of largest minus smallest, share of the median) and the
/// notes.
Table ratio_summary(std::span<const RatioRow> rows);

/// A figure that is no time: the error of a result, or memory. Smaller is better.
struct ErrorRow {
  std::string stage;  ///< with the unit: "reduction hausdorff (voxels)"
  std::string work;
  std::optional<double> ours;
  std::string peer;
  std::optional<double> peer_value;
  std::optional<double> ratio_goal;  ///< what peer_value / ours must reach
  std::optional<double> limit;       ///< what ours must stay below; at most one of the two goals is set

  /// peer_value / ours; none unless both are known and ours is not 0.
  std::optional<double> ratio() const;
  /// As of a RatioRow: "yes", "no", "not run", or empty without a goal.
  std::string met() const;
};

/// The columns stage,work,ours,peer,peer_value,ratio,goal,met.
Table error_csv(std::span<const ErrorRow> rows);

/// One stage of a run of the whole pipeline.
struct PipelineRow {
  std::string stage;
  double seconds = 0;
  double share = 0;         ///< of the whole run
  std::uint64_t bytes = 0;  ///< memory: what the stage declared, or of the whole run the growth that was measured
};

/// The columns stage,seconds,share,bytes.
Table pipeline_csv(std::span<const PipelineRow> rows);

}  // namespace voxcarve::bench
