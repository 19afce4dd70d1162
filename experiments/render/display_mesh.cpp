#include "experiments/render/display_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <span>
#include <tuple>

#include "common/mesh/topology.h"

namespace voxcarve {

UnitFrame UnitFrame::of(const Box& box) {
  UnitFrame frame;
  if (box.empty()) return frame;
  // Halved before they are added: the sum of two finite coordinates need not be finite.
  frame.center = 0.5 * box.lower + 0.5 * box.upper;
  const double half_extent = (0.5 * box.upper - 0.5 * box.lower).maxCoeff();
  if (half_extent > 0) frame.half_extent = half_extent;
  return frame;
}

namespace {

/// An edge of many faces is compared with this many of its earlier ones only, which bounds the time of hostile input.
constexpr std::size_t kFacesComparedAtAnEdge = 16;

/// Slack of the cosine, so that coplanar faces stay together at a crease angle of 0.
constexpr double kCosineSlack = 1e-12;

std::uint8_t to_byte(float channel) {
  if (!(channel > 0)) return 0;
  return channel >= 1 ? std::uint8_t{255} : static_cast<std::uint8_t>(std::lround(channel * 255));
}

Rgb8 color_of(const TriangleSoup& soup, std::size_t triangle, std::uint32_t vertex) {
  const Color* color = nullptr;
  if (!soup.triangle_colors.empty()) {
    color = &soup.triangle_colors[triangle];
  } else if (!soup.vertex_colors.empty()) {
    color = &soup.vertex_colors[vertex];
  }
  return color == nullptr ? kNeutralColor : Rgb8{to_byte(color->x()), to_byte(color->y()), to_byte(color->z())};
}

/// Builds a DisplayMesh vertex by vertex. A corner is numbered 3 * triangle + (0, 1, 2).
class CreaseSplitter {
 public:
  CreaseSplitter(const TriangleSoup& soup, const UnitFrame& frame, double crease_angle)
      : soup_(soup),
        welded_(merge_equal_positions(soup)),
        least_cosine_(std::cos(crease_angle * std::numbers::pi / 180) - kCosineSlack) {
    for (Point& position : welded_.positions) position = frame.to_unit(position);
    compute_faces();
    collect_corners();
  }

  DisplayMesh build(bool with_edges) {
    mesh_.triangles.resize(soup_.triangles.size());
    find_two_sided();
    first_copy_.resize(welded_.positions.size());
    for (std::size_t vertex = 0; vertex < welded_.positions.size(); ++vertex) {
      first_copy_[vertex] = static_cast<std::uint32_t>(mesh_.positions.size());
      const std::span<const std::uint32_t> corners(corners_.data() + first_corner_[vertex],
                                                   first_corner_[vertex + 1] - first_corner_[vertex]);
      group_corners(corners);
      sum_normals(corners);
      emit_copies(corners, welded_.positions[vertex]);
    }
    if (with_edges) collect_edges();
    return std::move(mesh_);
  }

 private:
  std::uint32_t vertex_of(std::uint32_t corner, std::uint32_t steps) const {
    return welded_.triangles[corner / 3][(corner % 3 + steps) % 3];
  }

  /// Unit normals; zero for a degenerate triangle.
  void compute_faces() {
    face_normals_.reserve(welded_.triangles.size());
    for (const Triangle& triangle : welded_.triangles) {
      const Point normal = area_vector(welded_, triangle).stableNormalized();
      face_normals_.push_back(normal.allFinite() ? normal : Point(Point::Zero()));
    }
  }

  /// The corners at each vertex, one after the other.
  void collect_corners() {
    first_corner_.assign(welded_.positions.size() + 1, 0);
    for (const Triangle& triangle : welded_.triangles) {
      for (const std::uint32_t vertex : triangle) ++first_corner_[vertex + 1];
    }
    std::partial_sum(first_corner_.begin(), first_corner_.end(), first_corner_.begin());
    std::vector<std::size_t> next(first_corner_.begin(), first_corner_.end() - 1);
    corners_.resize(3 * welded_.triangles.size());
    for (std::uint32_t corner = 0; corner < corners_.size(); ++corner) {
      corners_[next[vertex_of(corner, 0)]++] = corner;
    }
  }

  const Point& normal_at(std::uint32_t corner) const { return face_normals_[corner / 3]; }

  std::uint32_t root(std::uint32_t member) {
    while (group_[member] != member) member = group_[member] = group_[group_[member]];
    return member;
  }

  /// Links the corners of one vertex across the edges that leave it.
  void group_corners(std::span<const std::uint32_t> corners) {
    group_.resize(corners.size());
    std::iota(group_.begin(), group_.end(), 0U);
    spokes_.clear();
    for (std::uint32_t member = 0; member < corners.size(); ++member) {
      if (normal_at(corners[member]).isZero(0)) continue;
      spokes_.push_back({vertex_of(corners[member], 1), member});
      spokes_.push_back({vertex_of(corners[member], 2), member});
    }
    std::sort(spokes_.begin(), spokes_.end());
    std::size_t run = 0;
    for (std::size_t i = 0; i < spokes_.size(); ++i) {
      if (spokes_[i][0] != spokes_[run][0]) run = i;
      for (std::size_t j = std::max(run, i - std::min(i, kFacesComparedAtAnEdge)); j < i; ++j) {
        const double cosine = normal_at(corners[spokes_[i][1]]).dot(normal_at(corners[spokes_[j][1]]));
        if (cosine >= least_cosine_) group_[root(spokes_[i][1])] = root(spokes_[j][1]);
      }
    }
  }

  void sum_normals(std::span<const std::uint32_t> corners) {
    sums_.assign(corners.size(), Point::Zero());
    for (std::uint32_t member = 0; member < corners.size(); ++member) {
      const Point& apex = welded_.positions[vertex_of(corners[member], 0)];
      const Point a = welded_.positions[vertex_of(corners[member], 1)] - apex;
      const Point b = welded_.positions[vertex_of(corners[member], 2)] - apex;
      sums_[root(member)] += std::atan2(a.cross(b).norm(), a.dot(b)) * normal_at(corners[member]);
    }
  }

  /// The normal of a corner: its group's, or its own face's where the group cancels out.
  Eigen::Vector3f normal_of(std::uint32_t member, std::uint32_t corner) {
    Point normal = sums_[root(member)].stableNormalized();
    if (!(normal.squaredNorm() > 0.5)) normal = normal_at(corner);
    if (normal.isZero(0)) normal = Point::UnitZ();
    return normal.cast<float>();
  }

  /// One display vertex for each combination of group, vertex of the soup and colour.
  void emit_copies(std::span<const std::uint32_t> corners, const Point& position) {
    copies_.clear();
    for (std::uint32_t member = 0; member < corners.size(); ++member) {
      const std::uint32_t corner = corners[member];
      const std::uint32_t vertex = soup_.triangles[corner / 3][corner % 3];
      copies_.push_back({root(member), color_of(soup_, corner / 3, vertex), member});
    }
    std::sort(copies_.begin(), copies_.end());
    for (std::size_t i = 0; i < copies_.size(); ++i) {
      const auto& [group, color, member] = copies_[i];
      const std::uint32_t corner = corners[member];
      if (i == 0 || group != std::get<0>(copies_[i - 1]) || color != std::get<1>(copies_[i - 1])) {
        mesh_.positions.push_back(position.cast<float>());
        mesh_.normals.push_back(normal_of(member, corner));
        mesh_.colors.push_back(color);
      }
      mesh_.triangles[corner / 3][corner % 3] = static_cast<std::uint32_t>(mesh_.positions.size() - 1);
    }
  }

  /// Triangles of the same three positions stand together when their corners are sorted; how these were ordered before
  /// tells one side from the other.
  void find_two_sided() {
    struct Side {
      Triangle corners;
      bool turned;
      std::size_t triangle;
    };
    std::vector<Side> sides;
    sides.reserve(welded_.triangles.size());
    for (std::size_t t = 0; t < welded_.triangles.size(); ++t) {
      Triangle corners = welded_.triangles[t];
      if (!has_distinct_corners(corners)) continue;
      std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
      const bool turned = corners[1] > corners[2];
      if (turned) std::swap(corners[1], corners[2]);
      sides.push_back({corners, turned, t});
    }
    std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
      return std::tie(a.corners, a.turned) < std::tie(b.corners, b.turned);
    });
    mesh_.two_sided.assign(welded_.triangles.size(), false);
    for (std::size_t first = 0, end = 0; first < sides.size(); first = end) {
      while (end < sides.size() && sides[end].corners == sides[first].corners) ++end;
      if (sides[first].turned == sides[end - 1].turned) continue;
      for (std::size_t i = first; i < end; ++i) mesh_.two_sided[sides[i].triangle] = true;
    }
  }

  void collect_edges() {
    std::vector<std::array<std::uint32_t, 2>>& edges = mesh_.edges;
    edges.reserve(3 * welded_.triangles.size());
    for (const Triangle& triangle : welded_.triangles) {
      for (std::size_t side = 0; side < 3; ++side) {
        const auto [a, b] = std::minmax(triangle[side], triangle[(side + 1) % 3]);
        if (a != b) edges.push_back({first_copy_[a], first_copy_[b]});
      }
    }
    std::sort(edges.begin(), edges.end());
    edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  }

  const TriangleSoup& soup_;
  TriangleSoup welded_;  ///< equal positions merged, in the unit frame
  double least_cosine_;
  std::vector<Point> face_normals_;
  std::vector<std::size_t> first_corner_;
  std::vector<std::uint32_t> corners_;
  std::vector<std::uint32_t> first_copy_;  ///< display vertex of a welded vertex
  DisplayMesh mesh_;

  // Of the vertex at hand; kept to save allocations.
  std::vector<std::uint32_t> group_;                  ///< union-find parents
  std::vector<std::array<std::uint32_t, 2>> spokes_;  ///< the other end of an edge, and a corner beside it
  std::vector<Point> sums_;
  std::vector<std::tuple<std::uint32_t, Rgb8, std::uint32_t>> copies_;
};

}  // namespace

DisplayMesh make_display_mesh(const TriangleSoup& soup, const UnitFrame& frame, double crease_angle, bool with_edges) {
  return CreaseSplitter(soup, frame, crease_angle).build(with_edges);
}

}  // namespace voxcarve
