// mechanical-part, in place of the part of [He95, Fig. 4 and Table 2], which is not public: a clevis bracket in a box
// of 200 x 200 x 120, as the finest grid there, with holes of many sizes, of which the smallest vanish first.
//
// Its size of surface was chosen after Table 2. Marching cubes gives a vertex wherever an edge of the grid crosses the
// surface, and a closed surface has 2 (vertices - Euler characteristic) triangles; edges along x cross a surface about
// as often as the area of its shadow along x says, counted with multiplicity. So in voxels the triangles are about
// twice the integral of |nx| + |ny| + |nz| over the surface, and 271,504 triangles ask for an integral of 135,752 (of a
// part of axis-aligned faces, that is the area).
#include <algorithm>
#include <cmath>

#include "common/mesh/models/builders.h"
#include "common/mesh/models/machined_part.h"

namespace voxcarve {

namespace {

constexpr double kHalf = 100;       // of the base, along x and y
constexpr double kHeight = 120;     // of everything
constexpr double kThickness = 12;   // of the base
constexpr double kNotch = 68;       // the base's open slots begin at that |x|
constexpr double kNotchHalf = 56;   // and reach that |y|
constexpr double kCheekInner = 34;  // the cheeks' faces, in |y|
constexpr double kCheekOuter = 50;
constexpr double kCheekHalf = 32;  // of the cheeks, along x
constexpr double kPinHeight = 74;  // of the pin's axis
constexpr double kBarHalf = 10;    // of the bar between the cheeks, along x
constexpr double kBarBottom = 104;

Box box_of(double x0, double x1, double y0, double y1, double z0, double z1) {
  return {Point(x0, y0, z0), Point(x1, y1, z1)};
}

std::vector<Box> boxes() {
  return {box_of(-kHalf, kHalf, kNotchHalf, kHalf, 0, kThickness),
          box_of(-kHalf, kHalf, -kHalf, -kNotchHalf, 0, kThickness),
          box_of(-kNotch, kNotch, -kNotchHalf, kNotchHalf, 0, kThickness),
          box_of(-kCheekHalf, kCheekHalf, kCheekInner, kCheekOuter, 0, kHeight),
          box_of(-kCheekHalf, kCheekHalf, -kCheekOuter, -kCheekInner, 0, kHeight),
          box_of(-kBarHalf, kBarHalf, -kCheekOuter, kCheekOuter, kBarBottom, kHeight)};
}

/// Place k of n along a row of the given length about 0.
double place(int k, int n, double length) {
  return length * ((k + 0.5) / n - 0.5);
}

/// Through the base.
Passage base_hole(double x, double y, double radius, double frame) {
  Passage hole;
  hole.axis = 2;
  hole.center = {x, y};
  hole.frame = Eigen::Vector2d::Constant(frame);
  hole.low = 0;
  hole.high = kThickness;
  hole.radius = radius;
  return hole;
}

/// Through the cheek at the given side of y; u is z and v is x there.
Passage cheek_hole(int side, double x, double z, double radius, double frame) {
  Passage hole;
  hole.axis = 1;
  hole.center = {z, x};
  hole.frame = Eigen::Vector2d::Constant(frame);
  hole.low = side > 0 ? kCheekInner : -kCheekOuter;
  hole.high = side > 0 ? kCheekOuter : -kCheekInner;
  hole.outer_side = side;
  hole.radius = radius;
  return hole;
}

Passage center_bore() {
  Passage bore = base_hole(0, 0, 11, 30);
  bore.boss_radius = 26;
  bore.boss_height = 16;
  bore.counterbore_radius = 18;
  bore.counterbore_depth = 12;
  return bore;
}

Passage pin_bore(int side) {
  Passage bore = cheek_hole(side, 0, kPinHeight, 16, 27);
  bore.boss_radius = 24;
  bore.boss_height = 8;
  return bore;
}

Passage slot(int side) {
  Passage hole = base_hole(50 * side, 0, 7, 9);
  hole.half_length = 28;
  hole.frame[1] = 37;
  return hole;
}

/// Rows of `count` on either side. Where they would not have room, all is narrower.
void add_bolt_holes(int count, std::vector<Passage>& passages) {
  const double pitch = 192.0 / count;
  const double size = std::min(1.0, pitch / 24);
  for (const int side : {-1, 1}) {
    for (int k = 0; k < count; ++k) {
      Passage hole = base_hole(place(k, count, 192), 82.0 * side, 6 * size, 11 * size);
      hole.counterbore_radius = 10 * size;
      hole.counterbore_depth = 5;
      passages.push_back(hole);
    }
  }
}

void add_dowel_holes(int count, std::vector<Passage>& passages) {
  const double size = std::min(1.0, 192.0 / count / 9);
  for (const int side : {-1, 1}) {
    for (int k = 0; k < count; ++k) {
      passages.push_back(base_hole(place(k, count, 192), 63.5 * side, 2.5 * size, 4 * size));
    }
  }
}

void add_vents(int count, std::vector<Passage>& passages) {
  const double size = std::min(1.0, 60.0 / count / 12);
  for (const int side : {-1, 1}) {
    for (int k = 0; k < count; ++k) passages.push_back(cheek_hole(side, place(k, count, 60), 30, 4 * size, 5.5 * size));
  }
}

MachinedPart layout(const Parameters& parameters) {
  MachinedPart part{boxes(), {center_bore(), pin_bore(-1), pin_bore(1), slot(-1), slot(1)}};
  add_bolt_holes(static_cast<int>(parameters.integer("bolt_holes")), part.passages);
  add_dowel_holes(static_cast<int>(parameters.integer("dowel_holes")), part.passages);
  add_vents(static_cast<int>(parameters.integer("vents")), part.passages);
  return scaled(std::move(part), parameters.real("width") / (2 * kHalf));
}

}  // namespace

ProceduralModel mechanical_part_model() {
  ModelInfo info{"mechanical-part",
                 "a clevis bracket with bores, slots and small holes: genus 6 + 2 (bolt_holes + dowel_holes + vents)",
                 "He Fig. 4, Table 2",
                 {}};
  info.parameters.specs = {
      ParameterSpec::integer("arc_segments", "segments", 1, 500, 12, "of a quarter of a circle; of form=mesh only"),
      ParameterSpec::integer("bolt_holes", "holes", 0, 40, 4,
                             "in each of two rows in the base; 12 wide, counterbored to 20, at a width of 200"),
      ParameterSpec::integer("dowel_holes", "holes", 0, 40, 6, "in each of two rows in the base; 5 wide"),
      form_parameter(),
      ParameterSpec::integer("vents", "holes", 0, 40, 4, "in each of two cheeks; 8 wide"),
      ParameterSpec::real("width", "model", 1e-3, 1e6, 200, "of the base; the height is 0.6 of it")};
  return {std::move(info),
          [](const Parameters& parameters) {
            return surface_of(layout(parameters), static_cast<int>(parameters.integer("arc_segments")));
          },
          [](const Parameters& parameters) { return solid_of(layout(parameters)); }};
}

}  // namespace voxcarve
