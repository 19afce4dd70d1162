#include "methods/hagbi_elsana/carving.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/mesh/models/primitives.h"
#include "methods/hagbi_elsana/tetrahedron.h"
#include "tests/support/carving.h"
#include "tests/support/shapes.h"

namespace voxcarve {
namespace {

/// [HE10, 3 to 5] word by word: every step looks at every tetrahedron.
class SlowCarver {
 public:
  SlowCarver(const Complement& mesh, const CarvingOptions& options) : mesh_(mesh), options_(options) {
    step_.assign(mesh.size(), kNeverCarved);
    for (std::uint32_t t = mesh.first_ghost; t < mesh.size(); ++t) step_[t] = 0;
    depth_.assign(mesh.size(), 0);
  }

  std::vector<std::uint32_t> run(const std::vector<Void>& voids) {
    for (std::uint32_t t = 0; t < mesh_.first_ghost; ++t) {
      if (degree(t) > 0) depth_[t] = 1;
    }
    for (const Void& found : voids) depth_[found.seed] = 1;
    for (std::uint32_t step = 1;; ++step) {
      std::uint32_t best = kNeverCarved;
      for (std::uint32_t t = 0; t < mesh_.first_ghost; ++t) {
        if (step_[t] != kNeverCarved || depth_[t] == 0) continue;
        if (best == kNeverCarved || priority(t) > priority(best)) best = t;
      }
      if (best == kNeverCarved) return step_;
      std::vector<std::uint32_t> now = {best};
      step_[best] = step;
      const Point center = centroid(mesh_.points, mesh_.corners[best]);
      for (std::size_t next = 0; next < now.size() && options_.breadth > 0; ++next) {
        for (const std::uint32_t t : beyond(now[next])) {
          if ((centroid(mesh_.points, mesh_.corners[t]) - center).norm() <= options_.breadth)
            take(t, now[next], step, now);
        }
      }
      for (std::size_t next = 0; next < now.size(); ++next) {
        for (const std::uint32_t t : beyond(now[next])) {
          if (options_.exposed && degree(t) > 1) {
            take(t, now[next], step, now);
          } else if (depth_[t] == 0) {
            depth_[t] = depth_[now[next]] + 1;
          }
        }
      }
    }
  }

 private:
  void take(std::uint32_t t, std::uint32_t exposer, std::uint32_t step, std::vector<std::uint32_t>& now) {
    if (depth_[t] == 0) depth_[t] = depth_[exposer] + 1;
    step_[t] = step;
    now.push_back(t);
  }
  std::vector<std::uint32_t> beyond(std::uint32_t t) const {
    std::vector<std::uint32_t> result;
    for (int i = 0; i < 4; ++i) {
      const std::uint32_t other = mesh_.neighbors[t][static_cast<std::size_t>(i)];
      if (!mesh_.is_barrier(t, i) && step_[other] == kNeverCarved) result.push_back(other);
    }
    return result;
  }
  int degree(std::uint32_t t) const {
    int count = 0;
    for (int i = 0; i < 4; ++i) {
      count += !mesh_.is_barrier(t, i) && step_[mesh_.neighbors[t][static_cast<std::size_t>(i)]] != kNeverCarved;
    }
    return count;
  }
  double priority(std::uint32_t t) const {
    const TetrahedronCorners& corners = mesh_.corners[t];
    double quality = std::sqrt(longest_edge_squared(mesh_.points, corners));
    if (options_.priority == CarvingPriority::kVolume) quality = std::abs(volume(mesh_.points, corners));
    if (options_.priority == CarvingPriority::kCircumradiusRatio) {
      const auto squared = squared_edges(mesh_.points, corners);
      quality = std::sqrt(*std::ranges::min_element(squared)) / circumradius(mesh_.points, corners);
    }
    return quality / std::pow(depth_[t], options_.depth_power);
  }

  const Complement& mesh_;
  const CarvingOptions& options_;
  std::vector<std::uint32_t> step_;
  std::vector<std::uint32_t> depth_;
};

/// Moves every vertex a little, so that no two priorities are nearly equal and the twin's rounding decides nothing.
TriangleSoup shaken(TriangleSoup soup) {
  for (std::size_t i = 0; i < soup.positions.size(); ++i) {
    const auto angle = static_cast<double>(i);
    soup.positions[i] += 1e-3 * Point(std::sin(7 * angle), std::sin(11 * angle + 1), std::sin(13 * angle + 2));
  }
  return soup;
}

std::vector<TriangleSoup> small_models() {
  return {shaken(torus(2, 0.7, 12, 6)),
          shaken(test::joined({icosphere(Point(0, 0, 0), 1, 1), icosphere(Point(2.5, 0.3, 0), 1, 1)})),
          shaken(test::joined({uv_sphere(Point(0, 0, 0), 3, 8, 6), as_cavity(uv_sphere(Point(0, 0, 0), 2, 7, 5))}))};
}

TEST(Carve, DoesWhatThePaperSaysWordByWord) {
  for (const TriangleSoup& model : small_models()) {
    RunContext context;
    const Classification made = test::classified(model, context);
    for (const auto priority :
         {CarvingPriority::kLongestEdge, CarvingPriority::kVolume, CarvingPriority::kCircumradiusRatio}) {
      for (const double power : {0.0, 0.5, 10.0}) {
        for (const double breadth : {0.0, 0.8}) {
          for (const bool exposed : {true, false}) {
            CarvingOptions options;
            options.priority = priority;
            options.depth_power = power;
            options.breadth = breadth;
            options.exposed = exposed;
            EXPECT_EQ(carve(made.complement, made.voids, options, context),
                      SlowCarver(made.complement, options).run(made.voids))
                << static_cast<int>(priority) << " " << power << " " << breadth << " " << exposed;
          }
        }
      }
    }
  }
}

TEST(Carve, LeavesSmallVoidsShut) {
  RunContext context;
  // Inside a ball, a void of volume below 4/3 pi 2^3.
  const TriangleSoup model =
      test::joined({uv_sphere(Point(0, 0, 0), 3, 8, 6), as_cavity(uv_sphere(Point(0, 0, 0), 2, 8, 6))});
  const Classification made = test::classified(model, context);
  ASSERT_EQ(made.voids.size(), 1U);
  EXPECT_NEAR(made.voids[0].volume, signed_volume(uv_sphere(Point(0, 0, 0), 2, 8, 6)), 1e-9);
  CarvingOptions options;
  CarvingReport report;
  const auto open = carve(made.complement, made.voids, options, context, &report);
  EXPECT_EQ(report.shut_voids, 0U);
  EXPECT_EQ(std::ranges::count(open, kNeverCarved), 0);
  options.smallest_void = 34;
  const auto shut = carve(made.complement, made.voids, options, context, &report);
  EXPECT_EQ(report.shut_voids, 1U);
  EXPECT_GT(std::ranges::count(shut, kNeverCarved), 0);
}

TEST(Carve, DistanceAsDepthOpensTheOutsideFirst) {
  // Where depth is all that counts, what is carved next is the nearest to the hull of what can be.
  RunContext context;
  const Classification made = test::classified(shaken(torus(2, 0.5, 16, 8)), context);
  CarvingOptions options;
  options.depth_measure = DepthMeasure::kDistance;
  options.depth_power = 100;
  options.exposed = false;
  const auto steps = carve(made.complement, made.voids, options, context);
  double near = 0;
  double far = 0;
  std::size_t count = 0;
  const std::uint32_t last = *std::ranges::max_element(steps);
  for (std::uint32_t t = 0; t < made.complement.first_ghost; ++t) {
    const double height = std::abs(centroid(made.complement.points, made.complement.corners[t])[2]);
    (steps[t] <= last / 4 ? near : far) += height;  // the hull's flat sides are at +-0.5
    count += steps[t] <= last / 4;
  }
  EXPECT_GT(near / static_cast<double>(count), far / static_cast<double>(made.complement.first_ghost - count));
}

TEST(Carve, MeasuresSnakingAndSpiking) {
  RunContext context;
  const Classification made = test::classified(shaken(torus(2, 0.5, 16, 8)), context);
  CarvingReport eager;
  carve(made.complement, made.voids, {}, context, &eager);
  EXPECT_GE(eager.snaking, 1);
  EXPECT_GE(eager.spiking, 0);
  EXPECT_LE(eager.spiking, 1);
  // Level by level, nothing is reached by a detour.
  CarvingOptions by_level;
  by_level.depth_power = 100;
  by_level.exposed = false;
  CarvingReport even;
  carve(made.complement, made.voids, by_level, context, &even);
  EXPECT_DOUBLE_EQ(even.snaking, 1);
}

TEST(Carve, IsTheSameOnOneThreadAndOnTwo) {
  RunContext one;
  RunContext two;
  two.threads = 2;
  const TriangleSoup model = icosphere(Point(1, 2, 3), 1, 3);
  const TriangleSoup pair = test::joined({model, icosphere(Point(4, 2, 3), 1, 3)});
  const Classification made = test::classified(pair, one);
  CarvingOptions options;
  options.depth_power = 2;
  options.depth_measure = DepthMeasure::kDistance;
  EXPECT_EQ(carve(made.complement, made.voids, options, one), carve(made.complement, made.voids, options, two));
}

}  // namespace
}  // namespace voxcarve
