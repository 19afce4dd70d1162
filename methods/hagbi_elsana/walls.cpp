#include "methods/hagbi_elsana/walls.h"

#include <algorithm>
#include <array>
#include <string>

#include "common/run/errors.h"
#include "methods/hagbi_elsana/complement.h"
#include "methods/hagbi_elsana/facet_table.h"

namespace voxcarve {

namespace {

/// A tetrahedron's corners in ascending order; two bits each say which corner it was.
std::array<std::uint64_t, 4> sorted_corners(const std::array<std::uint32_t, 4>& corners) {
  std::array<std::uint64_t, 4> sorted{};
  for (std::size_t i = 0; i < 4; ++i) sorted[i] = std::uint64_t{corners[i]} << 2 | i;
  const auto order = [&](std::size_t a, std::size_t b) {
    const std::uint64_t low = std::min(sorted[a], sorted[b]);
    sorted[b] = std::max(sorted[a], sorted[b]);
    sorted[a] = low;
  };
  order(0, 1);
  order(2, 3);
  order(0, 2);
  order(1, 3);
  order(1, 2);
  return sorted;
}

void find_walls_of(std::uint32_t t, const std::array<std::uint32_t, 4>& corners, const FacetTable& table,
                   std::vector<Wall>& found) {
  const std::array<std::uint64_t, 4> sorted = sorted_corners(corners);
  const auto corner = [&](std::size_t i) { return static_cast<std::uint32_t>(sorted[i] >> 2); };
  std::array<FacetTable::Entry, 4> facet{};  // by face
  const auto opposite = [&](std::size_t i) -> FacetTable::Entry& { return facet[sorted[i] & 3]; };
  const std::uint32_t b = corner(1);
  const std::uint32_t c = corner(2);
  const std::uint32_t d = corner(3);
  const auto at_first = table.find<3>(corner(0), {{{b, c}, {b, d}, {c, d}}});
  opposite(3) = at_first[0];
  opposite(2) = at_first[1];
  opposite(1) = at_first[2];
  opposite(0) = table.find<1>(b, {{{c, d}}})[0];
  for (std::uint8_t i = 0; i < 4; ++i) {
    if (!facet[i].exists()) continue;
    const auto& order = Complement::kFace[i];
    const auto at = [&](std::size_t k) { return corners[static_cast<std::size_t>(order[k])]; };
    found.push_back({t, facet[i].facet(), i, SortedTriangle({at(0), at(1), at(2)}).odd == facet[i].odd()});
  }
}

}  // namespace

Walls find_walls(const Tetrahedralization& input, const RunContext& context) {
  const FacetTable table(input.facets, input.points.size());
  const std::int64_t count = std::ssize(input.tetrahedra);
  Walls walls;
  walls.faces.resize(input.tetrahedra.size());
  constexpr std::int64_t kGrain = 1 << 14;
  walls.pieces.resize(static_cast<std::size_t>((count + kGrain - 1) / kGrain));
  parallel_for(context, 0, count, kGrain, [&](std::int64_t begin, std::int64_t end) {
    std::vector<Wall>& mine = walls.pieces[static_cast<std::size_t>(begin / kGrain)];
    for (auto t = static_cast<std::uint32_t>(begin); t < static_cast<std::uint32_t>(end); ++t) {
      find_walls_of(t, input.tetrahedra[t], table, mine);
    }
    for (const Wall& wall : mine) {
      walls.faces[wall.tetrahedron] = static_cast<std::uint8_t>(walls.faces[wall.tetrahedron] | 1 << wall.face);
    }
  });
  std::vector<std::uint8_t> met(input.facets.size(), 0);
  walls.for_each([&](const Wall& wall) { met[wall.facet] = 1; });
  const auto missing = std::ranges::find(met, 0);
  if (missing != met.end()) {
    const auto facet = static_cast<std::size_t>(missing - met.begin());
    throw MethodFailure("the tetrahedralization has lost triangle " + std::to_string(input.facet_source[facet]) +
                        " of the model");
  }
  return walls;
}

std::vector<HullFace> find_hull(const Tetrahedralization& input) {
  std::vector<HullFace> hull;
  for (std::uint32_t t = 0; t < input.neighbors.size(); ++t) {
    const auto& around = input.neighbors[t];
    if ((around[0] | around[1] | around[2] | around[3]) >= 0) continue;
    for (int i = 0; i < 4; ++i) {
      if (around[static_cast<std::size_t>(i)] < 0) hull.push_back({t, i});
    }
  }
  return hull;
}

Regions find_regions(const Tetrahedralization& input, std::span<const HullFace> hull,
                     std::vector<std::uint8_t> barriers, const RunContext& context) {
  constexpr std::uint8_t kReached = 1 << 4;  // beside the four barriers: all that a look at a neighbour reads
  constexpr std::size_t kAhead = 16;         // neighbours of those that come so much later are fetched
  constexpr std::size_t kCheckEvery = 1 << 16;
  const std::size_t count = input.tetrahedra.size();
  Regions regions;
  regions.of.resize(count);
  std::vector<std::uint32_t> queue(count + 4);  // one more may be written for each face, if only to be overwritten
  std::size_t next = 0;
  std::size_t end = 0;
  const auto enter = [&](std::uint32_t t) {
    queue[end] = t;
    end += (barriers[t] & kReached) == 0;
    barriers[t] |= kReached;
  };
  const auto flood = [&](std::uint32_t region) {
    for (; next < end; ++next) {
      if (next % kCheckEvery == 0) context.check_cancelled();
      __builtin_prefetch(&input.neighbors[queue[std::min(next + kAhead, end - 1)]]);
      const std::uint32_t t = queue[next];
      regions.of[t] = region;
      const std::uint32_t closed = barriers[t];
      for (std::size_t i = 0; i < 4; ++i) {  // without a branch: barriers follow no pattern
        enter((closed >> i & 1) != 0 ? t : static_cast<std::uint32_t>(input.neighbors[t][i]));
      }
    }
  };
  for (const HullFace& face : hull) {
    if ((barriers[face.tetrahedron] >> face.face & 1) == 0) enter(face.tetrahedron);
  }
  for (const HullFace& face : hull) barriers[face.tetrahedron] |= static_cast<std::uint8_t>(1 << face.face);
  flood(0);
  regions.count = 1;
  for (std::uint32_t t = 0; t < count; ++t) {
    if ((barriers[t] & kReached) != 0) continue;
    enter(t);
    flood(regions.count++);
  }
  return regions;
}

}  // namespace voxcarve
