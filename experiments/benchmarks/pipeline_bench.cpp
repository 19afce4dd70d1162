// The paper's own measurement [NT03, Table 2 and section 6]: the turbine blade on 643 x 300 x 382 voxels, closed by a
// ball of 10 voxels and reduced to 200 triangles; beside it quadric reduction alone. Differs in the model, which is a
// stand-in with as many triangles in a box of the same proportions.
#include <fmt/format.h>

#include <algorithm>

#include "common/mesh/models/primitives.h"
#include "common/mesh/models/procedural.h"
#include "common/run/errors.h"
#include "common/volume/voxelize.h"
#include "experiments/benchmarks/contests.h"
#include "experiments/benchmarks/peak_memory.h"
#include "methods/registry.h"

namespace voxcarve::bench {

namespace {

constexpr double kBytesPerVoxel = 12;  ///< peak memory stays below
constexpr const char* kQslimAlone = "qslim alone";

/// The blade where the catalogue has it, else a torus of 1.7 million triangles that fills the same box.
Model blade() {
  try {
    const ProceduralModel& model = find_procedural_model("blade");
    return {"model:blade", model.build(Parameters::defaults(model.info.parameters))};
  } catch (const ParameterError&) {
    const TriangleSoup ring = torus(3, 1.2, 1860, 464);
    const Point stretch = Point(643, 300, 382).cwiseQuotient(bounds(ring).extent());
    return {"stretched torus", transformed(ring, Eigen::Affine3d(Eigen::Scaling(stretch)))};
  }
}

/// What the runs of one contestant left.
struct Record {
  std::vector<std::vector<StageTiming>> timings;
  std::vector<double> seconds;
  std::uint64_t peak_bytes = 0;
  bool peak_known = true;
};

Contestant contestant(const Lazy<Model>& model, const std::string& method, int threads,
                      const std::vector<std::string>& settings, const std::shared_ptr<Record>& record) {
  Contestant ours{"voxcarve", threads, {}};
  ours.warm_up = false;  // every run stands in the record
  ours.prepare = [=] {
    const Method& runner = find_method(method);
    const Parameters parameters = Parameters::parse(runner.info().parameters, settings, method);
    const Model& input = model.get();
    return [=, &runner, &input] {
      RunContext context;
      context.threads = threads;
      const PeakMemory memory;
      auto made = timed([&] { return runner.run(input, parameters, context); });
      const auto growth = memory.growth();
      record->peak_known = record->peak_known && growth.has_value();
      record->peak_bytes = std::max(record->peak_bytes, growth.value_or(0));
      record->timings.push_back(std::move(made.result.timings));
      record->seconds.push_back(made.seconds);
      return made.seconds;
    };
  };
  return ours;
}

/// Medians of the stages; every run has the same stages in the same order.
std::vector<PipelineRow> stage_rows(const Record& record) {
  std::vector<PipelineRow> rows;
  const double total = median(record.seconds);
  for (std::size_t s = 0; s < record.timings.front().size(); ++s) {
    std::vector<double> seconds;
    for (const auto& timings : record.timings) seconds.push_back(timings.at(s).seconds);
    const StageTiming& first = record.timings.front()[s];
    rows.push_back({first.stage, median(seconds), median(seconds) / total, first.bytes});
  }
  rows.push_back({"whole run", total, 1, record.peak_bytes});
  return rows;
}

}  // namespace

std::vector<Contest> pipeline_contests(const Scope& scope) {
  const std::int64_t resolution = scope.size(643, 160);
  const std::int64_t closing = scope.size(10, 3);
  const Lazy<Model> model([] { return blade(); });
  const std::string size = fmt::format("blade at {} voxels", resolution);

  Contest whole;
  whole.stage = "pipeline";
  whole.work = fmt::format("{} closing {} to 200 triangles", size, closing);
  const std::vector<std::string> settings = {fmt::format("resolution={}", resolution),
                                             "classifier=parity",
                                             "directions=3",
                                             "supersampling=1",
                                             "kernel=box",
                                             "morphology=close",
                                             fmt::format("distance={}", closing),
                                             "triangles=200"};
  const std::array records = {std::make_shared<Record>(), std::make_shared<Record>()};
  for (const int threads : {1, 2}) {
    whole.rows.push_back({whole.contestants.size(), {}, {}, {}});
    whole.contestants.push_back(
        contestant(model, "nooruddin-turk", threads, settings, records.at(static_cast<std::size_t>(threads - 1))));
  }
  whole.afterwards = [=, work = whole.work](Tables& tables) {
    const GridFrame frame = voxel_frame(bounds(*model.get().soup()), resolution);
    tables.remarks.push_back(
        fmt::format("pipeline: {}, {} triangles, {} x {} x {} voxels (the paper: 1,726,892 faces, "
                    "643 x 300 x 382)",
                    model.get().name, with_thousands(static_cast<long long>(model.get().soup()->triangles.size())),
                    frame.dims[0], frame.dims[1], frame.dims[2]));
    for (std::size_t r = 0; r < records.size(); ++r) {
      const Record& record = *records.at(r);
      if (record.seconds.empty()) continue;
      const std::optional<double> bytes =
          record.peak_known
              ? std::optional(static_cast<double>(record.peak_bytes) / static_cast<double>(frame.voxels()))
              : std::nullopt;
      const std::optional<double> limit = scope.quick ? std::nullopt : std::optional(kBytesPerVoxel);
      tables.errors.push_back(
          {fmt::format("pipeline peak memory T{} (bytes a voxel)", r + 1), work, bytes, "", {}, {}, limit});
    }
    if (records[0]->seconds.empty()) return;
    tables.pipeline = stage_rows(*records[0]);
    const auto voxelization = std::ranges::find(tables.pipeline, "voxelization", &PipelineRow::stage);
    if (voxelization == tables.pipeline.end()) return;
    tables.remarks.push_back(
        fmt::format("pipeline, T1: voxelization takes {:.0f} % of the run (the paper: 78 % of the "
                    "blade's, one processor of an SGI Onyx)",
                    100 * voxelization->share));
  };

  Contest alone;
  alone.stage = "pipeline";
  alone.work = fmt::format("blade {} to 200 triangles", kQslimAlone);
  const auto record = std::make_shared<Record>();
  alone.contestants = {contestant(model, "qslim", 1, {"triangles=200"}, record)};
  alone.rows = {{}};
  alone.afterwards = [=](Tables& tables) {
    const double seconds = median(record->seconds);
    if (!tables.pipeline.empty()) {
      const double whole_seconds = tables.pipeline.back().seconds;
      tables.pipeline.push_back({kQslimAlone, seconds, seconds / whole_seconds, record->peak_bytes});
    }
    tables.remarks.push_back(
        fmt::format("pipeline, T1: quadric reduction alone takes {:.3g} s to 200 triangles (the "
                    "paper: 4 min 8 s for the blade, 15 s for the motor of 140,113 faces)",
                    seconds));
  };
  return {whole, alone};
}

}  // namespace voxcarve::bench
