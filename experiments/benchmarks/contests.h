// What `./dev bench` runs: one function a stage. Inputs are made when a contest is run, not when it is listed.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "experiments/benchmarks/harness.h"

namespace voxcarve::bench {

std::vector<Contest> voxelization_contests(const Scope& scope);
std::vector<Contest> isosurface_contests(const Scope& scope);
/// The ball kernel, distance transforms, labelling, and Mason on the paper's largest grid.
std::vector<Contest> morphology_contests(const Scope& scope);
/// The Gaussian low-pass filter of fields.
std::vector<Contest> filter_contests(const Scope& scope);
/// Filtered densities of solids.
std::vector<Contest> low_pass_contests(const Scope& scope);
std::vector<Contest> reduction_contests(const Scope& scope);
/// The paper's blade from polygons to 200 triangles, stage by stage, and what it takes of memory.
std::vector<Contest> pipeline_contests(const Scope& scope);
/// Carving beside TetGen, its growth and memory, and extraction from a stream.
std::vector<Contest> carving_contests(const Scope& scope);
/// Metrics, without a peer here.
std::vector<Contest> other_contests(const Scope& scope);

/// One size of a growing input, run by ours alone.
struct GrowthPoint {
  std::string work;
  double size = 0;  ///< in the unit of its series
  std::function<TimedRun()> prepare;
  int iterations = 1;
};

/// A contest a point; notes tell the nanoseconds a unit and how the time grows since the point before. `afterwards` is
/// given the median seconds of all points when all of them ran.
std::vector<Contest> growth_contests(const std::string& stage, const std::string& unit, int threads,
                                     std::vector<GrowthPoint> points,
                                     std::function<void(std::span<const double>, Tables&)> afterwards = {});

}  // namespace voxcarve::bench
