// yucca: a stand-in for [HE10, Table 1 and Fig. 11]: sword leaves, open sheets of one layer, each a component of its
// own.
#include <cmath>
#include <numbers>
#include <vector>

#include "common/mesh/models/builders.h"
#include "common/mesh/models/growth.h"
#include "common/mesh/models/leaves.h"

namespace voxcarve {

namespace {

using std::numbers::pi;

/// A leaf from `base`, which starts in direction `elevation` above the horizontal at `azimuth` and bends down by `bend`
/// on its way: a gutter that is widest at a third of its length and pointed at both ends.
TriangleSoup sword_leaf(const Point& base, double azimuth, double elevation, double bend, double length, double width,
                        int rows, int columns) {
  const Point outward(std::cos(azimuth), std::sin(azimuth), 0);
  const Point across(std::sin(azimuth), -std::cos(azimuth), 0);  // so that the upper side is the front
  std::vector<std::vector<Point>> points = {{base}};
  Point spine = base;
  for (int i = 1; i <= rows + 1; ++i) {
    const double share = static_cast<double>(i) / (rows + 1);
    const double angle = elevation - bend * share * share;
    const Point along = std::cos(angle) * outward + std::sin(angle) * Point::UnitZ();
    const Point upward = -std::sin(angle) * outward + std::cos(angle) * Point::UnitZ();
    spine += length / (rows + 1) * along;
    if (i > rows) {
      points.push_back({spine});
      break;
    }
    const double half_width = 0.5 * width * std::pow(share / 0.33, 0.7) * std::pow((1 - share) / 0.67, 1.4);
    std::vector<Point> row;
    for (int k = 0; k < columns; ++k) {
      const double side = 2.0 * k / (columns - 1) - 1;
      row.emplace_back(spine + half_width * (side * across + 0.5 * side * side * upward));
    }
    points.push_back(std::move(row));
  }
  return strip(points);
}

/// Leaves about a short upright stem, in a golden spiral from the upright youngest to the drooping oldest.
TriangleSoup build_yucca(const Parameters& parameters) {
  const auto leaves = static_cast<int>(parameters.integer("leaves"));
  const auto rows = static_cast<int>(parameters.integer("rows"));
  const auto columns = static_cast<int>(parameters.integer("columns"));
  SeededSequence random(static_cast<std::uint64_t>(parameters.integer("seed")));
  FreeSpace space(0.1);
  TriangleSoup yucca;
  for (int i = 0; i < leaves; ++i) {
    const double age = (i + 0.5) / leaves;
    append(yucca, space.place(
                      [&](double crowding) {
                        const double azimuth = i * kGoldenAngle + random.uniform(-0.15, 0.15) * (1 + 3 * crowding);
                        const double elevation = radians(86 - 60 * age + random.uniform(-5, 5));
                        const double bend = radians(25 + 65 * age + random.uniform(-10, 10));
                        const double length = parameters.real("length") * random.uniform(0.8, 1) * (0.8 + 0.2 * age);
                        const double from_axis = 0.03 + 0.03 * age;
                        const Point base(from_axis * std::cos(azimuth), from_axis * std::sin(azimuth), 0.3 * (1 - age));
                        return sword_leaf(base, azimuth, elevation, bend, length, parameters.real("width"), rows,
                                          columns);
                      },
                      kLeafAttempts));
  }
  return yucca;
}

}  // namespace

ProceduralModel yucca_model() {
  ModelInfo info{"yucca",
                 "a group of long, narrow, pointed leaves: open sheets of one layer, a component each",
                 "HE Fig. 11, Table 1 (801 vertices, about 1,200 faces, 87 hull vertices)",
                 {}};
  info.parameters.specs = {
      seed_parameter(),
      ParameterSpec::integer("leaves", "leaves", 1, 100'000, 30, "number of leaves"),
      ParameterSpec::integer("rows", "rows", 1, 1000, 5, "rows of vertices between the two points of a leaf"),
      ParameterSpec::integer("columns", "vertices", 2, 1000, 5, "vertices of a row"),
      ParameterSpec::real("length", "model", 0.1, 10, 1, "of the longest leaves"),
      ParameterSpec::real("width", "model", 1e-3, 1, 0.09, "of a leaf at its widest")};
  info.parameters.check = [](const Parameters& parameters) {
    require_triangles_within_limit("yucca", 2.0 * static_cast<double>(parameters.integer("leaves")) *
                                                static_cast<double>(parameters.integer("rows")) *
                                                static_cast<double>(parameters.integer("columns") - 1));
  };
  return {std::move(info), build_yucca};
}

}  // namespace voxcarve
