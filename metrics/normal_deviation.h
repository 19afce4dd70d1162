// How far the normals of two surfaces differ.
#pragma once

#include <cstdint>
#include <variant>

#include "metrics/metric.h"
#include "metrics/surface_pair.h"

namespace voxcarve {

struct NormalDeviationOptions {
  std::int64_t samples = 20000;  ///< area-uniform samples a side
};

/// The angle above which a deviation counts as large, in degrees.
inline constexpr double kLargeDeviation = 30;

/// Angles in degrees, in [0, 90].
struct NormalDeviation {
  struct OneSided {
    double mean = 0;
    double rms = 0;
    double above_30 = 0;  ///< share of the samples that deviate by more than kLargeDeviation
  };
  OneSided a_to_b;  ///< samples of a against the nearest triangle of b
  OneSided b_to_a;
  double mean = 0;      ///< average of both directions
  double rms = 0;       ///< root of the average of both mean squares
  double above_30 = 0;  ///< average of both directions
};

/// The angle between the plane of a surface at area-uniform samples and the plane of the triangle of the other surface
/// that is nearest to the sample. Unoriented: inputs need not be oriented consistently, and a surface that is turned
/// inside out does not deviate. Samples are those of the mean Hausdorff distance, with the context's seed. On triangles
/// that both surfaces have the angle is 0. Where several triangles are nearest, as at an edge, the tree of the pair
/// chooses one; samples whose nearest triangle has no area do not count.
///
/// `from_a` and `from_b` are the pair's own surfaces or parts of them; the nearest triangle is always that of the
/// whole. Undefined, with the reason, for an empty part or one without area. Throws ResourceError when the
/// samples exceed the memory budget, and Cancelled.
std::variant<NormalDeviation, Undefined> normal_deviation(const SurfacePair& pair, const MeasuredSurface& from_a,
                                                          const MeasuredSurface& from_b,
                                                          const NormalDeviationOptions& options, RunContext& context);

/// The same between all of two surfaces. Undefined also for coordinates whose differences overflow.
std::variant<NormalDeviation, Undefined> normal_deviation(const TriangleSoup& a, const TriangleSoup& b,
                                                          const NormalDeviationOptions& options, RunContext& context);

}  // namespace voxcarve
