// Sizes and shapes: area, volume, box, edges, triangle quality.
#include <algorithm>
#include <cmath>
#include <limits>

#include "metrics/shape_measures.h"

namespace voxcarve {

namespace {

/// Minimum, mean and maximum of a stream of numbers.
struct Statistics {
  double least = std::numeric_limits<double>::infinity();
  double greatest = -std::numeric_limits<double>::infinity();
  double sum = 0;
  std::int64_t count = 0;

  void add(double value) {
    least = std::min(least, value);
    greatest = std::max(greatest, value);
    sum += value;
    ++count;
  }
  /// `value`, or a reason when there was nothing to look at.
  MetricValue or_undefined(double value, const char* reason) const {
    return count == 0 ? MetricValue(Undefined{reason}) : finite_value(value);
  }
  double mean() const { return sum / static_cast<double>(count); }
};

/// 2 r / R = 16 A^2 / (a b c (a + b + c)) with twice the area in the soup's normal. Scaled by the longest side, so that
/// tiny and huge triangles keep their digits.
double triangle_quality(const TriangleSoup& soup, const Triangle& t) {
  const Point& p = soup.positions[t[0]];
  const Point ab = soup.positions[t[1]] - p;
  const Point ac = soup.positions[t[2]] - p;
  const double scale = std::max(ab.cwiseAbs().maxCoeff(), ac.cwiseAbs().maxCoeff());
  if (!(scale > 0) || !std::isfinite(scale)) return 0;
  const Point u = ab / scale;
  const Point v = ac / scale;
  const double twice_area =
      Point(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]).norm();
  const double a = u.norm();
  const double b = v.norm();
  const double c = (u - v).norm();
  const double denominator = a * b * c * (a + b + c);
  return denominator > 0 ? std::min(1.0, 4 * twice_area * twice_area / denominator) : 0;
}

MetricValue volume_of(const TriangleSoup& soup, const SurfaceTopology& topology) {
  if (!topology.closed) return Undefined{"the surface is not closed"};
  if (!topology.oriented) return Undefined{"the surface is not oriented"};
  return soup.empty() ? MetricValue(0.0) : finite_value(signed_volume(soup));
}

void append_box(const TriangleSoup& soup, std::vector<Measurement>& out) {
  const Box box = bounds(soup);
  const auto value = [&box](double v) {
    return box.empty() ? MetricValue(Undefined{"no triangles"}) : finite_value(v);
  };
  out.push_back({"bbox_diagonal", value(box.diagonal())});
  const char* const names[3] = {"x", "y", "z"};
  for (int axis = 0; axis < 3; ++axis) {
    out.push_back({std::string("bbox.") + names[axis] + "_min", value(box.lower[axis])});
    out.push_back({std::string("bbox.") + names[axis] + "_max", value(box.upper[axis])});
  }
}

}  // namespace

MetricValue finite_value(double value) {
  if (!std::isfinite(value)) return Undefined{"beyond the range of double precision"};
  return value;
}

void append_geometry(const TriangleSoup& soup, const SurfaceTopology& topology, std::vector<Measurement>& out) {
  out.push_back({"area", finite_value(surface_area(soup))});
  out.push_back({"volume", volume_of(soup, topology)});
  append_box(soup, out);

  Statistics lengths;
  const EdgeTable edges(soup);
  for (std::size_t e = 0; e < edges.size(); ++e) {
    lengths.add((soup.positions[edges.high(e)] - soup.positions[edges.low(e)]).stableNorm());
  }
  out.push_back({"edge_length.min", lengths.or_undefined(lengths.least, "no edges")});
  out.push_back({"edge_length.mean", lengths.or_undefined(lengths.mean(), "no edges")});
  out.push_back({"edge_length.max", lengths.or_undefined(lengths.greatest, "no edges")});

  Statistics qualities;
  for (const Triangle& triangle : soup.triangles) qualities.add(triangle_quality(soup, triangle));
  out.push_back({"quality.min", qualities.or_undefined(qualities.least, "no triangles")});
  out.push_back({"quality.mean", qualities.or_undefined(qualities.mean(), "no triangles")});
}

}  // namespace voxcarve
