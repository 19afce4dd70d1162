// interpenetrating-figure: a standing man in a hat of 15 closed, overlapping, coloured parts, stand-in for the figure
// of [NT03, Fig. 7] (13,476 faces; head, arms and legs continue into the torso). Every part has 2 slices (stacks - 1)
// triangles: 30 * 32 * 14 = 13,440 by default.
#include <array>
#include <cmath>

#include "common/mesh/models/builders.h"
#include "common/mesh/models/primitives.h"

namespace voxcarve {

namespace {

constexpr int kParts = 15;

const Color kSkin(0.88F, 0.68F, 0.55F);
const Color kHatFelt(0.20F, 0.20F, 0.22F);
const Color kJacket(0.16F, 0.20F, 0.36F);
const Color kSleeve(0.20F, 0.25F, 0.44F);
const Color kTrousers(0.30F, 0.30F, 0.33F);
const Color kShoe(0.25F, 0.13F, 0.07F);

/// A limb: the convex hull of two balls.
struct Limb {
  Point start;
  double start_radius;
  Point end;
  double end_radius;
  Color color;
};

/// One side's limbs, x > 0; the other side's are their mirror images. Joints share a ball, so neighbours overlap there;
/// shoulder and hip lie within the torso. The figure stands on z = 0 and looks along -y.
const std::array<Limb, 6>& limbs() {
  static const std::array<Limb, 6> kLimbs = {
      Limb{{0.20, 0, 1.38}, 0.085, {0.42, 0.02, 1.15}, 0.070, kJacket},        // upper arm
      Limb{{0.42, 0.02, 1.15}, 0.065, {0.50, -0.10, 0.92}, 0.050, kSleeve},    // forearm
      Limb{{0.50, -0.10, 0.91}, 0.058, {0.51, -0.14, 0.80}, 0.042, kSkin},     // hand
      Limb{{0.10, 0, 0.98}, 0.115, {0.13, -0.01, 0.52}, 0.085, kTrousers},     // upper leg
      Limb{{0.13, -0.01, 0.52}, 0.080, {0.14, 0.02, 0.11}, 0.060, kTrousers},  // lower leg
      Limb{{0.14, 0.04, 0.065}, 0.065, {0.16, -0.16, 0.045}, 0.045, kShoe}};   // shoe
  return kLimbs;
}

/// `segments` segments along a polyline of fewer, by halving the longest piece's share again and again.
std::vector<Eigen::Vector2d> subdivided(const std::vector<Eigen::Vector2d>& polyline, int segments) {
  std::vector<int> pieces(polyline.size() - 1, 1);
  const auto piece_length = [&](std::size_t i) { return (polyline[i + 1] - polyline[i]).norm() / pieces[i]; };
  for (int total = static_cast<int>(pieces.size()); total < segments; ++total) {
    std::size_t longest = 0;
    for (std::size_t i = 1; i < pieces.size(); ++i) {
      if (piece_length(i) > piece_length(longest)) longest = i;
    }
    ++pieces[longest];
  }
  std::vector<Eigen::Vector2d> points = {polyline.front()};
  for (std::size_t i = 0; i + 1 < polyline.size(); ++i) {
    for (int k = 1; k < pieces[i]; ++k) {
      points.emplace_back(polyline[i] + (polyline[i + 1] - polyline[i]) * (static_cast<double>(k) / pieces[i]));
    }
    points.push_back(polyline[i + 1]);
  }
  return points;
}

/// Brim and crown in one; the head's top lies inside the crown.
TriangleSoup hat(int slices, int stacks) {
  const std::vector<Eigen::Vector2d> profile = {{0, 1.755},     {0.225, 1.765}, {0.230, 1.785},
                                                {0.145, 1.795}, {0.120, 1.945}, {0, 1.930}};
  return lathe(subdivided(profile, stacks), slices);
}

TriangleSoup build_figure(const Parameters& parameters) {
  const auto slices = static_cast<int>(parameters.integer("slices"));
  const auto stacks = static_cast<int>(parameters.integer("stacks"));
  const auto limb = [&](const Limb& l) {
    return colored(capsule(l.start, l.start_radius, l.end, l.end_radius, slices, stacks), l.color);
  };
  const Eigen::Affine3d flatten(Eigen::Scaling(1.0, 0.75, 1.0));
  const Eigen::Affine3d mirror(Eigen::Scaling(-1.0, 1.0, 1.0));

  TriangleSoup figure = limb({{0, 0, 1.53}, 0.080, {0, -0.01, 1.72}, 0.120, kSkin});  // head and neck
  append(figure, colored(hat(slices, stacks), kHatFelt));
  append(figure, transformed(limb({{0, 0, 0.98}, 0.21, {0, 0, 1.36}, 0.25, kJacket}), flatten));  // torso
  for (const Limb& one : limbs()) {
    const TriangleSoup side = limb(one);
    append(figure, side);
    append(figure, transformed(side, mirror));
  }
  return figure;
}

}  // namespace

ProceduralModel interpenetrating_figure_model() {
  ModelInfo info{
      "interpenetrating-figure", "a man in a hat of 15 closed, overlapping parts with a colour each", "NT Fig. 7", {}};
  info.parameters.specs = {ParameterSpec::integer("slices", "segments", 6, 10'000, 32, "segments around every part"),
                           ParameterSpec::integer("stacks", "segments", 6, 10'000, 15, "segments along every part")};
  info.parameters.check = [](const Parameters& parameters) {
    require_triangles_within_limit("interpenetrating-figure",
                                   kParts * 2.0 * static_cast<double>(parameters.integer("slices")) *
                                       static_cast<double>(parameters.integer("stacks") - 1));
  };
  return {std::move(info), build_figure};
}

}  // namespace voxcarve
