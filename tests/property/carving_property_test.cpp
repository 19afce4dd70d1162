// What carving promises of every stream, and solids of known topology carved to the end.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "common/mesh/models/primitives.h"
#include "common/mesh/models/procedural.h"
#include "common/mesh/topology.h"
#include "methods/hagbi_elsana/invariants.h"
#include "tests/support/carving.h"
#include "tests/support/shapes.h"

namespace voxcarve {
namespace {

using test::joined;

TriangleSoup sphere(double radius) {
  return uv_sphere(Point(0, 0, 0), radius, 10, 7);
}

/// Of a solid with a manifold surface, from the surface: components that face outward bound components of the solid,
/// those that face inward its voids, and every handle of either is one independent loop of the solid (Alexander).
struct SolidTopology {
  std::int64_t surface_components = 0;
  std::int64_t b0 = 0;
  std::int64_t b1 = 0;
  std::int64_t b2 = 0;
  bool operator==(const SolidTopology&) const = default;
};

std::ostream& operator<<(std::ostream& out, const SolidTopology& t) {
  return out << t.surface_components << " surfaces, Betti numbers " << t.b0 << " " << t.b1 << " " << t.b2;
}

SolidTopology solid_topology(const TriangleSoup& surface) {
  const SurfaceTopology topology = analyze_topology(surface);
  EXPECT_TRUE(topology.genus.has_value()) << topology.genus_reason;
  SolidTopology solid{topology.components, 0, topology.genus.value_or(-1), 0};
  std::vector<TriangleSoup> parts(static_cast<std::size_t>(topology.components));
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    parts[topology.component_of_triangle[t]].triangles.push_back(surface.triangles[t]);
  }
  for (TriangleSoup& part : parts) {
    part.positions = surface.positions;
    ++(signed_volume(part) > 0 ? solid.b0 : solid.b2);
  }
  return solid;
}

SolidTopology carved_topology(const TriangleSoup& model, const CarvingOptions& options = {}, bool box = false) {
  const CarvingStream stream = test::carved(model, options, box);
  return solid_topology(stream.extract(stream.last_step()));
}

TEST(CarvedSolids, EndInTheirOwnTopology) {
  const TriangleSoup cube = box(Point(0, 0, 0), Point(1, 1, 1));
  const struct {
    const char* name;
    TriangleSoup model;
    SolidTopology expected;
  } cases[] = {
      {"ball", sphere(1), {1, 1, 0, 0}},
      {"torus", torus(2, 0.6, 16, 8), {1, 1, 1, 0}},
      {"plate with four holes", make_procedural("genus-n?genus=4&subdivision=1"), {1, 1, 4, 0}},
      {"plate with nine holes", make_procedural("genus-n?genus=9&subdivision=2"), {1, 1, 9, 0}},
      {"box with 3 x 3 holes", make_procedural("perforated-box?holes=3"), {1, 1, 9, 0}},
      {"eight balls", make_procedural("geospheres?subdivision=1"), {8, 8, 0, 0}},
      {"shell", joined({sphere(3), as_cavity(sphere(2))}), {2, 1, 0, 1}},
      // A shell in a shell: two solids; the space between them and the inner one's are voids.
      {"void in a void", joined({sphere(3), as_cavity(sphere(2)), sphere(1), as_cavity(sphere(0.5))}), {4, 2, 0, 2}},
      // A torus made thick: its two loops, and the void that it holds.
      {"hollow ring", joined({torus(3, 1, 20, 10), as_cavity(torus(3, 0.5, 20, 10))}), {2, 1, 2, 1}},
      {"linked rings",
       joined(
           {torus(2, 0.5, 20, 10),
            transformed(torus(2, 0.5, 20, 10), Eigen::Translation3d(2, 0, 0) *
                                                   Eigen::AngleAxisd(1.5707963267948966, Eigen::Vector3d::UnitX()))}),
       {2, 2, 2, 0}},
      {"cubes that share a face", joined({cube, box(Point(1, 0, 0), Point(2, 1, 1))}), {1, 1, 0, 0}},
      {"cubes that touch in an edge", joined({cube, box(Point(1, 1, 0), Point(2, 2, 1))}), {2, 2, 0, 0}},
      {"cubes that touch in a vertex", joined({cube, box(Point(1, 1, 1), Point(2, 2, 2))}), {2, 2, 0, 0}},
      {"cube in part of a face", joined({cube, box(Point(1, .25, .25), Point(2, .75, .75))}), {1, 1, 0, 0}},
      {"ball in a ball", joined({sphere(3), sphere(1)}), {1, 1, 0, 0}},  // the union: what is inside stays there
      {"inside out", test::inside_out(torus(2, 0.6, 16, 8)), {1, 1, 1, 0}},
      // Two balls through each other, carved as their union.
      {"crossing balls",
       joined({sphere(1), transformed(sphere(1), Eigen::Affine3d(Eigen::Translation3d(.9, .2, .1)))}),
       {1, 1, 0, 0}}};
  for (const auto& [name, model, expected] : cases) {
    EXPECT_EQ(carved_topology(model), expected) << name;
    EXPECT_EQ(carved_topology(model, {}, true), expected) << name << ", from the box";
    CarvingOptions other;
    other.exposed = false;
    other.priority = CarvingPriority::kVolume;
    EXPECT_EQ(carved_topology(model, other), expected) << name << ", without the exposed rule";
  }
}

TEST(CarvedSolids, KeepVoidsThatAreLeftShut) {
  const TriangleSoup model = joined({sphere(3), as_cavity(sphere(2)), sphere(1), as_cavity(sphere(0.5))});
  CarvingOptions options;
  options.smallest_void = 1;  // above 4/3 pi 0.5^3 = 0.52, below what lies between radii 1 and 2: about 29
  EXPECT_EQ(carved_topology(model, options), (SolidTopology{3, 2, 0, 1}));
  options.smallest_void = 100;
  EXPECT_EQ(carved_topology(model, options), (SolidTopology{1, 1, 0, 0}));
}

TEST(CarvedSolids, EndInTheModelItself) {
  for (const TriangleSoup& model : {torus(2, 0.6, 16, 8), make_procedural("genus-n?genus=4&subdivision=1"),
                                    joined({sphere(3), as_cavity(sphere(2))})}) {
    const CarvingStream stream = test::carved(model);
    const TriangleSoup last = stream.extract(stream.last_step());
    const auto corners = [](const TriangleSoup& soup) {
      std::vector<std::array<std::array<double, 3>, 3>> triangles;
      for (const Triangle& t : soup.triangles) {
        auto& triangle = triangles.emplace_back();
        for (std::size_t c = 0; c < 3; ++c) {
          const Point& p = soup.positions[t[c]];
          triangle[c] = {p[0], p[1], p[2]};
        }
        std::ranges::rotate(triangle, std::ranges::min_element(triangle));
      }
      std::ranges::sort(triangles);
      return triangles;
    };
    EXPECT_EQ(corners(last), corners(model));
  }
}

std::map<std::string, TriangleSoup> models() {
  TriangleSoup open = torus(2, 0.7, 14, 7);
  open.triangles.erase(open.triangles.begin(), open.triangles.begin() + 5);
  return {{"torus", torus(2, 0.6, 16, 8)},
          {"eight balls", make_procedural("geospheres?subdivision=1")},
          {"plate", make_procedural("genus-n?genus=3&subdivision=1")},
          {"void in a void", joined({sphere(3), as_cavity(sphere(2)), sphere(1), as_cavity(sphere(0.5))})},
          {"open torus", open},
          {"hourglass", hourglass(Point(0, 0, -1), Point(0, 0, 1), 0.8, 9)},
          {"crossing balls", joined({sphere(1), icosphere(Point(0.9, 0.2, 0.1), 1, 1)})},
          {"touching cubes", joined({box(Point(0, 0, 0), Point(1, 1, 1)), box(Point(1, 1, 0), Point(2, 2, 1)),
                                     box(Point(2, 1, .5), Point(3, 2, 1.5))})},
          {"convex", box(Point(0, 0, 0), Point(1, 2, 3))}};
}

TEST(CarvingInvariants, HoldOfEveryCombinationOfOptions) {
  for (const auto& [name, model] : models()) {
    for (const bool from_box : {false, true}) {
      RunContext context;
      const Classification made = test::classified(model, context, from_box);
      for (const auto priority :
           {CarvingPriority::kLongestEdge, CarvingPriority::kVolume, CarvingPriority::kCircumradiusRatio}) {
        for (const auto& [power, measure] : {std::pair(0.0, DepthMeasure::kLevel), std::pair(2.0, DepthMeasure::kLevel),
                                             std::pair(3.0, DepthMeasure::kDistance)}) {
          for (const double breadth : {0.0, 0.5}) {
            for (const bool exposed : {true, false}) {
              for (const double smallest_void : {0.0, 1e9}) {
                if (smallest_void > 0 && made.voids.empty()) continue;
                const CarvingOptions options{priority, power, measure, breadth, exposed, smallest_void};
                const CarvingStream stream(made.complement, carve(made.complement, made.voids, options, context), "",
                                           context);
                const std::vector<InvariantCheck> checks = check_stream(stream, context);
                EXPECT_GE(checks.size(), 6U);
                for (const InvariantCheck& check : checks) {
                  EXPECT_TRUE(check.holds)
                      << name << (from_box ? " from the box, " : ", ") << static_cast<int>(priority) << " " << power
                      << " " << breadth << " " << exposed << " " << smallest_void << ": " << check.name << ", "
                      << check.detail;
                }
              }
            }
          }
        }
      }
    }
  }
}

TEST(CarvingInvariants, EveryNumberOfVerticesIsReachedWithoutVoidsAndBreadth) {
  for (const auto& [name, model] : models()) {
    for (const bool from_box : {false, true}) {
      RunContext context;
      const Classification made = test::classified(model, context, from_box);
      if (!made.voids.empty()) continue;
      for (const bool exposed : {true, false}) {
        CarvingOptions options;
        options.exposed = exposed;
        const CarvingStream stream(made.complement, carve(made.complement, made.voids, options, context), "", context);
        // A tetrahedron carved through one face brings its fourth corner; through two faces, all are there before.
        const std::uint32_t most = stream.vertices(stream.last_step());
        for (std::uint32_t vertices = stream.vertices(0); vertices <= most; ++vertices) {
          EXPECT_EQ(stream.vertices(stream.step_for_vertices(vertices)), vertices) << name << " " << from_box;
        }
      }
    }
  }
}

TEST(CarvingInvariants, LevelsContainTheLaterOnes) {
  // Volumes of levels by the divergence theorem: from the hull's down to the model's, never up.
  for (const auto& [name, model] : models()) {
    const CarvingStream stream = test::carved(model);
    double before = signed_volume(stream.extract(0));
    const double rounding = 1e-12 * before;
    for (std::uint32_t step = 1; step <= stream.last_step(); ++step) {
      const double now = signed_volume(stream.extract(step));
      EXPECT_LE(now, before + rounding) << name << " " << step;
      before = now;
    }
    if (name == "torus" || name == "eight balls" || name == "plate") {
      EXPECT_NEAR(before, signed_volume(model), 1e-9) << name;
    }
  }
}

}  // namespace
}  // namespace voxcarve
