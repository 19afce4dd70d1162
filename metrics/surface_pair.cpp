// Normalisation, triangles in common, and sampling: what the distances and angles between surfaces share.
#include "metrics/surface_pair.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "metrics/counter_random.h"

namespace voxcarve {

namespace {

constexpr std::int64_t kGrain = 256;    // samples a chunk
constexpr double kRoundingSteps = 256;  // roundings of a coordinate between input and distance, generously

TriangleSoup transformed(const TriangleSoup& soup, const Point& center, double scale) {
  TriangleSoup result;
  result.triangles = soup.triangles;
  result.positions.assign(soup.positions.size(), Point::Zero());
  for (const Triangle& triangle : soup.triangles) {
    for (const std::uint32_t v : triangle) result.positions[v] = scale * (soup.positions[v] - center);
  }
  return result;
}

/// The corners of every triangle in lexicographic order: equal keys are equal triangles as sets of points.
using TriangleKey = std::array<double, 9>;

std::vector<TriangleKey> keys_of(const TriangleSoup& soup) {
  std::vector<TriangleKey> keys;
  keys.reserve(soup.triangles.size());
  for (const Triangle& t : soup.triangles) {
    std::array<std::array<double, 3>, 3> corner;
    for (std::size_t c = 0; c < 3; ++c) {
      const Point& p = soup.positions[t[c]];
      corner[c] = {p[0] + 0.0, p[1] + 0.0, p[2] + 0.0};  // + 0.0 turns -0 into 0
    }
    std::sort(corner.begin(), corner.end());
    TriangleKey key;
    for (std::size_t i = 0; i < 9; ++i) key[i] = corner[i / 3][i % 3];
    keys.push_back(key);
  }
  return keys;
}

/// By triangle of `from`: 1 when it is a triangle of `to` too, so that its points are at distance 0 exactly.
std::vector<std::uint8_t> find_twins(const TriangleSoup& from, const TriangleSoup& to) {
  std::vector<TriangleKey> others = keys_of(to);
  std::sort(others.begin(), others.end());
  const std::vector<TriangleKey> keys = keys_of(from);
  std::vector<std::uint8_t> twin(keys.size());
  for (std::size_t t = 0; t < keys.size(); ++t) {
    twin[t] = std::binary_search(others.begin(), others.end(), keys[t]) ? 1 : 0;
  }
  return twin;
}

}  // namespace

MeasuredSurface SurfacePair::part_of(const MeasuredSurface& whole, const SurfacePart& part) const {
  MeasuredSurface result{transformed(part.surface, center, scale), {}};
  result.twin.reserve(part.source.size());
  for (const std::uint32_t t : part.source) result.twin.push_back(whole.twin[t]);
  return result;
}

std::variant<SurfacePair, Undefined> prepare_pair(const TriangleSoup& a, const TriangleSoup& b,
                                                  const RunContext& context) {
  if (a.empty()) return Undefined{"the first shape has no triangles"};
  if (b.empty()) return Undefined{"the second shape has no triangles"};
  Box box = bounds(a);
  double diagonal = box.diagonal();
  if (!(diagonal > 0)) {
    box.extend(bounds(b));
    diagonal = box.diagonal();
  }
  double scale = 1;
  if (diagonal > 0 && std::isfinite(diagonal)) {
    // Scaling in the range of normal numbers; beyond it the check below or the rounding allowance takes over.
    scale = std::ldexp(1.0, -std::clamp(std::ilogb(diagonal), -1000, 1000));
  }
  MeasuredSurface first{transformed(a, box.center(), scale), {}};
  MeasuredSurface second{transformed(b, box.center(), scale), {}};
  Box both = bounds(first.soup);
  both.extend(bounds(second.soup));
  const double reach = std::max(both.lower.cwiseAbs().maxCoeff(), both.upper.cwiseAbs().maxCoeff());
  if (!std::isfinite(diagonal) || !(reach < 1e70)) {  // fourth powers must not overflow
    return Undefined{"the shapes' coordinates are too far apart for double precision"};
  }
  context.check_cancelled();
  AabbTree tree_a(first.soup);
  context.check_cancelled();
  AabbTree tree_b(second.soup);
  context.check_cancelled();
  first.twin = find_twins(a, b);
  context.check_cancelled();
  second.twin = find_twins(b, a);
  return SurfacePair{std::move(first),
                     std::move(second),
                     std::move(tree_a),
                     std::move(tree_b),
                     diagonal,
                     box.center(),
                     scale,
                     kRoundingSteps * std::numeric_limits<double>::epsilon() * reach};
}

std::vector<SampleFoot> sample_feet(const MeasuredSurface& from, const AabbTree& to, std::int64_t samples,
                                    std::uint64_t stream, RunContext& context) {
  const TriangleSoup& soup = from.soup;
  context.require_memory(static_cast<std::uint64_t>(std::max<std::int64_t>(samples, 0)) * sizeof(SampleFoot) +
                             soup.triangles.size() * sizeof(double),
                         "sampling " + std::to_string(samples) + " points of a surface");
  std::vector<double> area_up_to;
  area_up_to.reserve(soup.triangles.size());
  double area = 0;
  for (const Triangle& t : soup.triangles) area_up_to.push_back(area += area_vector(soup, t).norm());
  if (!(area > 0) || samples < 1) return {};
  const CounterRandom random(context.seed, stream);
  std::vector<SampleFoot> feet(static_cast<std::size_t>(samples));
  parallel_for(context, 0, samples, kGrain, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t i = first; i < last; ++i) {
      const auto counter = 3 * static_cast<std::uint64_t>(i);
      const double share = (static_cast<double>(i) + random(counter)) / static_cast<double>(samples);
      // The first whose sum exceeds the share, so never one without area; the last with area takes what rounding left.
      auto found = std::upper_bound(area_up_to.begin(), area_up_to.end(), share * area);
      if (found == area_up_to.end()) found = std::lower_bound(area_up_to.begin(), area_up_to.end(), area);
      const auto triangle = static_cast<std::size_t>(found - area_up_to.begin());
      SampleFoot& foot = feet[static_cast<std::size_t>(i)];
      foot.from = static_cast<std::uint32_t>(triangle);
      if (from.twin[triangle] != 0) continue;
      const Triangle& t = soup.triangles[triangle];
      const double root = std::sqrt(random(counter + 1));
      const double along = random(counter + 2);
      const Point point = (1 - root) * soup.positions[t[0]] + root * (1 - along) * soup.positions[t[1]] +
                          root * along * soup.positions[t[2]];
      const AabbTree::Nearest nearest = to.nearest(point);
      foot.squared_distance = nearest.squared_distance;
      foot.nearest = nearest.triangle;
    }
  });
  return feet;
}

}  // namespace voxcarve
