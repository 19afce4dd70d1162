#include "common/mesh/arrangement_work.h"

#include <algorithm>
#include <bit>

#include "common/mesh/first_of_equals.h"
#include "common/mesh/topology.h"
#include "common/mesh/triangle_crossings.h"

namespace voxcarve {

namespace {

constexpr std::uint32_t kNone = 0xffffffffU;

/// Renames every vertex that triangles use to the first of them at its position.
std::int64_t merge_vertices(TriangleSoup& soup) {
  std::vector<std::uint32_t> used;
  {
    std::vector<char> is_used(soup.positions.size(), 0);
    for (const Triangle& t : soup.triangles)
      for (const std::uint32_t vertex : t) is_used[vertex] = 1;
    used.reserve(soup.positions.size());
    for (std::uint32_t i = 0; i < is_used.size(); ++i)
      if (is_used[i] != 0) used.push_back(i);
  }
  const auto position = [&](std::uint32_t i) -> const Point& { return soup.positions[used[i]]; };
  const std::vector<std::uint32_t> first = first_of_equals(
      used.size(),
      [&](std::uint32_t i) {
        std::uint64_t hash = 0;
        for (const double coordinate : position(i)) {
          hash = mixed(hash, std::bit_cast<std::uint64_t>(coordinate + 0.0));  // + 0.0 turns -0 into 0
        }
        return hash;
      },
      [&](std::uint32_t i, std::uint32_t j) { return position(i) == position(j); });
  std::vector<std::uint32_t> renamed(soup.positions.size(), kNone);
  std::int64_t merged = 0;
  for (std::uint32_t i = 0; i < used.size(); ++i) {
    renamed[used[i]] = used[first[i]];
    merged += first[i] != i ? 1 : 0;
  }
  if (merged == 0) return 0;
  for (Triangle& t : soup.triangles)
    for (std::uint32_t& vertex : t) vertex = renamed[vertex];
  return merged;
}

/// Keeps the triangles that `keep` names, in its order.
void select_triangles(ArrangementWork& work, const std::vector<std::uint32_t>& keep) {
  const auto select = [&keep](auto& values) {
    std::decay_t<decltype(values)> selected;
    selected.reserve(keep.size());
    for (const std::uint32_t index : keep) selected.push_back(values[index]);
    values = std::move(selected);
  };
  select(work.soup.triangles);
  select(work.multiplicity);
  select(work.source);
  select(work.suspects);
}

std::int64_t drop_degenerate(ArrangementWork& work, const RunContext& context) {
  const auto& p = work.soup.positions;
  std::vector<std::uint32_t> keep;
  keep.reserve(work.soup.triangles.size());
  for (std::uint32_t i = 0; i < work.soup.triangles.size(); ++i) {
    if (i % 65536 == 0) context.check_cancelled();
    const Triangle& t = work.soup.triangles[i];
    const bool whole = !work.suspects[i] || (has_distinct_corners(t) && !are_collinear(p[t[0]], p[t[1]], p[t[2]]));
    if (whole) keep.push_back(i);
  }
  const auto dropped = static_cast<std::int64_t>(work.soup.triangles.size() - keep.size());
  if (dropped > 0) select_triangles(work, keep);
  return dropped;
}

/// The triangle with its smallest vertex first and, if need be, turned round, so that coinciding ones become equal.
struct Unoriented {
  Triangle corners;
  bool turned;

  explicit Unoriented(const Triangle& t) : corners(t), turned(false) {
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
    if (corners[1] > corners[2]) {
      std::swap(corners[1], corners[2]);
      turned = true;
    }
  }
};

/// Adds up the multiplicities of triangles with the same vertices in the first of them.
std::int64_t merge_duplicates(ArrangementWork& work) {
  const std::vector<Unoriented> triangles(work.soup.triangles.begin(), work.soup.triangles.end());
  const std::vector<std::uint32_t> first = first_of_equals(
      triangles.size(),
      [&](std::uint32_t i) {
        const Triangle& t = triangles[i].corners;
        return mixed(mixed(0, std::uint64_t{t[0]} << 32 | t[1]), t[2]);
      },
      [&](std::uint32_t i, std::uint32_t j) { return triangles[i].corners == triangles[j].corners; });
  std::vector<std::uint32_t> keep;
  keep.reserve(triangles.size());
  for (std::uint32_t i = 0; i < triangles.size(); ++i) {
    if (first[i] == i) {
      keep.push_back(i);
    } else {
      const int sign = triangles[i].turned == triangles[first[i]].turned ? 1 : -1;
      work.multiplicity[first[i]] += sign * work.multiplicity[i];
    }
  }
  const auto merged = static_cast<std::int64_t>(triangles.size() - keep.size());
  if (merged > 0) select_triangles(work, keep);
  return merged;
}

/// Drops vertices that no triangle uses.
void compact_vertices(ArrangementWork& work) {
  std::vector<std::uint32_t> renamed(work.soup.positions.size(), kNone);
  for (const Triangle& t : work.soup.triangles)
    for (const std::uint32_t vertex : t) renamed[vertex] = 0;
  const auto old_end = renamed.begin() + static_cast<std::ptrdiff_t>(work.old_vertices);
  work.old_vertices = static_cast<std::size_t>(std::count(renamed.begin(), old_end, 0U));
  std::uint32_t count = 0;
  for (std::size_t i = 0; i < renamed.size(); ++i) {
    if (renamed[i] == kNone) continue;
    work.soup.positions[count] = work.soup.positions[i];
    renamed[i] = count++;
  }
  if (count == renamed.size()) return;
  work.soup.positions.resize(count);
  for (Triangle& t : work.soup.triangles)
    for (std::uint32_t& vertex : t) vertex = renamed[vertex];
}

}  // namespace

void ArrangementWork::reserve(std::size_t triangles) {
  soup.triangles.reserve(triangles);
  multiplicity.reserve(triangles);
  source.reserve(triangles);
  suspects.reserve(triangles);
}

void ArrangementWork::append(const Triangle& corners, std::int32_t its_multiplicity, std::uint32_t its_source,
                             bool suspect) {
  soup.triangles.push_back(corners);
  multiplicity.push_back(its_multiplicity);
  source.push_back(its_source);
  suspects.push_back(suspect);
}

void ArrangementWork::append(const ArrangementWork& other, std::uint32_t triangle) {
  append(other.soup.triangles[triangle], other.multiplicity[triangle], other.source[triangle],
         other.suspects[triangle]);
}

Removed clean_up(ArrangementWork& work, const RunContext& context) {
  Removed removed;
  context.check_cancelled();
  removed.vertices = merge_vertices(work.soup);
  removed.degenerate = drop_degenerate(work, context);
  context.check_cancelled();
  removed.duplicates = merge_duplicates(work);
  context.check_cancelled();
  compact_vertices(work);
  return removed;
}

}  // namespace voxcarve
