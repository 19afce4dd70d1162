#include "common/mesh/models/machined_part.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <set>
#include <span>

#include "common/run/errors.h"

namespace voxcarve {

namespace {

/// A section of a passage's wall: its radius, and where it is along the axis.
struct Section {
  double radius;
  double coordinate;
};

/// From the face at `high` to the one at `low`.
std::vector<Section> sections_of(const Passage& passage) {
  // Coordinates along the axis are first counted outward from the outer face.
  std::vector<Section> sections;
  double top = 0;
  if (passage.boss_radius > 0) {
    top = passage.boss_height;
    sections = {{passage.boss_radius, 0}, {passage.boss_radius, top}};
  }
  if (passage.counterbore_radius > 0) {
    sections.push_back({passage.counterbore_radius, top});
    top -= passage.counterbore_depth;
    sections.push_back({passage.counterbore_radius, top});
  }
  sections.push_back({passage.radius, top});
  sections.push_back({passage.radius, passage.low - passage.high});
  const double outer_face = passage.outer_side > 0 ? passage.high : passage.low;
  for (Section& section : sections) section.coordinate = outer_face + passage.outer_side * section.coordinate;
  if (passage.outer_side < 0) std::ranges::reverse(sections);
  return sections;
}

/// Points about the origin, counterclockwise, a multiple of four of them: point k/4 of all is where the section reaches
/// farthest along u, v, -u, -v for k = 0, 1, 2, 3.
std::vector<Eigen::Vector2d> outline(double radius, double half_length, int arc_segments) {
  std::vector<Eigen::Vector2d> quarter;  // from u to v, without the end
  if (half_length > 0) quarter.emplace_back(radius, 0);
  for (int k = 0; k < arc_segments; ++k) {
    const double angle = std::numbers::pi / 2 * k / arc_segments;
    quarter.emplace_back(radius * std::cos(angle), half_length + radius * std::sin(angle));
  }
  // The second quarter is the first one mirrored in the v axis, the other way round.
  std::vector<Eigen::Vector2d> points = quarter;
  points.emplace_back(0, half_length + radius);
  for (std::size_t k = quarter.size() - 1; k > 0; --k) points.emplace_back(-quarter[k].x(), quarter[k].y());
  const std::size_t half = points.size();
  for (std::size_t k = 0; k < half; ++k) points.emplace_back(-points[k]);
  return points;
}

/// The surface of boxes on the lattice of all planes in which a box or a passage's frame ends: two triangles a square
/// of the lattice, but for the frames.
class LatticeSurface {
 public:
  LatticeSurface(const MachinedPart& part, int arc_segments) : part_(part), arc_segments_(arc_segments) {
    for (const Box& box : part.boxes) {
      for (int axis = 0; axis < 3; ++axis) add_planes(axis, box.lower[axis], box.upper[axis]);
    }
    for (const Passage& passage : part.passages) {
      for (int i = 0; i < 2; ++i) {
        add_planes((passage.axis + 1 + i) % 3, passage.center[i] - passage.frame[i],
                   passage.center[i] + passage.frame[i]);
      }
    }
    for (std::vector<double>& planes : planes_) remove_repetitions(planes);
    const std::size_t corners = planes_[0].size() * planes_[1].size() * planes_[2].size();
    vertex_of_corner_.assign(corners, kNone);
    fill();
  }

  TriangleSoup build() {
    for (const Passage& passage : part_.passages) add_passage(passage);
    for (int axis = 0; axis < 3; ++axis) add_faces(axis);
    return std::move(soup_);
  }

 private:
  using Corner = std::array<std::size_t, 3>;  ///< numbers of planes
  using Face = std::array<std::size_t, 4>;    ///< axis, and the corner with the lowest numbers
  static constexpr std::uint32_t kNone = 0xffffffffU;

  /// Rectangle of faces: numbers of planes along u and v.
  struct Frame {
    std::array<std::size_t, 2> lower;
    std::array<std::size_t, 2> upper;
  };

  void add_planes(int axis, double low, double high) {
    planes_[static_cast<std::size_t>(axis)].push_back(low);
    planes_[static_cast<std::size_t>(axis)].push_back(high);
  }
  /// Planes that differ by rounding alone are one.
  void remove_repetitions(std::vector<double>& planes) {
    std::ranges::sort(planes);
    tolerance_ = std::max(tolerance_, 1e-9 * (planes.back() - planes.front()));
    const auto same = [&](double a, double b) { return b - a < tolerance_; };
    planes.erase(std::unique(planes.begin(), planes.end(), same), planes.end());
  }
  std::size_t plane_at(std::size_t axis, double coordinate) const {
    const auto& planes = planes_[axis];
    return static_cast<std::size_t>(std::ranges::lower_bound(planes, coordinate - tolerance_) - planes.begin());
  }

  std::size_t index_of(const Corner& corner) const {
    return (corner[2] * planes_[1].size() + corner[1]) * planes_[0].size() + corner[0];
  }
  void fill() {
    filled_.assign(vertex_of_corner_.size(), 0);
    for (const Box& box : part_.boxes) {
      Corner lower{};
      Corner upper{};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        lower[axis] = plane_at(axis, box.lower[static_cast<Eigen::Index>(axis)]);
        upper[axis] = plane_at(axis, box.upper[static_cast<Eigen::Index>(axis)]);
      }
      for (std::size_t k = lower[2]; k < upper[2]; ++k) {
        for (std::size_t j = lower[1]; j < upper[1]; ++j) {
          for (std::size_t i = lower[0]; i < upper[0]; ++i) filled_[index_of({i, j, k})] = 1;
        }
      }
    }
  }
  /// Of the cell above the lowest corner of `cell`, or `steps` cells from there along the axis.
  bool is_filled(Corner cell, std::size_t axis, int steps) const {
    if (steps < 0 && cell[axis] == 0) return false;
    cell[axis] -= steps < 0 ? 1 : 0;
    return filled_[index_of(cell)] != 0;  // cells beyond the last plane are never filled
  }

  std::uint32_t vertex(const Corner& corner) {
    std::uint32_t& number = vertex_of_corner_[index_of(corner)];
    if (number == kNone) {
      number = static_cast<std::uint32_t>(soup_.positions.size());
      soup_.positions.emplace_back(planes_[0][corner[0]], planes_[1][corner[1]], planes_[2][corner[2]]);
    }
    return number;
  }
  /// A triangle that is counterclockwise seen against the axis, for an outward normal along it, or the other way.
  void add_triangle(const Triangle& triangle, bool along_axis) {
    soup_.triangles.push_back(along_axis ? triangle : Triangle{triangle[0], triangle[2], triangle[1]});
  }

  static Corner corner_at(std::size_t axis, std::size_t plane, std::size_t u, std::size_t v) {
    Corner corner{};
    corner[axis] = plane;
    corner[(axis + 1) % 3] = u;
    corner[(axis + 2) % 3] = v;
    return corner;
  }

  void add_passage(const Passage& passage) {
    const auto axis = static_cast<std::size_t>(passage.axis);
    Frame frame{};
    for (std::size_t i = 0; i < 2; ++i) {
      const auto at = static_cast<Eigen::Index>(i);
      frame.lower[i] = plane_at((axis + 1 + i) % 3, passage.center[at] - passage.frame[at]);
      frame.upper[i] = plane_at((axis + 1 + i) % 3, passage.center[at] + passage.frame[at]);
    }
    const std::vector<std::uint32_t> entry = add_wall(passage);
    const std::size_t points = entry.size() / 2;  // the rims at `high` and at `low`
    add_frame(axis, plane_at(axis, passage.high), frame, {entry.data(), points}, true);
    add_frame(axis, plane_at(axis, passage.low), frame, {entry.data() + points, points}, false);
  }

  /// Returns the vertices of the first and of the last section.
  std::vector<std::uint32_t> add_wall(const Passage& passage) {
    std::vector<std::uint32_t> before;
    std::vector<std::uint32_t> rims;
    for (const Section& section : sections_of(passage)) {
      std::vector<std::uint32_t> ring;
      for (const Eigen::Vector2d& point : outline(section.radius, passage.half_length, arc_segments_)) {
        Point position;
        position[passage.axis] = section.coordinate;
        position[(passage.axis + 1) % 3] = passage.center[0] + point[0];
        position[(passage.axis + 2) % 3] = passage.center[1] + point[1];
        ring.push_back(static_cast<std::uint32_t>(soup_.positions.size()));
        soup_.positions.push_back(position);
      }
      for (std::size_t k = 0; k < before.size(); ++k) {
        const std::size_t next = (k + 1) % ring.size();
        soup_.triangles.push_back({before[k], before[next], ring[next]});
        soup_.triangles.push_back({before[k], ring[next], ring[k]});
      }
      if (before.empty()) rims = ring;
      before = std::move(ring);
    }
    rims.insert(rims.end(), before.begin(), before.end());
    return rims;
  }

  /// The ring between a rectangle of faces and a rim in it. Corner k of the rectangle, at 45 + 90 k degrees, sees all
  /// edges of its quadrant of the rim from outside: with (a, 0) and (0, b) the quadrant's ends, the lines of these
  /// edges are n . x = c with n >= 0, so none passes beyond (a, b), and the corner lies beyond that. The rest are
  /// triangles between a side of the rectangle, wherever the lattice cuts it, and the rim's point nearest to it.
  void add_frame(std::size_t axis, std::size_t plane, const Frame& frame, std::span<const std::uint32_t> rim,
                 bool along_axis) {
    take_faces(axis, plane, frame, along_axis);
    const std::size_t quarter = rim.size() / 4;
    const std::vector<Corner> loop = boundary(axis, plane, frame);
    std::size_t at = 0;  // in the loop; it starts at corner 3, before the side that faces point 0 of the rim
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t length = k % 2 == 0 ? frame.upper[1] - frame.lower[1] : frame.upper[0] - frame.lower[0];
      for (std::size_t i = 0; i < length; ++i, ++at) {
        add_triangle({vertex(loop[at]), vertex(loop[(at + 1) % loop.size()]), rim[k * quarter]}, along_axis);
      }
      const std::uint32_t corner = vertex(loop[at % loop.size()]);
      for (std::size_t i = k * quarter; i < (k + 1) * quarter; ++i) {
        add_triangle({rim[i], corner, rim[(i + 1) % rim.size()]}, along_axis);
      }
    }
  }
  /// Counterclockwise from the corner of the highest u and the lowest v.
  static std::vector<Corner> boundary(std::size_t axis, std::size_t plane, const Frame& frame) {
    const auto [u0, v0] = frame.lower;
    const auto [u1, v1] = frame.upper;
    std::vector<Corner> loop;
    for (std::size_t v = v0; v < v1; ++v) loop.push_back(corner_at(axis, plane, u1, v));
    for (std::size_t u = u1; u > u0; --u) loop.push_back(corner_at(axis, plane, u, v1));
    for (std::size_t v = v1; v > v0; --v) loop.push_back(corner_at(axis, plane, u0, v));
    for (std::size_t u = u0; u < u1; ++u) loop.push_back(corner_at(axis, plane, u, v0));
    return loop;
  }
  void take_faces(std::size_t axis, std::size_t plane, const Frame& frame, bool along_axis) {
    for (std::size_t v = frame.lower[1]; v < frame.upper[1]; ++v) {
      for (std::size_t u = frame.lower[0]; u < frame.upper[0]; ++u) {
        const Corner corner = corner_at(axis, plane, u, v);
        const bool free = is_filled(corner, axis, -1) == along_axis && is_filled(corner, axis, 0) != along_axis;
        if (!free || !taken_.insert({axis, corner[0], corner[1], corner[2]}).second) {
          throw InputError("a passage's frame is not on free faces");
        }
      }
    }
  }

  /// The squares across `axis` that no frame took.
  void add_faces(std::size_t axis) {
    const std::size_t u = (axis + 1) % 3;
    const std::size_t v = (axis + 2) % 3;
    for (std::size_t plane = 0; plane < planes_[axis].size(); ++plane) {
      for (std::size_t j = 0; j + 1 < planes_[v].size(); ++j) {
        for (std::size_t i = 0; i + 1 < planes_[u].size(); ++i) {
          const Corner corner = corner_at(axis, plane, i, j);
          const bool below = is_filled(corner, axis, -1);
          if (below == is_filled(corner, axis, 0)) continue;
          if (taken_.contains({axis, corner[0], corner[1], corner[2]})) continue;
          const std::uint32_t a = vertex(corner);
          const std::uint32_t b = vertex(corner_at(axis, plane, i + 1, j));
          const std::uint32_t c = vertex(corner_at(axis, plane, i + 1, j + 1));
          const std::uint32_t d = vertex(corner_at(axis, plane, i, j + 1));
          add_triangle({a, b, c}, below);
          add_triangle({a, c, d}, below);
        }
      }
    }
  }

  const MachinedPart& part_;
  int arc_segments_;
  std::array<std::vector<double>, 3> planes_;
  double tolerance_ = 0;
  std::vector<std::uint32_t> vertex_of_corner_;
  std::vector<std::uint8_t> filled_;  ///< cells, by their lowest corners
  std::set<Face> taken_;
  TriangleSoup soup_;
};

/// What `solid_of` gives, from its parts.
class MachinedSolid {
 public:
  explicit MachinedSolid(const MachinedPart& part) : boxes_(part.boxes) {
    for (const Passage& passage : part.passages) add(passage);
  }

  bool inside(const Point& p) const {
    const auto holds = [&](const RoundPrism& prism) { return prism.holds(p); };
    const auto in_box = [&](const Box& box) {
      return (p.array() >= box.lower.array()).all() && (p.array() <= box.upper.array()).all();
    };
    if (std::ranges::none_of(boxes_, in_box) && std::ranges::none_of(bosses_, holds)) return false;
    return std::ranges::none_of(bores_, [&](const RoundPrism& prism) { return prism.holds_within(p); });
  }

  double signed_clearance(const Point& p) const {
    double material = std::numeric_limits<double>::infinity();
    for (const Box& box : boxes_) material = std::min(material, box_clearance(p, box));
    for (const RoundPrism& boss : bosses_) material = std::min(material, boss.clearance(p));
    double removed = std::numeric_limits<double>::infinity();
    for (const RoundPrism& bore : bores_) removed = std::min(removed, bore.clearance(p));
    return std::max(material, -removed);
  }

  Box bounds() const {
    Box box;
    for (const Box& part : boxes_) box.extend(part);
    for (const RoundPrism& boss : bosses_) box.extend(boss.bounds());
    return box;
  }

 private:
  /// Cuts reach out of the material by a quarter of the length, lest a skin without thickness stay where faces are
  /// flush; bosses reach into it as far as the other face, where they add nothing.
  void add(const Passage& passage) {
    const double beyond = (passage.high - passage.low) / 4;
    const bool at_high = passage.outer_side > 0;
    const double height = passage.boss_radius > 0 ? passage.boss_height : 0;
    RoundPrism prism{passage.axis, passage.center, passage.half_length, 0, passage.low, passage.high};
    double& outer = at_high ? prism.high : prism.low;
    outer += passage.outer_side * height;
    if (passage.boss_radius > 0) {
      prism.radius = passage.boss_radius;
      bosses_.push_back(prism);
    }
    if (passage.counterbore_radius > 0) {
      RoundPrism counterbore = prism;
      counterbore.radius = passage.counterbore_radius;
      (at_high ? counterbore.low : counterbore.high) = outer - passage.outer_side * passage.counterbore_depth;
      (at_high ? counterbore.high : counterbore.low) = outer + passage.outer_side * beyond;
      bores_.push_back(counterbore);
    }
    prism.radius = passage.radius;
    prism.low -= beyond;
    prism.high += beyond;
    bores_.push_back(prism);
  }

  std::vector<Box> boxes_;
  std::vector<RoundPrism> bosses_;
  std::vector<RoundPrism> bores_;
};

}  // namespace

MachinedPart scaled(MachinedPart part, double factor) {
  for (Box& box : part.boxes) {
    box.lower *= factor;
    box.upper *= factor;
  }
  for (Passage& passage : part.passages) {
    passage.center *= factor;
    passage.frame *= factor;
    for (double* length : {&passage.low, &passage.high, &passage.radius, &passage.half_length, &passage.boss_radius,
                           &passage.boss_height, &passage.counterbore_radius, &passage.counterbore_depth}) {
      *length *= factor;
    }
  }
  return part;
}

TriangleSoup surface_of(const MachinedPart& part, int arc_segments) {
  return LatticeSurface(part, arc_segments).build();
}

ImplicitSolid solid_of(const MachinedPart& part) {
  return implicit_solid(MachinedSolid(part));
}

}  // namespace voxcarve
