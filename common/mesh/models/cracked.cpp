// cracked-*: one model for every degeneracy that [NT03] names (sections 1, 3.1-3.3 and 6; Table 1 says which voxelizer
// repairs which), on one solid: a ladder of two rails and three rungs, genus 2.
//
// The ladder lies on a lattice of 27 x 15 x 5 cells. A rail is 27 x 5 x 5 cells, a rung 5 x 3 between the rails, so it
// has 2 * 675 + 3 * 5 * 5 * 3 = 1575 cells. The affine map below turns it about the vertical by atan(5 / 12) and slants
// it: no face but the upright ones is parallel to an axis of the voxels, and none lies on a voxel boundary by chance.
// Its coefficients are integers / 16, so lattice points, the middles of their edges and the volume are exact in
// doubles, and T-joints and zero-area faces are degenerate to the last bit. Upright lines stay upright, and every one
// of them meets the ladder in one piece: with the axes among its directions, ray stabbing of the sound ladder gives the
// ladder. What goes wrong with a cracked one is due to its degeneracy. At resolution 128 a cell is 4.2 voxels wide.
#include "common/mesh/models/cracked.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "common/mesh/models/builders.h"
#include "common/mesh/models/degeneracies.h"
#include "common/mesh/models/primitives.h"
#include "common/run/errors.h"

namespace voxcarve {

namespace {

using Cell = Eigen::Vector3i;

constexpr std::array<int, 3> kCells = {27, 15, 5};
constexpr double kCellVolume = 2197.0 / 4096;  // determinant of the map: 13 (12^2 + 5^2) / 16^3
constexpr int kLadderCells = 1575;

/// Bars of the ladder, as boxes of cells. The rungs end 3 cells deep inside the rails.
struct Bar {
  Cell lower;
  Cell upper;
  bool contains(const Cell& cell) const {
    return (cell.array() >= lower.array()).all() && (cell.array() < upper.array()).all();
  }
};

const std::array<Bar, 5>& bars() {
  static const std::array<Bar, 5> kBars = {Bar{{0, 0, 0}, {27, 5, 5}}, Bar{{0, 10, 0}, {27, 15, 5}},
                                           Bar{{1, 2, 1}, {6, 13, 4}}, Bar{{11, 2, 1}, {16, 13, 4}},
                                           Bar{{21, 2, 1}, {26, 13, 4}}};
  return kBars;
}

bool in_ladder(const Cell& cell) {
  return std::ranges::any_of(bars(), [&](const Bar& bar) { return bar.contains(cell); });
}

/// A surface on the lattice of squares, of which `scale` make the edge of a cell, until it is put in place.
struct Draft {
  TriangleSoup soup;
  int scale = 1;
};

int scale_of(const Parameters& parameters) {
  return 1 << parameters.integer("halvings");
}

TriangleSoup surface_of(const std::function<bool(const Cell&)>& filled, int scale) {
  return block_surface(
      kCells,
      [&](int i, int j, int k) {
        return filled({i, j, k});
      },
      scale, scale);
}

Draft ladder(const Parameters& parameters) {
  const int scale = scale_of(parameters);
  return {surface_of(in_ladder, scale), scale};
}

/// The five bars, each with a closed surface of its own. So that they meet nowhere in a common vertex or edge, the
/// rungs lie a quarter of a square further along y, inside the rails at both ends, and the rails' inner vertices as far
/// from the lattice along x and z.
Draft overlapping_bars(const Parameters& parameters) {
  constexpr double kOffset = 0.25;
  Draft draft{{}, scale_of(parameters)};
  for (const Bar& bar : bars()) {
    TriangleSoup surface = surface_of([&](const Cell& cell) { return bar.contains(cell); }, draft.scale);
    const bool is_rung = bar.lower.y() % 5 != 0;
    for (Point& position : surface.positions) {
      for (const int axis : is_rung ? std::vector{1} : std::vector{0, 2}) {
        const bool at_end =
            position[axis] == draft.scale * bar.lower[axis] || position[axis] == draft.scale * bar.upper[axis];
        if (is_rung || !at_end) position[axis] += kOffset;
      }
    }
    append(draft.soup, surface);
  }
  return draft;
}

TriangleSoup placed(Draft draft) {
  Eigen::Matrix3d map;
  map << 12, -5, 0, 5, 12, 0, 3, -2, 13;
  map /= 16.0 * draft.scale;
  return transformed(std::move(draft.soup), Eigen::Affine3d(map));
}

/// Patches for defects, on squares that no other bar covers.
std::vector<SurfacePatch> patches_for(const Draft& draft, const Parameters& parameters, std::string_view number,
                                      int width, int height) {
  const auto is_exposed = [&](const Cell& low, int axis, int side) {
    Cell outside = low / draft.scale;
    // On the far side of a cell the square's lower corner is the next cell's already.
    if (side < 0) --outside[axis];
    return !in_ladder(outside);
  };
  const auto wanted = static_cast<std::size_t>(parameters.integer(number));
  std::vector<SurfacePatch> patches = SquareIndex(draft.soup, is_exposed).choose_patches(wanted, width, height);
  if (patches.size() < wanted) {
    throw ParameterError("only " + std::to_string(patches.size()) + " of " + std::to_string(wanted) + " " +
                         std::string(number) + " have room on the surface; lower it or raise halvings");
  }
  return patches;
}

void add_holes(Draft& draft, const Parameters& parameters) {
  const auto size = static_cast<int>(parameters.integer("hole_size"));
  cut_holes(draft.soup, patches_for(draft, parameters, "holes", size, size));
}

void add_cracks(Draft& draft, const Parameters& parameters) {
  const auto length = static_cast<int>(parameters.integer("crack_length"));
  const double width = parameters.real("width") * draft.scale;
  if (width >= 1) throw ParameterError("a crack must be narrower than a square; lower width or halvings");
  cut_cracks(draft.soup, patches_for(draft, parameters, "cracks", length, 2), width);
}

void add_redundant_polygons(Draft& draft, const Parameters& parameters) {
  duplicate_patches(draft.soup, patches_for(draft, parameters, "patches", 2, 2));
}

void add_t_joints(Draft& draft, const Parameters& parameters) {
  for (const SurfacePatch& patch : patches_for(draft, parameters, "joints", 1, 1)) {
    add_t_joint(draft.soup, 2 * patch.squares.front(), 0);
  }
}

void add_zero_area_faces(Draft& draft, const Parameters& parameters) {
  for (const SurfacePatch& patch : patches_for(draft, parameters, "faces", 1, 1)) {
    add_zero_area_face(draft.soup, 2 * patch.squares.front(), 0);
  }
}

/// Moves a coordinate, in cells, inward by `gap`: `inward` is +1 on faces that look down the axis and -1 on those that
/// look up, and varies linearly between them.
struct Shift {
  double coordinate;
  double inward;
};

double shifted(double coordinate, double gap, std::span<const Shift> shifts) {
  std::size_t next = 1;
  while (next + 1 < shifts.size() && coordinate > shifts[next].coordinate) ++next;
  const Shift& a = shifts[next - 1];
  const Shift& b = shifts[next];
  const double share = (coordinate - a.coordinate) / (b.coordinate - a.coordinate);
  return coordinate + gap * (a.inward + share * (b.inward - a.inward));
}

/// A second wall, parallel to the first one and `gap` inside it, all around.
void add_inner_wall(Draft& draft, const Parameters& parameters) {
  static constexpr std::array<Shift, 8> kAlongX = {
      {{0, 1}, {1, 1}, {6, -1}, {11, 1}, {16, -1}, {21, 1}, {26, -1}, {27, -1}}};
  static constexpr std::array<Shift, 4> kAlongY = {{{0, 1}, {5, -1}, {10, 1}, {15, -1}}};
  static constexpr std::array<Shift, 4> kAlongZ = {{{0, 1}, {1, 1}, {4, -1}, {5, -1}}};
  const std::array<std::span<const Shift>, 3> shifts = {kAlongX, kAlongY, kAlongZ};
  const double gap = parameters.real("gap");
  TriangleSoup inner = draft.soup;
  for (Point& position : inner.positions) {
    for (int axis = 0; axis < 3; ++axis) {
      position[axis] = draft.scale * shifted(position[axis] / draft.scale, gap, shifts[static_cast<std::size_t>(axis)]);
    }
  }
  append(draft.soup, inner);
}

/// Walls inside the bars, one polygon thick: at their rims three polygons meet in every edge. One stands across each
/// rail in the middle of each gap between rungs, one across the middle of each rung.
void add_inner_walls(Draft& draft, const Parameters& /*parameters*/) {
  const int scale = draft.scale;
  std::map<std::array<int, 3>, std::uint32_t> vertex_at;
  const auto key = [](const Point& p) {
    return std::array{static_cast<int>(p.x()), static_cast<int>(p.y()), static_cast<int>(p.z())};
  };
  for (std::uint32_t v = 0; v < draft.soup.positions.size(); ++v) vertex_at.emplace(key(draft.soup.positions[v]), v);
  const auto vertex = [&](const Cell& at) {
    const Point position = at.cast<double>();
    const auto [entry, added] =
        vertex_at.try_emplace(key(position), static_cast<std::uint32_t>(draft.soup.positions.size()));
    if (added) draft.soup.positions.push_back(position);
    return entry->second;
  };
  const auto add_wall = [&](const Cell& low, int axis, int width, int height) {
    const Cell u = Cell::Unit((axis + 1) % 3);
    const Cell v = Cell::Unit((axis + 2) % 3);
    for (int j = 0; j < height * scale; ++j) {
      for (int i = 0; i < width * scale; ++i) {
        const Cell at = scale * low + i * u + j * v;
        const std::array<std::uint32_t, 4> corners = {vertex(at), vertex(at + u), vertex(at + u + v), vertex(at + v)};
        draft.soup.triangles.push_back({corners[0], corners[1], corners[2]});
        draft.soup.triangles.push_back({corners[0], corners[2], corners[3]});
      }
    }
  };
  for (const int y : {0, 10}) {
    for (const int x : {8, 18}) add_wall({x, y, 0}, 0, 5, 5);
  }
  for (const int x : {1, 11, 21}) add_wall({x, 7, 1}, 1, 3, 5);
}

/// The ladder in two closed halves that share the wall x = 13, through the middle rung.
Draft halves(const Parameters& parameters) {
  Draft draft{{}, scale_of(parameters)};
  for (const bool left : {true, false}) {
    append(draft.soup,
           surface_of([&](const Cell& cell) { return in_ladder(cell) && (cell.x() < 13) == left; }, draft.scale));
  }
  return draft;
}

/// Two rails with three spikes each, in place of the rungs. Opposite spikes touch at their tips: share a vertex, or
/// have one each when `intact`. A spike is a pyramid on 3 x 3 cells, 2.5 cells high.
Draft pinched_ladder(const Parameters& parameters, bool intact) {
  constexpr int kBase = 3;
  Draft draft{{}, scale_of(parameters)};
  const int scale = draft.scale;
  std::array<std::uint32_t, 3> tips{};
  for (const bool first : {true, false}) {
    const TriangleSoup rail = surface_of([&](const Cell& cell) { return bars()[first ? 0 : 1].contains(cell); }, scale);
    const auto offset = static_cast<std::uint32_t>(draft.soup.positions.size());
    draft.soup.positions.insert(draft.soup.positions.end(), rail.positions.begin(), rail.positions.end());
    if (first || intact) {
      for (std::size_t rung = 0; rung < 3; ++rung) {
        tips[rung] = static_cast<std::uint32_t>(draft.soup.positions.size());
        draft.soup.positions.emplace_back(scale * Point(3.5 + 10.0 * static_cast<double>(rung), 7.5, 2.5));
      }
    }
    // Square by square: those under a spike go, and their outline gets the spike's flanks.
    const int wall = (first ? 5 : 10) * scale;
    for (const Triangle& t : rail.triangles) {
      const Point middle = (rail.positions[t[0]] + rail.positions[t[1]] + rail.positions[t[2]]) / (3.0 * scale);
      const auto rung = static_cast<int>(middle.x() / 10);
      const auto is_under = [&](const Point& p) {  // within the base, its outline included
        return p.y() == wall && p.x() >= scale * (2 + 10 * rung) && p.x() <= scale * (2 + kBase + 10 * rung) &&
               p.z() >= scale && p.z() <= scale * (1 + kBase);
      };
      const bool spike = std::ranges::all_of(t, [&](std::uint32_t v) { return is_under(rail.positions[v]); });
      if (!spike) {
        draft.soup.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
        continue;
      }
      for (std::size_t corner = 0; corner < 3; ++corner) {
        const Point& a = rail.positions[t[corner]];
        const Point& b = rail.positions[t[(corner + 1) % 3]];
        const auto on_line = [&](int axis, int cell) { return a[axis] == scale * cell && b[axis] == scale * cell; };
        const bool outline =
            on_line(0, 2 + 10 * rung) || on_line(0, 2 + kBase + 10 * rung) || on_line(2, 1) || on_line(2, 1 + kBase);
        if (outline) {
          draft.soup.triangles.push_back(
              {t[corner] + offset, t[(corner + 1) % 3] + offset, tips[static_cast<std::size_t>(rung)]});
        }
      }
    }
  }
  remove_unused_vertices(draft.soup);
  return draft;
}

// --- the models --------------------------------------------------------------------------------------------------

struct CrackedModel {
  CrackedSolid solid;
  std::string summary;
  std::vector<ParameterSpec> parameters;
  std::function<Draft(const Parameters&)> build;
};

CrackedSolid sound_ladder(std::string name, std::string degeneracy) {
  return {"cracked-" + std::move(name), std::move(degeneracy), kLadderCells * kCellVolume, 2, 1};
}

/// A model that takes a sound ladder, or its overlapping bars, and adds defects to it.
using Spoil = void (*)(Draft&, const Parameters&);
CrackedModel spoilt(std::string name, std::string degeneracy, std::string summary, std::vector<ParameterSpec> specs,
                    Draft (*start)(const Parameters&), Spoil spoil) {
  const auto build = [start, spoil](const Parameters& parameters) {
    Draft draft = start(parameters);
    if (spoil != nullptr) spoil(draft, parameters);
    return draft;
  };
  return {sound_ladder(std::move(name), std::move(degeneracy)), std::move(summary), std::move(specs), build};
}

ParameterSpec number_of(std::string name, std::int64_t default_value, std::string help) {
  return ParameterSpec::integer(std::move(name), "places", 0, 10'000, default_value, std::move(help));
}

std::vector<ParameterSpec> hole_parameters() {
  return {number_of("holes", 12, "number of holes"),
          ParameterSpec::integer("hole_size", "squares", 1, 20, 2, "side of a hole; two triangles a square")};
}

std::vector<ParameterSpec> crack_parameters() {
  return {number_of("cracks", 16, "number of cracks"),
          ParameterSpec::integer("crack_length", "squares", 2, 20, 4, "length of a crack"),
          ParameterSpec::real("width", "cells", 1e-4, 0.5, 0.1,
                              "of a crack in its middle; at resolution 128 the default is 0.42 voxels")};
}

std::vector<CrackedModel> all_cracked_models() {
  std::vector<CrackedModel> models;
  models.push_back(
      spoilt("cracks", "cracks", "a ladder with thin slits in its faces", crack_parameters(), ladder, add_cracks));
  models.push_back(spoilt("cracks-interpenetrating", "small cracks and interpenetrating parts",
                          "a ladder of five overlapping bars with thin slits", crack_parameters(), overlapping_bars,
                          add_cracks));
  models.push_back(spoilt("double-walls", "double walls", "a ladder with a second wall inside the first",
                          {ParameterSpec::real("gap", "cells", 1e-4, 0.5, 0.06,
                                               "between the walls; at resolution 128 the default is 0.25 voxels")},
                          ladder, add_inner_wall));
  models.push_back(
      spoilt("holes", "holes", "a ladder with holes of a few triangles", hole_parameters(), ladder, add_holes));
  models.push_back(spoilt("holes-interpenetrating", "holes and interpenetrating parts",
                          "a ladder of five overlapping bars with holes", hole_parameters(), overlapping_bars,
                          add_holes));
  models.push_back(spoilt("interpenetrating", "interpenetrating parts", "a ladder of five overlapping bars", {},
                          overlapping_bars, nullptr));
  models.push_back(spoilt("nonmanifold-edges", "more than two polygons meeting at an edge",
                          "a ladder with seven walls inside, one polygon thick", {}, ladder, add_inner_walls));
  CrackedSolid rails{"cracked-nonmanifold-vertices", "non-manifold vertices", (1350 + 6 * 7.5) * kCellVolume, 0, 2};
  models.push_back(
      {std::move(rails), "two rails whose spikes touch in three shared vertices", {}, [](const Parameters& parameters) {
         return pinched_ladder(parameters, false);
       }});
  models.push_back(spoilt("redundant-polygons", "more than one polygon at the same location",
                          "a ladder with patches of its surface standing twice",
                          {number_of("patches", 24, "number of doubled patches of 2 x 2 squares")}, ladder,
                          add_redundant_polygons));
  models.push_back(spoilt("shared-walls", "two subcomponents made exactly adjacent",
                          "a ladder in two closed halves with a wall in common", {}, halves, nullptr));
  models.push_back(spoilt("t-joints", "T-joints", "a ladder with vertices in the middle of its neighbours' edges",
                          {number_of("joints", 100, "number of T-joints")}, ladder, add_t_joints));
  models.push_back(spoilt("zero-area", "zero-area faces", "a closed ladder with zero-area faces between its triangles",
                          {number_of("faces", 100, "number of zero-area faces")}, ladder, add_zero_area_faces));
  std::ranges::sort(models, {}, [](const CrackedModel& model) { return model.solid.name; });
  return models;
}

}  // namespace

const std::vector<CrackedSolid>& cracked_solids() {
  static const std::vector<CrackedSolid> solids = [] {
    std::vector<CrackedSolid> all;
    for (CrackedModel& model : all_cracked_models()) all.push_back(std::move(model.solid));
    return all;
  }();
  return solids;
}

std::vector<ProceduralModel> cracked_models() {
  std::vector<ProceduralModel> models;
  for (CrackedModel& model : all_cracked_models()) {
    ModelInfo info{model.solid.name, std::move(model.summary), "NT Table 1", {}};
    info.parameters.specs = std::move(model.parameters);
    info.parameters.specs.push_back(
        ParameterSpec::integer("halvings", "times", 0, 4, 0, "how often the squares of one cell's side are halved"));
    info.parameters.specs.push_back(
        ParameterSpec::toggle("intact", false, "the sound solid instead, without the degeneracy"));
    const bool pinched = model.solid.components == 2;
    models.push_back({std::move(info), [build = std::move(model.build), pinched](const Parameters& parameters) {
                        if (!parameters.toggle("intact")) return placed(build(parameters));
                        return placed(pinched ? pinched_ladder(parameters, true) : ladder(parameters));
                      }});
  }
  return models;
}

}  // namespace voxcarve
