// Topology of surfaces as metrics, and the Betti numbers of the solids that they bound.
#include <algorithm>
#include <cmath>
#include <map>

#include "common/mesh/line_stabber.h"
#include "metrics/shape_measures.h"

namespace voxcarve {

void append_topology(const SurfaceTopology& topology, std::vector<Measurement>& out) {
  out.push_back({"vertices", topology.vertices});
  out.push_back({"triangles", topology.triangles + topology.collapsed_triangles});
  out.push_back({"components", topology.components});
  out.push_back({"closed", topology.closed});
  out.push_back({"oriented", topology.oriented});
  out.push_back({"boundary_edges", topology.boundary_edges});
  out.push_back({"boundary_loops", topology.boundary_loops});
  out.push_back({"nonmanifold_edges", topology.nonmanifold_edges});
  out.push_back({"nonmanifold_vertices", topology.nonmanifold_vertices});
  out.push_back({"euler_characteristic", topology.euler_characteristic});
  out.push_back({"genus", topology.genus ? MetricValue(*topology.genus) : Undefined{topology.genus_reason}});
}

namespace {

constexpr std::size_t kProbesAComponent = 16;
constexpr double kFlat = 1e-14;   // volume by area times diagonal below which it is rounding
constexpr double kTouch = 1e-12;  // share of the diagonal below which two depths are one

/// How components lie inside of each other, found by lines through a triangle of each.
class Nesting {
 public:
  Nesting(const TriangleSoup& soup, const SurfaceTopology& topology, const RunContext& context)
      : soup_(soup),
        labels_(topology.component_of_triangle),
        context_(context),
        diagonal_(bounds(soup).diagonal()),
        volumes_(topology.component_list.size(), 0),
        areas_(topology.component_list.size(), 0),
        probes_(topology.component_list.size()) {
    measure_components();
  }

  std::variant<SolidTopology, Undefined> run(std::int64_t euler_characteristic) {
    const auto count = static_cast<std::uint32_t>(volumes_.size());
    std::vector<std::vector<std::uint32_t>> holders(count);
    const LineStabber stabber(soup_);
    for (std::uint32_t c = 0; c < count; ++c) {
      if (c % 64 == 0) context_.check_cancelled();
      if (std::abs(volumes_[c]) <= kFlat * areas_[c] * diagonal_)
        return Undefined{"component " + std::to_string(c) + " encloses no volume"};
      if (!find_holders(stabber, c, holders[c])) {
        return Undefined{"component " + std::to_string(c) + " coincides with another one"};
      }
    }
    SolidTopology solid;
    for (std::uint32_t c = 0; c < count; ++c) {
      const bool outward = volumes_[c] > 0;
      // The innermost holder lies inside of all others.
      const auto parent = std::max_element(holders[c].begin(), holders[c].end(),
                                           [&](auto i, auto j) { return holders[i].size() < holders[j].size(); });
      if (parent == holders[c].end() && !outward) {
        return Undefined{"component " + std::to_string(c) + " faces inward and lies in no solid"};
      }
      if (parent != holders[c].end() && (volumes_[*parent] > 0) == outward) {
        return Undefined{"nested shells of the same orientation"};
      }
      ++(outward ? solid.b0 : solid.b2);
    }
    solid.b1 = solid.b0 + solid.b2 - euler_characteristic / 2;
    return solid;
  }

 private:
  struct Probe {
    double area = 0;  ///< projected along z
    std::uint32_t triangle = 0;
  };

  /// Signed volumes, and the triangles that are largest as seen along z.
  void measure_components() {
    const Point center = bounds(soup_).center();
    for (std::uint32_t t = 0; t < soup_.triangles.size(); ++t) {
      const std::uint32_t label = labels_[t];
      if (label == SurfaceTopology::kNoComponent) continue;
      const Triangle& triangle = soup_.triangles[t];
      const Point normal = area_vector(soup_, triangle);
      volumes_[label] += normal.dot(soup_.positions[triangle[0]] - center) / 6;
      areas_[label] += normal.norm() / 2;
      std::vector<Probe>& probes = probes_[label];
      probes.push_back({std::abs(normal[2]), t});
      std::inplace_merge(probes.begin(), probes.end() - 1, probes.end(),
                         [](const Probe& a, const Probe& b) { return a.area > b.area; });
      if (probes.size() > kProbesAComponent) probes.pop_back();
    }
  }

  /// The components whose inside holds component c: those with a winding number other than zero where a line meets c.
  /// Any point of c will do where no other component touches it; false when none was found.
  bool find_holders(const LineStabber& stabber, std::uint32_t c, std::vector<std::uint32_t>& holders) {
    for (const Probe& probe : probes_[c]) {
      const Triangle& t = soup_.triangles[probe.triangle];
      const Point middle = (soup_.positions[t[0]] + soup_.positions[t[1]] + soup_.positions[t[2]]) / 3;
      stabber.crossings(middle[0], middle[1], crossings_);
      std::map<std::uint32_t, int> windings;
      for (std::size_t i = 0; i < crossings_.size(); ++i) {
        const std::uint32_t label = labels_[crossings_[i].triangle];
        if (label != c) {
          windings[label] += crossings_[i].sign;
        } else if (!touches_another(i)) {
          for (const auto& [other, winding] : windings) {
            if (winding != 0) holders.push_back(other);
          }
          return true;
        }
      }
    }
    return false;
  }

  /// Whether another component is crossed where crossing i lies.
  bool touches_another(std::size_t i) const {
    const auto same_place = [&](std::size_t j) {
      return std::abs(crossings_[j].depth - crossings_[i].depth) <= kTouch * diagonal_;
    };
    const auto other = [&](std::size_t j) {
      return labels_[crossings_[j].triangle] != labels_[crossings_[i].triangle];
    };
    for (std::size_t j = i; j-- > 0 && same_place(j);) {
      if (other(j)) return true;
    }
    for (std::size_t j = i + 1; j < crossings_.size() && same_place(j); ++j) {
      if (other(j)) return true;
    }
    return false;
  }

  const TriangleSoup& soup_;
  const std::vector<std::uint32_t>& labels_;
  const RunContext& context_;
  double diagonal_;
  std::vector<double> volumes_;
  std::vector<double> areas_;
  std::vector<std::vector<Probe>> probes_;
  std::vector<Crossing> crossings_;
};

}  // namespace

std::variant<SolidTopology, Undefined> solid_topology(const TriangleSoup& soup, const SurfaceTopology& topology,
                                                      const MetricValue& self_intersections,
                                                      const RunContext& context) {
  if (!topology.closed) return Undefined{"the surface is not closed"};
  if (!topology.oriented) return Undefined{"the surface is not oriented"};
  if (!topology.genus) return Undefined{topology.genus_reason};
  if (const auto* reason = std::get_if<Undefined>(&self_intersections)) return *reason;
  if (const auto* count = std::get_if<std::int64_t>(&self_intersections); count == nullptr || *count > 0) {
    return Undefined{"the surface intersects itself"};
  }
  if (topology.components == 0) return SolidTopology{};
  if (!std::isfinite(bounds(soup).extent().prod())) return Undefined{"beyond the range of double precision"};
  return Nesting(soup, topology, context).run(topology.euler_characteristic);
}

}  // namespace voxcarve
