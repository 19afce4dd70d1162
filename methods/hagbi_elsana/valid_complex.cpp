#include "methods/hagbi_elsana/valid_complex.h"

#include <fmt/format.h>

#include <string>
#include <utility>

#include "common/mesh/alpha_wrap.h"
#include "common/mesh/arrangement.h"
#include "common/run/errors.h"
#include "common/run/text.h"

namespace voxcarve {

namespace {

/// Shares of the diagonal; what alpha-wrap takes by default.
constexpr double kWrapAlpha = 0.02;
constexpr double kWrapOffset = 0.001;

std::string counted(std::int64_t count, const char* one, const char* many) {
  return with_thousands(count) + " " + (count == 1 ? one : many);
}

void report(const ArrangementReport& done, RunContext& context) {
  const auto note = [&](std::int64_t count, const char* one, const char* many, const char* what) {
    if (count > 0) context.notice(counted(count, one, many) + " " + what);
  };
  note(done.merged_vertices, "vertex was", "vertices were", "merged with others at the same position");
  note(done.degenerate_triangles, "triangle was", "triangles were", "dropped for having no area");
  note(done.duplicate_triangles, "triangle was", "triangles were", "merged with others between the same vertices");
  if (done.crossing_pairs > 0) {
    context.notice(counted(done.crossing_pairs, "pair of triangles crosses", "pairs of triangles cross") + ": " +
                   counted(done.split_triangles, "triangle was", "triangles were") + " split, with " +
                   counted(done.new_vertices, "new vertex", "new vertices") + ", in " +
                   counted(done.passes, "pass", "passes"));
  }
}

class Pipeline {
 public:
  Pipeline(const TriangleSoup& soup, const ComplexOptions& options, RunContext& context)
      : soup_(soup), options_(options), context_(context) {}

  ValidComplex run() {
    if (arrange_and_tetrahedralize(soup_, "") || wrap()) return std::move(result_);
    throw MethodFailure("the model cannot be tetrahedralized: " + reasons_);
  }

 private:
  template <class Try>
  bool attempt(const std::string& how, const Try& run) {
    try {
      run();
      return true;
    } catch (const TetgenFailure& failure) {
      // Nothing makes a flat model solid; and what a result looks like must not depend on the machine's speed or
      // memory.
      if (failure.kind() == TetgenFailure::Kind::kTimeLimit || failure.kind() == TetgenFailure::Kind::kMemoryLimit ||
          failure.kind() == TetgenFailure::Kind::kFlat) {
        throw;
      }
      remember(how, failure.what());
    } catch (const MethodFailure& failure) {
      remember(how, failure.what());
    }
    return false;
  }

  void remember(const std::string& how, const std::string& reason) {
    reasons_ += (reasons_.empty() ? "" : "; ") + how + ": " + reason;
  }

  /// `what` names the soup in reasons, where it is not the model.
  bool arrange_and_tetrahedralize(const TriangleSoup& soup, const std::string& what) {
    const auto arranged = [&] {
      Arrangement arrangement = arrange(soup, context_);
      if (what.empty()) report(arrangement.report, context_);
      result_.complex = std::move(arrangement.complex);
      result_.multiplicity = std::move(arrangement.multiplicity);
    };
    if (!attempt(what + "crossings resolved", arranged)) return false;
    const auto tetrahedralize_with = [&](FacetSplitting splitting) {
      const std::vector<Point> corners = box_corners();
      result_.tetrahedralization = tetrahedralize(result_.complex, splitting, options_.limits, context_, corners);
      result_.tetrahedralization.steiner_points += corners.size();  // as much the model's as those
    };
    if (attempt(what + "triangles whole", [&] { tetrahedralize_with(FacetSplitting::kNone); })) return true;
    if (attempt(what + "close points told apart", [&] { tetrahedralize_with(FacetSplitting::kNoneNear); })) {
      context_.notice("TetGen had to tell points apart that are closer than usual (" + reasons_ + ")");
      return true;
    }
    if (!attempt(what + "triangles split", [&] { tetrahedralize_with(FacetSplitting::kAllowed); })) return false;
    const auto facets = static_cast<std::int64_t>(result_.tetrahedralization.facets.size());
    context_.notice("TetGen could not keep the model's triangles whole (" + reasons_ +
                    "): " + with_thousands(static_cast<std::int64_t>(result_.complex.triangles.size())) + " became " +
                    with_thousands(facets));
    return true;
  }

  bool wrap() {
    const std::string before = reasons_;
    TriangleSoup wrapped;
    const auto made = [&] {
      wrapped = alpha_wrap(soup_, kWrapAlpha, kWrapOffset, context_);
      if (wrapped.empty()) throw MethodFailure("the wrap is empty");
    };
    if (!attempt("wrapped", made) || !arrange_and_tetrahedralize(wrapped, "wrapped, ")) return false;
    result_.wrapped = true;
    context_.notice(
        fmt::format("the model could not be tetrahedralized ({}), so it was shrink-wrapped: vertices are the "
                    "wrap's, openings under {} of the diagonal are closed",
                    before, kWrapAlpha));
    return true;
  }

  std::vector<Point> box_corners() const {
    std::vector<Point> corners;
    if (!options_.box) return corners;
    const Box box = bounds(result_.complex);
    for (int i = 0; i < 8; ++i) {
      corners.emplace_back((i & 1) != 0 ? box.upper[0] : box.lower[0], (i & 2) != 0 ? box.upper[1] : box.lower[1],
                           (i & 4) != 0 ? box.upper[2] : box.lower[2]);
    }
    return corners;
  }

  const TriangleSoup& soup_;
  const ComplexOptions& options_;
  RunContext& context_;
  ValidComplex result_;
  std::string reasons_;
};

}  // namespace

ValidComplex make_valid_complex(const TriangleSoup& soup, const ComplexOptions& options, RunContext& context) {
  return Pipeline(soup, options, context).run();
}

}  // namespace voxcarve
