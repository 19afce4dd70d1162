// Rays from points of the surface, not pictures of it: small triangles count as much as large ones, whatever a pixel
// would be. Most visible points are seen at once along the direction that their neighbour was seen along; the blocked
// rays of hidden points begin where the neighbour's ray was blocked.
#include "metrics/visibility.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <numbers>

#include "metrics/occlusion_tree.h"

namespace voxcarve {

namespace {

constexpr std::int64_t kMaxGrain = 128;   // triangles a chunk
constexpr double kGrazing = 0.0087;       // sine of half a degree
constexpr double kMaxPieces = 2'000'000;  // above it pieces become longer

/// A piece of a triangle by barycentric coordinates of its corners, which are exact: sums of powers of two.
using Piece = std::array<Eigen::Vector3d, 3>;

const Piece& whole_triangle() {
  static const Piece piece = {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitZ()};
  return piece;
}

using Corners = std::array<Point, 3>;

Corners corners_of(const TriangleSoup& soup, const Triangle& t) {
  return {soup.positions[t[0]], soup.positions[t[1]], soup.positions[t[2]]};
}

Point at(const Corners& corners, const Eigen::Vector3d& weights) {
  return weights[0] * corners[0] + weights[1] * corners[1] + weights[2] * corners[2];
}

struct LongestSide {
  std::size_t from = 0;  ///< corner; the side ends at the next one
  double length = 0;
};

LongestSide longest_side(const Corners& corners, const Piece& piece) {
  const Corners p = {at(corners, piece[0]), at(corners, piece[1]), at(corners, piece[2])};
  LongestSide longest;
  for (std::size_t i = 0; i < 3; ++i) {
    const double length = (p[(i + 1) % 3] - p[i]).norm();
    if (length > longest.length) longest = {i, length};
  }
  return longest;
}

std::array<Piece, 2> halves(const Piece& piece, std::size_t from) {
  const std::size_t to = (from + 1) % 3;
  std::array<Piece, 2> result = {piece, piece};
  result[0][to] = result[1][from] = 0.5 * (piece[from] + piece[to]);
  return result;
}

/// The surface about the origin, its box's longest side in [1, 2).
TriangleSoup normalised(const TriangleSoup& surface) {
  TriangleSoup result;
  result.triangles = surface.triangles;
  result.positions.assign(surface.positions.size(), Point::Zero());
  const Box box = bounds(surface);
  const Point half = 0.5 * box.upper - 0.5 * box.lower;  // unlike the extent, never beyond the range of doubles
  const Point center = box.lower + half;
  const double size = half.maxCoeff();
  if (!(size > 0)) return result;
  const int exponent = -1 - std::ilogb(size);
  for (const Triangle& t : surface.triangles) {
    for (const std::uint32_t v : t) {
      for (int axis = 0; axis < 3; ++axis) {
        result.positions[v][axis] = std::ldexp(surface.positions[v][axis] - center[axis], exponent);
      }
    }
  }
  return result;
}

/// The lengths of the rule in normalised units.
struct Lengths {
  double coarse = 0;
  double fine = 0;
  double tolerance = 0;
};

Lengths lengths_of(const TriangleSoup& soup, const VisibilityOptions& options) {
  const double diagonal = bounds(soup).diagonal();
  Lengths lengths{options.coarse * diagonal, options.fine * diagonal, options.tolerance * diagonal};
  const auto pieces = [&] {
    // An estimate: halving longest sides ends in pieces of about a third of the area that their longest side, between
    // coarse / 2 and coarse, allows; or in a strip of them.
    double count = 0;
    for (const Triangle& t : soup.triangles) {
      const double area = area_vector(soup, t).norm() / 2;
      const double length = longest_side(corners_of(soup, t), whole_triangle()).length;
      count += 1 + area * 24 / (lengths.coarse * lengths.coarse) + 2 * length / lengths.coarse;
    }
    return count;
  };
  const auto triangles = static_cast<double>(soup.triangles.size());
  while (lengths.coarse < diagonal && pieces() > kMaxPieces + 2 * triangles) {
    lengths.coarse *= 2;
    lengths.fine *= 2;
  }
  return lengths;
}

/// What is visible of the triangles of one chunk.
struct Found {
  std::vector<std::uint32_t> whole;
  std::vector<std::uint32_t> cut;
  std::vector<Piece> pieces;  ///< of the triangles in `cut`, one each
};

/// Bytes that a piece takes: in lists that double as they grow, and as a triangle of its own three corners twice while
/// equal corners are merged.
constexpr std::uint64_t kBytesAPiece =
    2 * (sizeof(Piece) + sizeof(std::uint32_t)) + 2 * (3 * sizeof(Point) + sizeof(Triangle)) + sizeof(std::uint32_t);

/// Looks at the triangles of one chunk, one after the other.
class Viewer {
 public:
  Viewer(const TriangleSoup& soup, const OcclusionTree& tree, const std::vector<OcclusionTree::Direction>& directions,
         const Lengths& lengths, const RunContext& context, Found& found)
      : soup_(soup),
        tree_(tree),
        directions_(directions),
        lengths_(lengths),
        context_(context),
        found_(found),
        hints_(directions.size()) {}

  void look_at(std::uint32_t triangle) {
    triangle_ = triangle;
    corners_ = corners_of(soup_, soup_.triangles[triangle]);
    normal_ = area_vector(soup_, soup_.triangles[triangle]);
    const double size = normal_.norm();
    if (!(size > 0)) return;
    normal_ /= size;
    const auto rises_less = [this](const OcclusionTree::Direction& d, const OcclusionTree::Direction& e) {
      return normal_.dot(d.vector()) < normal_.dot(e.vector());
    };
    const auto [behind, before] = std::minmax_element(directions_.begin(), directions_.end(), rises_less);
    facing_ = {static_cast<std::size_t>(before - directions_.begin()),
               static_cast<std::size_t>(behind - directions_.begin())};
    if (visit(whole_triangle()) == Outcome::kVisible) found_.whole.push_back(triangle);
  }

 private:
  enum class Outcome { kHidden, kVisible, kPartly };

  /// Hidden and visible pieces are left to the caller; the visible pieces of a partly visible one were found already.
  Outcome visit(const Piece& piece) {
    const LongestSide side = longest_side(corners_, piece);
    if (side.length <= lengths_.coarse) {
      const Eigen::Vector3d centroid = (piece[0] + piece[1] + piece[2]) / 3;
      const bool visible = is_visible(at(corners_, centroid));
      bool agree = true;
      if (side.length > lengths_.fine) {
        for (std::size_t i = 0; agree && i < 3; ++i) {
          agree = is_visible(at(corners_, 0.75 * piece[i] + 0.25 * centroid)) == visible;
        }
      }
      if (agree) return visible ? Outcome::kVisible : Outcome::kHidden;
    }
    const std::array<Piece, 2> parts = halves(piece, side.from);
    const Outcome first = visit(parts[0]);
    const Outcome second = visit(parts[1]);
    if (first == second) return first;
    if (first == Outcome::kVisible) keep(parts[0]);
    if (second == Outcome::kVisible) keep(parts[1]);
    return Outcome::kPartly;
  }

  void keep(const Piece& piece) {
    found_.cut.push_back(triangle_);
    found_.pieces.push_back(piece);
  }

  /// The order of directions saves time and changes nothing: first the likely ones.
  bool is_visible(const Point& point) {
    context_.check_cancelled();
    const std::array<std::size_t, 3> likely = {lucky_, facing_[0], facing_[1]};
    const auto try_direction = [&](std::size_t d) {
      if (!is_visible_along(point, d)) return false;
      lucky_ = d;
      return true;
    };
    if (std::any_of(likely.begin(), likely.end(), try_direction)) return true;
    for (std::size_t d = 0; d < directions_.size(); ++d) {
      if (std::find(likely.begin(), likely.end(), d) == likely.end() && try_direction(d)) return true;
    }
    return false;
  }

  bool is_visible_along(const Point& point, std::size_t d) {
    const double rise = normal_.dot(directions_[d].vector());
    if (std::abs(rise) < kGrazing) return false;
    const Point start = point + std::copysign(lengths_.tolerance, rise) * normal_;
    return !tree_.blocks(start, directions_[d], hints_[d]);
  }

  const TriangleSoup& soup_;
  const OcclusionTree& tree_;
  const std::vector<OcclusionTree::Direction>& directions_;
  const Lengths& lengths_;
  const RunContext& context_;
  Found& found_;
  std::vector<OcclusionTree::Hint> hints_;  ///< by direction
  std::size_t lucky_ = 0;                   ///< the direction that the last visible point was seen along
  std::uint32_t triangle_ = 0;
  Corners corners_;
  Point normal_;
  std::array<std::size_t, 2> facing_{};  ///< the directions that look at the triangle's front and back most squarely
};

/// Puts together what the chunks found. `unit` is the surface in normalised units.
SurfacePart collect(const TriangleSoup& surface, const TriangleSoup& unit, const std::vector<Found>& chunks) {
  SurfacePart part;
  part.surface.positions = surface.positions;
  double area = 0;
  for (const Found& found : chunks) {
    for (const std::uint32_t t : found.whole) {
      part.surface.triangles.push_back(surface.triangles[t]);
      part.source.push_back(t);
      area += area_vector(unit, unit.triangles[t]).norm();
    }
  }
  remove_unused_vertices(part.surface);
  TriangleSoup pieces;
  for (const Found& found : chunks) {
    for (std::size_t i = 0; i < found.cut.size(); ++i) {
      const std::uint32_t t = found.cut[i];
      const Piece& piece = found.pieces[i];
      const Corners corners = corners_of(surface, surface.triangles[t]);
      const auto first = static_cast<std::uint32_t>(pieces.positions.size());
      for (const Eigen::Vector3d& weights : piece) pieces.positions.push_back(at(corners, weights));
      pieces.triangles.push_back({first, first + 1, first + 2});
      part.source.push_back(t);
      // Barycentric coordinates turn areas by their determinant.
      const double share = std::abs(piece[0].cross(piece[1]).dot(piece[2]));
      area += share * area_vector(unit, unit.triangles[t]).norm();
    }
  }
  append(part.surface, merge_equal_positions(pieces));
  double whole = 0;
  for (const Triangle& t : unit.triangles) whole += area_vector(unit, t).norm();
  part.share = whole > 0 ? std::min(1.0, area / whole) : 0;
  return part;
}

}  // namespace

std::vector<Point> view_directions(std::int64_t count) {
  constexpr double kGoldenAngle = std::numbers::pi * (3 - 2.23606797749978969);  // 3 - sqrt 5
  std::vector<Point> directions;
  for (std::int64_t i = 0; i < count; ++i) {
    const auto step = static_cast<double>(i) + 0.5;
    const double z = 1 - 2 * step / static_cast<double>(count);
    const double radius = std::sqrt((1 - z) * (1 + z));
    const double turn = kGoldenAngle * step;
    directions.emplace_back(radius * std::cos(turn), radius * std::sin(turn), z);
  }
  return directions;
}

SurfacePart visible_part(const TriangleSoup& surface, const VisibilityOptions& options, RunContext& context) {
  if (surface.empty()) return {};
  const auto triangles = static_cast<std::int64_t>(surface.triangles.size());
  Stage stage(context, "visible part", triangles);
  const std::uint64_t bytes =
      OcclusionTree::memory_estimate(surface.triangles.size()) +
      2 * (surface.positions.size() * sizeof(Point) + surface.triangles.size() * sizeof(Triangle));
  const auto require_memory = [&](std::uint64_t pieces) {
    context.require_memory(bytes + pieces * kBytesAPiece, "finding the visible part");
  };
  require_memory(0);
  const TriangleSoup unit = normalised(surface);
  const Lengths lengths = lengths_of(unit, options);
  context.check_cancelled();
  if (!(lengths.coarse > 0)) return {};
  const OcclusionTree tree(unit, lengths.tolerance, context);
  std::vector<OcclusionTree::Direction> directions;
  for (const Point& d : view_directions(std::max<std::int64_t>(options.directions, 1))) directions.emplace_back(d);

  // Few triangles are long ones, so chunks are small then.
  const std::int64_t grain = std::clamp<std::int64_t>(triangles / 64, 1, kMaxGrain);
  std::vector<Found> chunks(static_cast<std::size_t>((triangles + grain - 1) / grain));
  std::atomic<std::uint64_t> all_pieces = 0;  // their number is not known before they are found
  parallel_for(context, 0, triangles, grain, [&](std::int64_t first, std::int64_t last) {
    Viewer viewer(unit, tree, directions, lengths, context, chunks[static_cast<std::size_t>(first / grain)]);
    std::size_t pieces = 0;
    for (std::int64_t t = first; t < last; ++t) {
      viewer.look_at(static_cast<std::uint32_t>(t));
      const std::size_t found = chunks[static_cast<std::size_t>(first / grain)].pieces.size();
      if (found > pieces) require_memory(all_pieces += found - pieces);
      pieces = found;
    }
    stage.advance(last - first);
  });
  return collect(surface, unit, chunks);
}

}  // namespace voxcarve
