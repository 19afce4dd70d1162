#include "common/mesh/quadric.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>
#include <vector>

namespace voxcarve {
namespace {

using Eigen::Vector3d;
using Vector6d = Eigen::Matrix<double, 6, 1>;

struct Plane {
  Vector3d normal;
  Vector3d point;
  double weight;
  double squared_distance(const Vector3d& at) const { return weight * std::pow(normal.dot(at - point), 2); }
};

template <int N>
Eigen::Matrix<double, N, 1> random_vector(std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  Eigen::Matrix<double, N, 1> vector;
  for (int i = 0; i < N; ++i) vector[i] = uniform(random);
  return vector;
}

Plane random_plane(std::mt19937& random, const Vector3d& through) {
  return {random_vector<3>(random).normalized(), through, std::uniform_real_distribution<double>(0.1, 2)(random)};
}

TEST(Quadric, IsTheSumOfSquaredDistancesToPlanes) {
  // Two vertices with five planes each; everything that a collapse does to their quadrics against the sum over planes.
  std::mt19937 random(1);
  for (int trial = 0; trial < 50; ++trial) {
    const Vector3d first = random_vector<3>(random);
    const Vector3d second = random_vector<3>(random);
    std::vector<Plane> planes;
    Quadric<3> at_first, at_second;
    for (int i = 0; i < 5; ++i) {
      planes.push_back(random_plane(random, first));
      at_first += Quadric<3>::of_plane(planes.back().normal, planes.back().weight);
      planes.push_back(random_plane(random, second));
      at_second += Quadric<3>::of_plane(planes.back().normal, planes.back().weight);
    }
    const Vector3d half = 0.5 * (second - first);
    const Quadric<3> sum = Quadric<3>::sum_about_middle(at_first, at_second, half);
    Quadric<3> same = at_first.moved(half);
    same += at_second.moved(-half);
    for (int i = 0; i < 5; ++i) {
      const Vector3d point = random_vector<3>(random);
      double expected = 0;
      for (const Plane& plane : planes) expected += plane.squared_distance(point);
      const Vector3d displacement = point - (first + half);
      EXPECT_NEAR(sum(displacement), expected, 1e-13 * (1 + expected));
      EXPECT_NEAR(same(displacement), expected, 1e-13 * (1 + expected));
      const Vector3d step = random_vector<3>(random);
      EXPECT_NEAR(sum.moved(step)(displacement - step), expected, 1e-12 * (1 + expected));
    }
    double trace = 0;
    for (const Plane& plane : planes) trace += plane.weight;  // n n' has trace 1
    EXPECT_NEAR(sum.trace(), trace, 1e-13 * trace);
  }
}

TEST(Quadric, IsLeastWhereLeastSquaresSays) {
  // sqrt(w) n . x = sqrt(w) n . p in the sense of least squares, by orthogonal decomposition.
  std::mt19937 random(2);
  for (int trial = 0; trial < 50; ++trial) {
    Eigen::MatrixXd rows(8, 3);
    Eigen::VectorXd right(8);
    Quadric<3> quadric;
    for (int i = 0; i < 8; ++i) {
      const Plane plane = random_plane(random, random_vector<3>(random));
      rows.row(i) = std::sqrt(plane.weight) * plane.normal.transpose();
      right[i] = std::sqrt(plane.weight) * plane.normal.dot(plane.point);
      quadric += Quadric<3>::of_plane(plane.normal, plane.weight).moved(-plane.point);  // about the origin
    }
    const Vector3d expected = rows.completeOrthogonalDecomposition().solve(right);
    const auto [displacement, value] = quadric.minimum();
    // The regularisation of 1e-10 of the trace moves it by the trace over the least eigenvalue more, some 100 here.
    EXPECT_LT((displacement - expected).norm(), 1e-7);
    EXPECT_NEAR(value, (rows * expected - right).squaredNorm(), 1e-9);
    EXPECT_NEAR(value, quadric(displacement), 1e-12);
  }
}

TEST(Quadric, StaysNearTheOriginAlongFlatDirections) {
  // One plane z = 0.3 seen from the origin: the nearest of its points. Two planes: the nearest point of their line.
  Quadric<3> plane = Quadric<3>::of_plane(Vector3d::UnitZ(), 2).moved(Vector3d(0, 0, -0.3));
  EXPECT_LT((plane.minimum().displacement - Vector3d(0, 0, 0.3)).norm(), 1e-9);
  plane += Quadric<3>::of_plane(Vector3d::UnitX(), 5).moved(Vector3d(-0.7, 0, 0));
  EXPECT_LT((plane.minimum().displacement - Vector3d(0.7, 0, 0.3)).norm(), 1e-9);
  EXPECT_NEAR(plane.minimum().value, 0, 1e-15);  // rounding of 2 * 0.09 + 5 * 0.49, which cancel
}

TEST(Quadric, OfNothingIsZeroAndLeastAtTheOrigin) {
  const Quadric<6> nothing;
  EXPECT_EQ(nothing(Vector6d::Ones()), 0);
  EXPECT_EQ(nothing.minimum().displacement, Vector6d::Zero());
  EXPECT_EQ(nothing.minimum().value, 0);
}

TEST(Quadric, KeepsItsDigitsWhereTermsAboutAFarOriginWouldCancel) {
  // A plane that misses the vertex by 1e-12: its square, 1e-24, is far below the rounding of 1 that a quadric about an
  // origin 1 away has to subtract.
  const auto quadric = Quadric<3>::of_plane(Vector3d::UnitZ(), 1).moved(Vector3d(0.3, -0.2, 1e-12));
  EXPECT_NEAR(quadric(Vector3d(0.1, 0.1, 0)), 1e-24, 1e-36);
}

TEST(Quadric, OfASpanIsTheSquaredDistanceToAPlaneInSixDimensions) {
  std::mt19937 random(3);
  for (int trial = 0; trial < 50; ++trial) {
    const Vector6d first = random_vector<6>(random);
    const Vector6d second = random_vector<6>(random);
    const Vector6d point = random_vector<6>(random);
    Eigen::Matrix<double, 6, 2> span;
    span << first, second;
    const Eigen::Vector2d foot = span.colPivHouseholderQr().solve(point);
    const auto quadric = Quadric<6>::of_span(first, second, 1.5);
    EXPECT_NEAR(quadric(point), 1.5 * (point - span * foot).squaredNorm(), 1e-12);
    EXPECT_NEAR(quadric.trace(), 1.5 * 4, 1e-12);  // four directions leave the plane
  }
}

TEST(Quadric, OfASpanWithoutColoursIsThatOfThePlane) {
  // Where colours are the same, distance in position and colour is distance in position.
  Vector6d first, second, point;
  first << 1, 0, 0, 0, 0, 0;
  second << 1, 2, 0, 0, 0, 0;
  point << 5, -3, 0.25, 0, 0, 0;
  EXPECT_NEAR(Quadric<6>::of_span(first, second, 2)(point), 2 * 0.0625, 1e-14);
  EXPECT_NEAR(Quadric<6>::of_plane(Vector3d::UnitZ(), 2)(point), 2 * 0.0625, 1e-14);
}

TEST(Quadric, OfADegenerateSpanIsTheDistanceToALineOrPoint) {
  const Vector6d axis = Vector6d::Unit(0);
  EXPECT_NEAR(Quadric<6>::of_span(axis, axis, 1)(Vector6d::Ones()), 5, 1e-14);
  EXPECT_NEAR(Quadric<6>::of_span(Vector6d::Zero(), Vector6d::Zero(), 1)(Vector6d::Ones()), 6, 1e-14);
}

}  // namespace
}  // namespace voxcarve
