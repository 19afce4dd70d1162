#include "common/mesh/models/growth.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>

namespace voxcarve {

double SeededSequence::uniform(double low, double high) {
  state_ += 0x9e3779b97f4a7c15U;
  std::uint64_t bits = state_;
  bits = (bits ^ (bits >> 30U)) * 0xbf58476d1ce4e5b9U;
  bits = (bits ^ (bits >> 27U)) * 0x94d049bb133111ebU;
  bits ^= bits >> 31U;
  return low + (high - low) * (static_cast<double>(bits >> 11U) * 0x1p-53);
}

namespace {

/// Six times the signed volume of a tetrahedron.
double volume(const Point& a, const Point& b, const Point& c, const Point& d) {
  return (b - a).cross(c - a).dot(d - a);
}

bool pierces(const Point& p, const Point& q, const Point& a, const Point& b, const Point& c) {
  if ((volume(a, b, c, p) > 0) == (volume(a, b, c, q) > 0)) return false;
  const bool first = volume(p, q, a, b) > 0;
  return first == (volume(p, q, b, c) > 0) && first == (volume(p, q, c, a) > 0);
}

}  // namespace

void FreeSpace::visit_cells(const Box& box, const std::function<bool(std::uint64_t cell)>& stop) const {
  const auto cell_of = [&](const Point& point) {
    return std::array{std::llround(point.x() / cell_size_), std::llround(point.y() / cell_size_),
                      std::llround(point.z() / cell_size_)};
  };
  const auto low = cell_of(box.lower);
  const auto high = cell_of(box.upper);
  constexpr std::uint64_t kMask = (1U << 21U) - 1;  // cells that share a number only cost time
  for (long long k = low[2]; k <= high[2]; ++k) {
    for (long long j = low[1]; j <= high[1]; ++j) {
      for (long long i = low[0]; i <= high[0]; ++i) {
        const auto bits = [](long long index) { return static_cast<std::uint64_t>(index) & kMask; };
        if (stop(bits(k) << 42U | bits(j) << 21U | bits(i))) return;
      }
    }
  }
}

bool FreeSpace::crosses(const TriangleSoup& piece) const {
  bool found = false;
  for (const Triangle& triangle : piece.triangles) {
    const std::array<Point, 3> p = {piece.positions[triangle[0]], piece.positions[triangle[1]],
                                    piece.positions[triangle[2]]};
    Box box;
    for (const Point& point : p) box.extend(point);
    visit_cells(box, [&](std::uint64_t cell) {
      const auto entry = triangles_of_cell_.find(cell);
      if (entry == triangles_of_cell_.end()) return false;
      for (const std::uint32_t index : entry->second) {
        const auto& [a, b, c] = triangles_[index];
        for (std::size_t k = 0; k < 3 && !found; ++k) found = pierces(p[k], p[(k + 1) % 3], a, b, c);
        found = found || pierces(a, b, p[0], p[1], p[2]) || pierces(b, c, p[0], p[1], p[2]) ||
                pierces(c, a, p[0], p[1], p[2]);
        if (found) return true;
      }
      return false;
    });
    if (found) return true;
  }
  return false;
}

void FreeSpace::occupy(const TriangleSoup& piece) {
  for (const Triangle& triangle : piece.triangles) {
    const auto index = static_cast<std::uint32_t>(triangles_.size());
    triangles_.push_back({piece.positions[triangle[0]], piece.positions[triangle[1]], piece.positions[triangle[2]]});
    Box box;
    for (const std::uint32_t vertex : triangle) box.extend(piece.positions[vertex]);
    visit_cells(box, [&](std::uint64_t cell) {
      triangles_of_cell_[cell].push_back(index);
      return false;
    });
  }
}

TriangleSoup FreeSpace::place(const std::function<TriangleSoup(double crowding)>& make, int attempts) {
  TriangleSoup piece = make(0);
  for (int attempt = 1; attempt < attempts && crosses(piece); ++attempt) {
    piece = make(static_cast<double>(attempt) / attempts);
  }
  occupy(piece);
  return piece;
}

}  // namespace voxcarve
