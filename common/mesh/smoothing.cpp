// Based on [Tau95] with equal weights; differs in the vertices of a boundary, which are filtered as curves of their
// own, so that a border is not drawn in by the surface next to it.
#include "common/mesh/smoothing.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "common/mesh/topology.h"
#include "common/run/errors.h"
#include "common/run/text.h"

namespace voxcarve {

namespace {

constexpr std::int64_t kChunk = 1 << 14;  ///< vertices, about a millisecond
constexpr double kMostGrowth = 2;         ///< of any wave

/// The neighbours that each vertex is averaged with, in ascending order: those of vertex v from first[v] to
/// first[v + 1].
struct Neighbours {
  std::vector<std::size_t> first;
  std::vector<std::uint32_t> vertices;
};

template <class Visit>
void for_each_triangle(const TriangleSoup& surface, const RunContext& context, const Visit& visit) {
  constexpr std::size_t kTrianglesACheck = std::size_t{1} << 16;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    if (t % kTrianglesACheck == 0) context.check_cancelled();
    if (has_distinct_corners(surface.triangles[t])) visit(surface.triangles[t]);
  }
}

/// Reduces a list with one entry for every triangle at an edge to the neighbours to average with, and returns their
/// number. An edge of one triangle is a boundary edge.
std::size_t select_neighbours(std::uint32_t* begin, std::uint32_t* end) {
  std::sort(begin, end);
  const auto run_end = [end](const std::uint32_t* run) {
    return std::find_if(run, static_cast<const std::uint32_t*>(end), [run](std::uint32_t v) { return v != *run; });
  };
  bool on_boundary = false;
  for (const std::uint32_t* run = begin; run != end && !on_boundary; run = run_end(run)) {
    on_boundary = run_end(run) - run == 1;
  }
  std::uint32_t* kept = begin;
  for (const std::uint32_t* run = begin; run != end;) {
    const std::uint32_t* next = run_end(run);
    const std::uint32_t neighbour = *run;
    if (!on_boundary || next - run == 1) *kept++ = neighbour;
    run = next;
  }
  return static_cast<std::size_t>(kept - begin);
}

Neighbours find_neighbours(const TriangleSoup& surface, const RunContext& context) {
  const std::size_t count = surface.positions.size();
  Neighbours neighbours;
  std::vector<std::size_t>& first = neighbours.first;
  std::vector<std::uint32_t>& vertices = neighbours.vertices;
  // first[v + 2] counts, then first[v + 1] is where the list of v is filled, so that first[v] is where it begins.
  first.assign(count + 2, 0);
  for_each_triangle(surface, context, [&first](const Triangle& triangle) {
    for (const std::uint32_t v : triangle) first[v + std::size_t{2}] += 2;
  });
  std::partial_sum(first.begin(), first.end(), first.begin());
  vertices.resize(first.back());
  for_each_triangle(surface, context, [&first, &vertices](const Triangle& triangle) {
    for (std::size_t c = 0; c < 3; ++c) {
      std::size_t& fill = first[triangle[c] + std::size_t{1}];
      vertices[fill++] = triangle[(c + 1) % 3];
      vertices[fill++] = triangle[(c + 2) % 3];
    }
  });

  std::vector<std::uint32_t> selected(count);
  parallel_for(context, 0, static_cast<std::int64_t>(count), kChunk, [&](std::int64_t begin, std::int64_t end) {
    for (auto v = static_cast<std::size_t>(begin); v < static_cast<std::size_t>(end); ++v) {
      selected[v] =
          static_cast<std::uint32_t>(select_neighbours(vertices.data() + first[v], vertices.data() + first[v + 1]));
    }
  });
  std::size_t filled = 0;
  for (std::size_t v = 0; v < count; ++v) {
    const std::size_t list = std::exchange(first[v], filled);
    for (std::size_t n = 0; n < selected[v]; ++n) vertices[filled++] = vertices[list + n];
  }
  first[count] = filled;
  return neighbours;
}

/// to = from + weight (mean of the neighbours - from), for every vertex at once.
void step(const Neighbours& neighbours, double weight, const std::vector<Point>& from, std::vector<Point>& to,
          const RunContext& context, Stage& stage) {
  parallel_for(context, 0, static_cast<std::int64_t>(from.size()), kChunk, [&](std::int64_t begin, std::int64_t end) {
    for (auto v = static_cast<std::size_t>(begin); v < static_cast<std::size_t>(end); ++v) {
      const std::size_t first = neighbours.first[v];
      const std::size_t last = neighbours.first[v + 1];
      if (first == last) {
        to[v] = from[v];
        continue;
      }
      Point sum = Point::Zero();
      for (std::size_t n = first; n < last; ++n) sum += from[neighbours.vertices[n]];
      to[v] = from[v] + weight * (sum / static_cast<double>(last - first) - from[v]);
    }
    stage.advance(end - begin);
  });
}

}  // namespace

void check_options(const TaubinOptions& options) {
  if (options.iterations < 0) throw ParameterError("the number of smoothing iterations must not be negative");
  if (!(options.lambda > 0 && options.lambda < 1)) throw ParameterError("lambda must lie between 0 and 1");
  if (!(options.mu < -options.lambda && std::isfinite(options.mu)))
    throw ParameterError("mu must be less than -lambda, or smoothing shrinks");
  if (options.iterations == 0) return;
  const double sum = options.lambda + options.mu;
  const double product = options.lambda * options.mu;
  const double shortest = 1 - 2 * sum + 4 * product;
  const double largest = 1 - sum * sum / (4 * product);
  constexpr double kRounding = 1e-12;  // lambda and mu at which it is 1 exactly are legal
  if (std::abs(shortest) > 1 + kRounding || std::pow(largest, options.iterations) > kMostGrowth) {
    throw ParameterError("with lambda " + format_real(options.lambda) + " and mu " + format_real(options.mu) + ", " +
                         std::to_string(options.iterations) +
                         " iterations of smoothing make waves instead; bring mu closer to -lambda");
  }
}

void taubin_smooth(TriangleSoup& surface, const TaubinOptions& options, RunContext& context) {
  check_options(options);
  if (options.iterations == 0 || surface.empty()) return;

  const std::size_t vertices = surface.positions.size();
  Stage stage(context, "smoothing", 2 * std::int64_t{options.iterations} * static_cast<std::int64_t>(vertices));
  const std::uint64_t vertex_bytes = 2 * sizeof(Point) + sizeof(std::size_t) + sizeof(std::uint32_t);
  context.require_memory(vertices * vertex_bytes + surface.triangles.size() * 6 * sizeof(std::uint32_t), "smoothing");
  const Neighbours neighbours = find_neighbours(surface, context);
  std::vector<Point> positions = surface.positions;
  std::vector<Point> moved(vertices);
  for (int i = 0; i < options.iterations; ++i) {
    step(neighbours, options.lambda, positions, moved, context, stage);
    step(neighbours, options.mu, moved, positions, context, stage);
  }
  surface.positions = std::move(positions);
}

}  // namespace voxcarve
