#include "common/mesh/models/primitives.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <unordered_map>

#include "common/run/errors.h"

namespace voxcarve {

namespace {

using std::numbers::pi;

void require_rings(std::span<const Ring> rings, LoftEnds ends) {
  const std::size_t needed = ends == LoftEnds::kJoined ? 3 : 2;
  if (rings.size() < needed) throw InputError("a loft needs at least " + std::to_string(needed) + " rings");
  std::size_t points = 3;
  for (const Ring& ring : rings) points = std::max(points, ring.size());
  for (std::size_t i = 0; i < rings.size(); ++i) {
    const bool may_be_pole = ends == LoftEnds::kCapped && (i == 0 || i + 1 == rings.size());
    if (rings[i].size() == points || (may_be_pole && rings[i].size() == 1)) continue;
    throw InputError("ring " + std::to_string(i) + " of a loft has " + std::to_string(rings[i].size()) +
                     " points and another has " + std::to_string(points) + "; all need as many, at least 3");
  }
  if (std::ranges::all_of(rings, [](const Ring& ring) { return ring.size() == 1; })) {
    throw InputError("a loft needs a ring between its poles");
  }
}

/// Triangles between two rings whose points start at vertex `a` and `b`; either may be a pole.
void add_belt(TriangleSoup& soup, std::uint32_t a, std::size_t a_size, std::uint32_t b, std::size_t b_size) {
  const auto points = static_cast<std::uint32_t>(std::max(a_size, b_size));
  for (std::uint32_t k = 0; k < points; ++k) {
    const std::uint32_t next = (k + 1) % points;
    if (a_size == 1) {
      soup.triangles.push_back({a, b + next, b + k});
    } else if (b_size == 1) {
      soup.triangles.push_back({a + k, a + next, b});
    } else {
      soup.triangles.push_back({a + k, a + next, b + next});
      soup.triangles.push_back({a + k, b + next, b + k});
    }
  }
}

void add_cap(TriangleSoup& soup, std::uint32_t first, std::size_t size, bool at_start) {
  for (std::uint32_t k = 1; k + 1 < size; ++k) {
    soup.triangles.push_back(at_start ? Triangle{first, first + k + 1, first + k}
                                      : Triangle{first, first + k, first + k + 1});
  }
}

Ring circle(const Point& center, const Point& u, const Point& v, double radius, int sides) {
  Ring ring;
  for (int k = 0; k < sides; ++k) {
    const double angle = 2 * pi * k / sides;
    ring.emplace_back(center + radius * (std::cos(angle) * u + std::sin(angle) * v));
  }
  return ring;
}

/// A unit vector perpendicular to the unit vector `direction`, always the same one.
Point any_perpendicular(const Point& direction) {
  Eigen::Index axis = 0;
  direction.cwiseAbs().minCoeff(&axis);
  const Point helper = Point::Unit(axis);
  return (helper - helper.dot(direction) * direction).normalized();
}

/// Puts a solid that was built about the z axis at `origin` along `direction`.
Eigen::Affine3d placement(const Point& origin, const Point& direction) {
  const Point w = direction.normalized();
  const Point u = any_perpendicular(w);
  Eigen::Affine3d map = Eigen::Affine3d::Identity();
  map.linear().col(0) = u;
  map.linear().col(1) = w.cross(u);
  map.linear().col(2) = w;
  map.translation() = origin;
  return map;
}

}  // namespace

TriangleSoup loft(std::span<const Ring> rings, LoftEnds ends) {
  require_rings(rings, ends);
  TriangleSoup soup;
  std::vector<std::uint32_t> first;
  for (const Ring& ring : rings) {
    first.push_back(static_cast<std::uint32_t>(soup.positions.size()));
    soup.positions.insert(soup.positions.end(), ring.begin(), ring.end());
  }
  for (std::size_t i = 0; i + 1 < rings.size(); ++i) {
    add_belt(soup, first[i], rings[i].size(), first[i + 1], rings[i + 1].size());
  }
  if (ends == LoftEnds::kJoined) {
    add_belt(soup, first.back(), rings.back().size(), first.front(), rings.front().size());
  } else {
    add_cap(soup, first.front(), rings.front().size(), true);
    add_cap(soup, first.back(), rings.back().size(), false);
  }
  return soup;
}

TriangleSoup lathe(std::span<const Eigen::Vector2d> profile, int slices) {
  std::vector<Ring> rings;
  for (const Eigen::Vector2d& point : profile) {
    const Point center(0, 0, point.y());
    rings.push_back(point.x() > 0 ? circle(center, Point::UnitX(), Point::UnitY(), point.x(), slices) : Ring{center});
  }
  return loft(rings);
}

TriangleSoup lathe(std::span<const Eigen::Vector2d> profile, int slices, const Point& origin, const Point& direction) {
  return transformed(lathe(profile, slices), placement(origin, direction));
}

TriangleSoup box(const Point& lower, const Point& upper) {
  std::array<Ring, 2> rings;
  for (std::size_t end = 0; end < 2; ++end) {
    const double z = end == 0 ? lower.z() : upper.z();
    rings[end] = {
        {lower.x(), lower.y(), z}, {upper.x(), lower.y(), z}, {upper.x(), upper.y(), z}, {lower.x(), upper.y(), z}};
  }
  return loft(rings);
}

TriangleSoup uv_sphere(const Point& center, double radius, int slices, int stacks) {
  std::vector<Eigen::Vector2d> profile;
  for (int i = 0; i <= stacks; ++i) {
    const double angle = pi * i / stacks;
    const bool pole = i == 0 || i == stacks;
    profile.emplace_back(pole ? 0 : radius * std::sin(angle), -radius * std::cos(angle));
  }
  return transformed(lathe(profile, slices), Eigen::Affine3d(Eigen::Translation3d(center)));
}

TriangleSoup icosphere(const Point& center, double radius, int subdivision) {
  const double g = std::numbers::phi;
  TriangleSoup soup;
  soup.positions = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                    {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  soup.triangles = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                    {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                    {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (Point& position : soup.positions) position.normalize();
  for (int level = 0; level < subdivision; ++level) {
    std::unordered_map<std::uint64_t, std::uint32_t> midpoint_of;
    midpoint_of.reserve(soup.triangles.size() * 3 / 2);
    const auto midpoint = [&](std::uint32_t a, std::uint32_t b) {
      const std::uint64_t key = (std::uint64_t{std::min(a, b)} << 32U) | std::max(a, b);
      const auto [entry, added] = midpoint_of.try_emplace(key, static_cast<std::uint32_t>(soup.positions.size()));
      if (added) soup.positions.emplace_back((soup.positions[a] + soup.positions[b]).normalized());
      return entry->second;
    };
    std::vector<Triangle> finer;
    finer.reserve(4 * soup.triangles.size());
    for (const auto& [a, b, c] : soup.triangles) {
      const std::uint32_t ab = midpoint(a, b);
      const std::uint32_t bc = midpoint(b, c);
      const std::uint32_t ca = midpoint(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    soup.triangles = std::move(finer);
  }
  for (Point& position : soup.positions) position = center + radius * position;
  return soup;
}

TriangleSoup cylinder(const Point& a, const Point& b, double radius, int sides) {
  const std::array<Point, 2> path = {a, b};
  return swept_tube(path, radius, sides);
}

TriangleSoup capsule(const Point& a, double radius_a, const Point& b, double radius_b, int slices, int stacks) {
  const double length = (b - a).norm();
  const double sine = length > 0 ? (radius_a - radius_b) / length : 1;
  if (std::abs(sine) >= 1) throw InputError("a capsule needs two balls of which none holds the other");
  // The cone touches both balls at the same latitude.
  const double latitude = std::asin(sine);
  const int bottom = std::max(1, stacks / 3);
  const int top = std::max(1, stacks / 3);
  const int side = stacks - bottom - top;
  std::vector<Eigen::Vector2d> profile = {{0, -radius_a}};
  for (int i = 1; i <= bottom; ++i) {
    const double angle = -pi / 2 + (latitude + pi / 2) * i / bottom;
    profile.emplace_back(radius_a * std::cos(angle), radius_a * std::sin(angle));
  }
  const Eigen::Vector2d low = profile.back();
  const Eigen::Vector2d high(radius_b * std::cos(latitude), length + radius_b * std::sin(latitude));
  for (int i = 1; i <= side; ++i) profile.emplace_back(low + (high - low) * (static_cast<double>(i) / side));
  for (int i = 1; i < top; ++i) {
    const double angle = latitude + (pi / 2 - latitude) * i / top;
    profile.emplace_back(radius_b * std::cos(angle), length + radius_b * std::sin(angle));
  }
  profile.emplace_back(0, length + radius_b);
  return transformed(lathe(profile, slices), placement(a, b - a));
}

TriangleSoup torus(double major, double minor, int segments, int tube_segments) {
  std::vector<Ring> rings;
  for (int i = 0; i < segments; ++i) {
    const double angle = 2 * pi * i / segments;
    const Point outward(std::cos(angle), std::sin(angle), 0);
    // Travel is tangential, z cross outward; z and outward span the section counterclockwise about it.
    rings.push_back(circle(major * outward, Point::UnitZ(), outward, minor, tube_segments));
  }
  return loft(rings, LoftEnds::kJoined);
}

TriangleSoup swept_tube(std::span<const Point> path, double radius, int sides) {
  if (path.size() < 2) throw InputError("a tube needs a path of at least two points");
  std::vector<Ring> rings;
  Point u = Point::Zero();
  for (std::size_t i = 0; i < path.size(); ++i) {
    const Point tangent = (path[std::min(i + 1, path.size() - 1)] - path[i > 0 ? i - 1 : 0]).normalized();
    u = i == 0 ? any_perpendicular(tangent) : Point((u - u.dot(tangent) * tangent).normalized());
    rings.push_back(circle(path[i], u, tangent.cross(u), radius, sides));
  }
  return loft(rings);
}

std::vector<Point> smooth_path(std::span<const Point> controls, int segments) {
  if (controls.size() < 2) throw InputError("a smooth path needs at least two controls");
  const auto control = [&](std::size_t i) { return controls[std::min(i, controls.size() - 1)]; };
  std::vector<Point> path = {controls.front()};
  for (std::size_t i = 0; i + 1 < controls.size(); ++i) {
    const Point before = i > 0 ? controls[i - 1] : controls[0];
    const Point start = control(i);
    const Point end = control(i + 1);
    const Point after = control(i + 2);
    for (int k = 1; k <= segments; ++k) {
      const double t = static_cast<double>(k) / segments;
      const Point slope = 0.5 * (end - before);
      const Point quadratic = before - 2.5 * start + 2 * end - 0.5 * after;
      const Point cubic = 0.5 * (after - before) + 1.5 * (start - end);
      path.emplace_back(start + t * (slope + t * (quadratic + t * cubic)));
    }
  }
  return path;
}

TriangleSoup hourglass(const Point& a, const Point& b, double radius, int sides) {
  const Point tip = 0.5 * (a + b);
  const double height = 0.5 * (b - a).norm();
  const std::array<Eigen::Vector2d, 2> lower = {Eigen::Vector2d(radius, 0), Eigen::Vector2d(0, height)};
  const std::array<Eigen::Vector2d, 2> upper = {Eigen::Vector2d(0, height), Eigen::Vector2d(radius, 2 * height)};
  TriangleSoup soup = lathe(lower, sides, a, b - a);
  const auto lower_tip = static_cast<std::uint32_t>(soup.positions.size() - 1);
  const auto upper_tip = static_cast<std::uint32_t>(soup.positions.size());
  append(soup, lathe(upper, sides, a, b - a));
  for (Triangle& triangle : soup.triangles) std::ranges::replace(triangle, upper_tip, lower_tip);
  soup.positions[lower_tip] = tip;
  remove_unused_vertices(soup);
  return soup;
}

namespace {

/// Vertices on a lattice, created when first asked for.
class LatticeVertices {
 public:
  LatticeVertices(TriangleSoup& soup, const std::array<int, 3>& dims, double spacing)
      : soup_(soup),
        nx_(static_cast<std::uint64_t>(dims[0]) + 1),
        ny_(static_cast<std::uint64_t>(dims[1]) + 1),
        spacing_(spacing) {}

  std::uint32_t operator()(const Eigen::Vector3i& at) {
    const auto [x, y, z] = std::array{static_cast<std::uint64_t>(at[0]), static_cast<std::uint64_t>(at[1]),
                                      static_cast<std::uint64_t>(at[2])};
    const auto [entry, added] =
        index_of_.try_emplace((z * ny_ + y) * nx_ + x, static_cast<std::uint32_t>(soup_.positions.size()));
    if (added) soup_.positions.emplace_back(spacing_ * at.cast<double>());
    return entry->second;
  }

 private:
  TriangleSoup& soup_;
  std::uint64_t nx_;
  std::uint64_t ny_;
  double spacing_;
  std::unordered_map<std::uint64_t, std::uint32_t> index_of_;
};

}  // namespace

TriangleSoup block_surface(const std::array<int, 3>& dims, const std::function<bool(int, int, int)>& filled,
                           double cell_size, int subdivision) {
  TriangleSoup soup;
  LatticeVertices vertex(soup, {dims[0] * subdivision, dims[1] * subdivision, dims[2] * subdivision},
                         cell_size / subdivision);
  const auto exposed = [&](Eigen::Vector3i cell, int axis, int side) {
    cell[axis] += side;
    return cell[axis] < 0 || cell[axis] >= dims[static_cast<std::size_t>(axis)] || !filled(cell[0], cell[1], cell[2]);
  };
  const auto add_face = [&](const Eigen::Vector3i& cell, int axis, int side) {
    // u, v and the face's outward normal are right-handed.
    const Eigen::Vector3i u = Eigen::Vector3i::Unit((axis + (side > 0 ? 1 : 2)) % 3);
    const Eigen::Vector3i v = Eigen::Vector3i::Unit((axis + (side > 0 ? 2 : 1)) % 3);
    const Eigen::Vector3i corner =
        subdivision * (side > 0 ? Eigen::Vector3i(cell + Eigen::Vector3i::Unit(axis)) : cell);
    for (int j = 0; j < subdivision; ++j) {
      for (int i = 0; i < subdivision; ++i) {
        const Eigen::Vector3i low = corner + i * u + j * v;
        const std::uint32_t a = vertex(low);
        const std::uint32_t b = vertex(low + u);
        const std::uint32_t c = vertex(low + u + v);
        const std::uint32_t d = vertex(low + v);
        soup.triangles.push_back({a, b, c});
        soup.triangles.push_back({a, c, d});
      }
    }
  };
  for (int k = 0; k < dims[2]; ++k) {
    for (int j = 0; j < dims[1]; ++j) {
      for (int i = 0; i < dims[0]; ++i) {
        if (!filled(i, j, k)) continue;
        for (int face = 0; face < 6; ++face) {
          const int side = face % 2 == 0 ? -1 : 1;
          if (exposed({i, j, k}, face / 2, side)) add_face({i, j, k}, face / 2, side);
        }
      }
    }
  }
  return soup;
}

TriangleSoup transformed(TriangleSoup soup, const Eigen::Affine3d& map) {
  for (Point& position : soup.positions) position = map * position;
  if (map.linear().determinant() < 0) {
    for (Triangle& triangle : soup.triangles) std::swap(triangle[1], triangle[2]);
  }
  return soup;
}

TriangleSoup as_cavity(TriangleSoup soup) {
  for (Triangle& triangle : soup.triangles) std::swap(triangle[1], triangle[2]);
  return soup;
}

TriangleSoup colored(TriangleSoup soup, const Color& color) {
  soup.triangle_colors.assign(soup.triangles.size(), color);
  return soup;
}

}  // namespace voxcarve
