#include "common/mesh/distinct_triangles.h"

#include <algorithm>
#include <utility>

#include "common/mesh/topology.h"

namespace voxcarve {

DistinctTrianglesReport keep_distinct_triangles(TriangleSoup& soup) {
  DistinctTrianglesReport report;
  std::vector<std::pair<Triangle, std::uint32_t>> order;
  order.reserve(soup.triangles.size());
  for (std::uint32_t t = 0; t < soup.triangles.size(); ++t) {
    Triangle corners = soup.triangles[t];
    if (!has_distinct_corners(corners)) {
      ++report.collapsed;
      continue;
    }
    std::ranges::sort(corners);
    order.emplace_back(corners, t);
  }
  std::ranges::sort(order);  // the first of equal ones comes first
  const auto same = [](const auto& a, const auto& b) { return a.first == b.first; };
  const auto duplicates = std::ranges::unique(order, same);
  report.duplicate = static_cast<std::int64_t>(duplicates.size());
  order.erase(duplicates.begin(), duplicates.end());
  if (report.collapsed + report.duplicate == 0) return report;
  std::ranges::sort(order, {}, [](const auto& entry) { return entry.second; });
  std::size_t kept = 0;
  for (const auto& entry : order) {
    soup.triangles[kept] = soup.triangles[entry.second];
    if (!soup.triangle_colors.empty()) soup.triangle_colors[kept] = soup.triangle_colors[entry.second];
    ++kept;
  }
  soup.triangles.resize(kept);
  if (!soup.triangle_colors.empty()) soup.triangle_colors.resize(kept);
  return report;
}

}  // namespace voxcarve
