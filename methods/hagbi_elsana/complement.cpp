// Based on [HE10, 3]; what it leaves open, and how it is decided here: README.md.
#include "methods/hagbi_elsana/complement.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>
#include <tuple>

#include "common/mesh/topology.h"
#include "common/mesh/winding_number.h"
#include "common/run/errors.h"
#include "methods/hagbi_elsana/facet_table.h"
#include "methods/hagbi_elsana/tetrahedron.h"

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
    constexpr std::uint64_t kBytes = 4 * 4 + 4 + 1 + 4 + 4;  // walls, region, inside, number, stack
    constexpr std::uint64_t kOutput = 16 + 16 + 1;
    constexpr std::uint64_t kBytesAFacet = 8 + 2 * sizeof(Crossing);
    Stage stage(context_, "classification", 5);
    context_.require_memory(std::uint64_t{count} * (kBytes + kOutput) + input_.facets.size() * kBytesAFacet,
                            "classification");
    find_walls();
    stage.advance(1);
    inside_.assign(count, 0);
    if (rule == InsideRule::kWinding) {
      flood_regions();
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
  std::uint32_t facet_at(std::uint32_t t, int i) const {
    return facet_at_[4 * std::size_t{t} + static_cast<std::size_t>(i)];
  }

  void find_walls() {
    const FacetTable table(input_.facets);
    const std::size_t count = input_.tetrahedra.size();
    facet_at_.assign(4 * count, kNone);
    // Every facet lies between two tetrahedra or on the hull; each face is looked up from both its sides.
    constexpr std::int64_t kGrain = 1 << 14;
    parallel_for(context_, 0, static_cast<std::int64_t>(count), kGrain, [&](std::int64_t begin, std::int64_t end) {
      for (auto t = static_cast<std::uint32_t>(begin); t < static_cast<std::uint32_t>(end); ++t) {
        for (int i = 0; i < 4; ++i) {
          facet_at_[4 * std::size_t{t} + static_cast<std::size_t>(i)] = table.find(SortedTriangle(face(t, i)).corners);
        }
      }
    });
    std::vector<std::uint8_t> met(input_.facets.size(), 0);
    for (const std::uint32_t facet : facet_at_) {
      if (facet != kNone) met[facet] = 1;
    }
    const auto missing = std::ranges::find(met, 0);
    if (missing != met.end()) {
      const auto facet = static_cast<std::size_t>(missing - met.begin());
      throw MethodFailure("the tetrahedralization has lost triangle " + std::to_string(input_.facet_source[facet]) +
                          " of the model");
    }
  }

  /// Tetrahedra that no wall separates share a region; region 0 is the one that reaches beyond the hull.
  void flood_regions() {
    region_.assign(input_.tetrahedra.size(), kNone);
    std::vector<std::uint32_t> stack;
    const auto enter = [&](std::uint32_t t, std::uint32_t region) {
      if (region_[t] != kNone) return;
      region_[t] = region;
      stack.push_back(t);
    };
    const auto flood = [&](std::uint32_t region) {
      while (!stack.empty()) {
        const std::uint32_t t = stack.back();
        stack.pop_back();
        for (int i = 0; i < 4; ++i) {
          if (neighbor(t, i) >= 0 && facet_at(t, i) == kNone) enter(static_cast<std::uint32_t>(neighbor(t, i)), region);
        }
      }
    };
    const auto count = static_cast<std::uint32_t>(input_.tetrahedra.size());
    for (std::uint32_t t = 0; t < count; ++t) {
      for (int i = 0; i < 4; ++i) {
        if (neighbor(t, i) < 0 && facet_at(t, i) == kNone) enter(t, 0);
      }
    }
    flood(0);
    regions_ = 1;
    for (std::uint32_t t = 0; t < count; ++t) {
      if (region_[t] != kNone) continue;
      context_.check_cancelled();
      enter(t, regions_);
      flood(regions_++);
    }
  }

  /// What the winding number gains on the way out of a tetrahedron through a wall.
  std::int64_t gain(std::uint32_t t, int i) const {
    const std::uint32_t facet = facet_at(t, i);
    const bool in_front = SortedTriangle(face(t, i)).odd == SortedTriangle(input_.facets[facet]).odd;
    const std::int64_t times = multiplicity_[input_.facet_source[facet]];
    return in_front ? times : -times;
  }

  struct Crossing {
    std::uint32_t from = 0, to = 0;
    std::int64_t gain = 0;
  };

  void decide_regions() {
    std::vector<Crossing> crossings;
    for (std::uint32_t t = 0; t < region_.size(); ++t) {
      for (int i = 0; i < 4; ++i) {
        if (facet_at(t, i) == kNone) continue;
        const std::uint32_t beyond = neighbor(t, i) < 0 ? 0 : region_[static_cast<std::uint32_t>(neighbor(t, i))];
        if (beyond == region_[t]) continue;
        crossings.push_back({region_[t], beyond, gain(t, i)});
        if (neighbor(t, i) < 0) crossings.push_back({beyond, region_[t], -gain(t, i)});
      }
    }
    std::ranges::sort(crossings, {},
                      [](const Crossing& crossing) { return std::tuple(crossing.from, crossing.to, crossing.gain); });
    std::vector<std::size_t> first(regions_ + 1, 0);
    for (const Crossing& crossing : crossings) ++first[crossing.from + 1];
    for (std::size_t r = 0; r < regions_; ++r) first[r + 1] += first[r];

    std::vector<std::int64_t> winding(regions_, 0);
    std::vector<std::uint8_t> known(regions_, 0);
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
    std::vector<std::uint8_t> contradictory(regions_, 0);
    for (const Crossing& crossing : crossings) {
      if (winding[crossing.to] != winding[crossing.from] + crossing.gain) {
        contradictory[crossing.from] = contradictory[crossing.to] = 1;
      }
    }
    std::vector<std::uint8_t> inside(regions_, 0);
    if (std::ranges::count(contradictory, 1) > 0) mark_mostly_wound(contradictory, inside);
    for (std::uint32_t r = 1; r < regions_; ++r) {
      if (contradictory[r] == 0) {
        inside[r] = winding[r] != 0;
      } else if (winding[r] % 2 != 0) {
        inside[r] = 1;
      }
      result_.contradictory_regions += contradictory[r];
      if (contradictory[r] == 0 && std::abs(winding[r]) > 1) ++result_.nested_regions;
    }
    for (std::size_t t = 0; t < region_.size(); ++t) inside_[t] = inside[region_[t]];
  }

  /// Marks the contradictory regions in most of whose volume the generalised winding number is beyond 1/2: a solid that
  /// is there twice, say, which an even number of walls surrounds.
  void mark_mostly_wound(const std::vector<std::uint8_t>& contradictory, std::vector<std::uint8_t>& inside) {
    context_.require_memory(WindingNumber::memory_estimate(model_.triangles.size()), "winding numbers");
    const WindingNumber winding(model_, multiplicity_);
    std::vector<double> surplus(regions_, 0);  // of what is wound over what is not
    for (std::uint32_t t = 0; t < region_.size(); ++t) {
      if (region_[t] == 0 || contradictory[region_[t]] == 0) continue;
      if (t % 1024 == 0) context_.check_cancelled();
      const TetrahedronCorners& corners = input_.tetrahedra[t];
      const double size = std::abs(volume(input_.points, corners));
      surplus[region_[t]] += std::abs(winding.at(centroid(input_.points, corners))) > 0.5 ? size : -size;
    }
    for (std::size_t r = 0; r < inside.size(); ++r) inside[r] = surplus[r] > 0;
  }

  void decide_by_winding_number() {
    context_.require_memory(WindingNumber::memory_estimate(model_.triangles.size()), "winding numbers");
    const WindingNumber winding(model_, multiplicity_);
    constexpr std::uint8_t kUndecided = 2;
    constexpr std::int64_t kGrain = 256;
    parallel_for(context_, 0, std::ssize(inside_), kGrain, [&](std::int64_t begin, std::int64_t end) {
      for (auto t = static_cast<std::size_t>(begin); t < static_cast<std::size_t>(end); ++t) {
        const TetrahedronCorners& corners = input_.tetrahedra[t];
        const bool inside = std::abs(winding.at(centroid(input_.points, corners))) > 0.5;
        inside_[t] = is_flat(corners) ? kUndecided : inside;
      }
    });
    // The centroid of a flat one, between coplanar triangles, lies on the surface: it is where its neighbours are.
    std::vector<std::uint32_t> queue;
    for (std::uint32_t t = 0; t < inside_.size(); ++t) {
      if (inside_[t] != kUndecided) queue.push_back(t);
    }
    for (std::size_t next = 0; next < queue.size(); ++next) {
      for (int i = 0; i < 4; ++i) {
        const std::int32_t beyond = neighbor(queue[next], i);
        if (beyond < 0 || facet_at(queue[next], i) != kNone) continue;
        std::uint8_t& other = inside_[static_cast<std::size_t>(beyond)];
        if (other != kUndecided) continue;
        other = inside_[queue[next]];
        queue.push_back(static_cast<std::uint32_t>(beyond));
      }
    }
    std::ranges::replace(inside_, kUndecided, std::uint8_t{0});
  }

  bool is_flat(const TetrahedronCorners& corners) const {
    constexpr double kFlat = 1e-9;  // of a cube on the longest edge; rounding leaves less
    const double longest = std::sqrt(longest_edge_squared(input_.points, corners));
    return std::abs(volume(input_.points, corners)) < kFlat * longest * longest * longest;
  }

  void number_outside() {
    number_.assign(inside_.size(), Complement::kSolid);
    std::uint32_t next = 0;
    for (std::size_t t = 0; t < inside_.size(); ++t) {
      if (inside_[t] == 0) number_[t] = next++;
    }
    result_.complement.first_ghost = next;
    result_.tetrahedra = static_cast<std::uint32_t>(inside_.size());
  }

  void make_complement() {
    Complement& made = result_.complement;
    made.points = input_.points;
    made.model_points = static_cast<std::uint32_t>(input_.points.size() - input_.steiner_points);
    std::uint32_t hull_faces = 0;
    for (const auto& around : input_.neighbors)
      hull_faces += static_cast<std::uint32_t>(std::ranges::count(around, -1));
    const std::size_t size = std::size_t{made.first_ghost} + hull_faces;
    made.corners.reserve(size);
    made.neighbors.reserve(size);
    made.walls.reserve(size);
    std::uint32_t next_ghost = made.first_ghost;
    std::vector<HullFace> hull;
    for (std::uint32_t t = 0; t < inside_.size(); ++t) {
      std::array<std::uint32_t, 4> around{};
      std::uint8_t walls = 0;
      for (int i = 0; i < 4; ++i) {
        const bool wall = facet_at(t, i) != kNone;
        walls = static_cast<std::uint8_t>(walls | (wall ? 1 << i : 0));
        const std::int32_t beyond = neighbor(t, i);
        std::uint32_t& number = around[static_cast<std::size_t>(i)];
        number = beyond < 0 ? next_ghost++ : number_[static_cast<std::size_t>(beyond)];
        if (beyond < 0) hull.push_back({face(t, i), number_[t], wall});
        // Of the two sides of a fold one is counted.
        if (wall && inside_[t] == 0 && (beyond < 0 || (number != Complement::kSolid && number_[t] < number))) {
          ++result_.folds;
        }
      }
      if (inside_[t] != 0) continue;
      made.corners.push_back(input_.tetrahedra[t]);
      made.neighbors.push_back(around);
      made.walls.push_back(walls);
    }
    add_ghosts(hull);
  }

  /// A face of the hull, counterclockwise seen from within, and the tetrahedron behind it.
  struct HullFace {
    Triangle corners;
    std::uint32_t behind = 0;
    bool wall = false;
  };

  void add_ghosts(const std::vector<HullFace>& hull) {
    Complement& made = result_.complement;
    struct Side {
      std::uint64_t edge = 0;
      std::uint32_t ghost = 0;
      std::uint32_t face = 0;
    };
    std::vector<Side> sides;
    sides.reserve(3 * hull.size());
    for (const HullFace& face : hull) {
      const auto ghost = static_cast<std::uint32_t>(made.corners.size());
      // Turned around, for the ghost sees the face from the other side.
      made.corners.push_back({face.corners[1], face.corners[0], face.corners[2], Complement::kFar});
      made.neighbors.push_back({kNone, kNone, kNone, face.behind});
      made.walls.push_back(face.wall ? 8 : 0);
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
    result_.hull_faces = static_cast<std::uint32_t>(hull.size());
    std::vector<std::uint8_t> on_hull(made.points.size(), 0);
    for (const HullFace& face : hull) {
      for (const std::uint32_t corner : face.corners) on_hull[corner] = 1;
    }
    result_.hull_points = static_cast<std::uint32_t>(std::ranges::count(on_hull, 1));
  }

  void find_voids() {
    const Complement& made = result_.complement;
    std::vector<std::uint8_t> reached(made.size(), 0);
    std::vector<std::uint32_t> part;
    const auto enter = [&](std::uint32_t t) {
      if (reached[t] != 0) return;
      reached[t] = 1;
      part.push_back(t);
    };
    const auto flood = [&] {
      for (std::size_t next = 0; next < part.size(); ++next) {
        for (int i = 0; i < 4; ++i) {
          if (!made.is_barrier(part[next], i)) enter(made.neighbors[part[next]][static_cast<std::size_t>(i)]);
        }
      }
    };
    for (std::uint32_t ghost = made.first_ghost; ghost < made.size(); ++ghost) enter(ghost);
    flood();
    for (std::uint32_t t = 0; t < made.first_ghost; ++t) {
      if (reached[t] != 0) continue;
      context_.check_cancelled();
      part.clear();
      enter(t);
      flood();
      std::ranges::sort(part);
      Void found;
      double longest = -1;
      for (const std::uint32_t inside : part) {
        found.volume += volume(made.points, made.corners[inside]);
        const double edge = longest_edge_squared(made.points, made.corners[inside]);
        if (edge > longest) {
          longest = edge;
          found.seed = inside;
        }
      }
      result_.voids.push_back(found);
    }
    std::ranges::sort(result_.voids, {}, &Void::seed);
  }

  /// M is closed: inside tetrahedra with their faces, and walls. What touches in a vertex is one component.
  void label_solids() {
    Complement& made = result_.complement;
    DisjointSets sets(made.points.size());
    std::vector<std::uint8_t> is_solid(made.points.size(), 0);
    const auto join = [&](const auto& corners) {
      for (const std::uint32_t corner : corners) {
        is_solid[corner] = 1;
        sets.join(corners[0], corner);
      }
    };
    for (std::size_t t = 0; t < inside_.size(); ++t) {
      if (inside_[t] != 0) join(input_.tetrahedra[t]);
    }
    for (const Triangle& facet : input_.facets) join(facet);
    made.solid_of_point.assign(made.points.size(), kNone);
    std::uint32_t solids = 0;
    for (std::uint32_t point = 0; point < made.points.size(); ++point) {
      if (is_solid[point] == 0) continue;
      const std::uint32_t root = sets.find(point);  // its smallest point
      made.solid_of_point[point] = root == point ? solids++ : made.solid_of_point[root];
    }
  }

  const Tetrahedralization& input_;
  const TriangleSoup& model_;
  const std::vector<std::int32_t>& multiplicity_;
  RunContext& context_;
  std::vector<std::uint32_t> facet_at_;  ///< per face of a tetrahedron
  std::vector<std::uint32_t> region_;
  std::uint32_t regions_ = 0;
  std::vector<std::uint8_t> inside_;
  std::vector<std::uint32_t> number_;  ///< in the complement
  Classification result_;
};

}  // namespace

Classification classify(const Tetrahedralization& tetrahedralization, const TriangleSoup& model,
                        const std::vector<std::int32_t>& multiplicity, InsideRule rule, RunContext& context) {
  return Classifier(tetrahedralization, model, multiplicity, context).run(rule);
}

}  // namespace voxcarve
