// Generalised winding numbers after [JKS13], by the identity that a surface and a cone that closes it have an integer
// winding number together; the solid angle of a triangle is that of Van Oosterom and Strackee, 1983.
#include "metrics/inside_intervals.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/mesh/topology.h"

namespace voxcarve {

namespace {

constexpr int kSamples = 32;     // steps over the box's extent along the line
constexpr int kBisections = 20;  // to 2^-20 of a step
// Surface and cone are rounded to the lattice of the stabber, so where they nearly coincide their order is arbitrary:
// parts between crossings shorter than this share of the extent are dropped.
constexpr double kShortest = 1e-6;
constexpr double kInset = 1e-6;  // samples keep away from crossings by this share of the part between them

/// The signed solid angle of triangle (a, b, c) seen from the origin, in [-2 pi, 2 pi].
double solid_angle(const Point& a, const Point& b, const Point& c) {
  const double la = a.norm();
  const double lb = b.norm();
  const double lc = c.norm();
  const double numerator = a.dot(b.cross(c));
  const double denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
  return 2 * std::atan2(numerator, denominator);
}

void append(std::vector<Interval>& intervals, double begin, double end) {
  if (!(end > begin)) return;
  if (!intervals.empty() && intervals.back().end == begin) {
    intervals.back().end = end;
  } else {
    intervals.push_back({begin, end});
  }
}

}  // namespace

InsideIntervals::InsideIntervals(const TriangleSoup& soup) : closed_(merge_equal_positions(soup)), box_(bounds(soup)) {
  const EdgeTable edges(closed_);
  std::vector<std::array<std::uint32_t, 2>> chain;
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const std::int64_t surplus = edges.signed_incidence(e);
    const std::uint32_t from = surplus > 0 ? edges.low(e) : edges.high(e);
    const std::uint32_t to = surplus > 0 ? edges.high(e) : edges.low(e);
    for (std::int64_t i = 0; i < std::abs(surplus); ++i) chain.push_back({from, to});
  }
  if (chain.empty()) return;
  for (const auto& [from, to] : chain) {
    boundary_.push_back({closed_.positions[from], closed_.positions[to]});
    apex_ += closed_.positions[from] / static_cast<double>(chain.size());
  }
  const auto apex = static_cast<std::uint32_t>(closed_.positions.size());
  closed_.positions.push_back(apex_);
  closed_.vertex_colors.clear();
  closed_.triangle_colors.clear();
  for (const auto& [from, to] : chain) closed_.triangles.push_back({to, from, apex});  // runs the edge backwards
}

void InsideIntervals::prepare(int axis) {
  auto& stabber = stabbers_[static_cast<std::size_t>(axis)];
  if (!stabber) stabber = std::make_unique<LineStabber>(closed_, StabFrame::along_axis(axis));
}

double InsideIntervals::cone_winding(const Point& point) const {
  double sum = 0;
  const Point apex = apex_ - point;
  for (const Edge& edge : boundary_) sum += solid_angle(edge.to - point, edge.from - point, apex);
  return sum / (4 * std::numbers::pi);
}

void InsideIntervals::along_line(int axis, double u, double v, std::vector<Crossing>& crossings,
                                 std::vector<Interval>& out) const {
  out.clear();
  const LineStabber& stabber = *stabbers_[static_cast<std::size_t>(axis)];
  stabber.crossings(u, v, crossings);
  if (boundary_.empty()) {
    int winding = 0;
    for (std::size_t i = 0; i + 1 < crossings.size(); ++i) {
      winding += crossings[i].sign;
      if (winding != 0) append(out, crossings[i].depth, crossings[i + 1].depth);
    }
    return;
  }
  const StabFrame& frame = stabber.frame();
  const Point on_line = frame.at(u, v, box_.lower[axis]);
  if ((on_line.array() < box_.lower.array()).any() || (on_line.array() > box_.upper.array()).any()) return;
  // The apex is a mean of positions, so the cone stays in the box, and so do all crossings.
  int winding = 0;
  double begin = box_.lower[axis];
  for (const Crossing& crossing : crossings) {
    split_smooth_part(frame, u, v, winding, {begin, crossing.depth}, out);
    winding += crossing.sign;
    begin = crossing.depth;
  }
  split_smooth_part(frame, u, v, winding, {begin, box_.upper[axis]}, out);
}

/// Between crossings the winding number changes smoothly with the cone's solid angle alone.
void InsideIntervals::split_smooth_part(const StabFrame& frame, double u, double v, int crossed, const Interval& part,
                                        std::vector<Interval>& out) const {
  const double length = part.end - part.begin;
  const double extent = box_.extent().dot(frame.w);
  if (!(length > kShortest * extent)) return;
  const auto inside = [&](double depth) { return std::abs(crossed - cone_winding(frame.at(u, v, depth))) > 0.5; };
  const auto steps = std::max(1, static_cast<int>(std::ceil(kSamples * length / extent)));
  double entered = part.begin;
  double previous = part.begin + kInset * length;
  bool was_inside = inside(previous);
  for (int i = 1; i <= steps; ++i) {
    const double share = i == steps ? 1 - kInset : static_cast<double>(i) / steps;
    const double current = part.begin + share * length;
    const bool is_inside = inside(current);
    if (is_inside != was_inside) {
      double low = previous;
      double high = current;
      for (int k = 0; k < kBisections; ++k) {
        const double middle = low + (high - low) / 2;
        (inside(middle) == was_inside ? low : high) = middle;
      }
      if (was_inside) append(out, entered, high);
      entered = high;
    }
    was_inside = is_inside;
    previous = current;
  }
  if (was_inside) append(out, entered, part.end);
}

}  // namespace voxcarve
