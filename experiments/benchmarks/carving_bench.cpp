// Carving: what it costs beside TetGen, how that grows, and the extraction of a level.
#include <fmt/format.h>

#include <memory>

#include "common/mesh/arrangement.h"
#include "experiments/benchmarks/contests.h"
#include "experiments/benchmarks/peak_memory.h"
#include "experiments/benchmarks/shapes.h"
#include "methods/hagbi_elsana/stream.h"
#include "methods/hagbi_elsana/valid_complex.h"

namespace voxcarve::bench {

namespace {

/// A model, its complex and its tetrahedra.
struct Prepared {
  TriangleSoup soup;
  Arrangement arrangement;
  Tetrahedralization tetrahedralization;
};

/// A ball with bumps: no four vertices of which lie on a sphere or in a plane, which would slow TetGen down.
Lazy<Prepared> bumpy(std::int64_t vertices) {
  return Lazy<Prepared>([=] {
    RunContext context;
    context.threads = 2;
    Prepared made;
    made.soup = bumpy_ball(2 * vertices);
    made.arrangement = arrange(made.soup, context);
    made.tetrahedralization = tetrahedralize(made.arrangement.complex, FacetSplitting::kNone, {}, context);
    return made;
  });
}

/// All that the method does beside TetGen.
CarvingStream all_but_tetgen(const Prepared& input, RunContext& context) {
  const Arrangement arrangement = arrange(input.soup, context);
  Classification classified =
      classify(input.tetrahedralization, arrangement.complex, arrangement.multiplicity, InsideRule::kWinding, context);
  std::vector<std::uint32_t> steps = carve(classified.complement, classified.voids, {}, context);
  return {std::move(classified.complement), std::move(steps), "", context};
}

Contest overhead_contest(std::int64_t vertices, std::optional<double> goal) {
  const Lazy<Prepared> input = bumpy(vertices);
  Contest contest{
      "carving", fmt::format("{} vertices beside TetGen", short_count(static_cast<double>(vertices))), {}, {}, {}};
  for (const int threads : {1, 2}) {
    contest.contestants.push_back({"voxcarve", threads, prepared_call(input, threads, all_but_tetgen)});
  }
  contest.contestants.push_back({"TetGen", 1, prepared_call(input, 1, [](const Prepared& made, RunContext& context) {
                                   return tetrahedralize(made.arrangement.complex, FacetSplitting::kNone, {}, context);
                                 })});
  contest.contestants.back().warm_up = false;
  const auto note = [=] {
    return fmt::format("{} tetrahedra; arrangement, classification, carving and stream against TetGen alone",
                       with_thousands(std::ssize(input.get().tetrahedralization.tetrahedra)));
  };
  contest.rows = {{0, 2, goal, note}, {1, 2, goal, note}};
  return contest;
}

std::vector<Contest> growth(const Scope& scope) {
  std::vector<GrowthPoint> points;
  for (const std::int64_t vertices : scope.quick ? std::vector<std::int64_t>{1000, 4000}
                                                 : std::vector<std::int64_t>{10000, 30000, 100000, 300000, 1000000}) {
    points.push_back({fmt::format("by vertices: {}", short_count(static_cast<double>(vertices))),
                      static_cast<double>(vertices), prepared_call(bumpy(vertices), 1, all_but_tetgen)});
  }
  return growth_contests("carving", "vertex", 1, std::move(points));
}

/// Memory of classification, carving and stream, beside their input.
Contest memory_contest(const Scope& scope) {
  constexpr double kBytes = 200;
  const std::int64_t vertices = scope.size(100000, 2000);
  const Lazy<Prepared> input = bumpy(vertices);
  const auto bytes = std::make_shared<std::optional<double>>();
  Contest contest{"carving", fmt::format("{} vertices memory", short_count(static_cast<double>(vertices))), {}, {}, {}};
  Contestant ours{"voxcarve", 1, {}};
  ours.warm_up = false;
  ours.prepare = [=] {
    const Prepared& made = input.get();
    return [=, &made] {
      RunContext context;
      const PeakMemory memory;
      const auto run = timed([&] { return all_but_tetgen(made, context); });
      if (const auto growth = memory.growth()) {
        *bytes = static_cast<double>(*growth) / static_cast<double>(made.tetrahedralization.tetrahedra.size());
      }
      return run.seconds;
    };
  };
  contest.contestants = {ours};
  contest.rows = {{0, {}, {}, {}}};
  contest.afterwards = [=, work = contest.work](Tables& tables) {
    tables.errors.push_back(
        {"carving peak memory T1 (bytes a tetrahedron)", work, *bytes, "", {}, {}, scope.goal(kBytes)});
  };
  return contest;
}

/// A level in the middle of a long stream.
Contest extraction_contest(const Scope& scope) {
  constexpr double kMilliseconds = 10;
  const std::int64_t vertices = scope.size(100000, 2000);
  const Lazy<CarvingStream> stream([=] {
    RunContext context;
    context.threads = 2;
    return all_but_tetgen(bumpy(3 * vertices).get(), context);
  });
  const auto recorded = std::make_shared<std::vector<double>>();
  Contest contest{"extraction", fmt::format("{} vertices", short_count(static_cast<double>(vertices))), {}, {}, {}};
  for (const int threads : {1, 2}) {
    contest.rows.push_back({contest.contestants.size(), {}, {}, {}});
    contest.contestants.push_back({"voxcarve", threads, [=] {
                                     return [=, &made = stream.get()] {
                                       RunContext context;
                                       context.threads = threads;
                                       const std::uint32_t step = made.step_for_vertices(vertices);
                                       const auto run = timed([&] { return made.extract(step, &context); });
                                       if (threads == 2) recorded->push_back(1e3 * run.seconds);
                                       return run.seconds;
                                     };
                                   }});
    contest.contestants.back().iterations = 10;
  }
  contest.afterwards = [=, work = contest.work](Tables& tables) {
    if (recorded->empty()) return;
    tables.errors.push_back(
        {"extraction T2 (milliseconds)", work, median(*recorded), "", {}, {}, scope.goal(kMilliseconds)});
  };
  return contest;
}

}  // namespace

std::vector<Contest> carving_contests(const Scope& scope) {
  constexpr double kGoal = 1 / 0.3;  // at most 0.3 of TetGen's time
  std::vector<Contest> contests = {memory_contest(scope)};
  for (const std::int64_t vertices :
       scope.quick ? std::vector<std::int64_t>{4000} : std::vector<std::int64_t>{20000, 50000, 100000}) {
    contests.push_back(overhead_contest(vertices, scope.goal(kGoal)));
  }
  for (Contest& contest : growth(scope)) contests.push_back(std::move(contest));
  contests.push_back(extraction_contest(scope));
  return contests;
}

}  // namespace voxcarve::bench
