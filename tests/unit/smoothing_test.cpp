// Taubin smoothing against its slow twin, its transfer function, and what it is for: stairs go, volume stays.
#include "common/mesh/smoothing.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <random>
#include <set>
#include <stop_token>
#include <utility>
#include <vector>

#include "common/run/errors.h"
#include "common/volume/isosurface.h"
#include "tests/support/shapes.h"

namespace voxcarve {
namespace {

using test::frame_of;

/// One step for every weight, with neighbours found by looking through all edges.
TriangleSoup slow_smooth(TriangleSoup surface, const std::vector<double>& weights) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> triangles_at_edge;
  for (const Triangle& t : surface.triangles) {
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
    for (std::size_t c = 0; c < 3; ++c) ++triangles_at_edge[std::minmax(t[c], t[(c + 1) % 3])];
  }
  std::vector<std::set<std::uint32_t>> neighbours(surface.positions.size());
  std::vector<std::set<std::uint32_t>> boundary_neighbours(surface.positions.size());
  for (const auto& [edge, triangles] : triangles_at_edge) {
    for (const auto& [a, b] : {edge, std::pair(edge.second, edge.first)}) {
      neighbours[a].insert(b);
      if (triangles == 1) boundary_neighbours[a].insert(b);
    }
  }
  for (const double weight : weights) {
    const std::vector<Point> from = surface.positions;
    for (std::size_t v = 0; v < from.size(); ++v) {
      const std::set<std::uint32_t>& averaged = boundary_neighbours[v].empty() ? neighbours[v] : boundary_neighbours[v];
      if (averaged.empty()) continue;
      Point sum = Point::Zero();
      for (const std::uint32_t neighbour : averaged) sum += from[neighbour];
      surface.positions[v] = from[v] + weight * (sum / static_cast<double>(averaged.size()) - from[v]);
    }
  }
  return surface;
}

TriangleSoup slow_smooth(const TriangleSoup& surface, const TaubinOptions& options) {
  std::vector<double> weights;
  for (int i = 0; i < options.iterations; ++i) weights.insert(weights.end(), {options.lambda, options.mu});
  return slow_smooth(surface, weights);
}

TriangleSoup smoothed(TriangleSoup surface, const TaubinOptions& options, int threads = 1) {
  RunContext context;
  context.threads = threads;
  taubin_smooth(surface, options, context);
  return surface;
}

/// A lattice of columns x rows vertices (i, j), each cell cut along its rising diagonal: everywhere inside, the
/// neighbours are (+-1, 0), (0, +-1), (1, 1) and (-1, -1). Closed to a torus, it has no boundary at all.
TriangleSoup lattice(std::uint32_t columns, std::uint32_t rows, bool torus) {
  TriangleSoup surface;
  for (std::uint32_t j = 0; j < rows; ++j)
    for (std::uint32_t i = 0; i < columns; ++i) surface.positions.emplace_back(i, j, 0.75);
  const auto vertex = [&](std::uint32_t i, std::uint32_t j) { return j % rows * columns + i % columns; };
  for (std::uint32_t j = 0; j + (torus ? 0 : 1) < rows; ++j) {
    for (std::uint32_t i = 0; i + (torus ? 0 : 1) < columns; ++i) {
      surface.triangles.push_back({vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1)});
      surface.triangles.push_back({vertex(i, j), vertex(i + 1, j + 1), vertex(i, j + 1)});
    }
  }
  return surface;
}

TEST(Smoothing, MultipliesEachEigenvectorOfTheLaplacianByTheTransferFunction) {
  // On the torus cos(a i + b j + c), with a = 2 pi p / m and b = 2 pi q / n, is an eigenvector of the Laplacian
  // x - mean of the neighbours, for k = 1 - (cos a + cos b + cos(a + b)) / 3: opposite neighbours average to
  // cos(shift) times the middle. Each iteration multiplies it by (1 - lambda k) (1 - mu k) [Tau95].
  constexpr std::uint32_t m = 14, n = 9;
  constexpr int kWaves[6][2] = {{0, 0}, {1, 0}, {0, 2}, {3, 4}, {7, 4}, {5, 8}};
  for (const TaubinOptions& options : {TaubinOptions{}, TaubinOptions{.iterations = 3, .lambda = 0.33, .mu = -0.34}}) {
    TriangleSoup surface = lattice(m, n, true);
    TriangleSoup expected = surface;
    for (int first_wave : {0, 3}) {
      for (int axis = 0; axis < 3; ++axis) {
        const double a = 2 * std::numbers::pi * kWaves[first_wave + axis][0] / m;
        const double b = 2 * std::numbers::pi * kWaves[first_wave + axis][1] / n;
        const double k = 1 - (std::cos(a) + std::cos(b) + std::cos(a + b)) / 3;
        const double factor = std::pow((1 - options.lambda * k) * (1 - options.mu * k), options.iterations);
        for (std::uint32_t v = 0; v < m * n; ++v) {
          const double wave = std::cos(a * (v % m) + b * (v / m) + 0.4);
          surface.positions[v][axis] = wave;
          expected.positions[v][axis] = factor * wave;
        }
      }
      const TriangleSoup result = smoothed(surface, options);
      for (std::uint32_t v = 0; v < m * n; ++v) {
        ASSERT_LT((result.positions[v] - expected.positions[v]).lpNorm<Eigen::Infinity>(), 1e-12) << v;
      }
    }
  }
}

TEST(Smoothing, LeavesAPlaneAndItsStraightBorderWhereTheyAre) {
  // Every vertex is the mean of its neighbours but for the corners, and one step carries what happens there on by one
  // edge: after the six steps of three iterations only vertices up to six edges from a corner can have moved. All
  // coordinates are multiples of 1/4 and the means exact, so the others stay to the last bit.
  const TriangleSoup surface = lattice(21, 21, false);
  const TriangleSoup result = smoothed(surface, {.iterations = 3});
  EXPECT_EQ(result.triangles, surface.triangles);
  int stayed = 0;
  for (std::uint32_t v = 0; v < surface.positions.size(); ++v) {
    EXPECT_NEAR(result.positions[v][2], 0.75, 1e-15);
    const int i = static_cast<int>(v % 21);
    const int j = static_cast<int>(v / 21);
    const auto edges_to = [&](int ci, int cj) {
      const int di = i - ci;
      const int dj = j - cj;
      return di * dj > 0 ? std::max(std::abs(di), std::abs(dj)) : std::abs(di) + std::abs(dj);
    };
    if (std::min({edges_to(0, 0), edges_to(20, 0), edges_to(0, 20), edges_to(20, 20)}) > 6) {
      EXPECT_EQ(result.positions[v], surface.positions[v]) << i << ' ' << j;
      ++stayed;
    }
  }
  // Of 441 all but two squares of 7 x 7 and two triangles of 7 + 6 + ... + 1.
  EXPECT_EQ(stayed, 441 - 2 * 49 - 2 * 28);
}

TEST(Smoothing, AveragesBoundaryVerticesOverBoundaryNeighboursOnly) {
  // A square pyramid without its base. The neighbours of a base vertex along the boundary are opposite corners, with
  // the origin for their mean; the apex above would lift them, but does not count. The mean of the apex is that of the
  // base, the origin too. So a step multiplies everything by 1 - weight.
  TriangleSoup surface;
  surface.positions = {{1, 1, 0}, {-1, 1, 0}, {-1, -1, 0}, {1, -1, 0}, {0, 0, 3}};
  surface.triangles = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
  const TaubinOptions options{.iterations = 1, .lambda = 0.25, .mu = -0.5};
  const TriangleSoup result = smoothed(surface, options);
  const double factor = 0.75 * 1.5;
  for (std::size_t v = 0; v < 5; ++v) EXPECT_EQ(result.positions[v], factor * surface.positions[v]) << v;
}

TEST(Smoothing, LeavesUnusedVerticesAndColoursAlone) {
  TriangleSoup surface = lattice(4, 4, false);
  const auto unused = static_cast<std::uint32_t>(surface.positions.size());
  surface.positions.emplace_back(9, 9, 9);
  surface.positions.emplace_back(8, 8, 8);
  surface.triangles.push_back({unused, unused, 0});  // without area: no neighbours either
  surface.vertex_colors.assign(surface.positions.size(), Color(1, 0, 0));
  surface.triangle_colors.assign(surface.triangles.size(), Color(0, 1, 0));
  const TriangleSoup result = smoothed(surface, {});
  EXPECT_EQ(result.positions[unused], Point(9, 9, 9));
  EXPECT_EQ(result.positions[unused + 1], Point(8, 8, 8));
  EXPECT_EQ(result.vertex_colors, surface.vertex_colors);
  EXPECT_EQ(result.triangle_colors, surface.triangle_colors);
  EXPECT_NE(result.positions[0], surface.positions[0]);
  EXPECT_EQ(smoothed(surface, {.iterations = 0}), surface);
  EXPECT_EQ(smoothed(TriangleSoup(), {}), TriangleSoup());
}

TEST(Smoothing, EqualsItsSlowTwinOnAnySoup) {
  // Random triangles on few vertices: edges of one, two and many triangles, either orientation, repeated corners,
  // the same triangle twice, vertices of several fans.
  std::mt19937_64 generator(1);
  const auto coordinate = [&generator] { return static_cast<double>(generator() >> 11) * 0x1p-53; };
  for (int round = 0; round < 200; ++round) {
    TriangleSoup surface;
    const std::size_t vertices = 3 + generator() % 30;
    for (std::size_t v = 0; v < vertices; ++v) surface.positions.emplace_back(coordinate(), coordinate(), coordinate());
    for (std::size_t t = generator() % 60; t > 0; --t) {
      Triangle triangle;
      for (std::uint32_t& corner : triangle) corner = static_cast<std::uint32_t>(generator() % vertices);
      surface.triangles.push_back(triangle);
    }
    const TaubinOptions options{.iterations = 1 + round % 4};
    ASSERT_EQ(smoothed(surface, options), slow_smooth(surface, options)) << round;
  }
}

/// {field >= 0} is the ball around the centre of n^3 voxels.
Grid<float> ball_field(std::int64_t n, double radius) {
  Grid<float> field(frame_of({n, n, n}));
  for (std::int64_t k = 0; k < n; ++k)
    for (std::int64_t j = 0; j < n; ++j)
      for (std::int64_t i = 0; i < n; ++i) {
        const double distance = (field.frame.center({i, j, k}) - Point::Constant(0.5 * static_cast<double>(n))).norm();
        field(i, j, k) = static_cast<float>(radius - distance);
      }
  return field;
}

/// The surface of the ball's voxels: a sphere in stairs.
TriangleSoup stair_sphere(std::int64_t n, double radius) {
  const Grid<float> field = ball_field(n, radius);
  BinaryVolume volume(field.frame);
  for (std::size_t i = 0; i < volume.values.size(); ++i) volume.values[i] = field.values[i] >= 0;
  RunContext context;
  return isosurface(volume, context);
}

TEST(Smoothing, EqualsItsSlowTwinOnManyChunksAndOnTwoThreads) {
  const TriangleSoup surface = stair_sphere(90, 40.2);
  ASSERT_GT(surface.positions.size(), std::size_t{1} << 14);  // vertices a chunk
  const TaubinOptions options{.iterations = 2};
  const TriangleSoup expected = slow_smooth(surface, options);
  EXPECT_EQ(smoothed(surface, options, 1), expected);
  EXPECT_EQ(smoothed(surface, options, 2), expected);
}

TEST(Smoothing, KeepsTheVolumeThatPlainLaplacianSmoothingLoses) {
  // At small k, where the size of the sphere is, ten iterations multiply the radius by 1 - 10 (lambda + mu) k =
  // 1 + 0.26 k, and twenty steps by lambda by 1 - 20 lambda k = 1 - 10 k: 38 times the change, inward.
  RunContext context;
  const TriangleSoup sphere = scalar_isosurface(ball_field(32, 12.3), 0, context);
  const double volume = signed_volume(sphere);
  const double by_taubin = signed_volume(smoothed(sphere, {})) - volume;
  const double by_laplacian = signed_volume(slow_smooth(sphere, std::vector<double>(20, 0.5))) - volume;
  EXPECT_LT(by_laplacian, -0.02 * volume);
  EXPECT_LT(by_taubin, -by_laplacian / 30);
  EXPECT_GT(by_taubin, 0);
}

/// Root of the mean of (distance from the centre of n^3 voxels - radius)^2, all of it in voxels.
double deviation(const TriangleSoup& surface, std::int64_t n, double radius) {
  double sum = 0;
  for (const Point& p : surface.positions) {
    const double difference = (p - Point::Constant(0.5 * static_cast<double>(n))).norm() - radius;
    sum += difference * difference;
  }
  return std::sqrt(sum / static_cast<double>(surface.positions.size()));
}

TEST(Smoothing, TakesTheStairsOffASphere) {
  // Before: the vertex of an x-edge lies midway, so along x it misses the sphere by an error that is uniform over one
  // voxel, of variance 1/12, and along the normal by n_x times that. x-edges are crossed |n_x| times an area, and over
  // the sphere E |n_x|^3 = 1/4 and E |n_x| = 1/2, so the variance is (1/4) / (1/2) / 12 = 1/24.
  const TriangleSoup stairs = stair_sphere(90, 40.2);
  const double before = deviation(stairs, 90, 40.2);
  EXPECT_NEAR(before, std::sqrt(1.0 / 24), 0.01 * before);
  // After: the stairs around the six poles are long waves, which pass. Measured: 0.203, then 0.106 by ten iterations
  // and 0.082 by thirty.
  EXPECT_LT(deviation(smoothed(stairs, {}), 90, 40.2), 0.53 * before);
  EXPECT_LT(deviation(smoothed(stairs, {.iterations = 30}), 90, 40.2), 0.41 * before);
}

TEST(Smoothing, ReportsProgressAndCanBeCancelled) {
  TriangleSoup surface = lattice(200, 200, true);
  RunContext context;
  std::int64_t last = -1;
  context.progress = [&last](const ProgressEvent& event) {
    EXPECT_GE(event.done, last);
    EXPECT_EQ(event.total, 2 * 10 * 200 * 200);
    last = event.done;
  };
  taubin_smooth(surface, {}, context);
  EXPECT_EQ(last, 2 * 10 * 200 * 200);
  std::stop_source stop;
  context.cancellation = stop.get_token();
  context.progress = [&stop](const ProgressEvent& event) {
    if (event.done > event.total / 2) stop.request_stop();
  };
  const TriangleSoup before = surface;
  EXPECT_THROW(taubin_smooth(surface, {}, context), Cancelled);
  EXPECT_EQ(surface, before);
}

TEST(Smoothing, RefusesStepsThatMakeWaves) {
  // One iteration multiplies waves by f(k) = (1 - lambda k) (1 - mu k), k in [0, 2]. The most that any of them grows
  // by, by trying many k:
  const auto growth = [](const TaubinOptions& options) {
    double most = 0;
    for (int i = 0; i <= 20000; ++i) {
      const double k = i / 1e4;
      most = std::max(most, std::abs((1 - options.lambda * k) * (1 - options.mu * k)));
    }
    return std::pow(most, options.iterations);
  };
  int legal = 0;
  int refused = 0;
  for (const int iterations : {1, 2, 10, 100, 1000}) {
    for (int l = 1; l < 100; l += 7) {
      for (int m = 1; m <= 150; m += 2) {
        const TaubinOptions options{.iterations = iterations, .lambda = l / 100.0, .mu = -m / 100.0};
        if (!(options.mu < -options.lambda)) continue;
        const double shortest = std::abs((1 - 2 * options.lambda) * (1 - 2 * options.mu));
        if (std::abs(shortest - 1) < 1e-9 || std::abs(growth(options) - 2) < 1e-3) continue;  // too close to tell
        const bool makes_waves = shortest > 1 || growth(options) > 2;
        ++(makes_waves ? refused : legal);
        if (makes_waves) {
          EXPECT_THROW(check_options(options), ParameterError) << l << ' ' << m << ' ' << iterations;
        } else {
          EXPECT_NO_THROW(check_options(options)) << l << ' ' << m << ' ' << iterations;
        }
      }
    }
  }
  EXPECT_GT(legal, 300);
  EXPECT_GT(refused, 300);
  // The defaults grow by 1.0066 and 1.93: 1 + 0.02632^2 / (4 0.5 0.52632) = 1.000658.
  EXPECT_NO_THROW(check_options({}));
  EXPECT_NO_THROW(check_options({.iterations = 1000}));
  EXPECT_NO_THROW(check_options({.iterations = 0, .mu = -1.5}));  // nothing is done
  // Of k = 2 alone: (1 - 1.8) (1 + 1.82) = -2.256, though f's greatest value is 1.00003.
  EXPECT_THROW(check_options({.iterations = 1, .lambda = 0.9, .mu = -0.91}), ParameterError);
}

TEST(Smoothing, RefusesOptionsOutOfRangeAndABudgetTooSmall) {
  RunContext context;
  const TriangleSoup before = lattice(5, 5, false);
  TriangleSoup surface = before;
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  for (const TaubinOptions& options :
       {TaubinOptions{.iterations = -1}, TaubinOptions{.lambda = 0}, TaubinOptions{.lambda = 1},
        TaubinOptions{.lambda = kNan}, TaubinOptions{.mu = -0.5}, TaubinOptions{.mu = 0.6}, TaubinOptions{.mu = kNan},
        TaubinOptions{.mu = -std::numeric_limits<double>::infinity()}}) {
    EXPECT_THROW(taubin_smooth(surface, options, context), ParameterError);
  }
  // 25 vertices with two more positions, a list's begin and its length, and 32 triangles with 6 entries in lists.
  context.memory_budget = 25 * (2 * 24 + 8 + 4) + 32 * 6 * 4 - 1;
  EXPECT_THROW(taubin_smooth(surface, {}, context), ResourceError);
  EXPECT_EQ(surface, before);
  ++context.memory_budget;
  taubin_smooth(surface, {}, context);
  EXPECT_NE(surface, before);
}

}  // namespace
}  // namespace voxcarve
