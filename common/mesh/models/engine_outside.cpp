// What hangs on the engine's castings: intake, exhaust, ignition, the belt drive in front and other aggregates.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/mesh/models/engine_parts.h"
#include "common/mesh/models/primitives.h"

namespace voxcarve {

namespace {

using std::numbers::pi;
using Profile = std::vector<Eigen::Vector2d>;

const Color kAluminium(0.70F, 0.71F, 0.74F);
const Color kChrome(0.88F, 0.89F, 0.92F);
const Color kSteel(0.60F, 0.60F, 0.62F);
const Color kRust(0.50F, 0.32F, 0.22F);
const Color kRubber(0.08F, 0.08F, 0.09F);
const Color kBlue(0.12F, 0.25F, 0.60F);
const Color kBrass(0.80F, 0.63F, 0.25F);
const Color kCeramic(0.93F, 0.92F, 0.88F);
const Color kLead(0.85F, 0.45F, 0.05F);
const Color kFan(0.90F, 0.75F, 0.10F);

const Point kForward = -Point::UnitX();
const Point kUp = Point::UnitZ();

TriangleSoup tube(const EngineAssembly& engine, const std::vector<Point>& controls, double radius, int pieces,
                  int sides) {
  return swept_tube(smooth_path(controls, engine.segments(pieces)), radius, engine.segments(sides));
}

/// The pulley of radius r about `center`, from its front face back, with `grooves` grooves in its rim.
TriangleSoup pulley(const EngineAssembly& engine, const Point& center, double r, int grooves) {
  Profile profile = {{0.35 * r, -0.12}, {0.4 * r, -0.04}, {0.85 * r, -0.04}, {0.88 * r, -0.12}, {r, -0.12}};
  for (int k = 0; k < grooves; ++k) {
    const double z = -0.1 + 0.2 * k / grooves;
    const double step = 0.2 / grooves;
    profile.emplace_back(r, z);
    profile.emplace_back(0.9 * r, z + 0.35 * step);
    profile.emplace_back(0.9 * r, z + 0.6 * step);
  }
  profile.insert(profile.end(), {{r, 0.1}, {r, 0.12}, {0.88 * r, 0.12}, {0.85 * r, 0.05}, {0.3 * r, 0.05}, {0, 0.08}});
  return lathe(profile, engine.segments(64), center, kForward);
}

}  // namespace

void add_intake(EngineAssembly& engine) {
  const int corner = engine.segments(7);
  engine.add_casting(
      layered({{1.45, 3.0, 0.9, 0.15}, {1.9, 2.9, 0.9, 0.15}, {2.3, 2.6, 0.85, 0.2}, {2.4, 2.5, 0.75, 0.2}}, corner),
      kAluminium);
  for (const int side : {1, -1}) {
    for (int i = 0; i < 4; ++i) {
      const double x = cylinder_x(i, side);
      const std::vector<Point> controls = {{0.6 * x, 0.2 * side, 2.15},
                                           {0.75 * x, 0.62 * side, 2.42},
                                           {0.95 * x, 1.0 * side, 2.45},
                                           {x, 1.4 * side, 2.15}};
      engine.add(tube(engine, controls, 0.18, 8, 22), kAluminium);
      const Point port = bank_frame(side) * Point(x, -0.66, 2.58);
      const Point outward = bank_frame(side).linear() * Point(0, -1, 0);
      engine.add(cylinder(port - 0.05 * outward, port + 0.08 * outward, 0.27, engine.segments(28)), kSteel);
    }
  }
  // Carburettor and air cleaner.
  engine.add(layered({{2.4, 1.0, 0.7, 0.1, -0.1},
                      {2.48, 1.0, 0.7, 0.1, -0.1},
                      {2.48, 0.8, 0.55, 0.08, -0.1},
                      {2.75, 0.8, 0.55, 0.08, -0.1},
                      {2.8, 0.95, 0.65, 0.1, -0.1},
                      {2.88, 0.95, 0.65, 0.1, -0.1}},
                     corner),
             kBrass);
  for (const double y : {-0.15, 0.15}) {  // float bowls and jets
    engine.add(cylinder({-0.75, y, 2.5}, {-0.45, y, 2.5}, 0.12, engine.segments(20)), kBrass);
    for (const double x : {-0.3, 0.1})
      engine.add(hourglass({x, y, 2.5}, {x, y, 2.8}, 0.08, engine.segments(16)), kBrass);
  }
  const Point cleaner(-0.1, 0, 0);
  Profile base = {{0.4, 2.82}, {1.25, 2.86}, {1.3, 2.92}, {1.3, 3.0}, {1.18, 3.0}, {1.18, 2.98}, {0.4, 2.96}};
  engine.add(lathe(base, engine.segments(88), cleaner, kUp), kChrome);
  Profile filter = {{0.9, 2.95}};
  constexpr int kPleats = 6;
  for (int k = 0; k < kPleats; ++k) {
    filter.emplace_back(1.16, 2.97 + 0.05 * k);
    filter.emplace_back(1.1, 2.995 + 0.05 * k);
  }
  filter.emplace_back(0.9, 3.3);
  engine.add(lathe(filter, engine.segments(88), cleaner, kUp), kLead);
  const Profile lid = {{1.2, 3.22},  {1.3, 3.22}, {1.3, 3.3},   {1.25, 3.36}, {1.0, 3.4},
                       {0.95, 3.37}, {0.5, 3.37}, {0.45, 3.42}, {0, 3.44}};
  engine.add(lathe(lid, engine.segments(88), cleaner, kUp), kChrome);
  engine.add(tube(engine, {{-0.1, 0.93, 3.1}, {-0.5, 1.5, 3.1}, {-1.2, 1.75, 3.1}}, 0.2, 8, 26), kChrome);  // snorkel
}

void add_exhaust(EngineAssembly& engine) {
  for (const int side : {1, -1}) {
    const Eigen::Affine3d frame = bank_frame(side);
    for (int i = 0; i < 4; ++i) {
      const double x = cylinder_x(i, side);
      const Point port = frame * Point(x, 0.6, 2.5);
      const Point out = frame * Point(x, 1.0, 2.5);
      engine.add(tube(engine, {port, out, {x + 0.06, 2.72 * side, 0.75}, {x + 0.1, 2.66 * side, 0.3}}, 0.15, 8, 20),
                 kRust);
      // The port's flange, a plate with two bolts.
      TriangleSoup flange = layered({{0.0, 0.6, 0.4, 0.12}, {0.08, 0.6, 0.4, 0.12}}, engine.segments(5));
      const Eigen::Affine3d upright(Eigen::AngleAxisd(-pi / 2, Point::UnitX()));
      engine.add(transformed(flange, frame * Eigen::Translation3d(x, 0.8, 2.5) * upright), kSteel);
      for (const double dx : {-0.24, 0.24}) {
        engine.add(transformed(cylinder({x + dx, 0.78, 2.5}, {x + dx, 0.95, 2.5}, 0.045, 6), frame), kSteel);
      }
    }
    engine.add(tube(engine,
                    {{-1.85, 2.66 * side, 0.32},
                     {0, 2.66 * side, 0.3},
                     {1.9, 2.64 * side, 0.26},
                     {2.35, 2.4 * side, -0.3},
                     {2.5, 2.12 * side, -1.1}},
                    0.22, 10, 28),
               kRust);
    const Profile flange = {{0.22, 0}, {0.36, 0}, {0.36, 0.08}, {0.22, 0.08}};
    engine.add(lathe(flange, engine.segments(28), {2.48, 2.12 * side, -1.05}, {0.15, -0.15 * side, -0.5}), kSteel);
  }
}

void add_ignition(EngineAssembly& engine) {
  const Point foot(2.0, 0, 0);
  const Profile body = {{0.12, 1.4}, {0.12, 2.0}, {0.22, 2.05}, {0.26, 2.2}, {0.3, 2.22}, {0.3, 2.35}};
  engine.add(lathe(body, engine.segments(32), foot, kUp), kSteel);
  const Profile cap = {{0.31, 2.34}, {0.31, 2.5}, {0.26, 2.62}, {0, 2.64}};
  engine.add(lathe(cap, engine.segments(32), foot, kUp), kRubber);
  const Profile tower = {{0.055, 2.45}, {0.055, 2.78}, {0.04, 2.82}, {0, 2.82}};
  engine.add(lathe(tower, engine.segments(14), foot, kUp), kRubber);
  const Profile plug = {{0.03, -0.25}, {0.07, -0.2}, {0.07, 0.0},  {0.11, 0.0},  {0.11, 0.1},
                        {0.06, 0.12},  {0.05, 0.3},  {0.03, 0.32}, {0.03, 0.38}, {0, 0.39}};
  for (const int side : {1, -1}) {
    const Eigen::Affine3d frame = bank_frame(side);
    for (int i = 0; i < 4; ++i) {
      const double x = cylinder_x(i, side) + 0.45;
      const Point seat = frame * Point(x, 0.66, 2.72);
      const Point axis = frame.linear() * Point(0, 0.8, 0.6);
      engine.add(lathe(plug, engine.segments(18), seat, axis), kCeramic);
      const double angle = pi * (i + 0.5) / 4;  // towers in a circle, the front cylinder's in front
      const Point top = foot + Point(-0.2 * std::cos(angle), 0.2 * side * std::sin(angle), 0);
      engine.add(lathe(tower, engine.segments(14), top, kUp), kRubber);
      // A thin lead from the plug over the valve cover to its tower.
      const double lane = 1.35 + 0.1 * i;
      const std::vector<Point> lead = {seat + 0.3 * axis,
                                       seat + 0.75 * axis,
                                       frame * Point(x + 0.15, 0.6, 3.45),
                                       frame * Point(lane, 0.05 + 0.08 * i, 3.62),
                                       frame * Point(lane + 0.25, -0.5, 3.45),
                                       top + Point(-0.05, 0.25 * side, 3.1 - 0.04 * i),
                                       top + Point(0, 0, 2.75)};
      engine.add(tube(engine, lead, 0.042, 10, 12), kLead);
    }
  }
  engine.add(cylinder({1.7, -0.55, 1.75}, {2.3, -0.55, 1.75}, 0.16, engine.segments(26)), kBlue);  // coil
  engine.add(tube(engine, {{1.75, -0.55, 1.8}, {1.55, -0.4, 2.6}, {1.8, -0.1, 3.05}, {2.0, 0, 2.75}}, 0.042, 10, 9),
             kLead);
}

namespace {

struct DrivePulley {
  double y;
  double z;
  double radius;
  int grooves;
};

constexpr double kDriveX = -3.0;  // plane of the belt
const std::array<DrivePulley, 4> kPulleys = {
    {{0, 0, 0.58, 4}, {1.85, 0.15, 0.34, 3}, {0, 1.42, 0.5, 3}, {-1.95, 0.25, 0.26, 3}}};

/// The belt: the convex hull of the pulleys' circles, swept with a flat section.
TriangleSoup belt(const EngineAssembly& engine) {
  constexpr double kHalfWidth = 0.085;
  constexpr double kThickness = 0.05;
  // Pulley k is left for the next one at the angle of their common outer tangent.
  std::vector<Eigen::Vector2d> inner;
  std::vector<Eigen::Vector2d> normals;
  const auto departure = [](const DrivePulley& a, const DrivePulley& b) {
    const double distance = std::hypot(b.y - a.y, b.z - a.z);
    return std::atan2(b.z - a.z, b.y - a.y) - std::acos((a.radius - b.radius) / distance);
  };
  for (std::size_t k = 0; k < kPulleys.size(); ++k) {
    const DrivePulley& pulley = kPulleys[k];
    const double start = departure(kPulleys[(k + 3) % 4], pulley);
    double end = departure(pulley, kPulleys[(k + 1) % 4]);
    while (end < start) end += 2 * pi;
    const int steps = engine.segments(24);
    for (int i = 0; i <= steps; ++i) {
      const double angle = start + (end - start) * i / steps;
      const Eigen::Vector2d normal(std::cos(angle), std::sin(angle));
      inner.emplace_back(Eigen::Vector2d(pulley.y, pulley.z) + pulley.radius * normal);
      normals.push_back(normal);
    }
  }
  std::vector<Ring> rings;
  for (std::size_t i = 0; i < inner.size(); ++i) {
    const Eigen::Vector2d low = inner[i] - 0.02 * normals[i];
    const Eigen::Vector2d high = inner[i] + kThickness * normals[i];
    rings.push_back({{kDriveX - kHalfWidth, low.x(), low.y()},
                     {kDriveX + kHalfWidth, low.x(), low.y()},
                     {kDriveX + kHalfWidth, high.x(), high.y()},
                     {kDriveX - kHalfWidth, high.x(), high.y()}});
  }
  return loft(rings, LoftEnds::kJoined);
}

/// A twisted blade from the hub outward.
TriangleSoup fan_blade(const EngineAssembly& engine, double angle) {
  std::vector<Ring> rings;
  const int steps = engine.segments(10);
  for (int i = 0; i <= steps; ++i) {
    const double share = static_cast<double>(i) / steps;
    const double r = 0.2 + 1.25 * share;
    const double twist = 0.75 - 0.35 * share;
    const double half = 0.14 + 0.16 * share - 0.08 * share * share;
    Ring ring;
    constexpr double kThickness = 0.035;
    for (const auto& [u, v] :
         {std::pair{-half, -kThickness}, {-half, kThickness}, {half, kThickness}, {half, -kThickness}}) {
      ring.emplace_back(u * std::sin(twist) + v * std::cos(twist), u * std::cos(twist) - v * std::sin(twist), r);
    }
    rings.push_back(std::move(ring));
  }
  const Eigen::Affine3d turn(Eigen::Translation3d(-3.42, 0, 1.42) * Eigen::AngleAxisd(angle, Point::UnitX()));
  return transformed(loft(rings), turn);
}

}  // namespace

void add_front_drive(EngineAssembly& engine) {
  // Timing cover: an upright plate, rounded where the pulleys turn.
  const std::vector<Layer> cover = {
      {2.48, 2.7, 1.9, 0.5, 0.45}, {2.7, 2.65, 1.8, 0.5, 0.45}, {2.74, 2.4, 1.6, 0.45, 0.45}};
  const Eigen::Affine3d forward(Eigen::AngleAxisd(-pi / 2, Point::UnitY()));  // local z looks along -x, local x up
  engine.add_casting(transformed(layered(cover, engine.segments(8)), forward), kAluminium);
  for (std::size_t k = 0; k < kPulleys.size(); ++k) {
    const DrivePulley& p = kPulleys[k];
    engine.add(pulley(engine, {kDriveX, p.y, p.z}, p.radius, p.grooves), k == 0 ? kSteel : kChrome);
    engine.add(cylinder({-2.4, p.y, p.z}, {kDriveX - 0.14, p.y, p.z}, 0.1, engine.segments(20)), kSteel);
  }
  engine.add(belt(engine), kRubber);
  // Crankshaft damper behind its pulley, water pump housing, fan.
  const Profile damper = {{0.3, -2.9}, {0.62, -2.88}, {0.62, -2.76}, {0.5, -2.74}, {0.2, -2.7}};
  engine.add(lathe(damper, engine.segments(48), Point::Zero(), Point::UnitX()), kSteel);
  const Profile pump = {{0.55, 0}, {0.55, 0.15}, {0.3, 0.3}, {0.22, 0.5}, {0.15, 0.52}};
  engine.add(lathe(pump, engine.segments(40), {-2.45, 0, 1.42}, kForward), kAluminium);
  const Profile hub = {{0.15, 0}, {0.3, 0.02}, {0.3, 0.2}, {0.2, 0.3}, {0, 0.32}};
  engine.add(lathe(hub, engine.segments(36), {-3.25, 0, 1.42}, kForward), kSteel);
  constexpr int kBlades = 7;
  for (int k = 0; k < kBlades; ++k) engine.add(fan_blade(engine, 2 * pi * k / kBlades), kFan);
  for (int k = 0; k < 5; ++k) {
    const double angle = 2 * pi * k / 5;
    engine.add(cylinder({-3.5, 0.2 * std::cos(angle), 1.42 + 0.2 * std::sin(angle)},
                        {-3.4, 0.2 * std::cos(angle), 1.42 + 0.2 * std::sin(angle)}, 0.035, 6),
               kSteel);
  }
  engine.add(tube(engine, {{-2.5, 0.35, 1.6}, {-2.75, 0.75, 2.0}, {-2.85, 1.0, 2.5}, {-3.1, 1.05, 2.9}}, 0.17, 9, 26),
             kRubber);
}

void add_accessories(EngineAssembly& engine) {
  // Alternator: body with cooling slots, on a thin bracket.
  const DrivePulley& alternator = kPulleys[3];
  Profile body = {{0.1, 0}, {0.36, 0.04}, {0.42, 0.12}};
  for (int k = 0; k < 5; ++k) {
    const double z = 0.2 + 0.14 * k;
    body.insert(body.end(), {{0.42, z}, {0.38, z + 0.02}, {0.38, z + 0.06}, {0.42, z + 0.08}});
  }
  body.insert(body.end(), {{0.42, 0.95}, {0.3, 1.05}, {0, 1.06}});
  engine.add(lathe(body, engine.segments(40), {-2.75, alternator.y, alternator.z}, Point::UnitX()), kAluminium);
  engine.add(box({-2.62, -1.75, 0.05}, {-2.5, -0.9, 0.2}), kSteel);
  engine.add(box({-2.6, -1.75, 0.45}, {-2.54, -0.8, 0.52}), kSteel);
  // Power steering pump on the other side.
  const DrivePulley& steering = kPulleys[1];
  const Profile pump = {{0.1, 0}, {0.3, 0.05}, {0.3, 0.5}, {0.24, 0.6}, {0, 0.62}};
  engine.add(lathe(pump, engine.segments(32), {-2.75, steering.y, steering.z}, Point::UnitX()), kRubber);
  engine.add(lathe(Profile{{0.25, 0}, {0.25, 0.4}, {0.12, 0.46}, {0.12, 0.52}, {0, 0.53}}, engine.segments(28),
                   {-2.45, steering.y, steering.z + 0.2}, kUp),
             kRubber);
  engine.add(box({-2.6, 0.9, 0.0}, {-2.5, 1.75, 0.15}), kSteel);
  // Oil filter, starter with solenoid, fuel pump with its line, dipstick.
  const Profile filter = {{0.2, 0}, {0.32, 0.05}, {0.32, 0.7}, {0.25, 0.82}, {0, 0.83}};
  engine.add(lathe(filter, engine.segments(40), {-1.4, 1.1, -0.25}, {0, 0.8, -0.6}), kBlue);
  engine.add(lathe(Profile{{0.1, 0}, {0.34, 0.05}, {0.34, 1.1}, {0.2, 1.2}, {0.2, 1.4}}, engine.segments(40),
                   {1.1, 1.5, -0.75}, Point::UnitX()),
             kRubber);
  engine.add(cylinder({1.5, 1.55, -0.3}, {2.1, 1.55, -0.3}, 0.17, engine.segments(24)), kSteel);
  engine.add(lathe(Profile{{0.15, 0}, {0.28, 0.2}, {0.28, 0.3}, {0.2, 0.42}, {0, 0.45}}, engine.segments(28),
                   {-1.6, -1.2, -0.2}, {0, -0.9, -0.3}),
             kBrass);
  engine.add(tube(engine,
                  {{-1.6, -1.55, -0.3}, {-2.3, -1.9, 1.0}, {-2.45, -1.2, 2.3}, {-1.4, -0.5, 2.75}, {-0.7, -0.15, 2.55}},
                  0.05, 12, 9),
             kBrass);
  engine.add(tube(engine, {{0.6, -1.2, -0.4}, {0.65, -2.2, -0.3}, {0.7, -3.0, 0.6}, {0.7, -3.05, 2.2}}, 0.045, 12, 9),
             kSteel);
  engine.add(transformed(torus(0.12, 0.04, engine.segments(20), engine.segments(8)),
                         Eigen::Translation3d(0.7, -3.05, 2.3) * Eigen::AngleAxisd(pi / 2, Point::UnitX())),
             kFan);
  // Flywheel with its toothed rim, in front of the bell housing.
  constexpr int kTeeth = 90;
  std::vector<Ring> gear(4);
  gear[0] = {{2.56, 0, 0}};
  gear[3] = {{2.72, 0, 0}};
  for (int tooth = 0; tooth < kTeeth; ++tooth) {
    for (int corner = 0; corner < 4; ++corner) {
      const double angle = 2 * pi * (tooth + 0.25 * corner) / kTeeth;
      const double r = corner < 2 ? 1.2 : 1.28;
      gear[1].emplace_back(2.56, r * std::cos(angle), r * std::sin(angle));
      gear[2].emplace_back(2.72, r * std::cos(angle), r * std::sin(angle));
    }
  }
  engine.add(loft(gear), kSteel);
  const Profile bell = {{1.42, 2.74}, {1.42, 2.84}, {1.34, 2.86}, {1.2, 3.3},  {0.8, 3.75}, {0.62, 3.8},
                        {0.62, 4.1},  {0.4, 4.12},  {0.16, 4.12}, {0.16, 4.5}, {0, 4.52}};
  engine.add(lathe(bell, engine.segments(64), Point::Zero(), Point::UnitX()), kAluminium);
  for (int k = 0; k < 12; ++k) {
    const double angle = 2 * pi * k / 12;
    engine.add(cylinder({2.7, 1.34 * std::cos(angle), 1.34 * std::sin(angle)},
                        {2.92, 1.34 * std::cos(angle), 1.34 * std::sin(angle)}, 0.055, 6),
               kSteel);
  }
}

}  // namespace voxcarve
