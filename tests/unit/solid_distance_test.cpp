#include "methods/hagbi_elsana/solid_distance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <queue>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "common/mesh/aabb_tree.h"
#include "common/mesh/models/primitives.h"
#include "common/run/errors.h"
#include "tests/support/carving.h"
#include "tests/support/shapes.h"

namespace voxcarve {
namespace {

using Corners = std::array<Point, 4>;

/// Distances from the model, by looking at all of its triangles.
class SlowDistance {
 public:
  SlowDistance(const TriangleSoup& model, const CarvingStream& stream) : model_(model), mesh_(stream.complement()) {}

  double at(const Point& p) const {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Triangle& t : model_.triangles) {
      nearest = std::min(nearest,
                         squared_distance(p, model_.positions[t[0]], model_.positions[t[1]], model_.positions[t[2]]));
    }
    return std::sqrt(nearest);
  }

  /// The greatest distance of points on a lattice of `cells` cells an edge.
  double sampled(std::uint32_t t, int cells) const {
    const Corners corners = corners_of(t);
    double most = 0;
    for (int i = 0; i <= cells; ++i) {
      for (int j = 0; i + j <= cells; ++j) {
        for (int k = 0; i + j + k <= cells; ++k) {
          most = std::max(
              most, at((i * corners[0] + j * corners[1] + k * corners[2] + (cells - i - j - k) * corners[3]) / cells));
        }
      }
    }
    return most;
  }

  /// The greatest distance of the tetrahedron's points to 3 in 10,000, where that is above `least`; else `least`. Any
  /// above `enough` will do. By halves, those that may reach farthest first: distances change by no more than the way.
  double greatest(std::uint32_t t, double least, double enough = std::numeric_limits<double>::infinity()) const {
    struct Part {
      double bound;
      Corners corners;
      bool operator<(const Part& other) const { return bound < other.bound; }
    };
    std::priority_queue<Part> parts;
    double most = least;
    const auto add = [&](const Corners& corners) {
      const Point center = 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]);
      double radius = 0;
      for (const Point& corner : corners) radius = std::max(radius, (corner - center).norm());
      const double there = at(center);
      most = std::max(most, there);
      parts.push({there + radius, corners});
    };
    add(corners_of(t));
    while (!parts.empty() && most <= enough && parts.top().bound > (1 + 3e-4) * most) {
      const Corners corners = parts.top().corners;
      parts.pop();
      std::pair<std::size_t, std::size_t> longest{0, 1};
      for (std::size_t i = 0; i < 4; ++i) {
        for (std::size_t j = i + 1; j < 4; ++j) {
          const double length = (corners[i] - corners[j]).norm();
          if (length > (corners[longest.first] - corners[longest.second]).norm()) longest = {i, j};
        }
      }
      for (const auto& [keep, move] : {longest, std::pair(longest.second, longest.first)}) {
        Corners half = corners;
        half[move] = 0.5 * (corners[keep] + corners[move]);
        add(half);
      }
    }
    return most;
  }

 private:
  Corners corners_of(std::uint32_t t) const {
    Corners corners;
    for (std::size_t c = 0; c < 4; ++c) corners[c] = mesh_.points[mesh_.corners[t][c]];
    return corners;
  }

  const TriangleSoup& model_;
  const Complement& mesh_;
};

constexpr int kCells = 2 + test::case_count(3);  // of a tetrahedron's edge, between samples

struct Case {
  const char* name;
  TriangleSoup model;
  bool box;
};

std::vector<Case> cases() {
  TriangleSoup strip;  // an open fold
  strip.positions = {Point(0, 0, 0), Point(2, 0, 0.1), Point(2.1, 1, 0), Point(0, 1.1, 0.2), Point(0.3, 0.2, 1.5)};
  strip.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 1, 4}};
  return {{"torus", torus(2, 0.7, 12, 6), false},
          {"torus in a box", torus(2, 0.7, 10, 5), true},
          {"two balls", test::joined({icosphere(Point(0, 0, 0), 1, 1), icosphere(Point(4, 0.3, 0), 0.7, 1)}), false},
          {"void", test::joined({uv_sphere(Point(0, 0, 0), 3, 8, 6), as_cavity(uv_sphere(Point(0, 0, 0), 2, 7, 5))}),
           false},
          {"fold", strip, false}};
}

TEST(StepWithin, IsTheFirstWhoseSolidReachesNoFarther) {
  for (const Case& tested : cases()) {
    const CarvingStream stream = test::carved(tested.model, {}, tested.box);
    const SlowDistance slow(tested.model, stream);
    const double diagonal = bounds(tested.model).diagonal();
    std::uint32_t before = stream.last_step();
    for (const double share : {0.001, 0.01, 0.03, 0.06, 0.1, 0.15, 0.2, 0.3, 1.0}) {
      if (share < 0.05 && test::case_count(10) < 10) continue;  // what takes longest, under sanitizers
      SCOPED_TRACE(std::string(tested.name) + " " + std::to_string(share));
      const double distance = share * diagonal;
      RunContext context;
      const auto step = step_within(stream, distance, context);
      ASSERT_TRUE(step.has_value());
      EXPECT_LE(*step, before);  // the solids are nested
      before = *step;
      double excess = -1;
      bool far_before = *step == 0;
      const double nearly = distance * (1 - 1e-3);
      for (std::uint32_t t = 0; t < stream.complement().first_ghost; ++t) {
        if (stream.steps()[t] > *step) excess = std::max(excess, slow.sampled(t, kCells) - distance);
        if (stream.steps()[t] == *step) far_before = far_before || slow.greatest(t, nearly, nearly) > nearly;
      }
      EXPECT_LE(excess, 1e-12 * diagonal);
      EXPECT_TRUE(far_before);  // what the step carves was too far, or nearly
    }
    EXPECT_EQ(before, 0U);  // within a whole diagonal is the hull, and nearly the box
  }
}

TEST(StepWithin, IsNeverTooEarlyAndLateByLessThanOneInAThousand) {
  const TriangleSoup model = torus(2, 0.7, 9, 5);
  const CarvingStream stream = test::carved(model);
  const SlowDistance slow(model, stream);
  for (const std::uint32_t step : {0U, stream.last_step() / 2}) {
    double greatest = 0;
    for (std::uint32_t t = 0; t < stream.complement().first_ghost; ++t) {
      if (stream.steps()[t] > step) greatest = slow.greatest(t, greatest);
    }
    RunContext context;
    EXPECT_GT(step_within(stream, greatest * (1 - 1e-6), context), step);
    EXPECT_LE(step_within(stream, greatest * (1 + 1.3e-3), context), step);  // 3e-4 of these are the twin's
  }
}

TEST(StepWithin, NoDistanceIsTheModelItself) {
  for (const Case& tested : cases()) {
    const CarvingStream stream = test::carved(tested.model, {}, tested.box);
    RunContext context;
    EXPECT_EQ(step_within(stream, 0, context), stream.last_step()) << tested.name;
  }
}

TEST(StepWithin, ConvexModelsAreThemselvesFromTheStart) {
  const CarvingStream stream = test::carved(box(Point(0, 0, 0), Point(1, 1, 1)));
  RunContext context;
  EXPECT_EQ(step_within(stream, 0, context), 0U);
}

TEST(StepWithin, VoidsLeftShutKeepTheirDistance) {
  // In a shut void, of a uv sphere of radius 2, the centre is no nearer to the surface than the planes of its faces
  // are, and no farther than 2.
  const TriangleSoup model =
      test::joined({uv_sphere(Point(0, 0, 0), 3, 8, 6), as_cavity(uv_sphere(Point(0, 0, 0), 2, 8, 6))});
  CarvingOptions options;
  options.smallest_void = 1e9;
  const CarvingStream stream = test::carved(model, options);
  RunContext context;
  EXPECT_EQ(step_within(stream, 0, context), std::nullopt);
  EXPECT_EQ(step_within(stream, 1.5, context), std::nullopt);
  EXPECT_EQ(step_within(stream, 2.001, context), 0U);
  // Opened, the same model has a step for every distance.
  EXPECT_TRUE(step_within(test::carved(model), 0.1, context).has_value());
}

TEST(StepWithin, IsTheSameForTheModelAtAnyScale) {
  // Powers of two change no digit.
  TriangleSoup large = torus(2, 0.7, 12, 6);
  for (Point& p : large.positions) p *= 0x1p40;
  const CarvingStream stream = test::carved(torus(2, 0.7, 12, 6));
  const CarvingStream scaled = test::carved(large);
  RunContext context;
  for (const double distance : {0.05, 0.3, 0.9}) {
    EXPECT_EQ(step_within(stream, distance, context), step_within(scaled, 0x1p40 * distance, context)) << distance;
  }
}

TEST(StepWithin, CanBeCancelled) {
  const CarvingStream stream = test::carved(torus(2, 0.7, 12, 6));
  std::stop_source stop;
  stop.request_stop();
  RunContext context;
  context.cancellation = stop.get_token();
  EXPECT_THROW(step_within(stream, 0.1, context), Cancelled);
}

}  // namespace
}  // namespace voxcarve
