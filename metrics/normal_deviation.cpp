// Angles at the samples of the mean Hausdorff distance.
#include "metrics/normal_deviation.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <optional>

namespace voxcarve {

namespace {

/// The angle between the lines along two vectors, in degrees; small ones keep their digits.
double unoriented_angle(const Point& first, const Point& second) {
  return std::atan2(first.cross(second).norm(), std::abs(first.dot(second))) * (180 / std::numbers::pi);
}

std::optional<NormalDeviation::OneSided> one_sided(const MeasuredSurface& from, const TriangleSoup& to,
                                                   const AabbTree& tree, std::int64_t samples, std::uint64_t stream,
                                                   RunContext& context) {
  NormalDeviation::OneSided sum;
  std::int64_t count = 0;
  for (const SampleFoot& foot : sample_feet(from, tree, samples, stream, context)) {
    double angle = 0;
    if (foot.nearest != AabbTree::kNone) {
      // Directions, not areas: squares of tiny areas would vanish.
      const Point own = area_vector(from.soup, from.soup.triangles[foot.from]).stableNormalized();
      const Point other = area_vector(to, to.triangles[foot.nearest]).stableNormalized();
      if (other.isZero(0)) continue;
      angle = unoriented_angle(own, other);
    }
    ++count;
    sum.mean += angle;
    sum.rms += angle * angle;
    sum.above_30 += angle > kLargeDeviation ? 1 : 0;
  }
  if (count == 0) return std::nullopt;
  const auto n = static_cast<double>(count);
  return NormalDeviation::OneSided{sum.mean / n, std::sqrt(sum.rms / n), sum.above_30 / n};
}

}  // namespace

std::variant<NormalDeviation, Undefined> normal_deviation(const SurfacePair& pair, const MeasuredSurface& from_a,
                                                          const MeasuredSurface& from_b,
                                                          const NormalDeviationOptions& options, RunContext& context) {
  if (from_a.soup.empty()) return Undefined{"no part of the first shape to measure from"};
  if (from_b.soup.empty()) return Undefined{"no part of the second shape to measure from"};
  const auto first = one_sided(from_a, pair.b.soup, pair.tree_b, options.samples, 1, context);
  const auto second = one_sided(from_b, pair.a.soup, pair.tree_a, options.samples, 2, context);
  if (!first || !second) return Undefined{"a shape has no area to sample"};
  return NormalDeviation{*first, *second, (first->mean + second->mean) / 2,
                         std::sqrt((first->rms * first->rms + second->rms * second->rms) / 2),
                         (first->above_30 + second->above_30) / 2};
}

std::variant<NormalDeviation, Undefined> normal_deviation(const TriangleSoup& a, const TriangleSoup& b,
                                                          const NormalDeviationOptions& options, RunContext& context) {
  const auto pair = prepare_pair(a, b, context);
  if (const auto* reason = std::get_if<Undefined>(&pair)) return *reason;
  const auto& surfaces = std::get<SurfacePair>(pair);
  return normal_deviation(surfaces, surfaces.a, surfaces.b, options, context);
}

}  // namespace voxcarve
