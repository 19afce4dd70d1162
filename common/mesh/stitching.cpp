// Own work in place of a library's: CGAL 5.5 stitches and fills, but snaps borders only in an experimental header that
// relies on assertions, cuts every edge of many triangles open, and keeps no colours. The steps are those that
// [NT03, 2] surveys; holes are filled after [BS95].
#include "common/mesh/stitching.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "common/mesh/border_snapping.h"
#include "common/mesh/gluing.h"
#include "common/mesh/hole_filling.h"
#include "common/mesh/topology.h"

namespace voxcarve {

namespace {

/// The model times a power of two, about as large as 1: products of lengths neither overflow nor vanish, and the way
/// back is exact.
class UnitScale {
 public:
  explicit UnitScale(const TriangleSoup& soup) {
    const double diagonal = bounds(soup).diagonal();
    if (diagonal > 0 && std::isfinite(diagonal)) std::frexp(diagonal, &exponent_);
  }
  double to_unit(double length) const { return std::ldexp(length, -exponent_); }
  void to_unit(TriangleSoup& soup) const { scale(soup, -exponent_); }
  void to_model(TriangleSoup& soup) const { scale(soup, exponent_); }

 private:
  static void scale(TriangleSoup& soup, int exponent) {
    for (Point& p : soup.positions) p = p.unaryExpr([exponent](double x) { return std::ldexp(x, exponent); });
  }
  int exponent_ = 0;
};

std::string counted(std::int64_t count, const std::string& singular, const std::string& plural) {
  return std::to_string(count) + " " + (count == 1 ? singular : plural);
}

/// The mean colour of every triangle's vertices.
std::vector<Color> mean_colors(const TriangleSoup& soup) {
  std::vector<Color> colors;
  colors.reserve(soup.triangles.size());
  for (const Triangle& t : soup.triangles)
    colors.emplace_back((soup.vertex_colors[t[0]] + soup.vertex_colors[t[1]] + soup.vertex_colors[t[2]]) / 3.0F);
  return colors;
}

/// Whether a vertex of `merged`, which has the triangles of `soup`, looks different there.
bool looks_different(const TriangleSoup& soup, const TriangleSoup& merged) {
  for (std::size_t t = 0; t < soup.triangles.size(); ++t) {
    for (std::size_t c = 0; c < 3; ++c) {
      const Color difference = soup.vertex_colors[soup.triangles[t][c]] - merged.vertex_colors[merged.triangles[t][c]];
      if (difference.cwiseAbs().maxCoeff() > kVisibleColor) return true;
    }
  }
  return false;
}

/// Keeps the triangles for which `keep` is not 0.
void keep_triangles(TriangleSoup& soup, const std::vector<std::uint8_t>& keep) {
  std::size_t kept = 0;
  for (std::size_t t = 0; t < soup.triangles.size(); ++t) {
    if (keep[t] == 0) continue;
    soup.triangles[kept] = soup.triangles[t];
    if (!soup.triangle_colors.empty()) soup.triangle_colors[kept] = soup.triangle_colors[t];
    ++kept;
  }
  soup.triangles.resize(kept);
  if (!soup.triangle_colors.empty()) soup.triangle_colors.resize(kept);
}

struct DropReport {
  std::int64_t degenerate = 0;
  std::int64_t duplicate = 0;
};

/// Drops triangles without area, and of those with the same vertices all but the first.
DropReport drop_useless_triangles(TriangleSoup& soup) {
  DropReport report;
  std::vector<std::uint8_t> keep(soup.triangles.size(), 1);
  std::vector<std::pair<Triangle, std::uint32_t>> order;
  order.reserve(soup.triangles.size());
  for (std::uint32_t t = 0; t < soup.triangles.size(); ++t) {
    if (is_degenerate(soup, soup.triangles[t])) {
      keep[t] = 0;
      ++report.degenerate;
      continue;
    }
    Triangle vertices = soup.triangles[t];
    std::ranges::sort(vertices);
    order.emplace_back(vertices, t);
  }
  std::ranges::sort(order);
  for (std::size_t i = 1; i < order.size(); ++i) {
    if (order[i].first != order[i - 1].first) continue;
    keep[order[i].second] = 0;
    ++report.duplicate;
  }
  keep_triangles(soup, keep);
  return report;
}

class Stitcher {
 public:
  Stitcher(const TriangleSoup& soup, double tolerance, RunContext& context)
      : input_(soup),
        context_(context),
        triangles_(static_cast<std::int64_t>(soup.triangles.size())),
        stage_(context, "stitching", kSteps * triangles_),
        tolerance_(tolerance) {
    context.require_memory(soup.triangles.size() * kStitchBytesPerTriangle, "stitching");
  }

  TriangleSoup run() {
    merge();
    snap();
    orient_and_glue();
    const FillReport filled = fill_holes(soup_, context_);
    if (filled.holes > 0)
      note("filled " + counted(filled.holes, "hole", "holes") + " with " +
           counted(filled.triangles, "triangle", "triangles"));
    if (mixes_colors_) {
      note("vertices of different colours were merged; each triangle keeps the mean of its own");
    } else if (input_.triangle_colors.empty()) {
      soup_.triangle_colors.clear();
    }
    remove_unused_vertices(soup_);
    scale_.to_model(soup_);
    stage_.advance(triangles_);
    return std::move(soup_);
  }

 private:
  static constexpr std::int64_t kSteps = 4;

  void note(const std::string& text) { context_.notice("stitching " + text); }

  void merge() {
    TriangleSoup source = input_;
    if (!source.vertex_colors.empty() && source.triangle_colors.empty()) source.triangle_colors = mean_colors(source);
    context_.check_cancelled();
    soup_ = merge_equal_positions(source);
    context_.check_cancelled();
    std::vector<std::uint8_t> used(source.positions.size(), 0);
    for (const Triangle& t : source.triangles)
      for (const std::uint32_t v : t) used[v] = 1;
    const auto merged = std::ranges::count(used, 1) - static_cast<std::int64_t>(soup_.positions.size());
    if (merged > 0) note("merged " + counted(merged, "vertex", "vertices") + " of equal positions");
    mixes_colors_ = input_.triangle_colors.empty() && !source.vertex_colors.empty() && looks_different(source, soup_);
    scale_ = UnitScale(soup_);
    scale_.to_unit(soup_);
    const DropReport dropped = drop_useless_triangles(soup_);
    if (dropped.degenerate > 0)
      note("dropped " + counted(dropped.degenerate, "triangle", "triangles") + " without area");
    if (dropped.duplicate > 0)
      note("dropped " + counted(dropped.duplicate, "duplicate triangle", "duplicate triangles"));
    stage_.advance(triangles_);
  }

  void snap() {
    const double tolerance = scale_.to_unit(tolerance_);
    if (tolerance > 0) {
      const SnapReport snapped = snap_borders(soup_, tolerance, context_);
      if (snapped.merged_vertices > 0)
        note("merged " + counted(snapped.merged_vertices, "border vertex", "border vertices") + " with nearby ones");
      if (snapped.split_edges > 0)
        note("split " + counted(snapped.split_edges, "border edge", "border edges") + " at vertices that lie on them");
      mixes_colors_ = mixes_colors_ || (snapped.mixes_colors && input_.triangle_colors.empty());
      const DropReport dropped = drop_useless_triangles(soup_);
      if (dropped.degenerate + dropped.duplicate > 0)
        note("dropped " + counted(dropped.degenerate + dropped.duplicate, "triangle", "triangles") +
             " that merging collapsed");
    }
    stage_.advance(triangles_);
  }

  void orient_and_glue() {
    const OrientReport oriented = orient(soup_, context_);
    if (oriented.turned > 0)
      note("turned " + counted(oriented.turned, "triangle", "triangles") + " to agree with their neighbours");
    if (oriented.one_sided > 0) note("cut " + counted(oriented.one_sided, "edge", "edges") + " of a one-sided surface");
    const GlueReport glued = glue_to_manifold(soup_, context_);
    if (glued.crowded_edges > 0)
      note("took " + counted(glued.crowded_edges, "edge", "edges") + " of more than two triangles apart");
    if (glued.copied_vertices > 0)
      note("copied " + counted(glued.copied_vertices, "vertex", "vertices") + " to make the surface a manifold");
    stage_.advance(triangles_);
  }

  const TriangleSoup& input_;
  RunContext& context_;
  std::int64_t triangles_;
  Stage stage_;
  double tolerance_;
  TriangleSoup soup_;
  UnitScale scale_{TriangleSoup()};
  bool mixes_colors_ = false;
};

}  // namespace

TriangleSoup stitch(const TriangleSoup& soup, const StitchOptions& options, RunContext& context) {
  return Stitcher(soup, options.tolerance, context).run();
}

}  // namespace voxcarve
