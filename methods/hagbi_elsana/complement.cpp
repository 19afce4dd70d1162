// Based on [HE10, 3]; what it leaves open, and how it is decided here: README.md.
#include "methods/hagbi_elsana/complement.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "common/mesh/topology.h"
#include "common/mesh/winding_number.h"
#include "common/run/errors.h"
#include "methods/hagbi_elsana/tetrahedron.h"
#include "methods/hagbi_elsana/walls.h"

namespace voxcarve {

namespace {

constexpr std::uint32_t kNone = Complement::kNone;

class Classifier {
 public:
  Classifier(const Tetrahedralization& input, const TriangleSoup& model, const std::vector<std::int32_t>& multiplicity,
             RunContext& context)
      : input_(input), model_(model), multiplicity_(multiplicity), context_(context) {}

  Classification run(InsideRule rule) {
    const auto count = static_cast<std::uint32_t>(input_.tetrahedra.size());
    constexpr std::uint64_t kBytes = 1 + 1 + 4 + 4 + 4;  // walls, barriers, region, queue, number
    constexpr std::uint64_t kOutput = 16 + 16 + 1;
    constexpr std::uint64_t kBytesAFacet = 12 + 4 * sizeof(Wall) + 2 * sizeof(WallCrossing);
    Stage stage(context_, "classification", 5);
    context_.require_memory(std::uint64_t{count} * (kBytes + kOutput) + input_.facets.size() * kBytesAFacet,
                            "classification");
    walls_ = find_walls(input_, context_);
    hull_ = find_hull(input_);
    stage.advance(1);
    if (rule == InsideRule::kWinding) {
      regions_ = find_regions(input_, hull_, walls_.faces, context_);
      decide_regions();
    } else {
      decide_by_winding_number();
    }
    stage.advance(1);
    number_outside();
    stage.advance(1);
    make_complement();
    stage.advance(1);
    find_voids();
    label_solids();
    stage.advance(1);
    return std::move(result_);
  }

 private:
  Triangle face(std::uint32_t t, int i) const {
    const auto& order = Complement::kFace[static_cast<std::size_t>(i)];
    const auto& corner = input_.tetrahedra[t];
    return {corner[static_cast<std::size_t>(order[0])], corner[static_cast<std::size_t>(order[1])],
            corner[static_cast<std::size_t>(order[2])]};
  }
  std::int32_t neighbor(std::uint32_t t, int i) const { return input_.neighbors[t][static_cast<std::size_t>(i)]; }
  bool is_wall(std::uint32_t t, int i) const { return (walls_.faces[t] >> i & 1) != 0; }
  bool is_inside(std::uint32_t t) const { return inside_[regions_.of[t]] != 0; }
  std::uint32_t region_beyond(const Wall& wall) const {
    const std::int32_t beyond = neighbor(wall.tetrahedron, wall.face);
    return beyond < 0 ? 0 : regions_.of[static_cast<std::uint32_t>(beyond)];
  }

  /// What the winding number gains on the way out of a tetrahedron through a wall.
  std::int64_t gain(const Wall& wall) const {
    const std::int64_t times = multiplicity_[input_.facet_source[wall.facet]];
    return wall.in_front ? times : -times;
  }

  struct WallCrossing {
    std::uint32_t from = 0, to = 0;
    std::int64_t gain = 0;

    auto operator<=>(const WallCrossing&) const = default;
  };

  /// What walls say of the regions beside them, sorted, each nearly once.
  std::vector<WallCrossing> find_wall_crossings() const {
    std::vector<WallCrossing> crossings;
    // Most walls around a region say the same: what its last ones said, inwards and outwards, is not said again.
    std::vector<std::array<WallCrossing, 2>> last(regions_.count);
    const auto say = [&](const WallCrossing& crossing) {
      WallCrossing& before = last[std::max(crossing.from, crossing.to)][crossing.from < crossing.to ? 1 : 0];
      if (crossing == before) return;
      crossings.push_back(crossing);
      before = crossing;
    };
    walls_.for_each([&](const Wall& wall) {
      const std::uint32_t here = regions_.of[wall.tetrahedron];
      const std::uint32_t beyond = region_beyond(wall);
      if (beyond == here) return;
      const std::int64_t gained = gain(wall);
      say({here, beyond, gained});
      if (neighbor(wall.tetrahedron, wall.face) < 0) say({beyond, here, -gained});
    });
    std::ranges::sort(crossings);
    return crossings;
  }

  void decide_regions() {
    const std::vector<WallCrossing> crossings = find_wall_crossings();
    const std::size_t regions = regions_.count;
    std::vector<std::size_t> first(regions + 1, 0);
    for (const WallCrossing& crossing : crossings) ++first[crossing.from + 1];
    for (std::size_t r = 0; r < regions; ++r) first[r + 1] += first[r];

    std::vector<std::int64_t> winding(regions, 0);
    std::vector<std::uint8_t> known(regions, 0);
    std::vector<std::uint32_t> queue = {0};
    known[0] = 1;
    for (std::size_t next = 0; next < queue.size(); ++next) {  // every region lies behind some wall of another
      const std::uint32_t region = queue[next];
      for (std::size_t c = first[region]; c < first[region + 1]; ++c) {
        if (known[crossings[c].to] != 0) continue;
        known[crossings[c].to] = 1;
        winding[crossings[c].to] = winding[region] + crossings[c].gain;
        queue.push_back(crossings[c].to);
      }
    }
    std::vector<std::uint8_t> contradictory(regions, 0);
    for (const WallCrossing& crossing : crossings) {
      if (winding[crossing.to] != winding[crossing.from] + crossing.gain) {
        contradictory[crossing.from] = contradictory[crossing.to] = 1;
      }
    }
    inside_.assign(regions, 0);
    if (std::ranges::count(contradictory, 1) > 0) mark_mostly_wound(contradictory);
    for (std::uint32_t r = 1; r < regions_.count; ++r) {
      if (contradictory[r] == 0) {
        inside_[r] = winding[r] != 0;
      } else if (winding[r] % 2 != 0) {
        inside_[r] = 1;
      }
      result_.contradictory_regions += contradictory[r];
      if (contradictory[r] == 0 && std::abs(winding[r]) > 1) ++result_.nested_regions;
    }
  }

  /// Marks the contradictory regions in most of whose volume the generalised winding number is beyond 1/2: a solid that
  /// is there twice, say, which an even number of walls surrounds.
  void mark_mostly_wound(const std::vector<std::uint8_t>& contradictory) {
    context_.require_memory(WindingNumber::memory_estimate(model_.triangles.size()), "winding numbers");
    const WindingNumber winding(model_, multiplicity_);
    std::vector<std::uint8_t> wound(regions_.of.size(), 0);
    const auto is_open = [&](std::size_t t) { return regions_.of[t] != 0 && contradictory[regions_.of[t]] != 0; };
    constexpr std::int64_t kGrain = 256;
    parallel_for(context_, 0, std::ssize(wound), kGrain, [&](std::int64_t begin, std::int64_t end) {
      for (auto t = static_cast<std::size_t>(begin); t < static_cast<std::size_t>(end); ++t) {
        wound[t] = is_open(t) && std::abs(winding.at(centroid(input_.points, input_.tetrahedra[t]))) > 0.5;
      }
    });
    std::vector<double> surplus(regions_.count, 0);  // of what is wound over what is not
    for (std::size_t t = 0; t < wound.size(); ++t) {
      if (!is_open(t)) continue;
      const double size = std::abs(volume(input_.points, input_.tetrahedra[t]));
      surplus[regions_.of[t]] += wound[t] != 0 ? size : -size;
    }
    for (std::size_t r = 0; r < inside_.size(); ++r) inside_[r] = surplus[r] > 0;
  }

  void decide_by_winding_number() {
    context_.require_memory(WindingNumber::memory_estimate(model_.triangles.size()), "winding numbers");
    const WindingNumber winding(model_, multiplicity_);
    constexpr std::uint8_t kUndecided = 2;
    constexpr std::int64_t kGrain = 256;
    std::vector<std::uint8_t> inside(input_.tetrahedra.size());
    parallel_for(context_, 0, std::ssize(inside), kGrain, [&](std::int64_t begin, std::int64_t end) {
      for (auto t = static_cast<std::size_t>(begin); t < static_cast<std::size_t>(end); ++t) {
        const TetrahedronCorners& corners = input_.tetrahedra[t];
        const bool wound = std::abs(winding.at(centroid(input_.points, corners))) > 0.5;
        inside[t] = is_flat(corners) ? kUndecided : wound;
      }
    });
    // The centroid of a flat one, between coplanar triangles, lies on the surface: it is where its neighbours are.
    std::vector<std::uint32_t> queue;
    for (std::uint32_t t = 0; t < inside.size(); ++t) {
      if (inside[t] != kUndecided) queue.push_back(t);
    }
    for (std::size_t next = 0; next < queue.size(); ++next) {
      for (int i = 0; i < 4; ++i) {
        const std::int32_t beyond = neighbor(queue[next], i);
        if (beyond < 0 || is_wall(queue[next], i)) continue;
        std::uint8_t& other = inside[static_cast<std::size_t>(beyond)];
        if (other != kUndecided) continue;
        other = inside[queue[next]];
        queue.push_back(static_cast<std::uint32_t>(beyond));
      }
    }
    std::ranges::replace(inside, kUndecided, std::uint8_t{0});
    take_inside(inside);
  }

  /// Regions that walls separate, and where a tetrahedron is inside and its neighbour is not.
  void take_inside(const std::vector<std::uint8_t>& inside) {
    std::vector<std::uint8_t> barriers = walls_.faces;
    for (std::uint32_t t = 0; t < inside.size(); ++t) {
      for (int i = 0; i < 4; ++i) {
        const bool beyond = neighbor(t, i) >= 0 && inside[static_cast<std::size_t>(neighbor(t, i))] != 0;
        if (beyond != (inside[t] != 0)) barriers[t] = static_cast<std::uint8_t>(barriers[t] | 1 << i);
      }
    }
    regions_ = find_regions(input_, hull_, std::move(barriers), context_);
    inside_.assign(regions_.count, 0);
    for (std::size_t t = 0; t < inside.size(); ++t) inside_[regions_.of[t]] = inside[t];
  }

  bool is_flat(const TetrahedronCorners& corners) const {
    constexpr double kFlat = 1e-9;  // of a cube on the longest edge; rounding leaves less
    const double longest = std::sqrt(longest_edge_squared(input_.points, corners));
    return std::abs(volume(input_.points, corners)) < kFlat * longest * longest * longest;
  }

  void number_outside() {
    const std::size_t count = input_.tetrahedra.size();
    number_.resize(count);
    std::uint32_t next = 0;
    for (std::uint32_t t = 0; t < count; ++t) number_[t] = is_inside(t) ? Complement::kSolid : next++;
    result_.complement.first_ghost = next;
    result_.tetrahedra = static_cast<std::uint32_t>(count);
  }

  void make_complement() {
    Complement& made = result_.complement;
    made.points = input_.points;
    made.model_points = static_cast<std::uint32_t>(input_.points.size() - input_.steiner_points);
    const std::size_t size = std::size_t{made.first_ghost} + hull_.size();
    made.corners.reserve(size);
    made.neighbors.reserve(size);
    made.walls.reserve(size);
    std::uint32_t next_hull = 0;
    for (std::uint32_t t = 0; t < number_.size(); ++t) {
      const bool outside = number_[t] != Complement::kSolid;
      std::array<std::uint32_t, 4> around{};
      for (int i = 0; i < 4 && outside; ++i) {
        const std::int32_t beyond = neighbor(t, i);
        if (beyond >= 0) around[static_cast<std::size_t>(i)] = number_[static_cast<std::size_t>(beyond)];
      }
      for (; next_hull < hull_.size() && hull_[next_hull].tetrahedron == t; ++next_hull) {
        around[static_cast<std::size_t>(hull_[next_hull].face)] = made.first_ghost + next_hull;
      }
      if (!outside) continue;
      made.corners.push_back(input_.tetrahedra[t]);
      made.neighbors.push_back(around);
      made.walls.push_back(walls_.faces[t]);
    }
    add_ghosts();
  }

  void add_ghosts() {
    Complement& made = result_.complement;
    struct Side {
      std::uint64_t edge = 0;
      std::uint32_t ghost = 0;
      std::uint32_t face = 0;
    };
    std::vector<Side> sides;
    sides.reserve(3 * hull_.size());
    for (const HullFace& at : hull_) {
      const auto ghost = static_cast<std::uint32_t>(made.corners.size());
      const Triangle corners = face(at.tetrahedron, at.face);
      // Turned around, for the ghost sees the face from the other side.
      made.corners.push_back({corners[1], corners[0], corners[2], Complement::kFar});
      made.neighbors.push_back({kNone, kNone, kNone, number_[at.tetrahedron]});
      made.walls.push_back(is_wall(at.tetrahedron, at.face) ? 8 : 0);
      for (std::uint32_t i = 0; i < 3; ++i) {
        const std::uint32_t a = made.corners[ghost][(i + 1) % 3];
        const std::uint32_t b = made.corners[ghost][(i + 2) % 3];
        sides.push_back({std::uint64_t{std::min(a, b)} << 32 | std::max(a, b), ghost, i});
      }
    }
    std::ranges::sort(sides, {}, [](const Side& side) { return std::pair(side.edge, side.ghost); });
    for (std::size_t s = 0; s < sides.size(); s += 2) {
      const bool paired = s + 1 < sides.size() && sides[s].edge == sides[s + 1].edge &&
                          (s + 2 == sides.size() || sides[s + 2].edge != sides[s].edge);
      if (!paired) throw MethodFailure("the tetrahedralization's hull is not closed");
      made.neighbors[sides[s].ghost][sides[s].face] = sides[s + 1].ghost;
      made.neighbors[sides[s + 1].ghost][sides[s + 1].face] = sides[s].ghost;
    }
    result_.hull_faces = static_cast<std::uint32_t>(hull_.size());
    std::vector<std::uint8_t> on_hull(made.points.size(), 0);
    for (const HullFace& at : hull_) {
      for (const std::uint32_t corner : face(at.tetrahedron, at.face)) on_hull[corner] = 1;
    }
    result_.hull_points = static_cast<std::uint32_t>(std::ranges::count(on_hull, 1));
  }

  /// Regions on the outside that are not the one beyond the hull.
  void find_voids() {
    const Complement& made = result_.complement;
    std::vector<std::uint32_t> void_of(regions_.count, kNone);
    std::vector<double> longest;
    for (std::uint32_t t = 0; t < number_.size() && regions_.count > 1; ++t) {
      const std::uint32_t region = regions_.of[t];
      if (region == 0 || inside_[region] != 0) continue;
      if (void_of[region] == kNone) {
        void_of[region] = static_cast<std::uint32_t>(longest.size());
        result_.voids.emplace_back();
        longest.push_back(-1);
      }
      Void& found = result_.voids[void_of[region]];
      double& most = longest[void_of[region]];
      found.volume += volume(made.points, input_.tetrahedra[t]);
      const double edge = longest_edge_squared(made.points, input_.tetrahedra[t]);
      if (edge > most) {
        most = edge;
        found.seed = number_[t];
      }
    }
    std::ranges::sort(result_.voids, {}, &Void::seed);
  }

  /// M is closed: inside tetrahedra with their faces, and walls. What touches in a vertex is one component.
  /// Counts folds, too.
  void label_solids() {
    Complement& made = result_.complement;
    DisjointSets sets(made.points.size());
    std::vector<std::uint32_t> region_at(made.points.size(), kNone);  // the last one inside that was met there
    std::vector<std::uint32_t> point_of(regions_.count, kNone);       // its first corner
    for (std::uint32_t t = 0; t < number_.size(); ++t) {
      const std::uint32_t region = regions_.of[t];
      if (inside_[region] == 0) continue;
      if (point_of[region] == kNone) point_of[region] = input_.tetrahedra[t][0];
      for (const std::uint32_t corner : input_.tetrahedra[t]) {
        if (region_at[corner] == region) continue;
        region_at[corner] = region;
        sets.join(point_of[region], corner);
      }
    }
    walls_.for_each([&](const Wall& wall) {
      // Other walls are faces of tetrahedra that are inside.
      if (is_inside(wall.tetrahedron) || inside_[region_beyond(wall)] != 0) return;
      const std::int32_t beyond = neighbor(wall.tetrahedron, wall.face);
      // Of the two sides of a fold one is counted.
      result_.folds += beyond < 0 || wall.tetrahedron < static_cast<std::uint32_t>(beyond);
      const Triangle& corners = input_.facets[wall.facet];
      for (const std::uint32_t corner : corners) {
        region_at[corner] = 0;
        sets.join(corners[0], corner);
      }
    });
    made.solid_of_point.assign(made.points.size(), kNone);
    std::uint32_t solids = 0;
    for (std::uint32_t point = 0; point < made.points.size(); ++point) {
      if (region_at[point] == kNone) continue;
      const std::uint32_t root = sets.find(point);  // its smallest point
      made.solid_of_point[point] = root == point ? solids++ : made.solid_of_point[root];
    }
  }

  const Tetrahedralization& input_;
  const TriangleSoup& model_;
  const std::vector<std::int32_t>& multiplicity_;
  RunContext& context_;
  Walls walls_;
  std::vector<HullFace> hull_;
  Regions regions_;
  std::vector<std::uint8_t> inside_;   ///< by region
  std::vector<std::uint32_t> number_;  ///< in the complement
  Classification result_;
};

}  // namespace

Classification classify(const Tetrahedralization& tetrahedralization, const TriangleSoup& model,
                        const std::vector<std::int32_t>& multiplicity, InsideRule rule, RunContext& context) {
  return Classifier(tetrahedralization, model, multiplicity, context).run(rule);
}

}  // namespace voxcarve
