#include "experiments/benchmarks/ratios.h"

#include <fmt/format.h>

#include <algorithm>

namespace voxcarve::bench {

namespace {

constexpr int kDigits = 6;

std::string number_or_empty(const std::optional<double>& value) {
  return value ? rounded(*value, kDigits) : "";
}

std::optional<double> median_of(const std::vector<double>& seconds) {
  if (seconds.empty()) return std::nullopt;
  return median(seconds);
}

std::string at_least(const std::optional<double>& goal) {
  return goal ? ">= " + rounded(*goal, kDigits) : "";
}

std::string yes_or_no(bool met) {
  return met ? "yes" : "no";
}

/// "0.0512 (5, 3 %)": the median, the number of runs and their spread.
std::string runs_text(const std::vector<double>& seconds) {
  if (seconds.empty()) return "-";
  const double middle = median(seconds);
  const auto [least, most] = std::ranges::minmax(seconds);
  return fmt::format("{:.4g} ({}, {:.0f} %)", middle, seconds.size(), middle > 0 ? 50 * (most - least) / middle : 0);
}

}  // namespace

double median(std::vector<double> values) {
  std::ranges::sort(values);
  const std::size_t middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
}

std::optional<double> RatioRow::ratio() const {
  const auto ours = median_of(ours_seconds);
  const auto theirs = median_of(peer_seconds);
  if (!ours || !theirs || *ours <= 0) return std::nullopt;
  return *theirs / *ours;
}

std::string RatioRow::met() const {
  if (!goal) return "";
  if (!peer_present) return "no peer";
  const auto reached = ratio();
  if (!reached) return "not run";
  if (std::min(ours_seconds.size(), peer_seconds.size()) < kFewestRuns) return "too few runs";
  return yes_or_no(*reached >= *goal);
}

Table ratio_csv(std::span<const RatioRow> rows) {
  Table table{{"stage", "work", "threads", "ours_seconds", "peer", "peer_seconds", "ratio", "goal", "met"}, {}};
  for (const RatioRow& row : rows) {
    table.rows.push_back(
        {row.stage, row.work, std::to_string(row.threads), number_or_empty(median_of(row.ours_seconds)), row.peer,
         number_or_empty(median_of(row.peer_seconds)), number_or_empty(row.ratio()), at_least(row.goal), row.met()});
  }
  return table;
}

Table ratio_summary(std::span<const RatioRow> rows) {
  Table table{{"stage", "work", "T", "ours, s (runs, spread)", "peer", "peer, s (runs, spread)", "ratio", "goal", "met",
               "note"},
              {}};
  for (const RatioRow& row : rows) {
    const auto ratio = row.ratio();
    std::string note = row.note;
    if (!row.peer_present) note = note.empty() ? "built without the peer" : "built without the peer; " + note;
    table.rows.push_back({row.stage, row.work, std::to_string(row.threads), runs_text(row.ours_seconds), row.peer,
                          row.peer.empty() ? "" : runs_text(row.peer_seconds),
                          ratio ? fmt::format("{:.2f}", *ratio) : "", at_least(row.goal), row.met(), note});
  }
  return table;
}

std::optional<double> ErrorRow::ratio() const {
  if (!ours || !peer_value || *ours == 0) return std::nullopt;
  return *peer_value / *ours;
}

std::string ErrorRow::met() const {
  if (limit) return ours ? yes_or_no(*ours < *limit) : "not run";
  if (!ratio_goal) return "";
  if (!ours || !peer_value) return "not run";
  return yes_or_no(*peer_value >= *ratio_goal * *ours);  // holds of an error of ours of 0 too
}

Table error_csv(std::span<const ErrorRow> rows) {
  Table table{{"stage", "work", "ours", "peer", "peer_value", "ratio", "goal", "met"}, {}};
  for (const ErrorRow& row : rows) {
    const std::string goal = row.limit ? "< " + rounded(*row.limit, kDigits) : at_least(row.ratio_goal);
    table.rows.push_back({row.stage, row.work, number_or_empty(row.ours), row.peer, number_or_empty(row.peer_value),
                          number_or_empty(row.ratio()), goal, row.met()});
  }
  return table;
}

Table pipeline_csv(std::span<const PipelineRow> rows) {
  Table table{{"stage", "seconds", "share", "bytes"}, {}};
  for (const PipelineRow& row : rows) {
    table.rows.push_back({row.stage, rounded(row.seconds, kDigits), rounded(row.share, 4), std::to_string(row.bytes)});
  }
  return table;
}

}  // namespace voxcarve::bench
