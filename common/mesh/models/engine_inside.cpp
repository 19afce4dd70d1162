// The engine's interior: crankshaft, connecting rods, pistons, camshaft, and the valves with their springs.
#include <cmath>
#include <numbers>

#include "common/mesh/models/engine_parts.h"
#include "common/mesh/models/primitives.h"

namespace voxcarve {

namespace {

using std::numbers::pi;
using Profile = std::vector<Eigen::Vector2d>;

const Color kForged(0.55F, 0.52F, 0.50F);
const Color kPiston(0.80F, 0.80F, 0.82F);
const Color kValve(0.65F, 0.60F, 0.45F);
const Color kSpring(0.25F, 0.55F, 0.35F);

constexpr double kThrow = 0.32;      // from the crankshaft's axis to a crank pin
constexpr double kRodLength = 1.15;  // between the rod's eyes
constexpr double kPinAngles[4] = {0, pi / 2, 3 * pi / 2, pi};

/// The crank pin of one throw, at x in the middle of its two cylinders.
Point crank_pin(int cylinder) {
  const double angle = kPinAngles[cylinder] + pi / 3;
  return {cylinder_x(cylinder, 1) + 0.06, kThrow * std::cos(angle), kThrow * std::sin(angle)};
}

void add_crankshaft(EngineAssembly& engine) {
  for (int k = 0; k <= 4; ++k) {  // main journals
    const double x = -2.14 + 1.1 * k;
    engine.add(cylinder({x - 0.18, 0, 0}, {x + 0.18, 0, 0}, 0.2, engine.segments(32)), kForged);
  }
  for (int i = 0; i < 4; ++i) {
    const Point pin = crank_pin(i);
    const Point along = Point::UnitX();
    engine.add(cylinder(pin - 0.25 * along, pin + 0.25 * along, 0.15, engine.segments(28)), kForged);
    // Webs: a disc as the counterweight and a smaller one about the pin.
    const Point out = Point(0, pin.y(), pin.z()).normalized();
    for (const double dx : {-0.31, 0.31}) {
      const Point foot(pin.x() + dx, 0, 0);
      engine.add(
          cylinder(foot - 0.06 * along - 0.15 * out, foot + 0.06 * along - 0.15 * out, 0.34, engine.segments(36)),
          kForged);
      engine.add(cylinder(pin + (dx - 0.06) * along, pin + (dx + 0.06) * along, 0.22, engine.segments(28)), kForged);
    }
  }
}

void add_piston_and_rod(EngineAssembly& engine, int cylinder_index, int side) {
  const Eigen::Affine3d frame = bank_frame(side);
  const double x = cylinder_x(cylinder_index, side);
  const Point pin = frame.inverse() * crank_pin(cylinder_index);
  const double height = pin.z() + std::sqrt(kRodLength * kRodLength - pin.y() * pin.y());
  Profile profile = {{0.38, height - 0.22}, {0.4, height - 0.2}, {0.4, height + 0.02}};
  for (int ring = 0; ring < 3; ++ring) {
    const double z = height + 0.03 + 0.06 * ring;
    profile.insert(profile.end(), {{0.4, z}, {0.37, z + 0.005}, {0.37, z + 0.03}, {0.4, z + 0.035}});
  }
  profile.insert(profile.end(), {{0.4, height + 0.22}, {0.3, height + 0.24}, {0, height + 0.22}});
  engine.add(transformed(lathe(profile, engine.segments(40), {x, 0, 0}, Point::UnitZ()), frame), kPiston);
  const Point big_eye(x, pin.y(), pin.z());
  const Point small_eye(x, 0, height);
  const Point along = Point::UnitX();
  for (const auto& [eye, radius] : {std::pair{big_eye, 0.21}, {small_eye, 0.13}}) {
    engine.add(transformed(cylinder(eye - 0.09 * along, eye + 0.09 * along, radius, engine.segments(28)), frame),
               kForged);
  }
  engine.add(transformed(capsule(big_eye, 0.11, small_eye, 0.07, engine.segments(14), engine.segments(9)), frame),
             kForged);
  engine.add(
      transformed(cylinder(small_eye - 0.36 * along, small_eye + 0.36 * along, 0.06, engine.segments(16)), frame),
      kForged);
}

void add_valve(EngineAssembly& engine, const Eigen::Affine3d& frame, double x, double lift) {
  constexpr double kCoils = 5;
  const Profile valve = {{0, 2.26}, {0.17, 2.27}, {0.18, 2.3}, {0.08, 2.36}, {0.03, 2.44}, {0.03, 3.12}, {0.02, 3.14}};
  engine.add(transformed(lathe(valve, engine.segments(20), {x, 0, -lift}, Point::UnitZ()), frame), kValve);
  // Spring, and the keeper on top: an hourglass around the stem's end.
  std::vector<Point> helix;
  const int steps = engine.segments(16) * static_cast<int>(kCoils);
  for (int i = 0; i <= steps; ++i) {
    const double share = static_cast<double>(i) / steps;
    const double angle = 2 * pi * kCoils * share;
    helix.emplace_back(x + 0.1 * std::cos(angle), 0.1 * std::sin(angle), 2.86 + (0.2 - lift) * share);
  }
  engine.add(transformed(swept_tube(helix, 0.014, engine.segments(9)), frame), kSpring);
  engine.add(transformed(hourglass({x, 0, 3.05 - lift}, {x, 0, 3.2 - lift}, 0.08, engine.segments(16)), frame), kValve);
  // Rocker arm, from the keeper to its push rod, and the rod down to the camshaft.
  engine.add(
      transformed(capsule({x, 0.05, 3.2 - lift}, 0.04, {x, -0.35, 3.18}, 0.06, engine.segments(12), engine.segments(7)),
                  frame),
      kForged);
  engine.add(transformed(cylinder({x, -0.35, 3.15}, {x, -0.55, 1.3}, 0.025, engine.segments(8)), frame), kForged);
}

void add_camshaft(EngineAssembly& engine) {
  constexpr double kHeight = 0.85;
  engine.add(cylinder({-2.3, 0, kHeight}, {2.3, 0, kHeight}, 0.08, engine.segments(24)), kForged);
  for (int lobe = 0; lobe < 16; ++lobe) {
    const double x = -2.0 + 0.26 * lobe;
    const double nose = 2 * pi * lobe * 5 / 16;
    std::vector<Ring> rings(2);
    const int sides = engine.segments(28);
    for (int k = 0; k < sides; ++k) {
      const double angle = 2 * pi * k / sides;
      const double toward_nose = std::max(0.0, std::cos(angle - nose));
      const double r = 0.12 + 0.07 * toward_nose * toward_nose * toward_nose;
      for (std::size_t end = 0; end < 2; ++end) {
        rings[end].emplace_back(x + (end == 0 ? -0.05 : 0.05), r * std::cos(angle), kHeight + r * std::sin(angle));
      }
    }
    engine.add(loft(rings), kForged);
  }
}

}  // namespace

void add_interior(EngineAssembly& engine) {
  add_crankshaft(engine);
  add_camshaft(engine);
  for (const int side : {1, -1}) {
    const Eigen::Affine3d frame = bank_frame(side);
    for (int i = 0; i < 4; ++i) {
      add_piston_and_rod(engine, i, side);
      for (const double dx : {-0.2, 0.2}) {
        add_valve(engine, frame, cylinder_x(i, side) + dx, (i + (dx > 0 ? 1 : 0)) % 3 == 0 ? 0.04 : 0.0);
      }
    }
  }
}

}  // namespace voxcarve
