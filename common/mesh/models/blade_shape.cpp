#include "common/mesh/models/blade_shape.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace voxcarve {

namespace {

constexpr double kAirfoilStart = 235;
constexpr double kRootHalfLength = 165;
constexpr double kThickness = 28;       // the thickest half section has 0.79 of it
constexpr double kChannelShare = 0.38;  // of the thickness: at most 17 voxels, which a closing by 10 fills

/// From 0 to 1 with level ends.
double smooth_step(double from, double to, double value) {
  const double t = std::clamp((value - from) / (to - from), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

double chord_share(double angle) {
  return (1 + std::cos(angle)) / 2;
}

/// Signed by the side: positive on the suction side, 0 at both edges.
double half_thickness(double angle) {
  return kThickness * std::sin(angle) * (0.62 * std::pow(1 - chord_share(angle), 0.8) + 0.4);
}

/// The airfoil's section at height z: a point at `chord` on the camber line, a parabola, and `offset` across it.
/// Towards the tip the chord gets shorter and the section turns by 28 degrees.
Point airfoil_point(double z, double chord, double offset) {
  const double rise = std::clamp((z - kAirfoilStart) / (kBladeSpan - kAirfoilStart), 0.0, 1.0);
  const double length = 340 - 45 * rise;
  const double sag = 0.2 * length;
  const Eigen::Vector2d camber((chord - 0.5) * length, sag * (4 * chord * (1 - chord) - 0.55));
  const Eigen::Vector2d slope(length, 4 * sag * (1 - 2 * chord));
  const Eigen::Vector2d across = Eigen::Vector2d(-slope.y(), slope.x()).normalized();
  const Eigen::Vector2d turned = Eigen::Rotation2Dd(28 * std::numbers::pi / 180 * rise) * (camber + offset * across);
  return {turned.x(), turned.y(), z};
}

}  // namespace

const std::vector<BladeStation>& blade_stations() {
  constexpr double kRoot = kRootHalfLength;
  static const std::vector<BladeStation> stations = {
      {0, kRoot, 38, 0, 0, 0},      {12, kRoot, 50, 0, 9, 12},    {28, kRoot, 50, 0, 10, 28},
      {42, kRoot, 36, 0, 10, 42},   {56, kRoot, 64, 0, 14, 56},   {74, kRoot, 64, 0, 11, 74},
      {88, kRoot, 48, 0, 11, 88},   {102, kRoot, 78, 0, 15, 102}, {122, kRoot, 78, 0, 12, 122},
      {138, kRoot, 60, 0, 12, 138}, {190, kRoot, 60, 0, 24, 180}, {205, kRoot, 68, 0, 9, 190},
      {205, 191, 150, 0, 32, 208},  {235, 191, 150, 0, 16, 222},  {235, 191, 150, 0.9, 36, 242},
      {250, 191, 150, 1, 12, 252},  {643, 191, 150, 1, 234, 643}};
  return stations;
}

BladeStation between(const BladeStation& a, const BladeStation& b, double share) {
  const auto mix = [share](double from, double to) { return from + share * (to - from); };
  return {mix(a.z, b.z),
          mix(a.half_length, b.half_length),
          mix(a.half_width, b.half_width),
          mix(a.airfoil, b.airfoil),
          0,
          mix(a.channel_z, b.channel_z)};
}

Point blade_surface(const BladeStation& station, double angle) {
  const Point airfoil = airfoil_point(station.z, chord_share(angle), half_thickness(angle));
  // A rectangle with rounded corners whose x is linear in the chord's share, like the channels'.
  const double sine = std::sin(angle);
  const double flank = std::copysign(1 - std::pow(1 - std::min(1.0, std::abs(sine)), 9), sine);
  const Point rectangle(station.half_length * std::cos(angle), station.half_width * flank, station.z);
  return rectangle + station.airfoil * (airfoil - rectangle);
}

Point blade_interior(double z, double chord, double offset) {
  const Point root((2 * chord - 1) * kRootHalfLength, offset, z);
  return root + smooth_step(60, kAirfoilStart, z) * (airfoil_point(z, chord, offset) - root);
}

double channel_half_height(double angle) {
  return kChannelShare * half_thickness(angle);
}

std::array<double, 2> channel_ends(int channel) {
  constexpr double kRibHalfWidth = 0.02;
  constexpr double kLeadingWall = 0.045;
  constexpr double kTrailingWall = 0.05;
  const auto c = static_cast<std::size_t>(channel);
  return {channel == 0 ? kLeadingWall : kBladeRibs[c - 1] + kRibHalfWidth,
          channel + 1 == kBladeChannels ? 1 - kTrailingWall : kBladeRibs[c] - kRibHalfWidth};
}

}  // namespace voxcarve
