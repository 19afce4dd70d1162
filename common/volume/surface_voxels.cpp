// Based on [NT03, 3 and 5.2]. Differs in that overlaps of triangles and voxels are exact, by separating axes on a
// lattice of whole numbers; that of several colours in a voxel a stated one wins, where the paper is silent; and that
// the nearest coloured voxel comes from an exact feature transform.
#include "common/volume/surface_voxels.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "common/mesh/aabb_tree.h"
#include "common/run/errors.h"
#include "common/volume/distance_transform.h"
#include "common/volume/workspace_pool.h"

namespace voxcarve {

namespace {

using LatticePoint = Eigen::Matrix<std::int64_t, 3, 1>;
__extension__ using Wide = __int128;  ///< a normal times a coordinate

/// The vertices of a soup in whole steps of 2^-bits voxel from the frame's lower corner. Rounding lets a plane that was
/// meant to lie on the border of voxels lie there, and products of coordinates stay exact.
struct Lattice {
  int bits = 16;
  std::vector<LatticePoint> points;

  Lattice(const TriangleSoup& soup, const GridFrame& frame) {
    const auto to_voxels = [&](const Point& p) -> Point { return (p - frame.origin) / frame.voxel_size; };
    const Box box = bounds(soup);
    double largest = 1;
    if (!box.empty()) {
      largest =
          std::max({largest, to_voxels(box.lower).cwiseAbs().maxCoeff(), to_voxels(box.upper).cwiseAbs().maxCoeff()});
    }
    constexpr double kLimit = 0x1p28;
    while (bits > 1 && std::ldexp(largest + 1, bits) > kLimit) --bits;
    if (std::ldexp(largest + 1, bits) > kLimit)
      throw InputError("the grid is too fine for a soup so much larger than it");
    points.reserve(soup.positions.size());
    for (const Point& position : soup.positions) {
      // A vertex that no triangle uses may lie anywhere: clamping keeps the conversion defined and moves no other.
      const Point voxel = to_voxels(position).cwiseMin(largest).cwiseMax(-largest);
      points.emplace_back((voxel * std::ldexp(1.0, bits)).array().round().cast<std::int64_t>());
    }
  }

  std::int64_t one() const { return std::int64_t{1} << bits; }
};

/// Decides which boxes of lattice points a closed triangle meets: those that no plane through nothing of both separates
/// from it, among the directions of the box's faces, the triangle's plane and the products of their edges.
class BoxOverlap {
 public:
  BoxOverlap(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c)
      : lower_(a.cwiseMin(b).cwiseMin(c)), upper_(a.cwiseMax(b).cwiseMax(c)), normal_((b - a).cross(c - a)) {
    level_ = wide_dot(normal_, a);
    const std::array<LatticePoint, 3> corner = {a, b, c};
    std::size_t count = 0;
    for (std::size_t side = 0; side < 3; ++side) {
      const LatticePoint edge = corner[(side + 1) % 3] - corner[side];
      for (int axis = 0; axis < 3; ++axis) {
        Axis& separator = axes_[count++];
        separator.u = (axis + 1) % 3;
        separator.v = (axis + 2) % 3;
        separator.along_u = -edge[separator.v];
        separator.along_v = edge[separator.u];
        const std::array<std::int64_t, 3> at = {separator.dot(a), separator.dot(b), separator.dot(c)};
        separator.lowest = std::min({at[0], at[1], at[2]});
        separator.highest = std::max({at[0], at[1], at[2]});
      }
    }
  }

  const LatticePoint& lower() const { return lower_; }
  const LatticePoint& upper() const { return upper_; }

  /// Whether the closed box meets the triangle.
  bool meets(const LatticePoint& low, const LatticePoint& high) const {
    if ((upper_.array() < low.array()).any() || (lower_.array() > high.array()).any()) return false;
    // Sums of both ends stand for the centre and differences for the extent, all doubled.
    const LatticePoint sum = low + high;
    const LatticePoint extent = high - low;
    for (const Axis& axis : axes_) {
      const std::int64_t center = axis.dot(sum);
      const std::int64_t reach = std::abs(axis.along_u) * extent[axis.u] + std::abs(axis.along_v) * extent[axis.v];
      if (2 * axis.lowest > center + reach || 2 * axis.highest < center - reach) return false;
    }
    const Wide offset = 2 * level_ - wide_dot(normal_, sum);
    const Wide reach = wide_dot(normal_.cwiseAbs(), extent);
    return offset <= reach && -offset <= reach;
  }

 private:
  struct Axis {
    int u = 0, v = 0;
    std::int64_t along_u = 0, along_v = 0;
    std::int64_t lowest = 0, highest = 0;  ///< of the triangle

    std::int64_t dot(const LatticePoint& p) const { return along_u * p[u] + along_v * p[v]; }
  };

  static Wide wide_dot(const LatticePoint& a, const LatticePoint& b) {
    return static_cast<Wide>(a[0]) * b[0] + static_cast<Wide>(a[1]) * b[1] + static_cast<Wide>(a[2]) * b[2];
  }

  LatticePoint lower_, upper_;
  LatticePoint normal_;
  Wide level_ = 0;
  std::array<Axis, 9> axes_;
};

/// The point of a triangle that is nearest to the origin, as shares of its corners.
struct NearestPoint {
  double squared = std::numeric_limits<double>::infinity();
  std::array<double, 3> share{};
};

/// Corners must be whole numbers, so that two triangles with a common side find the same point on it.
NearestPoint nearest_to_origin(const std::array<Point, 3>& corner) {
  NearestPoint best;
  for (std::size_t side = 0; side < 3; ++side) {
    std::size_t from = side;
    std::size_t to = (side + 1) % 3;
    if (std::lexicographical_compare(corner[to].begin(), corner[to].end(), corner[from].begin(), corner[from].end()))
      std::swap(from, to);
    const Point edge = corner[to] - corner[from];
    const double length = edge.squaredNorm();
    const double along = length > 0 ? std::clamp(-corner[from].dot(edge) / length, 0.0, 1.0) : 0.0;
    const double squared = (corner[from] + along * edge).squaredNorm();
    if (squared >= best.squared) continue;
    best.squared = squared;
    best.share = {};
    best.share[from] = 1 - along;
    best.share[to] += along;
  }
  const Point ab = corner[1] - corner[0];
  const Point ac = corner[2] - corner[0];
  const Point normal = ab.cross(ac);
  const double area = normal.squaredNorm();
  if (area == 0) return best;
  const double v = -normal.dot(corner[0].cross(ac)) / area;
  const double w = -normal.dot(ab.cross(corner[0])) / area;
  if (v < 0 || w < 0 || v + w > 1) return best;
  const double height = normal.dot(corner[0]);
  const double squared = height * height / area;
  if (squared < best.squared) best = {squared, {1 - v - w, v, w}};
  return best;
}

/// Which triangles reach which slices: the triangles of slice k are those of items[first[k]] ... items[first[k + 1]],
/// in the order of the soup.
struct SliceIndex {
  std::vector<std::size_t> first;
  std::vector<std::uint32_t> items;

  SliceIndex(const TriangleSoup& soup, const Lattice& lattice, std::int64_t slices, RunContext& context)
      : first(static_cast<std::size_t>(slices) + 1, 0) {
    const auto for_each = [&](auto&& visit) {
      for (std::uint32_t t = 0; t < soup.triangles.size(); ++t) {
        const auto& triangle = soup.triangles[t];
        const std::array<std::int64_t, 3> z = {lattice.points[triangle[0]][2], lattice.points[triangle[1]][2],
                                               lattice.points[triangle[2]][2]};
        // A closed slice k reaches from k to k + 1, so one that ends on a border meets the slices on both sides.
        const std::int64_t low = std::max<std::int64_t>((std::min({z[0], z[1], z[2]}) - 1) >> lattice.bits, 0);
        const std::int64_t high = std::min(std::max({z[0], z[1], z[2]}) >> lattice.bits, slices - 1);
        for (std::int64_t k = low; k <= high; ++k) visit(static_cast<std::size_t>(k), t);
      }
    };
    for_each([&](std::size_t k, std::uint32_t) { ++first[k + 1]; });
    for (std::size_t k = 1; k < first.size(); ++k) first[k] += first[k - 1];
    context.require_memory(bytes_with(first.back(), lattice), "surface colours");
    items.resize(first.back());
    std::vector<std::size_t> fill(first.begin(), first.end() - 1);
    for_each([&](std::size_t k, std::uint32_t t) { items[fill[k]++] = t; });
  }

  /// What an index of so many entries and its lattice hold.
  static std::uint64_t bytes_with(std::size_t entries, const Lattice& lattice) {
    return entries * sizeof(std::uint32_t) + lattice.points.size() * sizeof(LatticePoint);
  }
};

/// Finds the surface voxels of one slice after the other.
class SliceRecorder {
 public:
  SliceRecorder(const TriangleSoup& soup, const Lattice& lattice, const GridFrame& frame)
      : soup_(soup), lattice_(lattice), frame_(frame), best_(static_cast<std::size_t>(frame.dims[0] * frame.dims[1])) {}

  static std::uint64_t memory(const GridFrame& frame) {
    return static_cast<std::uint64_t>(frame.dims[0] * frame.dims[1]) * sizeof(Best);
  }

  void record(std::int64_t k, std::span<const std::uint32_t> triangles, std::vector<std::int64_t>& voxels,
              std::vector<Color>& colors, const RunContext& context) {
    constexpr std::size_t kCheckEvery = 1024;
    k_ = k;
    std::ranges::fill(best_, Best());
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      if (i % kCheckEvery == 0) context.check_cancelled();
      record_triangle(triangles[i]);
    }
    const std::int64_t first = k * frame_.dims[0] * frame_.dims[1];
    for (std::size_t i = 0; i < best_.size(); ++i) {
      if (best_[i].triangle == kNone) continue;
      voxels.push_back(first + static_cast<std::int64_t>(i));
      const auto index = static_cast<std::int64_t>(i);
      colors.push_back(color_at(best_[i].triangle, index % frame_.dims[0], index / frame_.dims[0]));
    }
  }

 private:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  struct Best {
    double squared = std::numeric_limits<double>::infinity();
    std::uint32_t triangle = kNone;
  };
  struct Range {
    std::int64_t i_low, i_high, j_low, j_high;  ///< both ends included
  };

  std::array<LatticePoint, 3> corners_of(std::uint32_t triangle) const {
    const Triangle& t = soup_.triangles[triangle];
    return {lattice_.points[t[0]], lattice_.points[t[1]], lattice_.points[t[2]]};
  }

  void record_triangle(std::uint32_t triangle) {
    const auto corner = corners_of(triangle);
    const BoxOverlap overlap(corner[0], corner[1], corner[2]);
    const int bits = lattice_.bits;
    const Range range = {std::max<std::int64_t>((overlap.lower()[0] - 1) >> bits, 0),
                         std::min(overlap.upper()[0] >> bits, frame_.dims[0] - 1),
                         std::max<std::int64_t>((overlap.lower()[1] - 1) >> bits, 0),
                         std::min(overlap.upper()[1] >> bits, frame_.dims[1] - 1)};
    if (range.i_low <= range.i_high && range.j_low <= range.j_high) descend(overlap, range, triangle);
  }

  /// Halves a block of voxels until it is one, or does not meet the triangle.
  void descend(const BoxOverlap& overlap, const Range& range, std::uint32_t triangle) {
    const std::int64_t one = lattice_.one();
    if (!overlap.meets({range.i_low * one, range.j_low * one, k_ * one},
                       {(range.i_high + 1) * one, (range.j_high + 1) * one, (k_ + 1) * one})) {
      return;
    }
    const std::int64_t width = range.i_high - range.i_low;
    const std::int64_t height = range.j_high - range.j_low;
    if (width == 0 && height == 0) {
      consider(range.i_low, range.j_low, triangle);
    } else if (width >= height) {
      const std::int64_t middle = range.i_low + width / 2;
      descend(overlap, {range.i_low, middle, range.j_low, range.j_high}, triangle);
      descend(overlap, {middle + 1, range.i_high, range.j_low, range.j_high}, triangle);
    } else {
      const std::int64_t middle = range.j_low + height / 2;
      descend(overlap, {range.i_low, range.i_high, range.j_low, middle}, triangle);
      descend(overlap, {range.i_low, range.i_high, middle + 1, range.j_high}, triangle);
    }
  }

  NearestPoint nearest_point(std::uint32_t triangle, std::int64_t i, std::int64_t j) const {
    const std::int64_t one = lattice_.one();
    const LatticePoint center = LatticePoint(i, j, k_) * one + LatticePoint::Constant(one / 2);
    const auto corner = corners_of(triangle);
    return nearest_to_origin({(corner[0] - center).cast<double>(), (corner[1] - center).cast<double>(),
                              (corner[2] - center).cast<double>()});
  }

  /// Triangles come in the order of the soup, so a later one must be nearer, and by more than rounding makes it.
  void consider(std::int64_t i, std::int64_t j, std::uint32_t triangle) {
    constexpr double kHair = 1e-9;
    Best& best = best_[static_cast<std::size_t>(j * frame_.dims[0] + i)];
    const double squared = nearest_point(triangle, i, j).squared;
    const double rounding = best.triangle == kNone ? 0 : kHair * (best.squared + 1);
    if (squared + rounding < best.squared) best = {squared, triangle};
  }

  Color color_at(std::uint32_t triangle, std::int64_t i, std::int64_t j) const {
    if (!soup_.triangle_colors.empty()) return soup_.triangle_colors[triangle];
    const NearestPoint point = nearest_point(triangle, i, j);
    const Triangle& t = soup_.triangles[triangle];
    Color color = Color::Zero();
    for (std::size_t c = 0; c < 3; ++c) color += static_cast<float>(point.share[c]) * soup_.vertex_colors[t[c]];
    return color.cwiseMax(0.0F).cwiseMin(1.0F);
  }

  const TriangleSoup& soup_;
  const Lattice& lattice_;
  const GridFrame& frame_;
  std::int64_t k_ = 0;
  std::vector<Best> best_;  ///< of the slice's voxels
};

}  // namespace

SurfaceColors record_surface_colors(const TriangleSoup& soup, const GridFrame& frame, RunContext& context) {
  SurfaceColors result;
  result.frame = frame;
  if (soup.vertex_colors.empty() && soup.triangle_colors.empty()) return result;
  const std::int64_t slices = frame.dims[2];
  Stage stage(context, "surface colours", slices);
  constexpr std::int64_t kSlicesPerChunk = 4;
  const std::uint64_t recorders =
      workspaces_at_once(context, (slices + kSlicesPerChunk - 1) / kSlicesPerChunk) * SliceRecorder::memory(frame);
  context.require_memory(soup.positions.size() * sizeof(LatticePoint) + recorders, "surface colours");
  const Lattice lattice(soup, frame);
  const SliceIndex index(soup, lattice, slices, context);
  context.require_memory(SliceIndex::bytes_with(index.items.size(), lattice) + recorders, "surface colours");
  std::vector<SurfaceColors> slice(static_cast<std::size_t>(slices));
  parallel_for(context, 0, slices, kSlicesPerChunk, [&](std::int64_t begin, std::int64_t end) {
    SliceRecorder recorder(soup, lattice, frame);
    for (std::int64_t k = begin; k < end; ++k) {
      const auto s = static_cast<std::size_t>(k);
      const auto triangles = std::span(index.items).subspan(index.first[s], index.first[s + 1] - index.first[s]);
      if (!triangles.empty()) recorder.record(k, triangles, slice[s].voxels, slice[s].colors, context);
      stage.advance(1);
    }
  });
  std::size_t count = 0;
  for (const SurfaceColors& part : slice) count += part.voxels.size();
  context.require_memory(
      SliceIndex::bytes_with(index.items.size(), lattice) + 2 * count * (sizeof(std::int64_t) + sizeof(Color)),
      "surface colours");
  result.voxels.reserve(count);
  result.colors.reserve(count);
  for (const SurfaceColors& part : slice) {
    result.voxels.insert(result.voxels.end(), part.voxels.begin(), part.voxels.end());
    result.colors.insert(result.colors.end(), part.colors.begin(), part.colors.end());
  }
  return result;
}

DensityVolume thin_shell(const TriangleSoup& soup, const GridFrame& frame, double reach, RunContext& context) {
  if (!(reach > 0) || reach > 16)
    throw ParameterError("the reach of a thin shell must lie above 0 and up to 16 voxels");
  constexpr std::int64_t kBlock = 8;  // voxels a side of the blocks that are asked for first
  const std::int64_t layers = (frame.dims[2] + kBlock - 1) / kBlock;
  Stage stage(context, "thin shell", layers);
  constexpr std::uint64_t kTreeBytes = 200;  // a triangle, at most
  context.require_memory(static_cast<std::uint64_t>(frame.voxels()) * sizeof(float) +
                             soup.triangles.size() * kTreeBytes + soup.positions.size() * sizeof(Point),
                         "the thin shell");
  TriangleSoup local;  // in voxels, so that distances lose no digits to a far away origin
  local.triangles = soup.triangles;
  local.positions.reserve(soup.positions.size());
  for (const Point& position : soup.positions) local.positions.push_back((position - frame.origin) / frame.voxel_size);
  const AabbTree tree(local);
  DensityVolume density(frame);
  const double block_reach = reach + std::sqrt(3.0) * (kBlock - 1) / 2;
  const auto fill_block = [&](const Index3& low, const Index3& high) {
    const Point middle = 0.5 * (low + high).cast<double>();
    if (tree.nearest(middle, block_reach * block_reach).triangle == AabbTree::kNone) return;
    for (std::int64_t k = low[2]; k < high[2]; ++k) {
      for (std::int64_t j = low[1]; j < high[1]; ++j) {
        for (std::int64_t i = low[0]; i < high[0]; ++i) {
          const Point center = Index3(i, j, k).cast<double>() + Point::Constant(0.5);
          const AabbTree::Nearest nearest = tree.nearest(center, reach * reach);
          if (nearest.triangle == AabbTree::kNone) continue;
          density(i, j, k) = static_cast<float>(1 - std::sqrt(nearest.squared_distance) / reach);
        }
      }
    }
  };
  parallel_for(context, 0, layers, 1, [&](std::int64_t begin, std::int64_t) {
    for (std::int64_t j = 0; j < frame.dims[1]; j += kBlock) {
      context.check_cancelled();
      for (std::int64_t i = 0; i < frame.dims[0]; i += kBlock) {
        const Index3 low(i, j, begin * kBlock);
        fill_block(low, (low + Index3::Constant(kBlock)).cwiseMin(frame.dims));
      }
    }
    stage.advance(1);
  });
  return density;
}

}  // namespace voxcarve
