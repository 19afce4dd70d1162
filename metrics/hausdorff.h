// Certified Hausdorff distances between surfaces, and mean distances by sampling.
#pragma once

#include <cstdint>
#include <optional>
#include <variant>

#include "metrics/metric.h"
#include "metrics/surface_pair.h"

namespace voxcarve {

/// A distance in model units that lies in [lower, upper] for certain, rounding included.
struct DistanceInterval {
  double lower = 0;
  double upper = 0;
};

struct HausdorffOptions {
  double error = 1e-3;           ///< largest width of an interval, share of the first shape's bounding-box diagonal
  std::int64_t samples = 20000;  ///< area-uniform samples a side for mean and RMS
};

struct HausdorffDistances {
  DistanceInterval a_to_b;     ///< max over points of a of the distance to b
  DistanceInterval b_to_a;     ///< max over points of b of the distance to a
  DistanceInterval symmetric;  ///< max of both
  double diagonal = 0;         ///< of the box of a, or of both boxes when that is a point: what `error` is a share of
  /// Average of the two one-sided mean distances, and root of the average of the two one-sided mean squares; not
  /// defined when a shape has no area. Sampled with the context's seed.
  std::optional<double> mean;
  std::optional<double> rms;
};

/// Distances between two surfaces, both as sets of points: orientation, inside and connectivity do not matter, and
/// triangles without area are the segments and points that they are. The width of each interval is at most
/// `error` diagonals, unless that is less than what rounding of coordinates far apart leaves (about 1e-13 of the
/// largest distance from the centre of a's box). Equal sets of triangles have distance [0, 0] exactly.
/// Undefined, with the reason, for an empty shape or coordinates whose differences overflow. Throws ResourceError when
/// the samples exceed the memory budget, and Cancelled.
std::variant<HausdorffDistances, Undefined> hausdorff_distances(const TriangleSoup& a, const TriangleSoup& b,
                                                                const HausdorffOptions& options, RunContext& context);

/// The same from the points of `from_a` to the whole of b and from the points of `from_b` to the whole of a. Each is
/// the pair's own surface or a part of it. Undefined, with the reason, for an empty part. Throws ResourceError when the
/// samples exceed the memory budget, and Cancelled.
std::variant<HausdorffDistances, Undefined> hausdorff_distances(const SurfacePair& pair, const MeasuredSurface& from_a,
                                                                const MeasuredSurface& from_b,
                                                                const HausdorffOptions& options, RunContext& context);

}  // namespace voxcarve
