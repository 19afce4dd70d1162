#include "common/mesh/models/implicit_shapes.h"

#include <numbers>

namespace voxcarve {

double box_clearance(const Point& p, const Box& box) {
  const Point beyond = (box.lower - p).cwiseMax(p - box.upper);
  const double most = beyond.maxCoeff();
  return most > 0 ? beyond.cwiseMax(0.0).norm() : most;
}

Box RoundPrism::bounds() const {
  Point lower;
  Point upper;
  lower[axis] = low;
  upper[axis] = high;
  lower[(axis + 1) % 3] = center[0] - radius;
  upper[(axis + 1) % 3] = center[0] + radius;
  lower[(axis + 2) % 3] = center[1] - half_length - radius;
  upper[(axis + 2) % 3] = center[1] + half_length + radius;
  return {lower, upper};
}

namespace {

/// The arc tangent by its series, for |t| <= tan(pi / 16) = 0.1989: the first term left out, t^23 / 23, is below 4e-18.
double small_arc_tangent(double t) {
  constexpr int kTerms = 11;
  const double square = t * t;
  double sum = 0;
  for (int k = kTerms - 1; k >= 0; --k) sum = sum * -square + 1.0 / (2 * k + 1);
  return t * sum;
}

}  // namespace

double turns_of(double x, double y) {
  constexpr double kTangentOfEighth = 0.41421356237309504880;     // tan(pi / 8), a sixteenth of a turn
  constexpr double kTangentOfSixteenth = 0.19891236737965800691;  // tan(pi / 16)
  constexpr double kTangentOfThree = 0.66817863791929891999;      // tan(3 pi / 16)
  const double large = std::max(std::abs(x), std::abs(y));
  const double t = std::min(std::abs(x), std::abs(y)) / large;
  // The angle within the octant, 0 to 1/8 of a turn, from the nearest of 0, 1/16 and 1/8.
  double start = 0;
  double tangent = 0;
  if (t > kTangentOfThree) {
    start = 0.125;
    tangent = 1;
  } else if (t > kTangentOfSixteenth) {
    start = 0.0625;
    tangent = kTangentOfEighth;
  }
  double turns = start + small_arc_tangent((t - tangent) / (1 + t * tangent)) / (2 * std::numbers::pi);
  if (std::abs(y) > std::abs(x)) turns = 0.25 - turns;
  if (x < 0) turns = 0.5 - turns;
  if (y < 0) turns = 1 - turns;
  return turns;
}

}  // namespace voxcarve
