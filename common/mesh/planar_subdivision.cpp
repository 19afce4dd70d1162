// A constrained Delaunay triangulation (CGAL) in the projection along an axis, on exact numbers that are evaluated only
// where intervals leave a sign open. All numbers are made here and none leaves: calls may run on several threads.
#include "common/mesh/planar_subdivision.h"

#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Constrained_triangulation_face_base_2.h>
#include <CGAL/Exact_predicates_exact_constructions_kernel.h>
#include <CGAL/Triangulation_data_structure_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <type_traits>
#include <utility>

#include "common/mesh/aabb_tree.h"

namespace voxcarve {

namespace {

using Kernel = CGAL::Exact_predicates_exact_constructions_kernel;
using Number = Kernel::FT;
using PlanePoint = Kernel::Point_2;
/// What a Number evaluates to. New points are computed with it at once: all are needed exactly, to be rounded, and a
/// Number that is only a formula would be evaluated term by term, each under a lock.
using Exact = std::decay_t<decltype(std::declval<const Number&>().exact())>;
using SpacePoint = std::array<Exact, 3>;

constexpr std::uint32_t kUnnamed = std::numeric_limits<std::uint32_t>::max();
struct VertexName {
  std::uint32_t index = kUnnamed;
};

using VertexBase = CGAL::Triangulation_vertex_base_with_info_2<VertexName, Kernel>;
using FaceBase = CGAL::Constrained_triangulation_face_base_2<Kernel>;
using Structure = CGAL::Triangulation_data_structure_2<VertexBase, FaceBase>;
using Triangulation = CGAL::Constrained_Delaunay_triangulation_2<Kernel, Structure, CGAL::Exact_intersections_tag>;
using Vertex = Triangulation::Vertex_handle;

SpacePoint exact(const Point& p) {
  return {Exact(p[0]), Exact(p[1]), Exact(p[2])};
}

SpacePoint difference(const SpacePoint& p, const SpacePoint& q) {
  return {p[0] - q[0], p[1] - q[1], p[2] - q[2]};
}

SpacePoint cross(const SpacePoint& p, const SpacePoint& q) {
  return {p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]};
}

Exact dot(const SpacePoint& p, const SpacePoint& q) {
  return p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
}

/// Depends on the value alone, not on how it was computed.
double nearest_double(const Exact& value) {
  double best = CGAL::to_double(value);  // truncated, or off by one unit in the last place
  Exact error = CGAL::abs(Exact(value - Exact(best)));
  if (CGAL::is_zero(error)) return best;
  const double middle = best;
  for (const double limit : {-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()}) {
    const double neighbour = std::nextafter(middle, limit);
    const Exact other = CGAL::abs(Exact(value - Exact(neighbour)));
    if (other < error) {
      best = neighbour;
      error = other;
    }
  }
  return best;
}

class Subdivider {
 public:
  Subdivider(const TriangleSoup& soup, std::span<const std::uint32_t> triangles, const RunContext& context)
      : soup_(soup), triangles_(triangles), context_(context) {
    const Triangle& t = soup.triangles[triangles[0]];
    origin_ = exact(soup.positions[t[0]]);
    normal_ = cross(difference(exact(soup.positions[t[1]]), origin_), difference(exact(soup.positions[t[2]]), origin_));
    // Parts look least distorted along the largest component; any that is not zero is correct.
    const auto size = [this](std::size_t axis) { return std::abs(CGAL::to_double(normal_[axis])); };
    for (std::size_t axis = 1; axis < 3; ++axis) {
      if (size(axis) > size(axis_)) axis_ = axis;
    }
    for (std::size_t i = 0; CGAL::is_zero(normal_[axis_]) && i < 3; ++i) axis_ = i;
  }

  PlanarSubdivision run(std::span<const PlanarConstraint> constraints) {
    for (const std::uint32_t triangle : triangles_) {
      const Triangle& t = soup_.triangles[triangle];
      for (std::size_t i = 0; i < 3; ++i) constrain(vertex(t[i]), vertex(t[(i + 1) % 3]));
    }
    for (const PlanarConstraint& constraint : constraints) constrain(vertex(constraint[0]), vertex(constraint[1]));
    PlanarSubdivision result;
    name_new_vertices(result);
    if (triangles_.size() == 1) {
      add_parts_of_one(result);
    } else {
      add_parts_of_many(result);
    }
    return result;
  }

 private:
  std::size_t first_axis() const { return (axis_ + 1) % 3; }
  std::size_t second_axis() const { return (axis_ + 2) % 3; }
  PlanePoint projected(const Point& p) const {
    return {Number(p[static_cast<Eigen::Index>(first_axis())]), Number(p[static_cast<Eigen::Index>(second_axis())])};
  }

  Vertex vertex(std::uint32_t index) {
    Vertex& known = vertices_[{index, index, 0}];
    if (known == Vertex()) {
      known = triangulation_.insert(projected(soup_.positions[index]), hint_);
      known->info().index = index;
      hint_ = known->face();
    }
    return known;
  }

  Vertex vertex(const ContactPoint& point) {
    if (point.is_vertex()) return vertex(point.from);
    Vertex& known = vertices_[point];
    if (known == Vertex()) {
      const Triangle& t = soup_.triangles[point.triangle];
      const SpacePoint a = exact(soup_.positions[t[0]]);
      const SpacePoint normal =
          cross(difference(exact(soup_.positions[t[1]]), a), difference(exact(soup_.positions[t[2]]), a));
      const SpacePoint from = exact(soup_.positions[point.from]);
      const SpacePoint along = difference(exact(soup_.positions[point.to]), from);
      const Exact share = dot(normal, difference(a, from)) / dot(normal, along);
      const std::size_t u = first_axis();
      const std::size_t v = second_axis();
      const PlanePoint where(Number(Exact(from[u] + share * along[u])), Number(Exact(from[v] + share * along[v])));
      known = triangulation_.insert(where, hint_);
      hint_ = known->face();
    }
    return known;
  }

  void constrain(Vertex from, Vertex to) {
    if (++constrained_ % 16 == 0) context_.check_cancelled();
    if (from == to) return;
    triangulation_.insert_constraint(from, to);
    hint_ = to->face();
  }

  void name_new_vertices(PlanarSubdivision& result) {
    std::size_t count = 0;
    for (const Vertex v : triangulation_.finite_vertex_handles()) {
      if (v->info().index != kUnnamed) continue;
      if (++count % 64 == 0) context_.check_cancelled();
      v->info().index = static_cast<std::uint32_t>(soup_.positions.size() + result.new_positions.size());
      const std::size_t u = first_axis();
      const std::size_t w = second_axis();
      const Exact x = v->point().x().exact();
      const Exact y = v->point().y().exact();
      const Exact height =
          origin_[axis_] - (normal_[u] * (x - origin_[u]) + normal_[w] * (y - origin_[w])) / normal_[axis_];
      Point position;
      position[static_cast<Eigen::Index>(u)] = nearest_double(x);
      position[static_cast<Eigen::Index>(w)] = nearest_double(y);
      position[static_cast<Eigen::Index>(axis_)] = nearest_double(height);
      result.new_positions.push_back(position);
    }
  }

  /// Sign of a triangle's orientation in the projection.
  bool is_counterclockwise(const Triangle& t) const {
    const auto at = [&](std::size_t i) { return projected(soup_.positions[t[i]]); };
    return CGAL::orientation(at(0), at(1), at(2)) == CGAL::POSITIVE;
  }

  static Triangle corners_of(Triangulation::Face_handle face) {
    return {face->vertex(0)->info().index, face->vertex(1)->info().index, face->vertex(2)->info().index};
  }

  void add_parts_of_one(PlanarSubdivision& result) const {
    const bool aligned = is_counterclockwise(soup_.triangles[triangles_[0]]);
    for (const auto face : triangulation_.finite_face_handles()) {
      result.covers.push_back({triangles_[0], aligned});
      result.parts.push_back({corners_of(face), result.covers.size()});
    }
  }

  /// Edges of all triangles are edges of the triangulation, so a face is in a triangle iff its centroid is.
  void add_parts_of_many(PlanarSubdivision& result) const {
    TriangleSoup flat;
    std::vector<std::array<PlanePoint, 3>> outlines;
    std::vector<bool> turned;
    for (const std::uint32_t triangle : triangles_) {
      Triangle t = soup_.triangles[triangle];
      turned.push_back(!is_counterclockwise(t));
      if (turned.back()) std::swap(t[1], t[2]);
      std::array<PlanePoint, 3> outline;
      for (std::size_t i = 0; i < 3; ++i) {
        const Point& p = soup_.positions[t[i]];
        outline[i] = projected(p);
        const auto u = static_cast<Eigen::Index>(first_axis());
        const auto v = static_cast<Eigen::Index>(second_axis());
        flat.positions.emplace_back(p[u], p[v], 0.0);
      }
      const auto last = static_cast<std::uint32_t>(flat.positions.size());
      flat.triangles.push_back({last - 3, last - 2, last - 1});
      outlines.push_back(std::move(outline));
    }
    const AabbTree tree(flat);
    std::vector<std::uint32_t> candidates;
    std::size_t count = 0;
    for (const auto face : triangulation_.finite_face_handles()) {
      if (++count % 256 == 0) context_.check_cancelled();
      const PlanePoint middle =
          CGAL::centroid(face->vertex(0)->point(), face->vertex(1)->point(), face->vertex(2)->point());
      const auto x = CGAL::to_interval(middle.x());
      const auto y = CGAL::to_interval(middle.y());
      candidates.clear();
      tree.append_overlaps({Point(x.first, y.first, 0), Point(x.second, y.second, 0)}, candidates);
      std::sort(candidates.begin(), candidates.end());
      bool covered = false;
      for (const std::uint32_t candidate : candidates) {
        const auto& t = outlines[candidate];
        const auto left = [&](std::size_t i) {
          return CGAL::orientation(t[i], t[(i + 1) % 3], middle) == CGAL::POSITIVE;
        };
        if (!left(0) || !left(1) || !left(2)) continue;
        result.covers.push_back({triangles_[candidate], !turned[candidate]});
        covered = true;
      }
      if (covered) result.parts.push_back({corners_of(face), result.covers.size()});
    }
  }

  const TriangleSoup& soup_;
  std::span<const std::uint32_t> triangles_;
  const RunContext& context_;
  SpacePoint origin_;
  SpacePoint normal_;
  std::size_t axis_ = 0;  ///< of the projection
  Triangulation triangulation_;
  Triangulation::Face_handle hint_;
  std::map<ContactPoint, Vertex> vertices_;
  std::size_t constrained_ = 0;
};

}  // namespace

PlanarSubdivision subdivide(const TriangleSoup& soup, std::span<const std::uint32_t> triangles,
                            std::span<const PlanarConstraint> constraints, const RunContext& context) {
  return Subdivider(soup, triangles, context).run(constraints);
}

}  // namespace voxcarve
