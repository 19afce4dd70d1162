#include "common/mesh/models/tubes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "common/run/errors.h"

namespace voxcarve {

std::vector<Ring> tube_rings(std::span<const Point> path, const Point& reference,
                             const std::function<HalfAxes(double share)>& half_axes, int sides) {
  if (path.size() < 2) throw InputError("a tube needs a path of at least two points");
  std::vector<double> travelled = {0};
  for (std::size_t i = 1; i < path.size(); ++i) travelled.push_back(travelled.back() + (path[i] - path[i - 1]).norm());
  std::vector<Ring> rings;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const Point tangent = (path[std::min(i + 1, path.size() - 1)] - path[i > 0 ? i - 1 : 0]).normalized();
    const Point along = (reference - reference.dot(tangent) * tangent).normalized();
    const Point across = tangent.cross(along);
    const HalfAxes axes = half_axes(travelled[i] / travelled.back());
    Ring ring;
    for (int k = 0; k < sides; ++k) {
      const double angle = 2 * std::numbers::pi * k / sides;
      ring.emplace_back(path[i] + axes.along * std::cos(angle) * along + axes.across * std::sin(angle) * across);
    }
    rings.push_back(std::move(ring));
  }
  return rings;
}

std::vector<Ring> spindle_rings(std::span<const Point> path, const Point& reference,
                                const std::function<HalfAxes(double share)>& half_axes, int sides) {
  std::vector<Ring> rings = tube_rings(path, reference, half_axes, sides);
  rings.front() = {path.front()};
  rings.back() = {path.back()};
  return rings;
}

std::vector<Point> evenly_spaced(std::span<const Point> path, int segments, double stand_off) {
  double length = 0;
  for (std::size_t i = 1; i < path.size(); ++i) length += (path[i] - path[i - 1]).norm();
  const double spacing = (length - 2 * stand_off) / (segments - 2);
  std::vector<Point> points = {path.front()};
  double travelled = 0;
  for (std::size_t i = 1; i < path.size(); ++i) {
    const double step = (path[i] - path[i - 1]).norm();
    while (static_cast<int>(points.size()) < segments) {
      const double share = (stand_off + spacing * static_cast<double>(points.size() - 1) - travelled) / step;
      if (share > 1) break;
      points.emplace_back(path[i - 1] + share * (path[i] - path[i - 1]));
    }
    travelled += step;
  }
  points.push_back(path.back());
  return points;
}

TubeNetwork::RingOfVertices TubeNetwork::add_vertices(const Ring& ring) {
  RingOfVertices vertices(ring.size());
  std::iota(vertices.begin(), vertices.end(), static_cast<std::uint32_t>(positions_.size()));
  positions_.insert(positions_.end(), ring.begin(), ring.end());
  return vertices;
}

std::size_t TubeNetwork::add_body(std::span<const Ring> rings) {
  Piece piece{.rings = {}, .capped_at_start = true, .capped_at_end = true, .removed = {}};
  for (const Ring& ring : rings) piece.rings.push_back(add_vertices(ring));
  pieces_.push_back(std::move(piece));
  return pieces_.size() - 1;
}

bool TubeNetwork::has_quad(const Piece& piece, std::size_t ring, std::size_t side) {
  return ring + 1 < piece.rings.size() && piece.rings[ring].size() > 1 && piece.rings[ring + 1].size() > 1 &&
         std::ranges::find(piece.removed, std::array{ring, side}) == piece.removed.end();
}

TubeNetwork::Opening TubeNetwork::open(std::size_t piece_index, std::size_t ring, std::size_t side) {
  Piece& piece = pieces_.at(piece_index);
  const std::size_t sides = ring < piece.rings.size() ? piece.rings[ring].size() : 0;
  if (ring == 0 || side >= sides) throw InputError("an opening needs a ring before and after it");
  const std::size_t before = (side + sides - 1) % sides;
  const std::size_t after = (side + 1) % sides;
  const std::array<std::array<std::size_t, 2>, 4> quads = {
      {{ring - 1, before}, {ring - 1, side}, {ring, before}, {ring, side}}};
  for (const auto& [row, column] : quads) {
    if (!has_quad(piece, row, column)) throw InputError("an opening reaches into an end or into another opening");
  }
  piece.removed.insert(piece.removed.end(), quads.begin(), quads.end());
  const RingOfVertices& lower = piece.rings[ring - 1];
  const RingOfVertices& middle = piece.rings[ring];
  const RingOfVertices& upper = piece.rings[ring + 1];
  Opening opening{{lower[before], lower[side], lower[after], middle[after], upper[after], upper[side], upper[before],
                   middle[before]},
                  positions_[middle[side]],
                  Point::Zero()};
  for (std::size_t k = 0; k < kSides; ++k) {
    const Point from = positions_[opening.rim[k]] - opening.center;
    opening.normal += from.cross(positions_[opening.rim[(k + 1) % kSides]] - opening.center);
  }
  opening.normal.normalize();
  return opening;
}

TubeNetwork::RingOfVertices TubeNetwork::aligned(RingOfVertices rim, const Ring& ring) const {
  if (ring.size() != rim.size()) return rim;  // a pole, or rings of another size, which surface() would refuse
  Point rim_center = Point::Zero();
  Point ring_center = Point::Zero();
  for (std::size_t k = 0; k < ring.size(); ++k) {
    rim_center += positions_[rim[k]] / static_cast<double>(ring.size());
    ring_center += ring[k] / static_cast<double>(ring.size());
  }
  std::size_t best = 0;
  double best_agreement = -std::numeric_limits<double>::infinity();
  for (std::size_t turn = 0; turn < ring.size(); ++turn) {
    double agreement = 0;
    for (std::size_t k = 0; k < ring.size(); ++k) {
      agreement += (positions_[rim[(k + turn) % rim.size()]] - rim_center).dot(ring[k] - ring_center);
    }
    if (agreement > best_agreement) {
      best_agreement = agreement;
      best = turn;
    }
  }
  std::ranges::rotate(rim, rim.begin() + static_cast<std::ptrdiff_t>(best));
  return rim;
}

std::size_t TubeNetwork::add_sprout(const Opening& from, std::span<const Ring> rings) {
  if (rings.empty()) throw InputError("a sprout needs at least one ring or pole");
  Piece piece{.rings = {}, .capped_at_start = false, .capped_at_end = true, .removed = {}};
  piece.rings.push_back(aligned({from.rim.begin(), from.rim.end()}, rings.front()));
  for (const Ring& ring : rings) piece.rings.push_back(add_vertices(ring));
  pieces_.push_back(std::move(piece));
  return pieces_.size() - 1;
}

std::size_t TubeNetwork::add_bridge(const Opening& from, std::span<const Ring> rings, const Opening& to) {
  const std::size_t bridge = add_sprout(from, rings);
  // Travel goes into the far opening, whose rim therefore turns the other way.
  pieces_[bridge].rings.push_back(aligned({to.rim.rbegin(), to.rim.rend()}, rings.back()));
  pieces_[bridge].capped_at_end = false;
  return bridge;
}

TriangleSoup TubeNetwork::surface() const {
  TriangleSoup soup;
  soup.positions = positions_;
  for (const Piece& piece : pieces_) {
    for (std::size_t i = 0; i + 1 < piece.rings.size(); ++i) {
      const RingOfVertices& a = piece.rings[i];
      const RingOfVertices& b = piece.rings[i + 1];
      const std::size_t sides = std::max(a.size(), b.size());
      for (std::size_t k = 0; k < sides; ++k) {
        const std::size_t next = (k + 1) % sides;
        if (a.size() == 1) {
          soup.triangles.push_back({a[0], b[next], b[k]});
        } else if (b.size() == 1) {
          soup.triangles.push_back({a[k], a[next], b[0]});
        } else if (has_quad(piece, i, k)) {
          soup.triangles.push_back({a[k], a[next], b[next]});
          soup.triangles.push_back({a[k], b[next], b[k]});
        }
      }
    }
    const RingOfVertices& first = piece.rings.front();
    const RingOfVertices& last = piece.rings.back();
    for (std::size_t k = 1; piece.capped_at_start && k + 1 < first.size(); ++k) {
      soup.triangles.push_back({first[0], first[k + 1], first[k]});
    }
    for (std::size_t k = 1; piece.capped_at_end && k + 1 < last.size(); ++k) {
      soup.triangles.push_back({last[0], last[k], last[k + 1]});
    }
  }
  remove_unused_vertices(soup);
  return soup;
}

}  // namespace voxcarve
