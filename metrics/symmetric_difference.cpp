// Stratified Monte Carlo integration over lines, with independent replicates for the standard error.
#include "metrics/symmetric_difference.h"

#include <algorithm>
#include <cmath>

#include "metrics/counter_random.h"
#include "metrics/inside_intervals.h"

namespace voxcarve {

namespace {

constexpr std::int64_t kMinReplicates = 8;
constexpr std::int64_t kMinRaysAReplicate = 16;
constexpr std::int64_t kMaxSolidAngles = 60'000'000;  // of cone triangles, over all rays: some seconds

/// Lengths along lines, or sums of them.
struct Lengths {
  double a = 0;
  double b = 0;
  double both = 0;

  Lengths& operator+=(const Lengths& other) {
    a += other.a;
    b += other.b;
    both += other.both;
    return *this;
  }
};

double total_length(const std::vector<Interval>& intervals) {
  double sum = 0;
  for (const Interval& i : intervals) sum += i.end - i.begin;
  return sum;
}

double common_length(const std::vector<Interval>& first, const std::vector<Interval>& second) {
  double sum = 0;
  std::size_t i = 0;
  std::size_t j = 0;
  while (i < first.size() && j < second.size()) {
    const double begin = std::max(first[i].begin, second[j].begin);
    const double end = std::min(first[i].end, second[j].end);
    if (end > begin) sum += end - begin;
    ++(first[i].end < second[j].end ? i : j);
  }
  return sum;
}

/// The lines of all replicates. A job is one row of cells of one replicate.
struct Plan {
  Box box;
  std::int64_t replicates = 0;
  std::int64_t side = 0;  ///< cells a side, lines a row

  int axis(std::int64_t replicate) const { return static_cast<int>((replicate + 2) % 3); }
  double cross_section(int axis) const {
    const Point extent = box.extent();
    return extent[(axis + 1) % 3] * extent[(axis + 2) % 3];
  }
};

Lengths integrate_row(const InsideIntervals& a, const InsideIntervals& b, const Plan& plan, std::int64_t replicate,
                      std::int64_t row, std::uint64_t seed) {
  const CounterRandom random(seed, 16 + static_cast<std::uint64_t>(replicate));
  const int axis = plan.axis(replicate);
  const int axis_u = (axis + 1) % 3;
  const int axis_v = (axis + 2) % 3;
  const Point extent = plan.box.extent();
  const auto side = static_cast<double>(plan.side);
  std::vector<Crossing> crossings;
  std::vector<Interval> in_a;
  std::vector<Interval> in_b;
  Lengths sum;
  for (std::int64_t column = 0; column < plan.side; ++column) {
    const auto cell = 2 * static_cast<std::uint64_t>(row * plan.side + column);
    const double share_u = (static_cast<double>(column) + random(cell)) / side;
    const double share_v = (static_cast<double>(row) + random(cell + 1)) / side;
    const double u = plan.box.lower[axis_u] + share_u * extent[axis_u];
    const double v = plan.box.lower[axis_v] + share_v * extent[axis_v];
    a.along_line(axis, u, v, crossings, in_a);
    b.along_line(axis, u, v, crossings, in_b);
    sum += {total_length(in_a), total_length(in_b), common_length(in_a, in_b)};
  }
  return sum;
}

std::int64_t rays_to_cast(const SymmetricDifferenceOptions& options, std::int64_t replicates,
                          std::int64_t boundary_edges) {
  std::int64_t rays = std::max<std::int64_t>(options.rays, 1);
  if (boundary_edges > 0) {
    rays = std::min(rays, kMaxSolidAngles / (boundary_edges * InsideIntervals::kEvaluationsALine));
  }
  return std::max(rays, replicates * kMinRaysAReplicate);
}

/// Turns the sums over the lines of each replicate into volumes; the replicates are independent and equally good.
SymmetricDifference estimate(const Plan& plan, const std::vector<Lengths>& replicate_sums) {
  SymmetricDifference result;
  const auto lines = static_cast<double>(plan.side * plan.side);
  const auto count = static_cast<double>(plan.replicates);
  std::vector<double> volumes;
  for (std::int64_t r = 0; r < plan.replicates; ++r) {
    const Lengths& sum = replicate_sums[static_cast<std::size_t>(r)];
    const double area_a_line = plan.cross_section(plan.axis(r)) / lines;
    // Both parts of a length can be equal but for rounding, hence no negative rests.
    const double a_minus_b = std::max(0.0, sum.a - sum.both) * area_a_line;
    const double b_minus_a = std::max(0.0, sum.b - sum.both) * area_a_line;
    volumes.push_back(a_minus_b + b_minus_a);
    result.a_minus_b += a_minus_b / count;
    result.b_minus_a += b_minus_a / count;
    result.volume_a += sum.a * area_a_line / count;
    result.volume_b += sum.b * area_a_line / count;
  }
  result.volume = result.a_minus_b + result.b_minus_a;
  double squares = 0;
  for (const double volume : volumes) squares += (volume - result.volume) * (volume - result.volume);
  result.standard_error = std::sqrt(squares / (count * (count - 1)));
  result.rays = plan.replicates * plan.side * plan.side;
  return result;
}

}  // namespace

std::variant<SymmetricDifference, Undefined> symmetric_difference(const TriangleSoup& a, const TriangleSoup& b,
                                                                  const SymmetricDifferenceOptions& options,
                                                                  const RunContext& context) {
  Plan plan;
  plan.box = bounds(a);
  plan.box.extend(bounds(b));
  if (plan.box.empty()) return SymmetricDifference{};
  if (!std::isfinite(plan.box.extent().prod())) {
    return Undefined{"the shapes' coordinates are too far apart for double precision"};
  }
  InsideIntervals inside_a(a);
  InsideIntervals inside_b(b);
  for (const auto& [inside, name] : {std::pair(&inside_a, "first"), std::pair(&inside_b, "second")}) {
    if (inside->boundary_edges() > kMaxBoundaryEdges) {
      return Undefined{std::string("the ") + name + " shape is open with " + std::to_string(inside->boundary_edges()) +
                       " boundary edges; at most " + std::to_string(kMaxBoundaryEdges) + " are treated"};
    }
    for (int axis = 0; axis < 3; ++axis) {
      context.check_cancelled();
      inside->prepare(axis);
    }
  }
  plan.replicates = std::max(options.replicates, kMinReplicates);
  const std::int64_t rays =
      rays_to_cast(options, plan.replicates, inside_a.boundary_edges() + inside_b.boundary_edges());
  plan.side = static_cast<std::int64_t>(std::sqrt(static_cast<double>(rays / plan.replicates)));

  std::vector<Lengths> rows(static_cast<std::size_t>(plan.replicates * plan.side));
  parallel_for(context, 0, plan.replicates * plan.side, 1, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t job = first; job < last; ++job) {
      rows[static_cast<std::size_t>(job)] =
          integrate_row(inside_a, inside_b, plan, job / plan.side, job % plan.side, context.seed);
    }
  });
  std::vector<Lengths> sums(static_cast<std::size_t>(plan.replicates));
  for (std::size_t job = 0; job < rows.size(); ++job) sums[job / static_cast<std::size_t>(plan.side)] += rows[job];
  return estimate(plan, sums);
}

}  // namespace voxcarve
