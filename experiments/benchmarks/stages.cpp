// What every stage of the voxel pipeline and the two dear metrics cost, by size: cost per voxel and per triangle.
#include <benchmark/benchmark.h>

#include "common/mesh/models/primitives.h"
#include "common/mesh/reduction.h"
#include "common/volume/distance_transform.h"
#include "common/volume/isosurface.h"
#include "common/volume/labelling.h"
#include "common/volume/morphology.h"
#include "common/volume/voxelize.h"
#include "metrics/metric.h"

namespace voxcarve {
namespace {

/// A torus, whose genus, extent and curvature are in every way ordinary.
TriangleSoup shape(std::int64_t triangles) {
  const int segments = static_cast<int>(std::sqrt(static_cast<double>(triangles)));
  return torus(3, 1.2, segments, std::max(3, segments / 2));
}

BinaryVolume volume(std::int64_t resolution) {
  RunContext context;
  const TriangleSoup soup = shape(20000);
  return voxelize(soup, voxel_frame(bounds(soup), resolution), {.directions = 1, .axis = 2}, context);
}

void count_voxels(benchmark::State& state, const GridFrame& frame) {
  state.counters["voxels"] = static_cast<double>(frame.voxels());
  state.counters["per_voxel"] = benchmark::Counter(
      static_cast<double>(frame.voxels()), benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void voxelization(benchmark::State& state) {
  const TriangleSoup soup = shape(state.range(1));
  const GridFrame frame = voxel_frame(bounds(soup), state.range(0));
  const VoxelizeOptions options{.classifier = Classifier::kParity, .directions = static_cast<int>(state.range(2))};
  RunContext context;
  context.threads = 2;
  for (auto _ : state) benchmark::DoNotOptimize(voxelize(soup, frame, options, context));
  count_voxels(state, frame);
}
BENCHMARK(voxelization)
    ->ArgNames({"resolution", "triangles", "directions"})
    ->ArgsProduct({{128, 256}, {10000, 100000}, {3, 13}})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

void distance_transform(benchmark::State& state) {
  const BinaryVolume binary = volume(state.range(0));
  RunContext context;
  context.threads = 2;
  for (auto _ : state) benchmark::DoNotOptimize(squared_distance(binary, 1, context));
  count_voxels(state, binary.frame);
}
BENCHMARK(distance_transform)->ArgName("resolution")->Arg(128)->Arg(256)->Unit(benchmark::kMillisecond)->UseRealTime();

void closing(benchmark::State& state) {
  const BinaryVolume binary = volume(state.range(0));
  RunContext context;
  context.threads = 2;
  for (auto _ : state) benchmark::DoNotOptimize(close(binary, static_cast<double>(state.range(1)), context));
  count_voxels(state, binary.frame);
}
BENCHMARK(closing)
    ->ArgNames({"resolution", "distance"})
    ->Args({256, 3})
    ->Args({256, 10})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

void marching_cubes(benchmark::State& state) {
  const BinaryVolume binary = volume(state.range(0));
  RunContext context;
  for (auto _ : state) benchmark::DoNotOptimize(isosurface(binary, context));
  count_voxels(state, binary.frame);
}
BENCHMARK(marching_cubes)->ArgName("resolution")->Arg(128)->Arg(256)->Unit(benchmark::kMillisecond)->UseRealTime();

void labelling(benchmark::State& state) {
  const BinaryVolume binary = volume(state.range(0));
  RunContext context;
  for (auto _ : state) benchmark::DoNotOptimize(label_components(binary, 1, Connectivity::kFace, context));
  count_voxels(state, binary.frame);
}
BENCHMARK(labelling)->ArgName("resolution")->Arg(128)->Arg(256)->Unit(benchmark::kMillisecond)->UseRealTime();

void reduction_openmesh(benchmark::State& state) {
  const TriangleSoup soup = shape(state.range(0));
  RunContext context;
  for (auto _ : state) benchmark::DoNotOptimize(reduce_openmesh(soup, 1000, context));
}
BENCHMARK(reduction_openmesh)
    ->ArgName("triangles")
    ->Arg(20000)
    ->Arg(100000)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

void pair_metrics(benchmark::State& state) {
  const TriangleSoup a = shape(state.range(0));
  const TriangleSoup b = shape(state.range(0) / 4);
  RunContext context;
  context.threads = 2;
  for (auto _ : state) benchmark::DoNotOptimize(measure_pair(a, b, {}, context));
}
BENCHMARK(pair_metrics)->ArgName("triangles")->Arg(20000)->Arg(100000)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace voxcarve
