// Two surfaces made ready for queries from one to the other, whole or in part.
#pragma once

#include <cstdint>
#include <variant>
#include <vector>

#include "common/mesh/aabb_tree.h"
#include "metrics/metric.h"

namespace voxcarve {

/// Triangles and pieces of triangles of a surface.
struct SurfacePart {
  TriangleSoup surface;               ///< in the coordinates of the whole, without colours
  std::vector<std::uint32_t> source;  ///< by triangle of `surface`: the triangle of the whole that it is a piece of
  double share = 0;                   ///< of the whole's area, in [0, 1]
};

/// Points to measure from: one surface of a pair or a part of it, in normalised units.
struct MeasuredSurface {
  TriangleSoup soup;
  std::vector<std::uint8_t> twin;  ///< by triangle: 1 when it lies in a triangle that both surfaces have
};

/// Both surfaces about the centre of a's box, scaled by a power of two so that its diagonal is in [1, 2).
struct SurfacePair {
  MeasuredSurface a;
  MeasuredSurface b;
  AabbTree tree_a;
  AabbTree tree_b;
  double diagonal = 0;  ///< of the box of a, or of both boxes when that is a point; in model units
  Point center = Point::Zero();
  double scale = 1;     ///< model units times scale are normalised units
  double rounding = 0;  ///< largest rounding error of a distance, in normalised units

  /// A part of the first or the second shape that `prepare_pair` was given.
  MeasuredSurface part_of_a(const SurfacePart& part) const { return part_of(a, part); }
  MeasuredSurface part_of_b(const SurfacePart& part) const { return part_of(b, part); }

 private:
  MeasuredSurface part_of(const MeasuredSurface& whole, const SurfacePart& part) const;
};

/// Undefined, with the reason, for an empty shape or coordinates whose differences overflow. Throws Cancelled.
std::variant<SurfacePair, Undefined> prepare_pair(const TriangleSoup& a, const TriangleSoup& b,
                                                  const RunContext& context);

/// A sample of a surface and the nearest point of the other one.
struct SampleFoot {
  double squared_distance = 0;              ///< in normalised units
  std::uint32_t from = 0;                   ///< triangle that was sampled
  std::uint32_t nearest = AabbTree::kNone;  ///< triangle of the other surface; kNone when `from` has a twin there
};

/// Area-uniform samples of `from`, one in each of `samples` equal shares of the area, and their nearest triangles in
/// `to`. From the context's seed; samples of different `stream` are independent. Empty when there is no area. Throws
/// ResourceError when the samples exceed the memory budget, and Cancelled.
std::vector<SampleFoot> sample_feet(const MeasuredSurface& from, const AabbTree& to, std::int64_t samples,
                                    std::uint64_t stream, RunContext& context);

}  // namespace voxcarve
