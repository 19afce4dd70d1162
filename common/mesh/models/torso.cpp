// torso-ribs: the bones of a chest, a stand-in for [HE10, Fig. 13] (12,479 vertices), whose ribs "form complex
// tunnels".
//
// One closed surface. Spine and sternum are two spheres. Of twelve pairs of ribs, seven bridge from the spine to the
// sternum; the next three bridge from the spine to the underside of the rib above; the last two end free. So there are
// 20 bridges, of which one joins the spheres and 19 make a handle each: genus 19. Processes of the vertebrae and free
// ribs change nothing. Cartilage is not told from bone. The opening of the chest at the neck and the one at its bottom
// are the wide tunnels, those between neighbouring ribs the narrow ones. With the default parameters nothing
// intersects; much finer ribs cross in a few triangles at the joints of ribs 8 to 10.
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "common/mesh/models/builders.h"
#include "common/mesh/models/tubes.h"

namespace voxcarve {

namespace {

using std::numbers::pi;

constexpr int kPairs = 12;
constexpr int kTrueRibs = 7;     // reach the sternum
constexpr int kJoinedRibs = 10;  // these and those that reach the rib above
constexpr int kLumbar = 5;
constexpr int kVertebrae = kPairs + kLumbar;
constexpr std::size_t kSpineSides = 24;
constexpr std::size_t kSternumSides = 16;
constexpr double kStandOff = 0.07;  // of the first section of a rib from the opening
constexpr double kRibSpacing = 0.22;
constexpr double kLumbarSpacing = 0.27;
constexpr double kSternumTop = 2.9;
constexpr double kSternumBottom = 1.2;

/// x to the left, y to the front, z up; rib 0 leaves the spine at z = 3. The chest is about 2.7 wide.
double vertebra_height(int vertebra) {
  return vertebra < kPairs ? 3 - kRibSpacing * vertebra
                           : 3 - kRibSpacing * (kPairs - 1) - kLumbarSpacing * (vertebra - kPairs + 1);
}

/// Hollow in the small of the back, round at the chest.
Point spine_axis(double z) {
  return {0, -0.78 - 0.14 * std::sin((z - 0.2) * 1.05), z};
}

Point sternum_axis(double z) {
  return {0, 0.86 - 0.2 * (z - kSternumBottom), z};
}

struct TorsoDesign {
  explicit TorsoDesign(const Parameters& parameters)
      : rib_segments(static_cast<int>(parameters.integer("rib_segments"))),
        vertebra_rings(static_cast<int>(parameters.integer("vertebra_rings"))),
        sternum_rings(static_cast<int>(parameters.integer("sternum_rings"))) {}
  /// Of the spine's ring in the middle of a vertebra; they are numbered from the top.
  std::size_t middle_ring(int vertebra) const {
    return static_cast<std::size_t>(vertebra * vertebra_rings + vertebra_rings / 2);
  }
  /// Of the sternum's ring at which a rib arrives, numbered from the bottom.
  std::size_t sternum_ring(int rib) const {
    const double share = 0.92 - 0.74 * rib / (kTrueRibs - 1);
    return static_cast<std::size_t>(std::lround(share * (sternum_rings - 1)));
  }

  int rib_segments;
  int vertebra_rings;
  int sternum_rings;
};

/// From the bottom up: bodies of vertebrae, waisted, with discs between.
std::vector<Ring> spine_rings(const TorsoDesign& design) {
  std::vector<Point> path;
  std::vector<double> radii;
  for (int vertebra = kVertebrae - 1; vertebra >= 0; --vertebra) {
    const double spacing = vertebra < kPairs ? kRibSpacing : kLumbarSpacing;
    for (int i = 0; i < design.vertebra_rings; ++i) {
      const double share = (i - design.vertebra_rings / 2) / static_cast<double>(design.vertebra_rings);
      path.push_back(spine_axis(vertebra_height(vertebra) + share * spacing));
      const double grown = 0.13 + 0.005 * vertebra;
      radii.push_back(grown * (1 - 0.18 * std::cos(2 * pi * share)));
    }
  }
  std::size_t next = 0;
  return tube_rings(
      path, Point::UnitX(),
      [&](double) {
        return HalfAxes{1.15 * radii[next], radii[next++]};
      },
      static_cast<int>(kSpineSides));
}

/// From the bottom up: the process, the body, and the handle, which is the widest.
std::vector<Ring> sternum_rings(const TorsoDesign& design) {
  std::vector<Point> path;
  for (int i = 0; i < design.sternum_rings; ++i) {
    path.push_back(sternum_axis(kSternumBottom + (kSternumTop - kSternumBottom) * i / (design.sternum_rings - 1)));
  }
  const auto half_axes = [](double share) {
    const double tip = std::min(1.0, 0.35 + 5 * share);
    const double handle = std::exp(-std::pow((share - 0.93) / 0.1, 2));
    return HalfAxes{0.13 * tip + 0.1 * handle, 0.055 * tip + 0.015 * handle};
  };
  return tube_rings(path, Point::UnitX(), half_axes, static_cast<int>(kSternumSides));
}

/// The plan of rib `rib`: half width of the chest there.
double chest_half_width(int rib) {
  constexpr std::array<double, kPairs> kHalfWidths = {0.58, 0.85, 1.04, 1.17, 1.26, 1.31,
                                                      1.34, 1.33, 1.28, 1.2,  1.1,  1.0};
  return kHalfWidths[static_cast<std::size_t>(rib)];
}

/// Where ribs that start there lie furthest behind and in front.
std::array<double, 2> chest_depth(const Point& start) {
  return {start.y() - 0.12, sternum_axis(start.z() - 0.2).y() + 0.05};
}

/// The path of a rib from `start` on the spine: back and out, round the side, downward to the front; up to an angle
/// (0 behind, pi in front) of `last_angle`. `side` is 1 on the left, -1 on the right.
std::vector<Point> rib_controls(int rib, double side, const Point& start, double last_angle) {
  const auto [back, front] = chest_depth(start);
  const double fall = 0.26 + 0.065 * std::min(rib, 7);
  const double half_width = chest_half_width(rib);
  std::vector<Point> controls = {start, start + 0.16 * Point(0.85 * side, -0.5, 0.05)};
  constexpr int kSteps = 5;
  const double first_angle = pi * 0.26;
  for (int i = 0; i < kSteps; ++i) {
    const double angle = first_angle + (last_angle - first_angle) * i / (kSteps - 1);
    const double fallen = (1 - std::cos(angle)) / (1 - std::cos(0.78 * pi));
    controls.emplace_back(side * half_width * std::sin(angle),
                          (front + back) / 2 - (front - back) / 2 * std::cos(angle), start.z() - fall * fallen);
  }
  return controls;
}

/// The rings of a rib along `path`, without those at openings.
std::vector<Ring> rib_rings(const std::vector<Point>& path, bool free_end) {
  const auto half_axes = [&](double share) {
    const double taper = free_end ? std::sqrt(std::max(0.05, 1 - std::pow(share, 6))) : 1.0;
    return HalfAxes{0.052 * taper, 0.03 * taper};
  };
  std::vector<Ring> rings = tube_rings(path, Point::UnitZ(), half_axes, static_cast<int>(TubeNetwork::kSides));
  rings.erase(rings.begin());  // the rim of the opening takes its place
  if (free_end) {
    rings.back() = {path.back()};
  } else {
    rings.pop_back();
  }
  return rings;
}

class Torso {
 public:
  explicit Torso(const TorsoDesign& design)
      : design_(design),
        spine_(network_.add_body(spine_rings(design))),
        sternum_(network_.add_body(sternum_rings(design))) {}

  TriangleSoup build() {
    for (const double side : {1.0, -1.0}) {
      for (int rib = 0; rib < kPairs; ++rib) add_rib(rib, side);
      for (int vertebra = kPairs; vertebra < kVertebrae; ++vertebra) {
        add_process(vertebra, side > 0 ? kLeft : kRight, Point(side, -0.25, 0.05), 0.3);
      }
    }
    for (int vertebra = 0; vertebra < kVertebrae; ++vertebra) {
      const bool lumbar = vertebra >= kPairs;
      add_process(vertebra, kBack, Point(0, -1, lumbar ? -0.15 : -0.7), lumbar ? 0.2 : 0.16);
    }
    return transformed(network_.surface(), facing_front());
  }

 private:
  // Of the points about the spine, which begin at the left and go round by the front.
  static constexpr std::size_t kLeft = kSpineSides - 2;
  static constexpr std::size_t kRight = kSpineSides / 2 + 2;
  static constexpr std::size_t kBack = 3 * kSpineSides / 4;

  TubeNetwork::Opening spine_opening(int vertebra, std::size_t side) {
    return network_.open(spine_, design_.middle_ring(kVertebrae - 1 - vertebra), side);
  }

  void add_rib(int rib, double side) {
    const TubeNetwork::Opening from = spine_opening(rib, side > 0 ? kLeft : kRight);
    if (rib >= kJoinedRibs) {
      // These are about half as long.
      const std::vector<Point> controls = rib_controls(rib, side, from.center, pi * (rib == kJoinedRibs ? 0.6 : 0.48));
      network_.add_sprout(
          from, rib_rings(evenly_spaced(smooth_path(controls, 24), design_.rib_segments / 2, kStandOff), true));
      return;
    }
    const bool is_true = rib < kTrueRibs;
    const std::size_t joint = is_true ? 0 : lowest_ring_of_rib_above();
    const TubeNetwork::Opening to =
        is_true ? network_.open(sternum_, design_.sternum_ring(rib), side > 0 ? 0 : kSternumSides / 2)
                : network_.open(rib_above_, joint, kBottom);
    double last_angle = 0.78 * pi;
    if (!is_true) {
      const auto [back, front] = chest_depth(from.center);
      last_angle = 0.86 * std::acos(((front + back) / 2 - to.center.y()) / ((front - back) / 2));
    }
    std::vector<Point> controls = rib_controls(rib, side, from.center, last_angle);
    controls.push_back(to.center + (is_true ? 0.1 : 0.14) * to.normal);
    controls.push_back(to.center);
    path_above_ = evenly_spaced(smooth_path(controls, 24),
                                is_true ? design_.rib_segments : design_.rib_segments * 3 / 4, kStandOff);
    rib_above_ = network_.add_bridge(from, rib_rings(path_above_, false), to);
  }

  /// Between half and four fifths of its length; a little before, where its underside still faces down.
  std::size_t lowest_ring_of_rib_above() const {
    const auto segments = static_cast<std::ptrdiff_t>(path_above_.size()) - 1;
    const auto first = path_above_.begin() + segments / 2;
    const auto last = path_above_.begin() + segments * 4 / 5 + 1;
    const auto lowest = std::ranges::min_element(first, last, {}, [](const Point& point) { return point.z(); });
    return static_cast<std::size_t>(lowest - path_above_.begin() - segments / 30);
  }

  void add_process(int vertebra, std::size_t point, const Point& direction, double length) {
    const TubeNetwork::Opening from = spine_opening(vertebra, point);
    const Point along = direction.normalized();
    std::vector<Point> path;
    path = {from.center, from.center + 0.06 * from.normal};
    for (int i = 1; i <= 3; ++i) path.emplace_back(path[1] + length * i / 3 * along);
    const auto half_axes = [](double share) { return HalfAxes{0.03 + 0.01 * share, 0.025}; };
    std::vector<Ring> rings = tube_rings(path, Point::UnitZ(), half_axes, static_cast<int>(TubeNetwork::kSides));
    rings.erase(rings.begin());
    rings.back() = {path.back()};
    network_.add_sprout(from, rings);
  }

  static constexpr std::size_t kBottom = TubeNetwork::kSides / 2;

  TorsoDesign design_;
  TubeNetwork network_;
  std::size_t spine_;
  std::size_t sternum_;
  std::size_t rib_above_ = 0;
  std::vector<Point> path_above_;
};

double torso_triangles(const Parameters& parameters) {
  const TorsoDesign design(parameters);
  return 2.0 * (kVertebrae * static_cast<double>(kSpineSides) * design.vertebra_rings +
                static_cast<double>(kSternumSides) * design.sternum_rings +
                2.0 * kPairs * static_cast<double>(TubeNetwork::kSides) * design.rib_segments);
}

}  // namespace

ProceduralModel torso_ribs_model() {
  ModelInfo info{"torso-ribs",
                 "ribs, spine and sternum as one closed surface of genus 19: tunnels between all the ribs",
                 "HE Fig. 13 (12,479 vertices)",
                 {}};
  info.parameters.specs = {
      ParameterSpec::integer("rib_segments", "segments", 30, 10'000, 44,
                             "segments along a true rib; others have fewer"),
      ParameterSpec::integer("vertebra_rings", "rings", 8, 1000, 10, "rings of each of the 17 vertebrae"),
      ParameterSpec::integer("sternum_rings", "rings", 40, 10'000, 48, "rings of the sternum")};
  info.parameters.check = [](const Parameters& parameters) {
    require_triangles_within_limit("torso-ribs", torso_triangles(parameters));
  };
  return {std::move(info), [](const Parameters& parameters) { return Torso(TorsoDesign(parameters)).build(); }};
}

}  // namespace voxcarve
