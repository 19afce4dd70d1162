// The castings of the engine: block, oil pan, heads with fins, valve covers, and their bolts.
#include <cmath>
#include <numbers>

#include "common/mesh/models/engine_parts.h"
#include "common/mesh/models/primitives.h"

namespace voxcarve {

namespace {

using std::numbers::pi;
using Profile = std::vector<Eigen::Vector2d>;

const Color kIron(0.45F, 0.47F, 0.50F);
const Color kCavity(0.30F, 0.18F, 0.16F);
const Color kAluminium(0.72F, 0.73F, 0.75F);
const Color kCoverRed(0.72F, 0.12F, 0.10F);
const Color kPanBlack(0.13F, 0.13F, 0.15F);
const Color kSteel(0.82F, 0.80F, 0.74F);

/// A prism along x with a convex outline in (y, z).
TriangleSoup prism_along_x(const Profile& outline, double x_start, double x_end) {
  std::vector<Ring> rings(2);
  for (const Eigen::Vector2d& point : outline) {
    rings[0].emplace_back(x_start, point.x(), point.y());
    rings[1].emplace_back(x_end, point.x(), point.y());
  }
  return loft(rings);
}

Profile scaled(Profile outline, double factor) {
  for (Eigen::Vector2d& point : outline) point *= factor;
  return outline;
}

/// A hexagon-head bolt with its washer and the end of its shank, standing on `foot` along `direction`.
TriangleSoup bolt(const EngineAssembly& engine, const Point& foot, const Point& direction, double size) {
  const Point up = direction.normalized();
  const Profile washer = {{1.0 * size, -0.05 * size}, {1.0 * size, 0.15 * size}, {0.9 * size, 0.2 * size}};
  TriangleSoup soup = lathe(washer, engine.segments(16), foot, up);
  const Profile head = {{0.75 * size, 0.15 * size}, {0.75 * size, 0.7 * size}, {0.6 * size, 0.85 * size}};
  append(soup, lathe(head, 6, foot, up));
  append(soup, cylinder(foot - 1.5 * size * up, foot + 0.3 * size * up, 0.4 * size, engine.segments(11)));
  return soup;
}

}  // namespace

EngineAssembly::EngineAssembly(double detail) : segment_factor_(std::sqrt(detail)) {}

int EngineAssembly::segments(int base) const {
  return std::max(3, static_cast<int>(std::lround(base * segment_factor_)));
}

void EngineAssembly::add(TriangleSoup part, const Color& color) {
  append(soup, colored(std::move(part), color));
}

void EngineAssembly::add_casting(TriangleSoup part, const Color& color) {
  castings.push_back({soup.triangles.size(), part.triangles.size()});
  add(std::move(part), color);
}

double cylinder_x(int cylinder, int side) {
  return -1.65 + 1.1 * cylinder + (side < 0 ? 0.12 : 0);
}

Eigen::Affine3d bank_frame(int side) {
  Eigen::Affine3d frame(Eigen::AngleAxisd(-pi / 4, Point::UnitX()));
  if (side < 0) frame = Eigen::Scaling(1.0, -1.0, 1.0) * frame;
  return frame;
}

TriangleSoup layered(const std::vector<Layer>& layers, int corner_segments) {
  std::vector<Ring> rings;
  for (const Layer& layer : layers) {
    Ring ring;
    for (int corner = 0; corner < 4; ++corner) {
      const double sign_x = corner == 0 || corner == 3 ? 1 : -1;
      const double sign_y = corner < 2 ? 1 : -1;
      for (int k = 0; k <= corner_segments; ++k) {
        const double angle = pi / 2 * (corner + static_cast<double>(k) / corner_segments);
        ring.emplace_back(layer.x + sign_x * (layer.width / 2 - layer.rounding) + layer.rounding * std::cos(angle),
                          layer.y + sign_y * (layer.depth / 2 - layer.rounding) + layer.rounding * std::sin(angle),
                          layer.z);
      }
    }
    rings.push_back(std::move(ring));
  }
  return loft(rings);
}

void add_block(EngineAssembly& engine) {
  const Profile crankcase = {{1.15, -0.55}, {1.35, 0.1}, {0.9, 1.2}, {-0.9, 1.2}, {-1.35, 0.1}, {-1.15, -0.55}};
  engine.add_casting(prism_along_x(crankcase, -2.5, 2.5), kIron);
  engine.add(as_cavity(prism_along_x(scaled(crankcase, 0.85), -2.3, 2.3)), kCavity);
  const int corner = engine.segments(5);
  for (const int side : {1, -1}) {
    const double shift = side < 0 ? 0.06 : -0.06;
    const Eigen::Affine3d frame = bank_frame(side);
    engine.add_casting(
        transformed(layered({{0.4, 4.7, 1.5, 0.08, shift}, {2.3, 4.7, 1.44, 0.08, shift}}, corner), frame), kIron);
    for (int cylinder_index = 0; cylinder_index < 4; ++cylinder_index) {
      const double x = cylinder_x(cylinder_index, side);
      engine.add(transformed(as_cavity(cylinder({x, 0, 1.2}, {x, 0, 2.28}, 0.42, engine.segments(40))), frame),
                 kCavity);
      // Freeze plugs and ribs on the outer flank.
      const Profile plug = {{0.2, -0.05}, {0.2, 0.02}, {0.16, 0.03}, {0.14, -0.01}, {0, -0.01}};
      engine.add(transformed(lathe(plug, engine.segments(24), {x, 0.74, 1.25}, {0, 1, 0}), frame), kSteel);
      engine.add(transformed(box({x + 0.5, 0.6, 0.6}, {x + 0.56, 0.84, 2.2}), frame), kIron);
    }
  }
  engine.add_casting(box({-2.25, -0.95, 1.0}, {2.25, 0.95, 1.5}), kIron);  // floor of the valley

  // The oil pan: flange, tray and sump.
  const std::vector<Layer> pan = {
      {-1.75, 2.2, 1.5, 0.25, 0.75}, {-1.65, 2.5, 1.7, 0.3, 0.7}, {-1.1, 2.8, 1.9, 0.3, 0.6}, {-0.98, 4.5, 2.1, 0.2},
      {-0.7, 4.7, 2.3, 0.2},         {-0.64, 4.95, 2.6, 0.2},     {-0.52, 4.95, 2.6, 0.2}};
  engine.add_casting(layered(pan, engine.segments(6)), kPanBlack);
  for (int k = 0; k < 11; ++k) {
    for (const double y : {-1.22, 1.22}) {
      engine.add(bolt(engine, {-2.3 + 0.46 * k, y, -0.64}, {0, 0, -1}, 0.06), kSteel);
    }
  }
  engine.add(bolt(engine, {1.2, 0, -1.75}, {0, 0, -1}, 0.1), kSteel);  // drain plug
}

namespace {

/// A valve cover with a rim, two steps, ribs, a filler cap on the left one and a breather on the right.
void add_valve_cover(EngineAssembly& engine, int side, double shift) {
  const Eigen::Affine3d frame = bank_frame(side);
  const int corner = engine.segments(8);
  std::vector<Layer> layers = {{2.85, 4.5, 1.2, 0.2, shift},
                               {2.93, 4.5, 1.2, 0.2, shift},
                               {2.93, 4.35, 1.0, 0.18, shift},
                               {3.2, 4.3, 0.95, 0.18, shift}};
  for (int k = 1; k <= 4; ++k) {
    const double angle = pi / 2 * k / 5;
    layers.push_back({3.2 + 0.15 * std::sin(angle), 4.3 - 0.3 * (1 - std::cos(angle)),
                      0.95 - 0.3 * (1 - std::cos(angle)), 0.15, shift});
  }
  engine.add_casting(transformed(layered(layers, corner), frame), kCoverRed);
  const std::vector<Layer> hollow = {{2.87, 4.2, 0.86, 0.15, shift}, {3.25, 4.16, 0.8, 0.15, shift}};
  engine.add(transformed(as_cavity(layered(hollow, corner)), frame), kCavity);
  for (int k = 0; k < 4; ++k) {
    const double y = -0.24 + 0.16 * k;
    engine.add(transformed(layered({{3.3, 3.2, 0.06, 0.02, shift}, {3.4, 3.15, 0.05, 0.02, shift}}, corner),
                           frame * Eigen::Translation3d(0, y, 0)),
               kAluminium);
  }
  for (int k = 0; k < 6; ++k) {
    for (const double y : {-0.55, 0.55}) {
      const Point foot(shift - 2.0 + 0.8 * k, y, 2.93);
      engine.add(transformed(bolt(engine, foot, {0, 0, 1}, 0.045), frame), kSteel);
    }
  }
  const Profile cap = {{0.16, 3.28}, {0.16, 3.42}, {0.2, 3.44}, {0.22, 3.5}, {0.2, 3.56}, {0, 3.58}};
  engine.add(transformed(lathe(cap, engine.segments(32), {shift + (side > 0 ? -1.85 : 1.85), 0, 0}, {0, 0, 1}), frame),
             kPanBlack);
}

}  // namespace

void add_heads(EngineAssembly& engine) {
  constexpr int kFins = 6;
  const int corner = engine.segments(5);
  for (const int side : {1, -1}) {
    const double shift = side < 0 ? 0.06 : -0.06;
    const Eigen::Affine3d frame = bank_frame(side);
    const std::vector<Layer> head = {{2.3, 4.65, 1.36, 0.1, shift}, {2.85, 4.65, 1.3, 0.1, shift}};
    engine.add_casting(transformed(layered(head, corner), frame), kAluminium);
    engine.add(transformed(layered({{2.28, 4.75, 1.42, 0.05, shift}, {2.32, 4.75, 1.42, 0.05, shift}}, corner), frame),
               kPanBlack);  // gasket
    // Fins stand out of the head's outer flank and its two ends, one above the other.
    for (int k = 0; k < kFins; ++k) {
      const double z = 2.36 + 0.083 * k;
      engine.add(
          transformed(layered({{z, 4.85, 0.5, 0.1, shift, 0.58}, {z + 0.045, 4.85, 0.5, 0.1, shift, 0.58}}, corner),
                      frame),
          kAluminium);
    }
    for (int k = 0; k < 5; ++k) {
      for (const double y : {-0.62, 0.62}) {
        engine.add(transformed(bolt(engine, {shift - 2.2 + 1.1 * k, y, 2.85}, {0, 0, 1}, 0.06), frame), kSteel);
      }
    }
    add_valve_cover(engine, side, shift);
  }
}

}  // namespace voxcarve
