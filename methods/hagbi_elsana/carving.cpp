// Based on [HE10, 3 to 5].
#include "methods/hagbi_elsana/carving.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "common/mesh/aabb_tree.h"
#include "methods/hagbi_elsana/carving_queue.h"
#include "methods/hagbi_elsana/tetrahedron.h"

namespace voxcarve {

namespace {

/// Natural logarithm to a few units in the last place, by operations that IEEE 754 defines: the library's own differ
/// between machines in the last bit, and with it the order of nearly equal tetrahedra. -inf for 0 and less.
double portable_log(double value) {
  if (!(value > 0)) return -std::numeric_limits<double>::infinity();
  if (std::isinf(value)) return value;
  constexpr double kLog2 = 0x1.62e42fefa39efp-1;
  constexpr double kRootHalf = 0x1.6a09e667f3bcdp-1;
  int exponent = 0;
  double mantissa = std::frexp(value, &exponent);  // in [1/2, 1)
  if (mantissa < kRootHalf) {
    mantissa *= 2;
    --exponent;
  }
  // log m = 2 artanh((m - 1) / (m + 1)); the argument is below 0.172, so its 23rd power is below 2^-58.
  const double s = (mantissa - 1) / (mantissa + 1);
  const double square = s * s;
  double sum = 0;
  for (int odd = 21; odd >= 1; odd -= 2) sum = sum * square + 1.0 / odd;
  return exponent * kLog2 + 2 * s * sum;
}

class Carver {
 public:
  Carver(const Complement& complement, const CarvingOptions& options, RunContext& context)
      : mesh_(complement), options_(options), context_(context) {}

  std::vector<std::uint32_t> run(const std::vector<Void>& voids, CarvingReport* report) {
    Stage stage(context_, "carving", std::int64_t{mesh_.first_ghost});
    context_.require_memory(memory(mesh_.size()), "carving");
    prepare();
    compute_quality();
    if (counts_levels()) {
      HeapQueue queue;
      carve_all(queue, voids, stage);
    } else {
      RankQueue queue(rank_);
      decltype(rank_)().swap(rank_);  // assigning {} would keep the memory
      carve_all(queue, voids, stage);
    }
    if (report != nullptr) {
      report->shut_voids = 0;
      for (const Void& found : voids) report->shut_voids += found.volume < options_.smallest_void;
      measure(*report);
    }
    return std::move(step_);
  }

  static std::uint64_t memory(std::uint32_t tetrahedra) {
    return std::uint64_t{tetrahedra} * (sizeof(double) + 2 * sizeof(std::uint32_t) + 1 + RankQueue::kBytes);
  }

 private:
  static constexpr std::int64_t kReportEvery = 1 << 12;

  // A tetrahedron's state, in a byte, so that all of them stay at hand: which of its faces are barriers, whether it is
  // carved, and how many of its faces that are no barriers have the outside beyond them: dC,M(t) of [HE10, 3].
  static constexpr std::uint8_t kCarved = 16;
  static constexpr std::uint8_t kOneOpen = 32;
  static constexpr std::uint8_t kTwoOpen = 2 * kOneOpen;

  /// Does the level at which a tetrahedron is reached count for its priority?
  bool counts_levels() const { return options_.depth_power > 0 && options_.depth_measure == DepthMeasure::kLevel; }

  void prepare() {
    rank_.resize(mesh_.first_ghost);
    depth_.assign(mesh_.first_ghost, 0);
    step_.assign(mesh_.size(), kNeverCarved);
    state_.resize(mesh_.size());
    for (std::uint32_t t = 0; t < mesh_.size(); ++t) {
      std::uint8_t barriers = mesh_.walls[t];
      for (std::size_t i = 0; i < 4; ++i) {
        barriers = static_cast<std::uint8_t>(barriers | (mesh_.neighbors[t][i] == Complement::kSolid ? 1 << i : 0));
      }
      state_[t] = barriers;
    }
    for (std::uint32_t ghost = mesh_.first_ghost; ghost < mesh_.size(); ++ghost) become_outside(ghost, 0);
  }

  template <class Queue>
  void carve_all(Queue& queue, const std::vector<Void>& voids, Stage& stage) {
    for (std::uint32_t t = 0; t < mesh_.first_ghost; ++t) {
      if (state_[t] >= kOneOpen) enqueue(queue, t, 1);
    }
    for (const Void& found : voids) {
      if (found.volume >= options_.smallest_void) enqueue(queue, found.seed, 1);
    }
    std::uint32_t step = 0;
    std::int64_t carved = 0;
    while (!queue.empty()) {
      const std::uint32_t t = queue.pop();
      if constexpr (Queue::kKnowsPriorities) {
        if (!queue.empty()) __builtin_prefetch(&mesh_.neighbors[queue.next()]);
      }
      if (is_carved(t)) continue;
      carve_from(queue, t, ++step);
      carved += static_cast<std::int64_t>(now_.size());
      if (carved >= kReportEvery) {
        stage.advance(carved);
        carved = 0;
      }
    }
    stage.advance(carved);
  }

  /// Priorities without their depth, or their logarithms where depth counts, distances as depth included.
  void compute_quality() {
    std::optional<AabbTree> hull;
    double mean_edge = 0;
    if (options_.depth_power > 0 && options_.depth_measure == DepthMeasure::kDistance) {
      TriangleSoup surface;
      surface.positions = mesh_.points;
      for (std::uint32_t ghost = mesh_.first_ghost; ghost < mesh_.size(); ++ghost) {
        surface.triangles.push_back(mesh_.face(ghost, 3));
      }
      context_.require_memory(
          memory(mesh_.size()) + mesh_.points.size() * sizeof(Point) + 200 * surface.triangles.size(),
          "carving by distance");
      hull.emplace(surface);
      mean_edge = mean_edge_length();
    }
    constexpr std::int64_t kGrain = 1 << 12;
    parallel_for(context_, 0, mesh_.first_ghost, kGrain, [&](std::int64_t begin, std::int64_t end) {
      for (auto t = static_cast<std::uint32_t>(begin); t < static_cast<std::uint32_t>(end); ++t) {
        rank_[t] = quality(t);
        if (options_.depth_power > 0) rank_[t] = portable_log(rank_[t]);
        if (!hull) continue;
        const double squared = hull->nearest(centroid(mesh_.points, mesh_.corners[t])).squared_distance;
        rank_[t] -= options_.depth_power * portable_log(1 + std::sqrt(squared) / mean_edge);
      }
    });
  }

  double quality(std::uint32_t t) const {
    const TetrahedronCorners& corners = mesh_.corners[t];
    switch (options_.priority) {
      case CarvingPriority::kVolume:
        return std::abs(volume(mesh_.points, corners));
      case CarvingPriority::kCircumradiusRatio: {
        const std::array<double, 6> squared = squared_edges(mesh_.points, corners);
        const double shortest = std::sqrt(*std::ranges::min_element(squared));
        const double ratio = shortest / circumradius(mesh_.points, corners);
        return ratio > 0 ? ratio : 0;  // of a flat one, none
      }
      case CarvingPriority::kLongestEdge:
        break;
    }
    return std::sqrt(longest_edge_squared(mesh_.points, corners));
  }

  double mean_edge_length() const {
    double sum = 0;
    for (std::uint32_t t = 0; t < mesh_.first_ghost; ++t) {
      for (const double squared : squared_edges(mesh_.points, mesh_.corners[t])) sum += std::sqrt(squared);
    }
    return mesh_.first_ghost == 0 ? 1 : sum / (6.0 * mesh_.first_ghost);
  }

  bool is_carved(std::uint32_t t) const { return (state_[t] & kCarved) != 0; }

  template <class Queue>
  void enqueue(Queue& queue, std::uint32_t t, std::uint32_t depth) {
    depth_[t] = depth;
    if constexpr (Queue::kKnowsPriorities) {
      queue.push(t);
    } else {
      queue.push(t, rank_[t] - options_.depth_power * portable_log(depth));
    }
  }

  /// One step: `first`, what lies within the breadth of it, and what that exposes.
  template <class Queue>
  void carve_from(Queue& queue, std::uint32_t first, std::uint32_t step) {
    now_.clear();
    mark(first, step, depth_[first]);
    if (options_.breadth > 0) {
      const Point center = centroid(mesh_.points, mesh_.corners[first]);
      const double reach = options_.breadth * options_.breadth;
      for (std::size_t next = 0; next < now_.size(); ++next) {
        if (next % kReportEvery == 0) context_.check_cancelled();
        for_each_beyond(now_[next], [&](std::uint32_t t) {
          if ((centroid(mesh_.points, mesh_.corners[t]) - center).squaredNorm() <= reach) {
            mark(t, step, depth_of(t, now_[next]));
          }
        });
      }
    }
    for (std::size_t next = 0; next < now_.size(); ++next) {
      for_each_beyond(now_[next], [&](std::uint32_t t) {
        if (options_.exposed && state_[t] >= kTwoOpen) {
          mark(t, step, depth_of(t, now_[next]));
        } else if (depth_[t] == 0) {
          enqueue(queue, t, depth_[now_[next]] + 1);
        }
      });
    }
  }

  /// Of a tetrahedron that may have been carvable before.
  std::uint32_t depth_of(std::uint32_t t, std::uint32_t exposer) const {
    return depth_[t] != 0 ? depth_[t] : depth_[exposer] + 1;
  }

  void mark(std::uint32_t t, std::uint32_t step, std::uint32_t depth) {
    depth_[t] = depth;
    become_outside(t, step);
    now_.push_back(t);
  }

  void become_outside(std::uint32_t t, std::uint32_t step) {
    step_[t] = step;
    const std::uint8_t state = state_[t] |= kCarved;
    const std::array<std::uint32_t, 4> around = mesh_.neighbors[t];
    for (std::size_t i = 0; i < 4; ++i) {  // without a branch: barriers follow no pattern
      const bool closed = (state >> i & 1) != 0;
      std::uint8_t& beyond = state_[closed ? t : around[i]];
      beyond = static_cast<std::uint8_t>(beyond + (closed ? 0 : kOneOpen));  // four times at most
    }
  }

  /// The neighbours not carved yet that a way leads to.
  template <class Visit>
  void for_each_beyond(std::uint32_t t, const Visit& visit) const {
    const std::uint8_t state = state_[t];
    const std::array<std::uint32_t, 4> around = mesh_.neighbors[t];
    for (std::size_t i = 0; i < 4; ++i) {
      const bool closed = (state >> i & 1) != 0;
      const std::uint32_t beyond = closed ? t : around[i];  // what was carved itself is not visited
      if (!is_carved(beyond)) visit(beyond);
    }
  }

  void measure(CarvingReport& report) {
    // Level by level, as if by the least numbers of tetrahedra from the hull, and in a void from its seed.
    std::vector<std::uint8_t> reached(mesh_.size(), 0);
    std::fill(reached.begin() + mesh_.first_ghost, reached.end(), std::uint8_t{1});
    std::vector<std::uint32_t> queue(mesh_.first_ghost + std::size_t{1});
    std::size_t end = 0;
    const auto enter = [&](std::uint32_t t) {  // without a branch: one more may be written
      queue[end] = t;
      end += reached[t] == 0;
      reached[t] = 1;
    };
    for (std::uint32_t t = 0; t < mesh_.first_ghost; ++t) {
      if (depth_[t] == 1) enter(t);
    }
    constexpr std::size_t kAhead = 16;
    double ratio = 0;
    std::int64_t carved = 0;
    std::uint32_t least = 1;
    std::size_t level_end = end;
    for (std::size_t next = 0; next < end; ++next) {
      if (next % kReportEvery == 0) context_.check_cancelled();
      if (next == level_end) {
        ++least;
        level_end = end;
      }
      const std::uint32_t ahead = queue[std::min(next + kAhead, end - 1)];
      __builtin_prefetch(&mesh_.neighbors[ahead]);
      __builtin_prefetch(&depth_[ahead]);
      const std::uint32_t t = queue[next];
      if (is_carved(t)) {
        ratio += static_cast<double>(depth_[t]) / least;
        ++carved;
      }
      for (std::size_t i = 0; i < 4; ++i) enter((state_[t] >> i & 1) != 0 ? t : mesh_.neighbors[t][i]);
    }
    if (carved > 0) report.snaking = ratio / static_cast<double>(carved);
    report.spiking = spiking_share();
  }

  /// A step spikes when its first tetrahedron has one face on the outside, and lies deeper behind it than twice that
  /// face's longest edge.
  double spiking_share() const {
    std::int64_t spikes = 0;
    std::int64_t carved = 0;
    for (std::uint32_t t = 0; t < mesh_.first_ghost; ++t) {
      if (step_[t] == kNeverCarved) continue;
      ++carved;
      int earlier = 0;
      int open_face = 0;
      for (int i = 0; i < 4; ++i) {
        if ((state_[t] >> i & 1) != 0 || step_[mesh_.neighbors[t][static_cast<std::size_t>(i)]] >= step_[t]) continue;
        ++earlier;
        open_face = i;
      }
      if (earlier != 1) continue;
      const Triangle face = mesh_.face(t, open_face);
      const Point& a = mesh_.points[face[0]];
      const Point& b = mesh_.points[face[1]];
      const Point& c = mesh_.points[face[2]];
      const Point& apex = mesh_.points[mesh_.corners[t][static_cast<std::size_t>(open_face)]];
      const double longest = std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
      const Point normal = (b - a).cross(c - a);
      const double height = normal.dot(apex - a);  // times the normal's length
      spikes += height * height > 4 * longest * normal.squaredNorm();
    }
    return carved == 0 ? 0 : static_cast<double>(spikes) / static_cast<double>(carved);
  }

  const Complement& mesh_;
  const CarvingOptions& options_;
  RunContext& context_;
  std::vector<double> rank_;
  std::vector<std::uint32_t> depth_;  ///< in levels; 0 until it is carvable
  std::vector<std::uint32_t> step_;
  std::vector<std::uint8_t> state_;
  std::vector<std::uint32_t> now_;  ///< carved in this step
};

}  // namespace

std::vector<std::uint32_t> carve(const Complement& complement, const std::vector<Void>& voids,
                                 const CarvingOptions& options, RunContext& context, CarvingReport* report) {
  return Carver(complement, options, context).run(voids, report);
}

}  // namespace voxcarve
