// two-spheres [HE10, Fig. 4], geospheres [HE10, Fig. 10] and sphereflake [He95, Fig. 3 and Table 1]. The sphereflake's
// construction follows the description of Haines, "A Proposal for Standard Graphics Environments", IEEE CG&A 7(11),
// 1987.
#include <array>
#include <cmath>
#include <numbers>

#include "common/mesh/models/builders.h"
#include "common/mesh/models/primitives.h"

namespace voxcarve {

namespace {

constexpr int kChildren = 9;

double icosphere_triangles(const Parameters& parameters) {
  return 20 * std::pow(4.0, static_cast<double>(parameters.integer("subdivision")));
}

ParameterSpec subdivision_parameter(std::int64_t default_value) {
  return ParameterSpec::integer("subdivision", "levels", 0, 8, default_value,
                                "how often the 20 triangles of an icosahedron are split in four");
}

TriangleSoup build_two_spheres(const Parameters& parameters) {
  const double radius = parameters.real("radius");
  const auto subdivision = static_cast<int>(parameters.integer("subdivision"));
  const Point offset(parameters.real("distance") / 2, 0, 0);
  TriangleSoup soup = icosphere(-offset, radius, subdivision);
  append(soup, icosphere(offset, radius, subdivision));
  return soup;
}

/// Spheres at the corners of a box about the origin. With two subdivisions each has 10 * 4^2 + 2 = 162 vertices.
TriangleSoup build_geospheres(const Parameters& parameters) {
  const double radius = parameters.real("radius");
  const auto subdivision = static_cast<int>(parameters.integer("subdivision"));
  const Point half = 0.5 * Point(parameters.real("width"), parameters.real("depth"), parameters.real("height"));
  TriangleSoup soup;
  for (const double z : {-1.0, 1.0}) {
    for (const double y : {-1.0, 1.0}) {
      for (const double x : {-1.0, 1.0})
        append(soup, icosphere(half.cwiseProduct(Point(x, y, z)), radius, subdivision));
    }
  }
  return soup;
}

/// A sphere of the flake: `axis` points away from its parent.
struct FlakeSphere {
  Point center;
  Point axis;
  double radius;
  int depth;
};

/// Six directions around the equator and three above, 60 degrees from their neighbours: the nine of a face-centred
/// cubic packing's twelve contacts that do not point back to the parent.
std::array<Point, kChildren> child_directions(const Point& axis) {
  Eigen::Index least = 0;
  axis.cwiseAbs().minCoeff(&least);
  const Point helper = Point::Unit(least);
  const Point u = (helper - helper.dot(axis) * axis).normalized();
  const Point v = axis.cross(u);
  std::array<Point, kChildren> directions;
  for (int i = 0; i < 6; ++i) {
    const double angle = std::numbers::pi * i / 3;
    directions[static_cast<std::size_t>(i)] = std::cos(angle) * u + std::sin(angle) * v;
  }
  for (int i = 0; i < 3; ++i) {
    const double angle = std::numbers::pi * (1 + 4 * i) / 6;  // between two of the equator's
    const Point flat = std::cos(angle) * u + std::sin(angle) * v;
    directions[static_cast<std::size_t>(6 + i)] = std::sqrt(1.0 / 3) * flat + std::sqrt(2.0 / 3) * axis;
  }
  return directions;
}

/// Breadth first: the spheres of one depth stand together. Children have a third of the radius and touch their parent.
TriangleSoup build_sphereflake(const Parameters& parameters) {
  const auto depth = static_cast<int>(parameters.integer("depth"));
  const TriangleSoup unit = icosphere(Point::Zero(), 1, static_cast<int>(parameters.integer("subdivision")));
  std::vector<FlakeSphere> spheres = {{Point::Zero(), Point::UnitZ(), parameters.real("radius"), 0}};
  for (std::size_t next = 0; next < spheres.size(); ++next) {
    const FlakeSphere sphere = spheres[next];  // a copy: the vector grows below
    if (sphere.depth == depth) break;
    const double radius = sphere.radius / 3;
    for (const Point& direction : child_directions(sphere.axis)) {
      spheres.push_back({sphere.center + (sphere.radius + radius) * direction, direction, radius, sphere.depth + 1});
    }
  }
  TriangleSoup soup;
  soup.positions.reserve(spheres.size() * unit.positions.size());
  soup.triangles.reserve(spheres.size() * unit.triangles.size());
  for (const FlakeSphere& sphere : spheres) {
    const auto offset = static_cast<std::uint32_t>(soup.positions.size());
    for (const Point& position : unit.positions) soup.positions.emplace_back(sphere.center + sphere.radius * position);
    for (const auto& [a, b, c] : unit.triangles) soup.triangles.push_back({a + offset, b + offset, c + offset});
  }
  return soup;
}

}  // namespace

ProceduralModel two_spheres_model() {
  ModelInfo info{"two-spheres", "two equal spheres apart: closed, two components", "HE Fig. 4", {}};
  info.parameters.specs = {ParameterSpec::real("distance", "model", 1e-3, 1e6, 3,
                                               "between the centres; below two radii the spheres overlap"),
                           ParameterSpec::real("radius", "model", 1e-3, 1e6, 1, "radius of both spheres"),
                           subdivision_parameter(4)};
  info.parameters.check = [](const Parameters& parameters) {
    require_triangles_within_limit("two-spheres", 2 * icosphere_triangles(parameters));
  };
  return {std::move(info), build_two_spheres};
}

ProceduralModel geospheres_model() {
  ModelInfo info{"geospheres",
                 "eight equal geodesic spheres at the corners of a box: closed; their convex hull is a chamfered box",
                 "HE Fig. 10",
                 {}};
  const std::string apart = "between the centres; below two radii the spheres overlap";
  info.parameters.specs = {ParameterSpec::real("width", "model", 1e-3, 1e6, 4, "along x, " + apart),
                           ParameterSpec::real("depth", "model", 1e-3, 1e6, 4, "along y, " + apart),
                           ParameterSpec::real("height", "model", 1e-3, 1e6, 4, "along z, " + apart),
                           ParameterSpec::real("radius", "model", 1e-3, 1e6, 1, "radius of the spheres"),
                           subdivision_parameter(2)};
  info.parameters.check = [](const Parameters& parameters) {
    require_triangles_within_limit("geospheres", 8 * icosphere_triangles(parameters));
  };
  return {std::move(info), build_geospheres};
}

ProceduralModel sphereflake_model() {
  ModelInfo info{"sphereflake",
                 "a sphere that carries nine of a third its size, and so on: 820 spheres at depth 3",
                 "He Fig. 3, Table 1",
                 {}};
  info.parameters.specs = {
      ParameterSpec::integer("depth", "levels", 0, 6, 3, "generations of children; (9^(depth+1) - 1) / 8 spheres"),
      ParameterSpec::real("radius", "model", 1e-3, 1e6, 1, "radius of the largest sphere"), subdivision_parameter(2)};
  info.parameters.check = [](const Parameters& parameters) {
    const double spheres = (std::pow(9.0, static_cast<double>(parameters.integer("depth") + 1)) - 1) / 8;
    require_triangles_within_limit("sphereflake", spheres * icosphere_triangles(parameters));
  };
  return {std::move(info), build_sphereflake};
}

}  // namespace voxcarve
