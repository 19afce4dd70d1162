// The groups that the single-shape metrics are computed in; metric.cpp puts them together.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "common/mesh/topology.h"
#include "metrics/metric.h"

namespace voxcarve {

/// A value, or Undefined when it is not finite: no metric is ever NaN or infinite.
MetricValue finite_value(double value);

/// Appends the counts of `analyze_topology`: vertices ... genus.
void append_topology(const SurfaceTopology& topology, std::vector<Measurement>& out);

/// Appends area, volume, bounding box, edge-length and triangle-quality statistics. The quality of a triangle is twice
/// the radius of its inscribed circle by that of its circumscribed one: 1 when equilateral, 0 without area. Edges are
/// distinct pairs of indices. The volume is the signed one and needs a surface that is closed and oriented.
void append_geometry(const TriangleSoup& soup, const SurfaceTopology& topology, std::vector<Measurement>& out);

/// Betti numbers of the bounded solid behind a surface: components, tunnels (handles) and voids.
struct SolidTopology {
  std::int64_t b0 = 0;
  std::int64_t b1 = 0;
  std::int64_t b2 = 0;
};

/// The Betti numbers of the solid that a surface bounds, or the reason why it bounds none. Defined for closed, oriented
/// 2-manifolds without self-intersections whose components nest with alternating orientation, the outermost ones facing
/// outward: an inward one bounds a void of the component around it, an outward one inside of a void is a solid of its
/// own. b0 counts outward components, b2 inward ones, and b1 = b0 + b2 - chi / 2, since the Euler characteristic chi of
/// a solid's surface is twice that of the solid. `self_intersections` is what count_self_intersections gave. Components
/// that touch are told apart by where they do not touch.
std::variant<SolidTopology, Undefined> solid_topology(const TriangleSoup& soup, const SurfaceTopology& topology,
                                                      const MetricValue& self_intersections, const RunContext& context);

}  // namespace voxcarve
