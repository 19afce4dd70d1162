#include "experiments/benchmarks/growth.h"

#include <Eigen/Core>
#include <Eigen/QR>
#include <cmath>
#include <limits>

namespace voxcarve::bench {

VoxelizationCosts fit_costs(std::span<const VoxelizationSample> samples) {
  // Each row is divided by its seconds: the right-hand side is 1 throughout and residuals are relative.
  Eigen::MatrixX3d counts(static_cast<Eigen::Index>(samples.size()), 3);
  for (Eigen::Index row = 0; row < counts.rows(); ++row) {
    const VoxelizationSample& sample = samples[static_cast<std::size_t>(row)];
    counts.row(row) = Eigen::RowVector3d(sample.triangles, sample.columns, sample.voxels) * (1e-9 / sample.seconds);
  }
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(counts.rows());
  VoxelizationCosts best;
  double least = std::numeric_limits<double>::infinity();
  for (unsigned subset = 1; subset < 8; ++subset) {
    Eigen::MatrixX3d part = counts;
    for (Eigen::Index c = 0; c < 3; ++c) {
      if ((subset >> c & 1U) == 0) part.col(c).setZero();
    }
    const Eigen::Vector3d costs = part.colPivHouseholderQr().solve(ones);  // 0 for a column of zeros
    const Eigen::VectorXd residual = part * costs - ones;
    if ((costs.array() < 0).any() || residual.squaredNorm() >= least) continue;
    least = residual.squaredNorm();
    best = {costs[0], costs[1], costs[2], residual.cwiseAbs().maxCoeff()};
  }
  return best;
}

double growth_exponent(double size, double seconds, double larger_size, double its_seconds) {
  return std::log(its_seconds / seconds) / std::log(larger_size / size);
}

}  // namespace voxcarve::bench
