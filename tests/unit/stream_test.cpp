#include "methods/hagbi_elsana/stream.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <thread>

#include "common/mesh/models/primitives.h"
#include "common/mesh/topology.h"
#include "common/run/errors.h"
#include "tests/support/carving.h"
#include "tests/support/shapes.h"
#include "tests/support/slow_stream.h"

namespace voxcarve {
namespace {

using Corners = std::array<std::uint32_t, 4>;

Corners sorted(Corners corners) {
  std::ranges::sort(corners);
  return corners;
}

/// A model with all tetrahedra of its hull, those inside it too.
struct Shape {
  explicit Shape(const TriangleSoup& soup) {
    RunContext context;
    const ValidComplex valid = make_valid_complex(soup, {}, context);
    made = classify(valid.tetrahedralization, valid.complex, valid.multiplicity, InsideRule::kWinding, context);
    facets = valid.tetrahedralization.facets;
    std::set<Corners> carvable;
    for (std::uint32_t t = 0; t < made.complement.first_ghost; ++t) carvable.insert(sorted(made.complement.corners[t]));
    for (const Corners& corners : valid.tetrahedralization.tetrahedra) {
      if (!carvable.contains(sorted(corners))) inside.push_back(corners);
    }
  }

  Classification made;
  std::vector<Triangle> facets;
  std::vector<Corners> inside;
};

/// Components of the union of all simplices that are left: of the model's triangles, its inside and what was not
/// carved.
std::uint32_t slow_components(const Shape& shape, const std::vector<std::uint32_t>& steps, std::uint32_t step) {
  const std::size_t points = shape.made.complement.points.size();
  std::vector<std::uint32_t> label(points);
  std::vector<bool> present(points, false);
  for (std::uint32_t p = 0; p < points; ++p) label[p] = p;
  const auto find = [&](std::uint32_t p) {
    while (label[p] != p) p = label[p];
    return p;
  };
  const auto unite = [&](const auto& simplex) {
    for (const std::uint32_t p : simplex) {
      present[p] = true;
      const std::uint32_t low = std::min(find(p), find(simplex[0]));
      const std::uint32_t high = std::max(find(p), find(simplex[0]));
      label[high] = low;
    }
  };
  for (const Triangle& facet : shape.facets) unite(facet);
  for (const Corners& corners : shape.inside) unite(corners);
  for (std::uint32_t t = 0; t < shape.made.complement.first_ghost; ++t) {
    if (steps[t] > step) unite(shape.made.complement.corners[t]);
  }
  std::uint32_t count = 0;
  for (std::uint32_t p = 0; p < points; ++p) count += present[p] && label[p] == p;
  return count;
}

/// Three half-discs of paper that meet in one edge, and a fold across two of them: open, with six sheets at the spine.
TriangleSoup book() {
  TriangleSoup soup;
  soup.positions = {Point(0, 0, 0), Point(0, 0, 1), Point(1, 0.1, 0.5), Point(-0.6, 0.9, 0.5), Point(-0.5, -1, 0.4)};
  soup.triangles = {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}};
  return soup;
}

/// A strip of paper, folded once.
TriangleSoup sheet() {
  TriangleSoup soup;
  for (const double y : {0.0, 0.7, 1.3}) {
    for (const double x : {0.0, 1.0, 2.1})
      soup.positions.emplace_back(x, y, x > 0.5 && x < 1.5 ? 0.8 + 0.1 * y : 0.05 * y);
  }
  for (std::uint32_t row = 0; row < 2; ++row) {
    for (std::uint32_t column = 0; column < 2; ++column) {
      const std::uint32_t p = 3 * row + column;
      soup.triangles.push_back({p, p + 1, p + 4});
      soup.triangles.push_back({p, p + 4, p + 3});
    }
  }
  return soup;
}

TriangleSoup tetrahedron(const Point& a, const Point& b, const Point& c, const Point& d) {
  TriangleSoup soup;
  soup.positions = {a, b, c, d};
  soup.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  return (b - a).cross(c - a).dot(d - a) > 0 ? soup : test::inside_out(soup);
}

const TriangleSoup kCube = box(Point(0, 0, 0), Point(1, 1, 1));

std::map<std::string, TriangleSoup> small_models() {
  const auto sphere = [](double radius, int slices) { return uv_sphere(Point(0, 0, 0), radius, slices, slices - 2); };
  return {{"two balls", test::joined({icosphere(Point(0, 0, 0), 1, 1), icosphere(Point(2.5, 0.3, 0), 1, 1)})},
          {"torus", torus(2, 0.7, 12, 6)},
          {"voids", test::joined({sphere(3, 8), as_cavity(sphere(2, 7)), sphere(1, 6), as_cavity(sphere(0.5, 5))})},
          {"sheet", sheet()},
          {"book", book()},
          {"cubes that share a face", test::joined({kCube, box(Point(1, 0, 0), Point(2, 1, 1))})},
          {"cubes that touch in an edge", test::joined({kCube, box(Point(1, 1, 0), Point(2, 2, 1))})},
          {"cubes that touch in a vertex", test::joined({kCube, box(Point(1, 1, 1), Point(2, 2, 2))})},
          {"cubes that touch in part of an edge", test::joined({kCube, box(Point(1, 1, 0.3), Point(2, 2, 1.3))})},
          {"soup", test::crossing_triangles(60, 7)}};
}

std::vector<CarvingOptions> option_sets() {
  std::vector<CarvingOptions> sets(5);
  sets[1].exposed = false;
  sets[2].breadth = 0.6;
  sets[3].priority = CarvingPriority::kVolume;
  sets[3].depth_power = 2;
  sets[4].smallest_void = 1e9;  // every void stays shut
  sets[4].priority = CarvingPriority::kCircumradiusRatio;
  return sets;
}

void expect_closed_manifold(const TriangleSoup& surface) {
  const SurfaceTopology topology = analyze_topology(surface);
  EXPECT_TRUE(topology.closed);
  EXPECT_TRUE(topology.oriented);
  EXPECT_EQ(topology.nonmanifold_edges, 0);
  EXPECT_EQ(topology.nonmanifold_vertices, 0);
  EXPECT_EQ(topology.collapsed_triangles, 0);
}

TEST(CarvingStream, HoldsWhatASearchThroughAllTetrahedraFinds) {
  for (const auto& [name, model] : small_models()) {
    const Shape shape(model);
    int number = 0;
    for (const CarvingOptions& options : option_sets()) {
      SCOPED_TRACE(name + ", options " + std::to_string(number++));
      RunContext context;
      const auto steps = carve(shape.made.complement, shape.made.voids, options, context);
      const CarvingStream stream(shape.made.complement, steps, "", context);
      const test::SlowStream slow{shape.made.complement, steps};
      ASSERT_EQ(stream.last_step(), slow.last_step());
      const std::vector<std::uint32_t> components = stream.closed_components(RunContext());
      ASSERT_EQ(components.size(), std::size_t{slow.last_step()} + 1);
      std::vector<std::uint32_t> vertices;
      std::vector<std::uint32_t> triangles;
      for (std::uint32_t step = 0; step <= slow.last_step(); ++step) {
        SCOPED_TRACE("step " + std::to_string(step));
        const auto faces = slow.faces(step);
        vertices.push_back(test::distinct_positions(faces));
        triangles.push_back(static_cast<std::uint32_t>(faces.size()));
        EXPECT_EQ(stream.vertices(step), vertices.back());
        EXPECT_EQ(stream.triangles(step), triangles.back());
        EXPECT_EQ(components[step], slow_components(shape, steps, step));
        const TriangleSoup surface = stream.extract(step);
        EXPECT_EQ(test::position_triples(surface), faces);
        expect_closed_manifold(surface);
        if (HasFailure()) return;
      }
      std::vector<std::uint32_t> levels = {0};
      for (std::uint32_t step = 1; step <= slow.last_step(); ++step) {
        if (step == slow.last_step() || vertices[step + 1] > vertices[step]) levels.push_back(step);
      }
      EXPECT_EQ(stream.levels(), levels);
      const auto last_within = [](const std::vector<std::uint32_t>& counts, std::int64_t most) {
        std::uint32_t step = 0;
        while (step + 1 < counts.size() && counts[step] <= most && counts[step + 1] <= most) ++step;
        return step;
      };
      const std::int64_t most_triangles = *std::ranges::max_element(triangles);
      for (std::int64_t most = 0; most <= most_triangles + 1; ++most) {
        EXPECT_EQ(stream.step_for_vertices(most), last_within(vertices, most)) << most;
        EXPECT_EQ(stream.step_for_triangles(most), last_within(triangles, most)) << most;
      }
    }
  }
}

/// Surface components of the last level, each a sphere, and their vertices.
void expect_spheres(const TriangleSoup& model, std::int64_t spheres, std::int64_t vertices, std::uint32_t positions) {
  const CarvingStream stream = test::carved(model);
  const TriangleSoup surface = stream.extract(stream.last_step());
  expect_closed_manifold(surface);
  const SurfaceTopology topology = analyze_topology(surface);
  EXPECT_EQ(topology.components, spheres);
  EXPECT_EQ(topology.genus.value_or(-1), 0);
  EXPECT_EQ(topology.vertices, vertices);
  EXPECT_EQ(stream.vertices(stream.last_step()), positions);
  EXPECT_EQ(stream.closed_components(RunContext()).back(), 1U);  // as a closed set they hang together
}

TEST(CarvingStream, BodiesThatTouchInAnEdgeAreCutApart) {
  const Point a(0, 0, 0);
  const Point b(0, 0, 1);
  const TriangleSoup right = tetrahedron(a, b, Point(1, -0.4, 0.5), Point(1, 0.4, 0.4));
  const TriangleSoup left = tetrahedron(a, b, Point(-1, -0.5, 0.3), Point(-1.1, 0.3, 0.6));
  const TriangleSoup front = tetrahedron(a, b, Point(-0.2, -1, 0.5), Point(0.3, -1.2, 0.4));
  // Four vertices each; the two on the edge are common to all.
  expect_spheres(test::joined({right, left}), 2, 8, 6);
  expect_spheres(test::joined({right, left, front}), 3, 12, 8);
  // Cubes: eight vertices each, of which the edge's two are common.
  expect_spheres(test::joined({kCube, box(Point(1, 1, 0), Point(2, 2, 1))}), 2, 16, 14);
}

TEST(CarvingStream, BodiesThatTouchInAVertexAreCutApart) {
  expect_spheres(test::joined({kCube, box(Point(1, 1, 1), Point(2, 2, 2))}), 2, 16, 15);
  expect_spheres(
      test::joined({tetrahedron(Point(0, 0, 0), Point(1, -0.4, 0.5), Point(1, 0.4, 0.4), Point(1, 0, 1)),
                    tetrahedron(Point(0, 0, 0), Point(-1, -0.4, 0.5), Point(-1, 0.4, 0.4), Point(-1, 0, 1))}),
      2, 8, 7);
}

TEST(CarvingStream, CubesThatShareAFaceBecomeOneBody) {
  // The common face is inside: 12 of 16 corners are distinct, and all of them lie on the surface of the whole.
  expect_spheres(test::joined({kCube, box(Point(1, 0, 0), Point(2, 1, 1))}), 1, 12, 12);
}

TEST(CarvingStream, ASingleTriangleOnASolidStaysAsAFold) {
  TriangleSoup model = kCube;  // a fin on the cube's upper edge x = 1, z = 1
  const auto first = static_cast<std::uint32_t>(model.positions.size());
  model.positions.insert(model.positions.end(), {Point(1, 0, 1), Point(1, 1, 1), Point(1.5, 0.5, 1.5)});
  model.triangles.push_back({first, first + 1, first + 2});
  const CarvingStream stream = test::carved(model);
  const TriangleSoup surface = stream.extract(stream.last_step());
  expect_closed_manifold(surface);
  EXPECT_EQ(surface.triangles.size(), 12U + 2U);
  EXPECT_NEAR(signed_volume(surface), 1, 1e-12);
  // Held by its wedges, the fin would leave the cube's edge with four triangles: its two sides are cut off together.
  const SurfaceTopology topology = analyze_topology(surface);
  EXPECT_EQ(topology.components, 2);
  EXPECT_EQ(topology.vertices, 8 + 3);
  EXPECT_EQ(stream.closed_components(RunContext()).back(), 1U);
}

TEST(CarvingStream, ConvexModelsHaveOneLevel) {
  const CarvingStream stream = test::carved(kCube);
  EXPECT_EQ(stream.last_step(), 0U);
  EXPECT_EQ(stream.levels(), std::vector<std::uint32_t>{0});
  EXPECT_EQ(stream.vertices(0), 8U);
  EXPECT_EQ(stream.triangles(0), 12U);
  EXPECT_EQ(stream.closed_components(RunContext()), std::vector<std::uint32_t>{1});
  EXPECT_EQ(stream.step_for_vertices(100), 0U);
  EXPECT_EQ(stream.step_for_vertices(3), 0U);
  EXPECT_EQ(test::position_triples(stream.extract(0)), test::position_triples(kCube));
}

TEST(CarvingStream, IsTheSameOnOneThreadAndOnTwoAndForTwoReaders) {
  // More than one chunk of faces: 2 * 5,120 triangles at the end.
  const CarvingStream stream =
      test::carved(test::joined({icosphere(Point(0, 0, 0), 1, 4), icosphere(Point(2.5, 0.3, 0), 1, 4)}));
  ASSERT_EQ(stream.triangles(stream.last_step()), 10240U);
  std::vector<std::uint32_t> asked;
  for (std::uint32_t i = 0; i <= 12; ++i) asked.push_back(stream.last_step() / 12 * i);
  asked.push_back(stream.last_step());
  std::vector<TriangleSoup> expected;
  RunContext two;
  two.threads = 2;
  for (const std::uint32_t step : asked) {
    expected.push_back(stream.extract(step));
    EXPECT_EQ(stream.extract(step, &two), expected.back()) << step;
  }
  std::array<std::size_t, 2> equal{};
  std::vector<std::thread> readers;
  for (std::size_t reader = 0; reader < equal.size(); ++reader) {
    readers.emplace_back([&, reader] {
      for (std::size_t k = 0; k < asked.size(); ++k) {
        const std::size_t mine = reader == 0 ? k : asked.size() - 1 - k;
        equal[reader] += stream.extract(asked[mine]) == expected[mine];
      }
    });
  }
  for (std::thread& reader : readers) reader.join();
  EXPECT_EQ(equal, (std::array<std::size_t, 2>{asked.size(), asked.size()}));
}

/// The stream of a ball beside another, with its steps changed.
void expect_steps_refused(const std::function<void(const Complement&, std::vector<std::uint32_t>&)>& change) {
  RunContext context;
  const Classification made =
      test::classified(test::joined({icosphere(Point(0, 0, 0), 1, 1), icosphere(Point(3, 0.3, 0), 1, 1)}), context);
  auto steps = carve(made.complement, made.voids, {}, context);
  change(made.complement, steps);
  EXPECT_THROW(CarvingStream(made.complement, steps, "", context), InputError);
}

TEST(CarvingStream, RefusesStepsThatContradictThemselves) {
  expect_steps_refused([](const Complement&, auto& steps) { steps.pop_back(); });
  expect_steps_refused([](const Complement&, auto& steps) { steps.back() = 1; });   // a ghost that is carved
  expect_steps_refused([](const Complement&, auto& steps) { steps.front() = 0; });  // a tetrahedron that is none
  expect_steps_refused([](const Complement&, auto& steps) { steps.front() = 0x7fffffff; });  // no such many steps
}

}  // namespace
}  // namespace voxcarve
