#include "common/mesh/models/leaves.h"

#include <algorithm>

namespace voxcarve {

TriangleSoup strip(const std::vector<std::vector<Point>>& rows) {
  TriangleSoup sheet;
  std::uint32_t before = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto first = static_cast<std::uint32_t>(sheet.positions.size());
    sheet.positions.insert(sheet.positions.end(), rows[i].begin(), rows[i].end());
    if (i == 0) continue;
    const std::size_t columns = std::max(rows[i - 1].size(), rows[i].size());
    for (std::uint32_t k = 0; k + 1 < columns; ++k) {
      if (rows[i - 1].size() == 1) {
        sheet.triangles.push_back({before, first + k + 1, first + k});
      } else if (rows[i].size() == 1) {
        sheet.triangles.push_back({before + k, before + k + 1, first});
      } else {
        sheet.triangles.push_back({before + k, before + k + 1, first + k + 1});
        sheet.triangles.push_back({before + k, first + k + 1, first + k});
      }
    }
    before = first;
  }
  return sheet;
}

ParameterSpec seed_parameter() {
  return ParameterSpec::integer("seed", "-", 0, 1'000'000'000, 1, "of what is irregular: another seed, another plant");
}

}  // namespace voxcarve
