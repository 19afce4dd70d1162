// engine: a V8 of many parts, stand-in for the car motor of [NT03, Fig. 8] (140,113 faces; "many degeneracies such as
// T-joints, zero-area faces, and nonmanifold vertices", "parts connected by thin structures and a lot of interior
// detail"). The number of faces is the paper's at the default parameters.
//
// Every part is a closed surface that runs into its neighbours. Cavities in the block and under the valve covers hold
// the moving parts. On purpose:
// - T-joints on the castings: one-sided splits of zero width, so that a ray hardly ever slips through;
// - zero-area faces on the castings, over splits of the same kind;
// - non-manifold vertices: the jets and the valves' keepers are cones that share their tips;
// - thin connections: leads, lines, dipstick, brackets.
// The outer shell is tight but for the T-joints, so ray stabbing gives the filled engine [NT03, 3.2]; parity count
// makes the overlaps hollow.
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "common/mesh/models/builders.h"
#include "common/mesh/models/degeneracies.h"
#include "common/mesh/models/engine_parts.h"
#include "common/mesh/models/primitives.h"
#include "common/run/errors.h"

namespace voxcarve {

namespace {

constexpr int kKnobSides = 135;  // of the knob on the air cleaner: 2 triangles a side make up the paper's number

/// Sites for defects on the castings: triangles with the corner from which their longest side starts. No two of these
/// sides share a vertex, so that every defect stands alone.
class DefectSites {
 public:
  explicit DefectSites(const EngineAssembly& engine) : soup_(engine.soup), is_taken_(engine.soup.positions.size()) {
    for (const auto& [first, triangles] : engine.castings) {
      for (std::size_t i = 0; i < triangles; ++i) candidates_.push_back(first + i);
    }
  }

  /// `count` sites, evenly spread. Throws ParameterError, with the parameter's `name`, when there are not so many left.
  std::vector<std::array<std::size_t, 2>> take(int count, const std::string& name) {
    std::vector<std::array<std::size_t, 2>> sites;
    for (int k = 0; k < count; ++k) {
      const std::size_t start = candidates_.size() * static_cast<std::size_t>(k) / static_cast<std::size_t>(count);
      for (std::size_t i = 0; i < candidates_.size(); ++i) {
        const std::size_t triangle = candidates_[(start + i) % candidates_.size()];
        const std::size_t corner = longest_side(triangle);
        const std::uint32_t a = soup_.triangles[triangle][corner];
        const std::uint32_t b = soup_.triangles[triangle][(corner + 1) % 3];
        if (is_taken_[a] || is_taken_[b]) continue;
        is_taken_[a] = is_taken_[b] = true;
        sites.push_back({triangle, corner});
        break;
      }
    }
    if (sites.size() < static_cast<std::size_t>(count)) {
      throw ParameterError("only " + std::to_string(sites.size()) + " of " + std::to_string(count) + " " + name +
                           " fit on the castings; lower " + name + " or raise detail");
    }
    return sites;
  }

 private:
  std::size_t longest_side(std::size_t triangle) const {
    const Triangle& t = soup_.triangles[triangle];
    std::array<double, 3> lengths{};
    for (std::size_t i = 0; i < 3; ++i) lengths[i] = (soup_.positions[t[(i + 1) % 3]] - soup_.positions[t[i]]).norm();
    return static_cast<std::size_t>(std::ranges::max_element(lengths) - lengths.begin());
  }

  const TriangleSoup& soup_;
  std::vector<bool> is_taken_;
  std::vector<std::size_t> candidates_;
};

TriangleSoup build_engine(const Parameters& parameters) {
  EngineAssembly engine(parameters.real("detail"));
  add_block(engine);
  add_heads(engine);
  add_intake(engine);
  add_exhaust(engine);
  add_ignition(engine);
  add_front_drive(engine);
  add_accessories(engine);
  add_interior(engine);
  const std::array<Eigen::Vector2d, 3> knob = {Eigen::Vector2d(0, 3.4), {0.12, 3.5}, {0, 3.6}};
  engine.add(lathe(knob, kKnobSides, {-0.1, 0, 0}, Point::UnitZ()), Color(0.8F, 0.8F, 0.82F));

  // On a lattice of 2^-20 the middle of a side is exact, and a zero-area face has no area to the last bit.
  for (Point& position : engine.soup.positions) {
    for (double& coordinate : position) coordinate = std::ldexp(std::nearbyint(std::ldexp(coordinate, 20)), -20);
  }
  DefectSites sites(engine);
  TriangleSoup soup = engine.soup;
  for (const auto& [triangle, corner] : sites.take(static_cast<int>(parameters.integer("t_joints")), "t_joints")) {
    add_t_joint(soup, triangle, corner);
  }
  for (const auto& [triangle, corner] :
       sites.take(static_cast<int>(parameters.integer("zero_area_faces")), "zero_area_faces")) {
    add_zero_area_face(soup, triangle, corner);
  }
  return soup;
}

}  // namespace

ProceduralModel engine_model() {
  ModelInfo info{"engine",
                 "a V8 of hundreds of overlapping coloured parts with T-joints, zero-area faces, non-manifold vertices",
                 "NT Fig. 8",
                 {}};
  info.parameters.specs = {
      ParameterSpec::real("detail", "times", 0.1, 50, 1, "factor on the number of triangles of round parts, about"),
      ParameterSpec::integer("t_joints", "places", 0, 200, 121, "T-joints on the castings"),
      ParameterSpec::integer("zero_area_faces", "triangles", 0, 100, 60, "faces of no area on the castings")};
  return {std::move(info), build_engine};
}

}  // namespace voxcarve
