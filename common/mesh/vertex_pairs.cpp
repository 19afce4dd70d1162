// Based on [GH97, 4]; close vertices are found in a grid of cells as long as the threshold.
#include "common/mesh/vertex_pairs.h"

#include <algorithm>
#include <array>
#include <string>

#include "common/run/errors.h"
#include "common/run/text.h"

namespace voxcarve {

namespace {

/// Cells are no smaller: their indices take 21 bits each.
constexpr double kSmallestCell = 1e-6;
constexpr int kIndexBits = 21;

/// Cells of a grid in the order of x, then y, then z: a run of cells along z is a range of keys.
class CellGrid {
 public:
  CellGrid(std::span<const Point> points, const std::vector<std::uint32_t>& used, double threshold) {
    for (const std::uint32_t vertex : used) box_.extend(points[vertex]);
    // Nothing is farther apart than the box is long, and there is a cell on either side of it.
    size_ = std::max({threshold, kSmallestCell, kSmallestCell * box_.diagonal()});
    entries_.reserve(used.size());
    for (const std::uint32_t vertex : used) entries_.push_back({key_of(points[vertex]), vertex});
    std::sort(entries_.begin(), entries_.end());
  }

  struct Entry {
    std::uint64_t key = 0;
    std::uint32_t vertex = 0;
    auto operator<=>(const Entry&) const = default;
  };
  using Range = std::span<const Entry>;

  const std::vector<Entry>& entries() const { return entries_; }

  /// The vertices in the 27 cells around the one with this key: nine ranges.
  std::array<Range, 9> around(std::uint64_t key) const {
    std::array<Range, 9> ranges;
    std::size_t count = 0;
    for (std::uint64_t x = 0; x < 3; ++x) {
      for (std::uint64_t y = 0; y < 3; ++y) {
        const std::uint64_t middle = key - kStepX - kStepY + x * kStepX + y * kStepY;
        const auto first = std::ranges::lower_bound(entries_, middle - 1, {}, &Entry::key);
        const auto last = std::ranges::upper_bound(first, entries_.end(), middle + 1, {}, &Entry::key);
        ranges.at(count++) = Range(first, last);
      }
    }
    return ranges;
  }

 private:
  static constexpr std::uint64_t kStepX = std::uint64_t{1} << (2 * kIndexBits);
  static constexpr std::uint64_t kStepY = std::uint64_t{1} << kIndexBits;

  std::uint64_t key_of(const Point& point) const {
    std::uint64_t key = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const auto index = static_cast<std::uint64_t>((point[axis] - box_.lower[axis]) / size_) + 1;
      key = (key << kIndexBits) + index;
    }
    return key;
  }

  Box box_;
  double size_ = 1;
  std::vector<Entry> entries_;
};

std::vector<std::uint32_t> used_vertices(std::size_t count, std::span<const Triangle> triangles) {
  std::vector<std::uint8_t> is_used(count);
  for (const Triangle& triangle : triangles) {
    for (const std::uint32_t vertex : triangle) is_used[vertex] = 1;
  }
  std::vector<std::uint32_t> used;
  for (std::uint32_t vertex = 0; vertex < count; ++vertex) {
    if (is_used[vertex] != 0) used.push_back(vertex);
  }
  return used;
}

[[noreturn]] void throw_too_many(double threshold, std::uint64_t most) {
  throw ResourceError("more than " + std::to_string(most) + " pairs of vertices are nearer than the threshold of " +
                      format_real(threshold) + ", too many for the memory budget; lower the threshold");
}

/// Appends the pairs nearer than the threshold whose lower cell, and of one cell whose lower vertex, is this entry's.
void append_close(std::span<const Point> points, const CellGrid::Entry& entry,
                  const std::array<CellGrid::Range, 9>& ranges, double threshold, std::vector<VertexPair>& pairs) {
  for (const CellGrid::Range& range : ranges) {
    for (const CellGrid::Entry& other : range) {
      if (other <= entry) continue;
      if ((points[entry.vertex] - points[other.vertex]).squaredNorm() >= threshold * threshold) continue;
      const auto [low, high] = std::minmax(entry.vertex, other.vertex);
      pairs.push_back({low, high});
    }
  }
}

}  // namespace

std::vector<VertexPair> find_vertex_pairs(std::span<const Point> points, std::span<const Triangle> triangles,
                                          double threshold, std::uint64_t most, RunContext& context) {
  const std::vector<std::uint32_t> used = used_vertices(points.size(), triangles);
  Stage stage(context, "vertex pairs", static_cast<std::int64_t>(used.size()));
  std::vector<VertexPair> pairs;
  pairs.reserve(3 * triangles.size());
  for (const Triangle& triangle : triangles) {
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const auto [low, high] = std::minmax(triangle.at(corner), triangle.at((corner + 1) % 3));
      pairs.push_back({low, high});
    }
  }
  const auto sort_unique = [&] {
    std::sort(pairs.begin(), pairs.end());
    pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
    if (pairs.size() > most) throw_too_many(threshold, most);
  };
  sort_unique();
  if (!(threshold > 0)) return pairs;
  const std::uint64_t edges = pairs.size();
  const CellGrid grid(points, used, threshold);
  std::array<CellGrid::Range, 9> ranges;
  const CellGrid::Entry* previous = nullptr;
  for (const CellGrid::Entry& entry : grid.entries()) {
    if (previous == nullptr || previous->key != entry.key) ranges = grid.around(entry.key);
    previous = &entry;
    append_close(points, entry, ranges, threshold, pairs);
    if (pairs.size() > most + edges) throw_too_many(threshold, most);  // edges may be close pairs too
    stage.advance(1);
  }
  sort_unique();
  return pairs;
}

}  // namespace voxcarve
