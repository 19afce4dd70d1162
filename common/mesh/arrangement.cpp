// The scheme of exact intersection, one triangulation a plane, rounding and repetition is common; see [ZGZJ16] for a
// survey of its kind. Differs in what it keeps: coincident triangles become one with a signed multiplicity, zero
// included, so that both the walls and the winding numbers are the soup's.
#include "common/mesh/arrangement.h"

#include <algorithm>
#include <numeric>
#include <string>

#include "common/mesh/arrangement_work.h"
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

/// Moves new vertices at crossings to the first vertex there, if one is within `reach`. Where planes are nearly the
/// same, points closer than the spacing of numbers come from them, and rounding turns the parts between these over,
/// again in each pass; without such parts there is nothing to turn over.
void weld(ArrangementWork& work, const std::vector<Crossing>& crossings, double reach) {
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
  std::vector<bool> moved(positions.size(), false);
  for (const std::uint32_t vertex : near) {
    const std::uint32_t place = places.find(vertex);
    if (vertex < work.old_vertices || place == vertex) continue;
    positions[vertex] = positions[place];
    moved[vertex] = true;
  }
  for (std::size_t i = 0; i < work.suspects.size(); ++i) {
    const Triangle& t = work.soup.triangles[i];
    if (moved[t[0]] || moved[t[1]] || moved[t[2]]) work.suspects[i] = true;
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
void append_parts(const PlanarSubdivision& division, const ArrangementWork& work, std::size_t old_positions,
                  ArrangementWork& out) {
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
    out.append(corners, first.aligned ? multiplicity : -multiplicity, work.source[first.triangle], true);
  }
  out.soup.positions.insert(out.soup.positions.end(), division.new_positions.begin(), division.new_positions.end());
}

/// Replaces the triangles of the groups by their parts.
void replace(ArrangementWork& work, const std::vector<Group>& groups, const std::vector<PlanarSubdivision>& divisions) {
  const std::size_t old_positions = work.soup.positions.size();
  ArrangementWork parts;
  parts.soup.positions = std::move(work.soup.positions);
  for (const PlanarSubdivision& division : divisions) append_parts(division, work, old_positions, parts);
  std::vector<std::uint32_t> order(parts.source.size());
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(),
                   [&parts](std::uint32_t i, std::uint32_t j) { return parts.source[i] < parts.source[j]; });
  std::vector<bool> split(work.soup.triangles.size(), false);
  for (const Group& group : groups)
    for (const std::uint32_t triangle : group.triangles) split[triangle] = true;

  ArrangementWork out;
  out.old_vertices = work.old_vertices;
  out.soup.positions = std::move(parts.soup.positions);
  out.reserve(split.size() + order.size());
  std::size_t next = 0;  // in the order of the parts: those of a source come after what it has kept
  const auto append_parts_before = [&](std::uint32_t source) {
    for (; next < order.size() && parts.source[order[next]] < source; ++next) out.append(parts, order[next]);
  };
  for (std::uint32_t i = 0; i < split.size(); ++i) {
    if (split[i]) continue;
    append_parts_before(work.source[i]);
    out.append(work, i);
  }
  append_parts_before(kNone);
  work = std::move(out);
}

/// One pass: cuts all triangles along their crossings, to the last bit, and rounds. Returns how many were cut.
std::int64_t resolve(ArrangementWork& work, const std::vector<Crossing>& crossings, RunContext& context) {
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
  replace(work, groups, divisions);
  clean_up(work, context);
  return triangles;
}

double largest_coordinate(const TriangleSoup& soup) {
  double largest = 0;
  for (const Point& p : soup.positions) largest = std::max(largest, p.cwiseAbs().maxCoeff());
  return largest;
}

/// All pairs that cross. Suspects are then what is in them: of others, no two cross.
///
/// That stays so while suspects are replaced, as parts of them are suspects, and when vertices move, as their triangles
/// become suspects. Nor do other triangles cross after a clean-up: it moves nothing, and vertices that become common
/// are one more thing that triangles may have in common. So it is enough to look at suspects again.
std::vector<Crossing> find_next_crossings(ArrangementWork& work, RunContext& context) {
  const bool all = std::find(work.suspects.begin(), work.suspects.end(), false) == work.suspects.end();
  std::vector<Crossing> crossings =
      all ? find_crossings(work.soup, context) : find_crossings(work.soup, work.suspects, context);
  work.suspects.assign(work.suspects.size(), false);
  for (const Crossing& crossing : crossings) work.suspects[crossing.first] = work.suspects[crossing.second] = true;
  return crossings;
}

[[noreturn]] void throw_unresolved(const ArrangementWork& work, const std::vector<Crossing>& crossings) {
  throw MethodFailure("after " + std::to_string(kMostPasses) + " passes " + std::to_string(crossings.size()) +
                      " pairs of triangles still cross, parts of triangles " +
                      std::to_string(work.source[crossings[0].first]) + " and " +
                      std::to_string(work.source[crossings[0].second]) + " the first");
}

}  // namespace

Arrangement arrange(const TriangleSoup& soup, RunContext& context) {
  validate(soup, "the soup to arrange");
  ArrangementWork work;
  ArrangementReport report;
  {
    Stage stage(context, "merging", 1);
    // The copy, and at the most a hash table of the vertices or the triangles beside it.
    context.require_memory(soup.positions.size() * 40 + soup.triangles.size() * 60, "merging equal vertices");
    work.soup.positions = soup.positions;
    work.soup.triangles = soup.triangles;
    work.multiplicity.assign(soup.triangles.size(), 1);
    work.source.resize(soup.triangles.size());
    std::iota(work.source.begin(), work.source.end(), 0U);
    work.suspects.assign(soup.triangles.size(), true);
    work.old_vertices = soup.positions.size();
    const Removed removed = clean_up(work, context);
    report.merged_vertices = removed.vertices;
    report.degenerate_triangles = removed.degenerate;
    report.duplicate_triangles = removed.duplicates;
  }
  std::vector<Crossing> crossings = find_next_crossings(work, context);
  report.crossing_pairs = static_cast<std::int64_t>(crossings.size());
  for (double reach = kFirstWeld * largest_coordinate(work.soup); !crossings.empty(); reach *= kWeldGrowth) {
    if (report.passes == kMostPasses) throw_unresolved(work, crossings);
    report.split_triangles += resolve(work, crossings, context);
    ++report.passes;
    crossings = find_next_crossings(work, context);
    if (crossings.empty()) break;
    report.rounding_pairs += static_cast<std::int64_t>(crossings.size());
    weld(work, crossings, reach);
    clean_up(work, context);
    crossings = find_next_crossings(work, context);
  }
  report.new_vertices = static_cast<std::int64_t>(work.soup.positions.size() - work.old_vertices);
  return {std::move(work.soup), std::move(work.multiplicity), std::move(work.source), report};
}

}  // namespace voxcarve
