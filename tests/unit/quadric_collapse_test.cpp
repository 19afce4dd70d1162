// The loop of the reduction against slow, obvious twins that keep the planes themselves in lists.
#include "common/mesh/quadric_collapse.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>
#include <random>

#include "common/mesh/aabb_tree.h"
#include "common/mesh/cost_buckets.h"
#include "common/mesh/models/primitives.h"
#include "common/mesh/topology.h"

namespace voxcarve {
namespace {

using Eigen::Vector3d;

/// A sphere with bumps: no two edges cost the same.
TriangleSoup bumpy_sphere(int subdivision) {
  TriangleSoup soup = icosphere(Point::Zero(), 1, subdivision);
  for (Point& p : soup.positions) {
    p *= 0.4 * (1 + 0.1 * std::sin(5 * p[0] + 1) * std::sin(4 * p[1] - 2) + 0.07 * std::cos(6 * p[2] + p[0]));
  }
  return soup;
}

struct Plane {
  Vector3d normal;
  Vector3d point;
  double weight;
};
using Planes = std::vector<Plane>;

std::vector<Planes> planes_by_vertex(const TriangleSoup& soup) {
  std::vector<Planes> planes(soup.positions.size());
  for (const Triangle& t : soup.triangles) {
    const Vector3d area = area_vector(soup, t);
    for (const std::uint32_t v : t) planes[v].push_back({area.normalized(), soup.positions[v], 0.5 * area.norm()});
  }
  return planes;
}

Planes united(const Planes& first, const Planes& second) {
  Planes result = first;
  result.insert(result.end(), second.begin(), second.end());
  return result;
}

double weight_of(const Planes& planes) {
  double sum = 0;
  for (const Plane& plane : planes) sum += plane.weight;
  return sum;
}

double cost_at(const Planes& planes, const Vector3d& at) {
  double sum = 0;
  for (const Plane& plane : planes) sum += plane.weight * std::pow(plane.normal.dot(at - plane.point), 2);
  return sum;
}

/// Where the weighted squared distances to the planes are least, by orthogonal decomposition, as seen from `origin`.
Vector3d nearest_to(const Planes& planes, const Vector3d& origin) {
  Eigen::MatrixXd rows(planes.size(), 3);
  Eigen::VectorXd right(planes.size());
  for (std::size_t i = 0; i < planes.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    rows.row(row) = std::sqrt(planes[i].weight) * planes[i].normal.transpose();
    right[row] = std::sqrt(planes[i].weight) * planes[i].normal.dot(planes[i].point - origin);
  }
  return origin + Vector3d(rows.completeOrthogonalDecomposition().solve(right));
}

QuadricCollapse<3> collapse_of(const TriangleSoup& soup) {
  const RunContext context;
  const std::vector<Planes> planes = planes_by_vertex(soup);
  std::vector<Quadric<3>> quadrics(planes.size());
  for (std::size_t v = 0; v < planes.size(); ++v) {
    for (const Plane& plane : planes[v]) quadrics[v] += Quadric<3>::of_plane(plane.normal, plane.weight);
  }
  return {*CornerTable::build(soup.triangles, soup.positions.size(), context), soup.positions, std::move(quadrics)};
}

TriangleSoup soup_of(const QuadricCollapse<3>& collapse) {
  TriangleSoup soup;
  for (std::uint32_t v = 0; v < collapse.table().vertices(); ++v) soup.positions.push_back(collapse.point(v));
  for (std::uint32_t t = 0; t < collapse.table().slots(); ++t) soup.triangles.push_back(collapse.table().corners(t));
  return soup;
}

/// Renames the end of the edge to its start, and moves that.
TriangleSoup collapsed(TriangleSoup soup, std::uint32_t start, std::uint32_t end, const Vector3d& point) {
  soup.positions[start] = point;
  for (Triangle& t : soup.triangles) std::replace(t.begin(), t.end(), end, start);
  std::erase_if(soup.triangles, [](const Triangle& t) { return !has_distinct_corners(t); });
  return soup;
}

/// No triangle turns by a right angle or more; the topology stays.
bool is_legal(const TriangleSoup& before, std::uint32_t start, std::uint32_t end, const Vector3d& point) {
  for (Triangle t : before.triangles) {
    const Vector3d old_area = area_vector(before, t);
    std::replace(t.begin(), t.end(), end, start);
    if (!has_distinct_corners(t) || std::find(t.begin(), t.end(), start) == t.end()) continue;
    TriangleSoup moved;
    for (const std::uint32_t v : t) moved.positions.push_back(v == start ? point : Vector3d(before.positions[v]));
    if (!(area_vector(moved, {0, 1, 2}).dot(old_area) > 0)) return false;
  }
  const SurfaceTopology topology = analyze_topology(collapsed(before, start, end, point));
  return topology.closed && topology.nonmanifold_vertices == 0 && topology.euler_characteristic == 2 &&
         topology.triangles + 2 == static_cast<std::int64_t>(before.triangles.size());
}

/// Evaluates every edge anew before every collapse.
TriangleSoup eager_reduction(TriangleSoup soup, std::size_t triangles) {
  std::vector<Planes> planes = planes_by_vertex(soup);
  while (soup.triangles.size() > triangles) {
    struct Candidate {
      double priority;
      std::uint32_t start, end;
      Vector3d point;
    };
    std::vector<Candidate> candidates;
    for (const Triangle& t : soup.triangles) {
      for (std::size_t c = 0; c < 3; ++c) {
        const std::uint32_t start = t[c];
        const std::uint32_t end = t[(c + 1) % 3];
        if (start > end) continue;
        const Planes both = united(planes[start], planes[end]);
        const Vector3d point = nearest_to(both, 0.5 * (soup.positions[start] + soup.positions[end]));
        candidates.push_back({cost_at(both, point) / std::sqrt(weight_of(both)), start, end, point});
      }
    }
    std::sort(candidates.begin(), candidates.end(),
              [](const Candidate& a, const Candidate& b) { return a.priority < b.priority; });
    const auto best = std::find_if(candidates.begin(), candidates.end(),
                                   [&](const Candidate& c) { return is_legal(soup, c.start, c.end, c.point); });
    if (best == candidates.end()) break;
    planes[best->start] = united(planes[best->start], planes[best->end]);
    soup = collapsed(std::move(soup), best->start, best->end, best->point);
  }
  return soup;
}

/// Mean squared distance of vertices and centres of the triangles to the other surface, both ways.
double squared_error(const TriangleSoup& a, const TriangleSoup& b) {
  double total = 0;
  for (const auto& [from, to] : {std::pair(&a, &b), std::pair(&b, &a)}) {
    const AabbTree tree(*to);
    double sum = 0;
    double area = 0;
    for (const Triangle& t : from->triangles) {
      const double weight = area_vector(*from, t).norm();
      Point center = Point::Zero();
      for (const std::uint32_t v : t) {
        center += from->positions[v] / 3;
        sum += weight / 4 * tree.nearest(from->positions[v]).squared_distance;
      }
      sum += weight / 4 * tree.nearest(center).squared_distance;
      area += weight;
    }
    total += sum / area / 2;
  }
  return total;
}

TEST(QuadricCollapse, PutsEveryMergedVertexWhereThePlanesAreNearest) {
  const TriangleSoup soup = bumpy_sphere(2);
  const auto triangles = static_cast<std::uint32_t>(soup.triangles.size());
  QuadricCollapse<3> collapse = collapse_of(soup);
  TriangleSoup twin = soup;
  std::vector<Planes> planes = planes_by_vertex(soup);
  int collapses = 0;
  int on_optimum = 0;
  collapse.watcher = [&](const CornerTable&, const QuadricCollapseEvent<3>& event) {
    ++collapses;
    const Planes both = united(planes[event.start], planes[event.end]);
    const Vector3d middle = 0.5 * (twin.positions[event.start] + twin.positions[event.end]);
    const double length = (twin.positions[event.start] - twin.positions[event.end]).norm();
    const Vector3d best = nearest_to(both, middle);
    EXPECT_NEAR(cost_at(both, event.point), event.cost, 1e-12 * event.cost + 1e-17);
    EXPECT_TRUE(is_legal(twin, event.start, event.end, event.point));
    if ((best - middle).norm() < 2 * length) {  // farther away it is given up for an end or the middle
      ++on_optimum;
      EXPECT_NEAR(event.cost, cost_at(both, best), 1e-6 * event.cost + 1e-16);
    }
    planes[event.start] = both;
    twin = collapsed(std::move(twin), event.start, event.end, event.point);
  };
  RunContext context;
  Stage stage(context, "test", triangles);
  collapse.run(triangles / 2, stage);  // one round, after which vertices get new numbers
  EXPECT_EQ(collapses, static_cast<int>(triangles) / 4);
  EXPECT_GT(on_optimum, collapses * 9 / 10);
  EXPECT_EQ(collapse.table().triangles(), twin.triangles.size());
  for (std::uint32_t t = 0; t < collapse.table().slots(); ++t) {
    const Triangle corner = collapse.table().corners(t);
    for (std::size_t c = 0; c < 3; ++c) EXPECT_EQ(collapse.point(corner[c]), twin.positions[twin.triangles[t][c]]);
  }
}

TEST(QuadricCollapse, IsAsGoodAsTheEagerOrder) {
  // Equal errors cannot be expected, since buckets change the order of what costs nearly the same.
  const TriangleSoup soup = bumpy_sphere(2);
  for (const std::uint32_t triangles : {160U, 80U, 40U}) {
    QuadricCollapse<3> collapse = collapse_of(soup);
    RunContext context;
    Stage stage(context, "test", 320);
    collapse.run(triangles, stage);
    EXPECT_EQ(collapse.table().triangles(), triangles);
    const double lazy = squared_error(soup, soup_of(collapse));
    const double eager = squared_error(soup, eager_reduction(soup, triangles));
    EXPECT_LT(lazy, 1.15 * eager) << triangles;
    EXPECT_GT(lazy, 0.8 * eager) << triangles;
  }
}

TEST(QuadricCollapse, RemembersWhereTrianglesAndVerticesCameFrom) {
  const TriangleSoup soup = bumpy_sphere(3);
  QuadricCollapse<3> collapse = collapse_of(soup);
  RunContext context;
  Stage stage(context, "test", 1280);
  collapse.run(200, stage);
  int unmoved = 0;
  for (std::uint32_t v = 0; v < collapse.table().vertices(); ++v) {
    if (collapse.vertex_source(v) == CornerTable::kNone) continue;
    ++unmoved;
    EXPECT_EQ(collapse.point(v), soup.positions[collapse.vertex_source(v)]);
  }
  EXPECT_LT(unmoved, 50);
  for (std::uint32_t t = 1; t < collapse.table().slots(); ++t) {
    EXPECT_LT(collapse.triangle_source(t - 1), collapse.triangle_source(t));  // in the order of the input
  }
}

TEST(CostBuckets, GiveItemsInTheOrderOfTheirCosts) {
  std::mt19937 random(1);
  std::vector<double> costs = {0, -1, std::nan(""), 1e-300, 1e300, std::numeric_limits<double>::infinity()};
  for (int i = 0; i < 2000; ++i) costs.push_back(std::exp(std::uniform_real_distribution<double>(-60, 60)(random)));
  const auto value_of = [&](std::uint32_t item) { return costs[item] > 0 ? costs[item] : 0.0; };
  for (const int coarseness : {0, 4}) {
    CostBuckets buckets;
    for (std::uint32_t i = 0; i < costs.size(); ++i) buckets.push(i, costs[i]);
    std::vector<std::uint32_t> items;
    double before = 0;
    std::size_t count = 0;
    while (buckets.take(items, coarseness)) {
      ASSERT_FALSE(items.empty());
      EXPECT_TRUE(std::is_sorted(items.begin(), items.end()));
      double least = std::numeric_limits<double>::infinity();
      double most = 0;
      for (const std::uint32_t item : items) {
        least = std::min(least, value_of(item));
        most = std::max(most, value_of(item));
      }
      EXPECT_GE(least, before);
      // Float holds 1e-38 to 3e38; what lies beyond is together with 0 or the most. Rounding may add 2^-24.
      if (least > 1e-37 && most < 1e38) {
        EXPECT_LT(most, least * (coarseness == 0 ? 1 + 1.0 / 16 : 2) * (1 + 0x1p-23));
      }
      before = least;
      count += items.size();
    }
    EXPECT_EQ(count, costs.size());
    EXPECT_FALSE(buckets.take(items, 0));
  }
}

TEST(CostBuckets, NeverGoBack) {
  CostBuckets buckets;
  std::vector<std::uint32_t> items;
  buckets.push(1, 8);
  buckets.push(2, 64);
  ASSERT_TRUE(buckets.take(items, 0));
  EXPECT_EQ(items, (std::vector<std::uint32_t>{1}));
  buckets.push(7, 2);  // below the current bucket: enters there, with the one that is cheapest by word
  buckets.push_now(5);
  ASSERT_TRUE(buckets.take(items, 0));
  EXPECT_EQ(items, (std::vector<std::uint32_t>{5, 7}));
  buckets.push(9, 64);
  buckets.rename([](std::uint32_t item) { return item == 2 ? 0xffffffffU : item + 100; });
  ASSERT_TRUE(buckets.take(items, 0));
  EXPECT_EQ(items, (std::vector<std::uint32_t>{109}));
  EXPECT_FALSE(buckets.take(items, 0));
}

}  // namespace
}  // namespace voxcarve
