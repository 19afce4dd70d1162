// Constrained Delaunay tetrahedralization with TetGen, in a process of its own: TetGen ends in assertions, segmentation
// faults and endless loops on inputs that it does not like, and none of these must reach the caller.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/mesh/triangle_soup.h"
#include "common/run/context.h"
#include "common/run/errors.h"

namespace voxcarve {

/// Constrained Delaunay tetrahedralization of the convex hull of a complex of triangles.
///
/// Point i is point i of the complex, to the last bit. Of points at one position the tetrahedra and the facets name
/// the first that a triangle uses; no tetrahedron names the others, nor a point that no triangle uses. Every face of
/// `facets` is a face of a tetrahedron.
struct Tetrahedralization {
  std::vector<Point> points;       ///< the complex's, in their order, those asked for beside it, then Steiner points
  std::size_t steiner_points = 0;  ///< how many of them are Steiner points
  /// Positively oriented: (b - a).cross(c - a).dot(d - a) > 0, up to rounding.
  std::vector<std::array<std::uint32_t, 4>> tetrahedra;
  std::vector<std::array<std::int32_t, 4>>
      neighbors;                            ///< [t][i]: across the face opposite vertex i; -1 beyond the hull
  std::vector<Triangle> facets;             ///< the complex's triangles, oriented as there; split if allowed
  std::vector<std::uint32_t> facet_source;  ///< which triangle of the complex each is a part of; ascending
  std::uint64_t peak_bytes = 0;             ///< the child's memory beyond what it shared, by the system
  double seconds = 0;                       ///< elapsed, from the call to the return
};

enum class FacetSplitting {
  kNone,      ///< every triangle stays whole; Steiner points lie off the triangles (TetGen's pcYQn)
  kNoneNear,  ///< the same, and points closer than usual are told apart (pcYT1e-14Qn)
  kAllowed    ///< Steiner points may split triangles, and points closer than usual are told apart (pcT1e-14Qn)
};

struct TetgenLimits {
  double seconds = 600;     ///< elapsed, for the whole call
  std::uint64_t bytes = 0;  ///< of the child's memory beyond what it shares; 0: the context's memory budget
};

/// Why there is no tetrahedralization.
class TetgenFailure : public MethodFailure {
 public:
  enum class Kind {
    kFlat,        ///< all points lie in a plane
    kRefused,     ///< the complex is no complex (facets intersect, say), or TetGen could not recover a facet
    kCrashed,     ///< TetGen ended without a word, or what it gave makes no sense
    kTimeLimit,   ///< TetgenLimits::seconds
    kMemoryLimit  ///< TetgenLimits::bytes
  };
  TetgenFailure(Kind kind, const std::string& message) : MethodFailure(message), kind_(kind) {}
  Kind kind() const noexcept { return kind_; }

 private:
  Kind kind_;
};

/// Tetrahedralizes the convex hull of the points that triangles use and of `more_points`, so that the triangles are
/// unions of faces (with FacetSplitting::kNone and kNoneNear: are faces).
///
/// Two triangles may meet only in a common vertex or edge; coincident ones count once, as the first. Triangles without
/// an area are refused. Coordinates may be of any size: multiplying them by a power of two changes nothing else. The
/// same complex gives the same result, whatever the number of threads.
///
/// Runs in a forked child, silently; the progress stage "tetrahedralization" counts triangles and does not move before
/// the end. Throws TetgenFailure, InputError as `validate` does, ResourceError when the expected memory exceeds the
/// context's budget or the system gives no child, and Cancelled. In every case the child is gone on return. The system
/// sends SIGCHLD for it; a program that ignores the signal or reaps children of others loses nothing but the reason of
/// a crash. May be called from several threads, with a context each.
Tetrahedralization tetrahedralize(const TriangleSoup& complex, FacetSplitting splitting, const TetgenLimits& limits,
                                  RunContext& context, std::span<const Point> more_points = {});

}  // namespace voxcarve
