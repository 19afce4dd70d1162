// two-spheres [HE10, Fig. 4], geospheres [HE10, Fig. 10] and sphereflake [He95, Fig. 3 and Table 1].
#include <cmath>

#include "common/mesh/models/builders.h"
#include "common/mesh/models/implicit_shapes.h"
#include "common/mesh/models/primitives.h"
#include "common/mesh/models/sphereflake.h"

namespace voxcarve {

namespace {

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

Sphereflake flake(const Parameters& parameters) {
  return {static_cast<int>(parameters.integer("depth")), parameters.real("radius")};
}

TriangleSoup build_sphereflake(const Parameters& parameters) {
  const TriangleSoup unit = icosphere(Point::Zero(), 1, static_cast<int>(parameters.integer("subdivision")));
  const Sphereflake spheres = flake(parameters);
  TriangleSoup soup;
  soup.positions.reserve(spheres.balls().size() * unit.positions.size());
  soup.triangles.reserve(spheres.balls().size() * unit.triangles.size());
  for (const Sphereflake::Ball& sphere : spheres.balls()) {
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
      form_parameter(), ParameterSpec::real("radius", "model", 1e-3, 1e6, 1, "radius of the largest sphere"),
      subdivision_parameter(2)};
  info.parameters.check = [](const Parameters& parameters) {
    if (parameters.choice("form") != "mesh") return;
    const double spheres = (std::pow(9.0, static_cast<double>(parameters.integer("depth") + 1)) - 1) / 8;
    require_triangles_within_limit("sphereflake", spheres * icosphere_triangles(parameters));
  };
  return {std::move(info), build_sphereflake,
          [](const Parameters& parameters) { return implicit_solid(flake(parameters)); }};
}

}  // namespace voxcarve
