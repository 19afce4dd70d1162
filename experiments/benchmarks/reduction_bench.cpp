// Reduction by quadrics: time against meshoptimizer, CGAL and OpenMesh, and the error that each leaves.
#include <fmt/format.h>

#include <cmath>
#include <map>

#include "common/mesh/quadric_reduction.h"
#include "common/mesh/reduction.h"
#include "common/mesh/topology.h"
#include "common/volume/isosurface.h"
#include "experiments/benchmarks/contests.h"
#include "experiments/benchmarks/peers.h"
#include "experiments/benchmarks/shapes.h"
#include "metrics/hausdorff.h"

namespace voxcarve::bench {

namespace {

constexpr const char* kStage = "reduction";
constexpr std::int64_t kShare = 100;  ///< one triangle of so many is left

/// Width of the certified Hausdorff interval, whose middle is reported, as a share of the diagonal: a thirtieth of a
/// voxel at a million triangles.
constexpr double kHausdorffError = 5e-5;

/// The ball's isosurface has about 8.2 triangles for every voxel of a face of its grid.
std::int64_t resolution_for(std::int64_t triangles) {
  return std::llround(std::sqrt(static_cast<double>(triangles) / 8.2));
}

TriangleSoup smooth_surface(std::int64_t triangles) {
  RunContext context;
  return isosurface(bumpy_ball_density(resolution_for(triangles)), 0.5F, context);
}

/// Stairs: the surface of a volume without densities.
TriangleSoup binary_surface(std::int64_t triangles) {
  RunContext context;
  return isosurface(thresholded(bumpy_ball_density(resolution_for(triangles)), 0.5F), context);
}

using Results = std::shared_ptr<std::map<std::string, TriangleSoup>>;

TimedRun remembering(ReducingPeer run, const Results& results, const std::string& name) {
  return [=] {
    auto made = run();
    (*results)[name] = std::move(made.result);
    return made.seconds;
  };
}

TriangleSoup reduced_by_ours(const TriangleSoup& surface, std::int64_t triangles, RunContext& context) {
  return reduce_quadric(surface, {.triangles = triangles}, context);
}

/// "9,998 triangles, closed manifold of genus 0", or what is wrong with it.
std::string description(const TriangleSoup& surface) {
  const SurfaceTopology topology = analyze_topology(surface);
  std::string text = with_thousands(static_cast<long long>(surface.triangles.size())) + " triangles, ";
  const std::int64_t singular = topology.nonmanifold_edges + topology.nonmanifold_vertices;
  if (singular == 0 && topology.closed && topology.genus)
    return text + fmt::format("closed manifold of genus {}", *topology.genus);
  return text + fmt::format("{} non-manifold edges, {} non-manifold vertices, {} boundary edges{}",
                            topology.nonmanifold_edges, topology.nonmanifold_vertices, topology.boundary_edges,
                            topology.oriented ? "" : ", not oriented");
}

struct Errors {
  double hausdorff = 0;
  std::optional<double> rms;
};

std::optional<Errors> errors_of(const TriangleSoup& surface, const TriangleSoup& result) {
  RunContext context;
  context.threads = 2;
  const HausdorffOptions options{.error = kHausdorffError, .samples = 100000};
  const auto measured = hausdorff_distances(surface, result, options, context);
  const auto* distances = std::get_if<HausdorffDistances>(&measured);
  if (distances == nullptr) return std::nullopt;
  return Errors{0.5 * (distances->symmetric.lower + distances->symmetric.upper), distances->rms};
}

/// Rows of the errors of every result beside ours.
void add_errors(const std::string& work, const TriangleSoup& surface, const Results& results, bool with_goals,
                Tables& tables) {
  std::map<std::string, std::optional<Errors>> errors;
  for (const auto& [name, result] : *results) {
    errors[name] = errors_of(surface, result);
    tables.remarks.push_back(fmt::format("reduction, {}: {}: {}", work, name, description(result)));
  }
  const auto hausdorff = [&](const std::string& name) -> std::optional<double> {
    const auto entry = errors.find(name);
    return entry != errors.end() && entry->second ? std::optional(entry->second->hausdorff) : std::nullopt;
  };
  const auto rms = [&](const std::string& name) -> std::optional<double> {
    const auto entry = errors.find(name);
    return entry != errors.end() && entry->second ? entry->second->rms : std::nullopt;
  };
  for (const auto& [name, error] : errors) {
    if (name == "voxcarve") continue;
    // "Error no larger than CGAL's Garland-Heckbert".
    const std::optional<double> goal = with_goals && name.starts_with("CGAL") ? std::optional(1.0) : std::nullopt;
    tables.errors.push_back(
        {"reduction hausdorff (voxels)", work, hausdorff("voxcarve"), name, hausdorff(name), goal, {}});
    tables.errors.push_back({"reduction rms (voxels)", work, rms("voxcarve"), name, rms(name), goal, {}});
  }
}

Contest against_peers(const Lazy<TriangleSoup>& surface, const std::string& what, std::int64_t triangles,
                      const Scope& scope) {
  const std::int64_t target = triangles / kShare;
  const auto results = std::make_shared<std::map<std::string, TriangleSoup>>();
  Contest contest;
  contest.stage = kStage;
  contest.work = fmt::format("{} {} to {} triangles", what, short_count(static_cast<double>(triangles)),
                             short_count(static_cast<double>(target)));
  const auto add = [&](const std::string& name, bool at_hand, auto make) {
    Contestant contestant{name, 1, {}};
    if (at_hand) contestant.prepare = [=] { return remembering(make(surface.get(), target), results, name); };
    contest.contestants.push_back(contestant);
  };
  const auto as_peer = [](auto reduce) {
    return [=](const TriangleSoup& input, std::int64_t count) -> ReducingPeer {
      return [=, &input] {
        RunContext context;
        return timed([&] { return reduce(input, count, context); });
      };
    };
  };
  add("voxcarve", true, as_peer(reduced_by_ours));
  add("meshoptimizer", peers_at_hand().meshoptimizer, meshoptimizer_reduction);
  add("CGAL Garland-Heckbert", true, cgal_reduction);
  add("OpenMesh ModQuadric", true, as_peer(reduce_openmesh));
  for (std::size_t slow : {2, 3}) {
    contest.contestants[slow].once = true;
    contest.contestants[slow].warm_up = false;
  }
  contest.rows = {{0, 1, scope.goal(0.5), {}}, {0, 2, {}, {}}, {0, 3, {}, {}}};
  contest.afterwards = [=, work = contest.work](Tables& tables) {
    tables.remarks.push_back(fmt::format("reduction, {}: input: {}", work, description(surface.get())));
    tables.remarks.push_back(
        fmt::format("reduction, {}: Hausdorff distances are the middles of certified intervals of "
                    "{:.3f} voxels",
                    work, kHausdorffError * bounds(surface.get()).diagonal()));
    add_errors(work, surface.get(), results, !scope.quick, tables);
  };
  return contest;
}

}  // namespace

std::vector<Contest> reduction_contests(const Scope& scope) {
  const std::int64_t triangles = scope.size(1000000, 100000);
  std::vector<Contest> contests;
  contests.push_back(
      against_peers(Lazy<TriangleSoup>([=] { return smooth_surface(triangles); }), "smooth", triangles, scope));
  contests.push_back(
      against_peers(Lazy<TriangleSoup>([=] { return binary_surface(triangles); }), "binary", triangles, scope));
  std::vector<GrowthPoint> points;
  for (const std::int64_t count : {10000, 30000, 100000, 300000, 1000000}) {
    if (count > triangles) break;
    const Lazy<TriangleSoup> surface([=] { return smooth_surface(count); });
    points.push_back(
        {fmt::format("by triangles: smooth {} triangles to a hundredth", short_count(static_cast<double>(count))),
         static_cast<double>(count),
         prepared_call(surface, 1,
                       [=](const TriangleSoup& input, RunContext& context) {
                         return reduced_by_ours(input, count / kShare, context);
                       }),
         count <= 30000 ? 5 : 1});
  }
  std::ranges::move(growth_contests(kStage, "triangle", 1, std::move(points)), std::back_inserter(contests));
  return contests;
}

}  // namespace voxcarve::bench
