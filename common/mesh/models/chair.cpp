// chair: a slatted chair, stand-in for [NT03, Fig. 9] (3,261 faces; closing distance 10 voxels, set by the gaps).
//
// Every part is a closed solid of its own and no two touch or overlap, so every voxelizer that counts parity agrees.
// Lengths are shares of the height (1 model unit); g is the gap between slats and j = g / 2 every joint: slat to post,
// leg to seat, seat to back. There are no armrests or stretchers, so the only loops run through gaps and joints.
//
// What a closing does. A ball of radius r enters a gap of width w < 2 r between bars rounded by c as deep as
//     d(w) = r + c - sqrt((r + c)^2 - (w / 2 + c)^2),
// from both sides, and the gap is closed where 2 d(w) is less than the bars' depth t. At the end of a slat the widest
// circle that touches the post and two slats' corners has radius j / 2 + g^2 / (8 j), which is g / 2 for j = g / 2: no
// wider than the gap itself. So all that is needed is 2 d(g) < t. With the defaults g = 0.045, t = 0.045, c = 0.005 and
// r = 10 voxels that holds at resolutions up to 420 (g is 18.9 voxels, 2 d = 17.1, t = 18.9); as a sampled gap may come
// out a voxel wider, use at most 400 (g is 18 voxels). At 256 the gaps have 11.5 voxels, the joints 5.8 and the
// thinnest bar (a leg at the floor) 9. Below 64 the ball no longer passes freely between the legs, which are 0.36
// apart. From 64 to 400 the closed chair is one solid of genus 0: seat and back become plates that meet along an edge,
// and four legs hang from them.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "common/mesh/models/builders.h"
#include "common/mesh/models/primitives.h"
#include "common/run/errors.h"
#include "common/run/text.h"

namespace voxcarve {

namespace {

constexpr double kHeight = 1;
constexpr double kWidth = 0.46;       // along x
constexpr double kDepth = 0.48;       // along y, front to back
constexpr double kSeatHeight = 0.45;  // underside of the seat
constexpr double kBackTop = 0.985;    // upper edge of the top slat
constexpr double kLeg = 0.05;         // side of a leg's square section below the seat
constexpr double kFootScale = 0.7;    // a leg's section at the floor, as a share of that
constexpr double kThickness = 0.045;  // of slats
constexpr double kRounding = 0.005;   // radius of the bars' long edges
constexpr double kNarrowestSlat = 0.02;

/// The parameters, and the lengths that follow from them.
struct ChairDesign {
  explicit ChairDesign(const Parameters& parameters)
      : gap(parameters.real("gap")),
        back_slats(static_cast<int>(parameters.integer("back_slats"))),
        seat_slats(static_cast<int>(parameters.integer("seat_slats"))),
        slat_segments(static_cast<int>(parameters.integer("slat_segments"))),
        leg_segments(static_cast<int>(parameters.integer("leg_segments"))),
        corner_segments(static_cast<int>(parameters.integer("corner_segments"))) {}

  double joint() const { return gap / 2; }
  /// How far slats hang through or bow back in their middle. As much as a joint, so that the lowest back slat, which
  /// starts a joint behind the seat, is nowhere further from it than a gap.
  double bow() const { return gap / 2; }
  double back_start() const { return kSeatHeight - bow(); }
  double back_slat_width() const { return (kBackTop - back_start() - (back_slats - 1) * gap) / back_slats; }
  double seat_end() const { return kDepth - kLeg - joint(); }
  double seat_slat_width() const { return (seat_end() - (seat_slats - 1) * gap) / seat_slats; }
  double leg_top() const { return kSeatHeight - joint(); }
  double triangles() const {
    const double ring = 4.0 * (corner_segments + 1);
    const auto bar = [&](double segments) { return 2 * ring * segments + 2 * (ring - 2); };
    return (static_cast<double>(back_slats) + seat_slats) * bar(slat_segments) + 4 * bar(leg_segments);
  }

  double gap;
  int back_slats;
  int seat_slats;
  int slat_segments;
  int leg_segments;
  int corner_segments;
};

/// A rectangle with rounded corners about the origin, counterclockwise.
std::vector<Eigen::Vector2d> rounded_rectangle(double width, double height, double rounding, int corner_segments) {
  std::vector<Eigen::Vector2d> points;
  constexpr std::array<std::array<int, 2>, 4> kSigns = {{{1, 1}, {-1, 1}, {-1, -1}, {1, -1}}};
  for (std::size_t corner = 0; corner < 4; ++corner) {
    const Eigen::Vector2d center(kSigns[corner][0] * (width / 2 - rounding),
                                 kSigns[corner][1] * (height / 2 - rounding));
    for (int k = 0; k <= corner_segments; ++k) {
      const double angle =
          std::numbers::pi / 2 * (static_cast<double>(corner) + static_cast<double>(k) / corner_segments);
      points.emplace_back(center + rounding * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
    }
  }
  return points;
}

/// 0 between the posts' inner faces and beyond, 1 in the middle.
double bow_profile(double x) {
  const double u = std::clamp((x - kLeg) / (kWidth - 2 * kLeg), 0.0, 1.0);
  return 4 * u * (1 - u);
}

/// A slat along x from `first` to `last` whose section is `section` (y, z), displaced by `bow` in its middle.
TriangleSoup slat(const ChairDesign& design, const std::vector<Eigen::Vector2d>& section, double first, double last,
                  const Point& center, const Point& bow) {
  std::vector<Ring> rings;
  for (int i = 0; i <= design.slat_segments; ++i) {
    const double x = first + (last - first) * i / design.slat_segments;
    const Point middle = Point(x, center.y(), center.z()) + bow_profile(x) * bow;
    Ring ring;
    for (const Eigen::Vector2d& point : section) ring.emplace_back(middle + Point(0, point.x(), point.y()));
    rings.push_back(std::move(ring));
  }
  return loft(rings);
}

/// A leg about (x, y), tapered to the floor. A post goes on above the seat with its full section, to the chair's
/// height.
TriangleSoup leg(const ChairDesign& design, double x, double y, bool is_post) {
  const auto section = rounded_rectangle(kLeg, kLeg, kRounding, design.corner_segments);
  const int lower = is_post ? (design.leg_segments + 1) / 2 : design.leg_segments;
  const int upper = design.leg_segments - lower;
  std::vector<Ring> rings;
  const auto add_ring = [&](double z, double scale) {
    Ring ring;
    for (const Eigen::Vector2d& point : section) ring.emplace_back(x + scale * point.x(), y + scale * point.y(), z);
    rings.push_back(std::move(ring));
  };
  for (int i = 0; i <= lower; ++i) {
    const double share = static_cast<double>(i) / lower;
    add_ring(design.leg_top() * share, kFootScale + (1 - kFootScale) * share);
  }
  for (int i = 1; i <= upper; ++i) add_ring(design.leg_top() + (kHeight - design.leg_top()) * i / upper, 1);
  return loft(rings);
}

TriangleSoup build_chair(const Parameters& parameters) {
  const ChairDesign design(parameters);
  TriangleSoup chair;
  for (const double x : {kLeg / 2, kWidth - kLeg / 2}) {
    append(chair, leg(design, x, kLeg / 2, false));
    append(chair, leg(design, x, kDepth - kLeg / 2, true));
  }
  const double seat_width = design.seat_slat_width();
  const auto seat_section = rounded_rectangle(seat_width, kThickness, kRounding, design.corner_segments);
  for (int i = 0; i < design.seat_slats; ++i) {
    const Point center(0, seat_width / 2 + i * (seat_width + design.gap), kSeatHeight + kThickness / 2);
    append(chair, slat(design, seat_section, 0, kWidth, center, {0, 0, -design.bow()}));
  }
  const double back_width = design.back_slat_width();
  const auto back_section = rounded_rectangle(kThickness, back_width, kRounding, design.corner_segments);
  const double inner = kLeg + design.joint();
  for (int i = 0; i < design.back_slats; ++i) {
    const Point center(0, kDepth - kLeg + kThickness / 2,
                       design.back_start() + back_width / 2 + i * (back_width + design.gap));
    append(chair, slat(design, back_section, inner, kWidth - inner, center, {0, design.bow(), 0}));
  }
  return chair;
}

void check_chair(const Parameters& parameters) {
  const ChairDesign design(parameters);
  if (std::min(design.back_slat_width(), design.seat_slat_width()) < kNarrowestSlat) {
    throw ParameterError("chair: so many slats with this gap leave slats narrower than " + format_real(kNarrowestSlat) +
                         " of the height; lower gap, back_slats or seat_slats");
  }
  require_triangles_within_limit("chair", design.triangles());
}

}  // namespace

ProceduralModel chair_model() {
  ModelInfo info{"chair",
                 "a slatted chair of height 1 from separate closed bars; a closing joins them into genus 0",
                 "NT Fig. 9",
                 {}};
  info.parameters.specs = {
      ParameterSpec::real("gap", "height", 0.01, 0.07, 0.045,
                          "between slats, as a share of the height; joints have half"),
      ParameterSpec::integer("back_slats", "slats", 1, 50, 6, "slats in the back"),
      ParameterSpec::integer("seat_slats", "slats", 1, 50, 5, "slats in the seat"),
      ParameterSpec::integer("slat_segments", "segments", 2, 10'000, 8, "segments along a slat"),
      ParameterSpec::integer("leg_segments", "segments", 2, 10'000, 9, "segments along a leg"),
      ParameterSpec::integer("corner_segments", "segments", 1, 1000, 2, "segments of each rounded edge")};
  info.parameters.check = check_chair;
  return {std::move(info), build_chair};
}

}  // namespace voxcarve
