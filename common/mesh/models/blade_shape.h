// The geometry of the model `blade`: where its outer surface and its cooling channels are. z is the span, x runs from
// the leading to the trailing edge, +y is the suction side. Lengths are in voxels at resolution 643.
#pragma once

#include <array>
#include <vector>

#include "common/mesh/triangle_soup.h"

namespace voxcarve {

constexpr double kBladeLengthX = 382;
constexpr double kBladeLengthY = 300;
constexpr double kBladeSpan = 643;
constexpr int kBladeChannels = 5;

/// Shares of the chord at which the ribs between the channels stand.
constexpr std::array<double, kBladeChannels - 1> kBladeRibs = {0.2, 0.4, 0.6, 0.8};

/// A cross-section of the outer surface. Sections of the platform's faces lie at one height.
struct BladeStation {
  double z;
  double half_length;  ///< of the rectangle along x
  double half_width;   ///< of the rectangle along y
  double airfoil;      ///< 0: the rectangle, 1: the airfoil
  int belts;           ///< between this station and the one before, at detail 1
  double channel_z;    ///< height of the channels' walls in the same row; grows even along the platform's faces
};

/// From the root's end face to the tip: a fir tree of three lobes, shank, platform, airfoil.
const std::vector<BladeStation>& blade_stations();

/// The station `share` of the way from `a` to `b`.
BladeStation between(const BladeStation& a, const BladeStation& b, double share);

/// The outer surface at `angle`: 0 is the trailing edge, pi / 2 the suction side, pi the leading edge. The chord's
/// share from the leading edge is (1 + cos(angle)) / 2.
Point blade_surface(const BladeStation& station, double angle);

/// A point in the blade's interior at height z: `chord` as a share from the leading edge, `offset` from the camber
/// line.
Point blade_interior(double z, double chord, double offset);

/// Half the distance between the walls of a channel, at the angle that belongs to a share of the chord.
double channel_half_height(double angle);

/// Where a channel begins and ends, as shares of the chord.
std::array<double, 2> channel_ends(int channel);

}  // namespace voxcarve
