// mushrooms and foot-bones: stand-ins for [HE10, Table 1 and Fig. 8]. All parts are closed, of genus 0, and apart.
//
// The paper's counts say what the bones are: closed surfaces of genus 0 have 2 V - 4 faces each, and 2 * 2,154 - 4,204
// = 4 * 26. A human foot has 26 bones. A bone of m rings of n points has m n + 2 vertices; the numbers below add up:
//     14 phalanges of 62, 5 metatarsals of 98, calcaneus 170, talus 122, navicular and cuboid 102 each, and 3
//     cuneiforms of 100: 868 + 490 + 170 + 122 + 204 + 300 = 2,154.
// Likewise 15 mushrooms of 23 rings of 13 points and 2 poles have 15 * 301 = 4,515 vertices and 15 * 598 = 8,970 faces.
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "common/mesh/models/builders.h"
#include "common/mesh/models/growth.h"
#include "common/mesh/models/tubes.h"

namespace voxcarve {

namespace {

using std::numbers::pi;

// --- mushrooms ---------------------------------------------------------------------------------------------------

struct Mushroom {
  Eigen::Vector2d foot;
  Eigen::Vector2d lean;  ///< of the top against the foot
  double cap_radius;
  double cap_height;
  double stem_height;
  double stem_radius;
  double droop;  ///< of the rim below the gills' centre
};

struct MushroomRings {
  int stem;
  int gills;
  int cap;
  int total() const { return stem + gills + cap; }
};

TriangleSoup mushroom_surface(const Mushroom& mushroom, const MushroomRings& rings, int slices) {
  std::vector<Eigen::Vector2d> profile = {{0, 0}};
  for (int i = 0; i < rings.stem; ++i) {
    const double share = static_cast<double>(i) / (rings.stem - 1);
    const double swelling = 1 + 0.6 * std::pow(1 - share, 3);
    profile.emplace_back(mushroom.stem_radius * swelling, share * mushroom.stem_height);
  }
  for (int i = 1; i <= rings.gills; ++i) {
    const double share = static_cast<double>(i) / rings.gills;
    profile.emplace_back(mushroom.stem_radius + share * (mushroom.cap_radius - mushroom.stem_radius),
                         mushroom.stem_height - share * share * mushroom.droop);
  }
  for (int i = 1; i <= rings.cap + 1; ++i) {
    const double angle = pi / 2 * i / (rings.cap + 1);
    profile.emplace_back(
        i > rings.cap ? 0 : mushroom.cap_radius * std::cos(angle),
        mushroom.stem_height - mushroom.droop + (mushroom.cap_height + mushroom.droop) * std::sin(angle));
  }
  TriangleSoup surface = lathe(profile, slices);
  const double top = mushroom.stem_height + mushroom.cap_height;
  for (Point& position : surface.positions) {
    const double share = position.z() / top;
    position.head<2>() += mushroom.foot + share * share * mushroom.lean;
  }
  return surface;
}

/// A clump: large mushrooms in the middle, smaller and more slanted ones around. Each goes as near to the middle, along
/// its own direction of a golden spiral, as lets a circle that holds all of it stay clear of all others.
std::vector<Mushroom> clump(int count, double gap, SeededSequence& random) {
  constexpr double kGoldenAngle = pi * (3 - 2.23606797749978969);  // 3 - sqrt 5
  std::vector<Mushroom> mushrooms;
  for (int i = 0; i < count; ++i) {
    const double rank = static_cast<double>(i) / count;
    const double size = (1 - 0.65 * rank) * random.uniform(0.85, 1);
    const double youth = random.uniform(0, 1);  // the young have narrow, high caps
    const Eigen::Vector2d direction(std::cos(i * kGoldenAngle), std::sin(i * kGoldenAngle));
    Mushroom mushroom{.foot = Eigen::Vector2d::Zero(),
                      .lean = size * (0.05 + 0.35 * rank) * direction,
                      .cap_radius = size * (0.55 - 0.2 * youth),
                      .cap_height = size * (0.25 + 0.2 * youth),
                      .stem_height = size * random.uniform(0.8, 1.2),
                      .stem_radius = size * 0.11,
                      .droop = size * (0.1 + 0.12 * youth)};
    const auto is_clear = [&](const Mushroom& other) {
      // Between its foot and its top the axis stays within the circle about the middle of the lean.
      const Eigen::Vector2d apart = mushroom.foot + 0.5 * mushroom.lean - other.foot - 0.5 * other.lean;
      return apart.norm() >
             mushroom.cap_radius + 0.5 * mushroom.lean.norm() + other.cap_radius + 0.5 * other.lean.norm() + gap;
    };
    for (int step = 0; !std::ranges::all_of(mushrooms, is_clear); ++step) mushroom.foot = 0.01 * step * direction;
    mushrooms.push_back(mushroom);
  }
  return mushrooms;
}

MushroomRings mushroom_rings(const Parameters& parameters) {
  return {static_cast<int>(parameters.integer("stem_rings")), static_cast<int>(parameters.integer("gill_rings")),
          static_cast<int>(parameters.integer("cap_rings"))};
}

TriangleSoup build_mushrooms(const Parameters& parameters) {
  SeededSequence random(static_cast<std::uint64_t>(parameters.integer("seed")));
  TriangleSoup soup;
  for (const Mushroom& mushroom :
       clump(static_cast<int>(parameters.integer("mushrooms")), parameters.real("gap"), random)) {
    append(soup,
           mushroom_surface(mushroom, mushroom_rings(parameters), static_cast<int>(parameters.integer("slices"))));
  }
  return soup;
}

// --- foot-bones --------------------------------------------------------------------------------------------------

/// A bone along a line: x points from the heel to the toes, y from the big toe outwards, z up; lengths are centimetres.
struct Bone {
  Point from;
  Point to;
  double half_height;
  double half_width;
  double waist;  ///< thickness in the middle, as a share of that between the ends
  double taper;  ///< thickness at the far end, as a share of that at the near one
  double arch;   ///< how far the middle is lifted
  int slices;
  int rings;
};

TriangleSoup bone_surface(const Bone& bone, double detail) {
  const auto scaled = [&](int count) { return std::max(3, static_cast<int>(std::lround(detail * count))); };
  const int rings = scaled(bone.rings);
  std::vector<Point> path;
  for (int i = 0; i <= rings + 1; ++i) {
    const double share = (1 - std::cos(pi * i / (rings + 1))) / 2;  // denser at the round ends
    path.emplace_back(bone.from + share * (bone.to - bone.from) + 4 * share * (1 - share) * bone.arch * Point::UnitZ());
  }
  const auto half_axes = [&](double share) {
    const double u = 2 * share - 1;
    const double round_end = std::cbrt(std::max(0.0, 1 - std::abs(u * u * u)));
    const double scale = round_end * (bone.waist + (1 - bone.waist) * u * u) * (1 + (bone.taper - 1) * share);
    return HalfAxes{scale * bone.half_height, scale * bone.half_width};
  };
  return loft(spindle_rings(path, Point::UnitZ(), half_axes, scaled(bone.slices)));
}

std::vector<Bone> bones_of_a_foot() {
  std::vector<Bone> bones = {
      {{0.2, 0.2, 1.8}, {8.0, 1.4, 2.2}, 1.75, 1.55, 0.8, 0.7, 0, 12, 14},     // calcaneus
      {{4.9, -0.1, 4.7}, {9.7, -1.2, 4.6}, 1.3, 1.5, 0.75, 0.85, 0, 12, 10},   // talus
      {{9.9, -1.25, 4.6}, {11.3, -1.25, 4.4}, 1.2, 1.7, 1, 1, 0, 10, 10},      // navicular
      {{8.3, 1.85, 2.3}, {12.0, 2.3, 2.1}, 1.1, 1.15, 0.95, 1, 0, 10, 10},     // cuboid
      {{11.6, -2.45, 3.9}, {14.0, -2.6, 3.5}, 1.15, 0.62, 0.95, 1, 0, 14, 7},  // cuneiforms
      {{11.7, -1.15, 4.5}, {13.7, -1.2, 4.2}, 1.0, 0.58, 0.95, 1, 0, 14, 7},
      {{11.6, 0.1, 4.2}, {13.9, 0.15, 3.8}, 1.0, 0.58, 0.95, 1, 0, 14, 7},
  };
  struct Toe {
    Point base;  ///< of the metatarsal
    Point head;
    double half_width;              ///< of the metatarsal
    std::vector<double> phalanges;  ///< their lengths
  };
  const std::array<Toe, 5> toes = {{{{14.25, -2.65, 3.4}, {19.2, -3.3, 1.3}, 0.85, {3.0, 2.3}},
                                    {{13.95, -1.2, 4.2}, {20.0, -1.3, 1.1}, 0.55, {2.4, 1.3, 0.9}},
                                    {{14.15, 0.2, 3.8}, {19.6, 0.45, 1.05}, 0.52, {2.2, 1.2, 0.9}},
                                    {{12.3, 1.75, 2.7}, {18.8, 2.1, 1.0}, 0.5, {2.0, 1.0, 0.85}},
                                    {{12.2, 3.1, 2.0}, {17.8, 3.7, 0.9}, 0.55, {1.8, 0.8, 0.8}}}};
  constexpr double kJoint = 0.12;
  for (const Toe& toe : toes) {
    const double width = toe.half_width;
    bones.push_back({toe.base, toe.head, 1.05 * width, width, 0.55, 1, 0.25, 8, 12});
    Point direction = Point(toe.head.x() - toe.base.x(), toe.head.y() - toe.base.y(), 0).normalized();
    Point start = toe.head;
    double phalanx_width = 0.8 * width;
    for (const double length : toe.phalanges) {
      start += kJoint * direction;
      const Point end = start + length * direction - Point(0, 0, 0.1 * length);
      bones.push_back({start, end, 0.85 * phalanx_width, phalanx_width, 0.65, 0.85, 0.1, 6, 10});
      start = end;
      phalanx_width *= 0.88;
    }
  }
  return bones;
}

TriangleSoup build_foot_bones(const Parameters& parameters) {
  TriangleSoup soup;
  for (const Bone& bone : bones_of_a_foot()) append(soup, bone_surface(bone, parameters.real("detail")));
  return soup;
}

}  // namespace

ProceduralModel mushrooms_model() {
  ModelInfo info{"mushrooms",
                 "a clump of mushrooms, caps on stems: each closed, of genus 0, and apart from the others",
                 "HE Table 1 (4,515 vertices, about 9,000 faces, 282 hull vertices)",
                 {}};
  info.parameters.specs = {
      ParameterSpec::integer("seed", "-", 0, 1'000'000'000, 1, "of sizes and shapes: another seed, another clump"),
      ParameterSpec::integer("mushrooms", "mushrooms", 1, 1000, 15, "number of mushrooms"),
      ParameterSpec::integer("slices", "slices", 3, 10'000, 13, "vertices of a ring"),
      ParameterSpec::integer("stem_rings", "rings", 2, 10'000, 9, "rings of a stem"),
      ParameterSpec::integer("gill_rings", "rings", 1, 10'000, 4, "rings of a cap's underside"),
      ParameterSpec::integer("cap_rings", "rings", 1, 10'000, 10, "rings of a cap's upper side"),
      ParameterSpec::real("gap", "model", 0, 1, 0.03,
                          "between circles that hold a mushroom; the largest is about 1.5 high")};
  info.parameters.check = [](const Parameters& parameters) {
    require_triangles_within_limit("mushrooms", 2.0 * static_cast<double>(parameters.integer("mushrooms")) *
                                                    static_cast<double>(parameters.integer("slices")) *
                                                    mushroom_rings(parameters).total());
  };
  return {std::move(info), build_mushrooms};
}

ProceduralModel foot_bones_model() {
  ModelInfo info{"foot-bones",
                 "the 26 bones of a foot: each closed, of genus 0, and apart from the others",
                 "HE Fig. 8, Table 1 (2,154 vertices, 4,204 faces, 124 hull vertices)",
                 {}};
  info.parameters.specs = {
      ParameterSpec::real("detail", "-", 0.5, 60, 1, "factor on the numbers of rings and of their vertices")};
  info.parameters.check = [](const Parameters& parameters) {
    const double detail = parameters.real("detail");
    require_triangles_within_limit("foot-bones", 4'204 * detail * detail);
  };
  return {std::move(info), build_foot_bones};
}

}  // namespace voxcarve
