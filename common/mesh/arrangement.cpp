// The scheme of exact intersection, one triangulation a plane, rounding and repetition is common; see [ZGZJ16] for a
// survey of its kind. Differs in what it keeps: coincident triangles become one with a signed multiplicity, zero
// included, so that both the walls and the winding numbers are the soup's.
#include "common/mesh/arrangement.h"

#include <algorithm>
#include <numeric>
#include <string>

#include "common/mesh/planar_subdivision.h"
#include "common/mesh/topology.h"
#include "common/mesh/triangle_crossings.h"
#include "common/run/errors.h"

namespace voxcarve {

namespace {

constexpr std::int64_t kMostPasses = 5;
constexpr double kFirstWeld = 0x1p-48;  // of the largest coordinate: 16 units in its last place
constexpr double kWeldGrowth = 16;      // from pass to pass
constexpr std::int64_t kGroupsAChunk = 8;
constexpr std::uint32_t kNone = 0xffffffffU;

/// What the passes work on.
struct Work {
  TriangleSoup soup;
  std::vector<std::int32_t> multiplicity;
  std::vector<std::uint32_t> source;
  std::size_t old_vertices = 0;  ///< the first so many positions are the soup's own
};

/// How many of each kind a clean-up took away.
struct Removed {
  std::int64_t vertices = 0;
  std::int64_t degenerate = 0;
  std::int64_t duplicates = 0;
};

/// Renames every vertex that triangles use to the first of them at its position.
std::int64_t merge_vertices(TriangleSoup& soup) {
  std::vector<std::uint32_t> order;
  {
    std::vector<bool> used(soup.positions.size(), false);
    for (const Triangle& t : soup.triangles)
      for (const std::uint32_t vertex : t) used[vertex] = true;
    for (std::uint32_t i = 0; i < used.size(); ++i)
      if (used[i]) order.push_back(i);
  }
  const auto compare = [&soup](std::uint32_t i, std::uint32_t j) {
    const Point& p = soup.positions[i];
    const Point& q = soup.positions[j];
    for (const Eigen::Index axis : {0, 1, 2})
      if (p[axis] != q[axis]) return p[axis] < q[axis] ? -1 : 1;
    return 0;
  };
  std::sort(order.begin(), order.end(), [&compare](std::uint32_t i, std::uint32_t j) {
    const int sign = compare(i, j);
    return sign != 0 ? sign < 0 : i < j;
  });
  std::vector<std::uint32_t> first(soup.positions.size(), kNone);
  std::int64_t merged = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && compare(order[i - 1], order[i]) == 0;
    first[order[i]] = same ? first[order[i - 1]] : order[i];
    merged += same ? 1 : 0;
  }
  for (Triangle& t : soup.triangles)
    for (std::uint32_t& vertex : t) vertex = first[vertex];
  return merged;
}

/// Keeps the triangles that `keep` names, in its order.
void select_triangles(Work& work, const std::vector<std::uint32_t>& keep) {
  const auto select = [&keep](auto& values) {
    std::decay_t<decltype(values)> selected;
    selected.reserve(keep.size());
    for (const std::uint32_t index : keep) selected.push_back(values[index]);
    values = std::move(selected);
  };
  select(work.soup.triangles);
  select(work.multiplicity);
  select(work.source);
}

/// The triangle with its smallest vertex first and, if need be, turned round, so that coinciding ones become equal.
struct Unoriented {
  Triangle corners;
  bool turned;
  std::uint32_t index;

  Unoriented(const Triangle& t, std::uint32_t i) : corners(t), turned(false), index(i) {
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
    if (corners[1] > corners[2]) {
      std::swap(corners[1], corners[2]);
      turned = true;
    }
  }
};

/// Adds up the multiplicities of triangles with the same vertices in the first of them.
std::int64_t merge_duplicates(Work& work) {
  std::vector<Unoriented> triangles;
  triangles.reserve(work.soup.triangles.size());
  for (std::uint32_t i = 0; i < work.soup.triangles.size(); ++i) triangles.emplace_back(work.soup.triangles[i], i);
  std::sort(triangles.begin(), triangles.end(), [](const Unoriented& t, const Unoriented& u) {
    return t.corners != u.corners ? t.corners < u.corners : t.index < u.index;
  });
  std::vector<std::uint32_t> keep;
  const Unoriented* first = nullptr;
  for (const Unoriented& t : triangles) {
    if (first == nullptr || first->corners != t.corners) {
      first = &t;
      keep.push_back(t.index);
    } else {
      work.multiplicity[first->index] += (t.turned == first->turned ? 1 : -1) * work.multiplicity[t.index];
    }
  }
  const auto merged = static_cast<std::int64_t>(triangles.size() - keep.size());
  std::sort(keep.begin(), keep.end());
  if (merged > 0) select_triangles(work, keep);
  return merged;
}

/// Drops vertices that no triangle uses.
void compact_vertices(Work& work) {
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
  work.soup.positions.resize(count);
  for (Triangle& t : work.soup.triangles)
    for (std::uint32_t& vertex : t) vertex = renamed[vertex];
}

Removed clean_up(Work& work, const RunContext& context) {
  Removed removed;
  context.check_cancelled();
  removed.vertices = merge_vertices(work.soup);
  context.check_cancelled();
  std::vector<std::uint32_t> keep;
  keep.reserve(work.soup.triangles.size());
  for (std::uint32_t i = 0; i < work.soup.triangles.size(); ++i) {
    if (i % 65536 == 0) context.check_cancelled();
    const Triangle& t = work.soup.triangles[i];
    const auto& p = work.soup.positions;
    if (has_distinct_corners(t) && !are_collinear(p[t[0]], p[t[1]], p[t[2]])) keep.push_back(i);
  }
  removed.degenerate = static_cast<std::int64_t>(work.soup.triangles.size() - keep.size());
  if (removed.degenerate > 0) select_triangles(work, keep);
  context.check_cancelled();
  removed.duplicates = merge_duplicates(work);
  compact_vertices(work);
  return removed;
}

/// Moves new vertices at crossings to the first vertex there, if one is within `reach`. Where planes are nearly the
/// same, points closer than the spacing of numbers come from them, and rounding turns the parts between these over,
/// again in each pass; without such parts there is nothing to turn over.
void weld(Work& work, const std::vector<Crossing>& crossings, double reach) {
  auto& positions = work.soup.positions;
  std::vector<std::uint32_t> near;
  for (const Crossing& crossing : crossings) {
    for (const std::uint32_t triangle : {crossing.first, crossing.second}) {
      const Triangle& t = work.soup.triangles[triangle];
      near.insert(near.end(), t.begin(), t.end());
    }
  }
  std::sort(near.begin(), near.end());
  near.erase(std::unique(near.begin(), near.end()), near.end());
  std::stable_sort(near.begin(), near.end(),
                   [&positions](std::uint32_t i, std::uint32_t j) { return positions[i][0] < positions[j][0]; });
  DisjointSets places(positions.size());  // the representative is the first: an old vertex, where there is one
  for (std::size_t i = 0; i < near.size(); ++i) {
    for (std::size_t j = i + 1; j < near.size(); ++j) {
      const Point apart = positions[near[j]] - positions[near[i]];
      if (apart[0] > reach) break;
      if (apart.cwiseAbs().maxCoeff() <= reach) places.join(near[i], near[j]);
    }
  }
  for (const std::uint32_t vertex : near) {
    if (vertex >= work.old_vertices) positions[vertex] = positions[places.find(vertex)];
  }
}

/// Triangles of one plane that overlap or touch in it, with what crosses them from other planes.
struct Group {
  std::vector<std::uint32_t> triangles;
  std::vector<PlanarConstraint> constraints;
};

/// A single triangle that others merely touch with its own corners and edges stays as it is.
bool needs_subdivision(const TriangleSoup& soup, const Group& group) {
  if (group.triangles.size() > 1) return true;
  const Triangle& t = soup.triangles[group.triangles[0]];
  const auto is_corner = [&t](const ContactPoint& point) {
    return point.is_vertex() && std::find(t.begin(), t.end(), point.from) != t.end();
  };
  return !std::all_of(group.constraints.begin(), group.constraints.end(),
                      [&is_corner](const PlanarConstraint& c) { return is_corner(c[0]) && is_corner(c[1]); });
}

/// In the order of their first triangles.
std::vector<Group> groups_of(const TriangleSoup& soup, const std::vector<Crossing>& crossings) {
  DisjointSets planes(soup.triangles.size());
  std::vector<bool> touched(soup.triangles.size(), false);
  for (const Crossing& crossing : crossings) {
    touched[crossing.first] = touched[crossing.second] = true;
    if (crossing.coplanar) planes.join(crossing.first, crossing.second);
  }
  std::vector<Group> groups;
  std::vector<std::uint32_t> group_of(soup.triangles.size(), kNone);  // of representatives, which come first
  for (std::uint32_t triangle = 0; triangle < soup.triangles.size(); ++triangle) {
    if (!touched[triangle]) continue;
    std::uint32_t& group = group_of[planes.find(triangle)];
    if (group == kNone) {
      group = static_cast<std::uint32_t>(groups.size());
      groups.emplace_back();
    }
    groups[group].triangles.push_back(triangle);
  }
  for (const Crossing& crossing : crossings) {
    if (crossing.coplanar) continue;
    for (const std::uint32_t triangle : {crossing.first, crossing.second}) {
      groups[group_of[planes.find(triangle)]].constraints.push_back(crossing.ends);
    }
  }
  for (Group& group : groups) {  // several triangles of a plane may share an edge that something crosses
    std::sort(group.constraints.begin(), group.constraints.end());
    const auto last = std::unique(group.constraints.begin(), group.constraints.end());
    group.constraints.erase(last, group.constraints.end());
  }
  std::erase_if(groups, [&soup](const Group& group) { return !needs_subdivision(soup, group); });
  return groups;
}

/// Bytes of a pass beside the soup: a constraint costs exact numbers in the triangulation of its plane, of which there
/// are as many at once as threads, and some ten vertices and parts for good.
std::uint64_t memory_estimate(const std::vector<Group>& groups, int threads) {
  constexpr std::uint64_t kExactBytes = 8'000;
  constexpr std::uint64_t kLastingBytes = 600;
  std::uint64_t largest = 0;
  std::uint64_t all = 0;
  for (const Group& group : groups) {
    const std::uint64_t items = group.constraints.size() + group.triangles.size();
    largest = std::max(largest, items);
    all += items;
  }
  return all * (sizeof(PlanarConstraint) + kLastingBytes) + largest * kExactBytes * static_cast<std::uint64_t>(threads);
}

/// Appends the parts of a group, each in the orientation of its first source.
void append_parts(const PlanarSubdivision& division, const Work& work, std::size_t old_positions, Work& out) {
  const auto shift = static_cast<std::uint32_t>(out.soup.positions.size() - old_positions);
  std::size_t cover = 0;
  for (const PlanarPart& part : division.parts) {
    PlanarCover first = division.covers[cover];
    std::int32_t multiplicity = 0;  // in the orientation of the part
    for (; cover < part.covers_end; ++cover) {
      const PlanarCover& c = division.covers[cover];
      multiplicity += (c.aligned ? 1 : -1) * work.multiplicity[c.triangle];
      if (work.source[c.triangle] < work.source[first.triangle]) first = c;
    }
    Triangle corners = part.corners;
    for (std::uint32_t& vertex : corners)
      if (vertex >= old_positions) vertex += shift;
    if (!first.aligned) std::swap(corners[1], corners[2]);
    out.soup.triangles.push_back(corners);
    out.multiplicity.push_back(first.aligned ? multiplicity : -multiplicity);
    out.source.push_back(work.source[first.triangle]);
  }
  out.soup.positions.insert(out.soup.positions.end(), division.new_positions.begin(), division.new_positions.end());
}

/// Replaces the triangles of the groups by their parts.
Work replaced(const Work& work, const std::vector<Group>& groups, const std::vector<PlanarSubdivision>& divisions) {
  Work out;
  out.old_vertices = work.old_vertices;
  out.soup.positions = work.soup.positions;
  std::vector<bool> split(work.soup.triangles.size(), false);
  for (const Group& group : groups)
    for (const std::uint32_t triangle : group.triangles) split[triangle] = true;
  for (std::size_t i = 0; i < split.size(); ++i) {
    if (split[i]) continue;
    out.soup.triangles.push_back(work.soup.triangles[i]);
    out.multiplicity.push_back(work.multiplicity[i]);
    out.source.push_back(work.source[i]);
  }
  for (const PlanarSubdivision& division : divisions) append_parts(division, work, work.soup.positions.size(), out);
  std::vector<std::uint32_t> order(out.source.size());
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(),
                   [&out](std::uint32_t i, std::uint32_t j) { return out.source[i] < out.source[j]; });
  select_triangles(out, order);
  return out;
}

/// One pass: cuts all triangles along their crossings, to the last bit, and rounds. Returns how many were cut.
std::int64_t resolve(Work& work, const std::vector<Crossing>& crossings, RunContext& context) {
  const std::vector<Group> groups = groups_of(work.soup, crossings);
  std::int64_t total = 0;
  std::int64_t triangles = 0;
  for (const Group& group : groups) {
    total += static_cast<std::int64_t>(group.triangles.size() + group.constraints.size());
    triangles += static_cast<std::int64_t>(group.triangles.size());
  }
  Stage stage(context, "arrangement", total);
  context.require_memory(memory_estimate(groups, context.threads) + crossings.size() * sizeof(Crossing),
                         "the arrangement of crossing triangles");
  std::vector<PlanarSubdivision> divisions(groups.size());
  parallel_for(context, 0, static_cast<std::int64_t>(groups.size()), kGroupsAChunk,
               [&](std::int64_t begin, std::int64_t end) {
                 for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
                   const Group& group = groups[i];
                   divisions[i] = subdivide(work.soup, group.triangles, group.constraints, context);
                   stage.advance(static_cast<std::int64_t>(group.triangles.size() + group.constraints.size()));
                 }
               });
  work = replaced(work, groups, divisions);
  clean_up(work, context);
  return triangles;
}

double largest_coordinate(const TriangleSoup& soup) {
  double largest = 0;
  for (const Point& p : soup.positions) largest = std::max(largest, p.cwiseAbs().maxCoeff());
  return largest;
}

[[noreturn]] void throw_unresolved(const Work& work, const std::vector<Crossing>& crossings) {
  throw MethodFailure("after " + std::to_string(kMostPasses) + " passes " + std::to_string(crossings.size()) +
                      " pairs of triangles still cross, parts of triangles " +
                      std::to_string(work.source[crossings[0].first]) + " and " +
                      std::to_string(work.source[crossings[0].second]) + " the first");
}

}  // namespace

Arrangement arrange(const TriangleSoup& soup, RunContext& context) {
  validate(soup, "the soup to arrange");
  Work work;
  ArrangementReport report;
  {
    Stage stage(context, "merging", 1);
    // The copy, and at the most sorted names of the vertices or the triangles beside it.
    context.require_memory(soup.positions.size() * 40 + soup.triangles.size() * 60, "merging equal vertices");
    work.soup.positions = soup.positions;
    work.soup.triangles = soup.triangles;
    work.multiplicity.assign(soup.triangles.size(), 1);
    work.source.resize(soup.triangles.size());
    std::iota(work.source.begin(), work.source.end(), 0U);
    work.old_vertices = soup.positions.size();
    const Removed removed = clean_up(work, context);
    report.merged_vertices = removed.vertices;
    report.degenerate_triangles = removed.degenerate;
    report.duplicate_triangles = removed.duplicates;
  }
  std::vector<Crossing> crossings = find_crossings(work.soup, context);
  report.crossing_pairs = static_cast<std::int64_t>(crossings.size());
  for (double reach = kFirstWeld * largest_coordinate(work.soup); !crossings.empty(); reach *= kWeldGrowth) {
    if (report.passes == kMostPasses) throw_unresolved(work, crossings);
    report.split_triangles += resolve(work, crossings, context);
    ++report.passes;
    crossings = find_crossings(work.soup, context);
    if (crossings.empty()) break;
    report.rounding_pairs += static_cast<std::int64_t>(crossings.size());
    weld(work, crossings, reach);
    clean_up(work, context);
    crossings = find_crossings(work.soup, context);
  }
  report.new_vertices = static_cast<std::int64_t>(work.soup.positions.size() - work.old_vertices);
  return {std::move(work.soup), std::move(work.multiplicity), std::move(work.source), report};
}

}  // namespace voxcarve
