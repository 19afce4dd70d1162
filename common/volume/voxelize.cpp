// Based on parity count and ray stabbing [NT03, 3.1 and 3.2]; differs in casting a ray of every direction exactly
// through every voxel centre. Along the axes all voxels of a column share one ray, so a column needs one toggle a
// crossing instead of a sorted list; along the other directions rays are looked up in a LineStabber.
#include "common/volume/voxelize.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/mesh/line_stabber.h"
#include "common/run/errors.h"
#include "common/volume/axis_scan.h"
#include "common/volume/labelling.h"

namespace voxcarve {

namespace {

/// Votes of the directions on every voxel. For ray stabbing one vote "exterior" decides.
struct Votes {
  explicit Votes(const GridFrame& frame) : interior(frame), exterior(frame) {}
  Grid<std::uint8_t> interior;
  Grid<std::uint8_t> exterior;
};

/// Walks the voxels of column (u, v) along `axis`: calls body(grid index, position in the column).
template <class Body>
void for_column(const GridFrame& frame, int axis, std::int64_t u, std::int64_t v, const Body& body) {
  Index3 voxel = Index3::Zero();
  voxel[(axis + 1) % 3] = u;
  voxel[(axis + 2) % 3] = v;
  const std::array<std::int64_t, 3> stride = {1, frame.dims[0], frame.dims[0] * frame.dims[1]};
  std::int64_t index = (voxel[2] * frame.dims[1] + voxel[1]) * frame.dims[0] + voxel[0];
  for (std::int64_t position = 0; position < frame.dims[axis]; ++position) {
    body(static_cast<std::size_t>(index), position);
    index += stride[static_cast<std::size_t>(axis)];
  }
}

std::size_t columns_across(const GridFrame& frame, int axis) {
  return static_cast<std::size_t>(frame.dims[(axis + 1) % 3] * frame.dims[(axis + 2) % 3]);
}

/// Parity count along one axis: a crossing toggles the first voxel behind it, and the running parity of the toggles
/// classifies the column.
VoxelizeReport::Axis vote_parity(const LatticeSoup& lattice, const GridFrame& frame, int axis, Votes& votes,
                                 Stage& stage, RunContext& context) {
  BinaryVolume toggles(frame);
  std::vector<std::uint32_t> crossings(columns_across(frame, axis), 0);
  const std::int64_t row = frame.dims[(axis + 1) % 3];
  const std::array<std::int64_t, 3> stride = {1, frame.dims[0], frame.dims[0] * frame.dims[1]};
  scan_convert(lattice, frame, axis, stage, [&](std::int64_t u, std::int64_t v, std::int64_t first) {
    ++crossings[static_cast<std::size_t>(v * row + u)];
    if (first >= frame.dims[axis]) return;  // behind the last voxel centre
    const std::int64_t index = u * stride[static_cast<std::size_t>((axis + 1) % 3)] +
                               v * stride[static_cast<std::size_t>((axis + 2) % 3)] +
                               first * stride[static_cast<std::size_t>(axis)];
    toggles.values[static_cast<std::size_t>(index)] ^= 1;
  });
  parallel_for(context, 0, frame.dims[(axis + 2) % 3], 1, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t v = begin; v < end; ++v) {
      for (std::int64_t u = 0; u < row; ++u) {
        if (crossings[static_cast<std::size_t>(v * row + u)] % 2 != 0) continue;  // invalid: does not vote
        std::uint8_t parity = 0;
        for_column(frame, axis, u, v, [&](std::size_t index, std::int64_t) {
          parity ^= toggles.values[index];
          votes.interior.values[index] = static_cast<std::uint8_t>(votes.interior.values[index] + parity);
          votes.exterior.values[index] = static_cast<std::uint8_t>(votes.exterior.values[index] + 1 - parity);
        });
      }
    }
  });
  VoxelizeReport::Axis report{axis, 0, 0};
  for (const std::uint32_t count : crossings) {
    report.columns += count > 0;
    report.invalid_columns += count % 2;
  }
  return report;
}

/// Ray stabbing along one axis: exterior before the first crossing and behind the last one.
VoxelizeReport::Axis vote_stabbing(const LatticeSoup& lattice, const GridFrame& frame, int axis, Votes& votes,
                                   Stage& stage, RunContext& context) {
  struct Span {
    std::int32_t first = std::numeric_limits<std::int32_t>::max();
    std::int32_t last = -1;
  };
  std::vector<Span> spans(columns_across(frame, axis));
  const std::int64_t row = frame.dims[(axis + 1) % 3];
  scan_convert(lattice, frame, axis, stage, [&](std::int64_t u, std::int64_t v, std::int64_t first) {
    Span& span = spans[static_cast<std::size_t>(v * row + u)];
    span.first = std::min(span.first, static_cast<std::int32_t>(first));
    span.last = std::max(span.last, static_cast<std::int32_t>(first));
  });
  parallel_for(context, 0, frame.dims[(axis + 2) % 3], 1, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t v = begin; v < end; ++v) {
      for (std::int64_t u = 0; u < row; ++u) {
        const Span span = spans[static_cast<std::size_t>(v * row + u)];
        for_column(frame, axis, u, v, [&](std::size_t index, std::int64_t position) {
          if (position < span.first || position >= span.last) votes.exterior.values[index] = 1;
        });
      }
    }
  });
  return {axis, std::ranges::count_if(spans, [](const Span& span) { return span.last >= 0; }), 0};
}

/// The soup in voxel units, the lower corner of the grid at the origin: projections on oblique directions keep their
/// digits however far from the origin the model lies.
TriangleSoup in_voxel_units(const TriangleSoup& soup, const GridFrame& frame) {
  TriangleSoup local;
  local.triangles = soup.triangles;
  local.positions.reserve(soup.positions.size());
  for (const Point& position : soup.positions)
    local.positions.emplace_back((position - frame.origin) / frame.voxel_size);
  return local;
}

/// In voxels. The projections of oblique directions are rounded, so there a centre on the surface is moved in earnest,
/// a thousandth of a voxel the way that the axes move it infinitesimally.
const Point kObliqueShift(0x1p-10, 0x1p-13, 0x1p-16);

/// More than half of all directions: no vote to come changes the class, nor that it is vouched for.
bool is_decided(std::uint8_t interior, std::uint8_t exterior, int directions) {
  return 2 * std::max(interior, exterior) > directions;
}

/// Lets every voxel that is still open vote along one direction that is no axis. The stabber is in voxel units.
void vote_oblique(const LineStabber& stabber, const VoxelizeOptions& options, Votes& votes, Stage& stage,
                  RunContext& context) {
  const GridFrame& frame = votes.interior.frame;
  parallel_for(context, 0, frame.dims[2], 1, [&](std::int64_t begin, std::int64_t end) {
    std::vector<Crossing> crossings;
    for (std::int64_t k = begin; k < end; ++k) {
      for (std::int64_t j = 0; j < frame.dims[1]; ++j) {
        for (std::int64_t i = 0; i < frame.dims[0]; ++i) {
          const std::size_t index = votes.interior.index(i, j, k);
          std::uint8_t& interior = votes.interior.values[index];
          std::uint8_t& exterior = votes.exterior.values[index];
          if (options.classifier == Classifier::kStabbing ? exterior != 0
                                                          : is_decided(interior, exterior, options.directions))
            continue;
          const Point center = Index3(i, j, k).cast<double>() + Point::Constant(0.5) + kObliqueShift;
          const double depth = center.dot(stabber.frame().w);
          crossings.clear();
          stabber.append_crossings(center.dot(stabber.frame().u), center.dot(stabber.frame().v), crossings);
          const auto in_front =
              std::ranges::count_if(crossings, [depth](const Crossing& c) { return c.depth <= depth; });
          const auto total = static_cast<std::int64_t>(crossings.size());
          if (options.classifier == Classifier::kStabbing) {
            if (in_front == 0 || in_front == total) exterior = 1;
          } else if (total % 2 == 0) {
            ++(in_front % 2 != 0 ? interior : exterior);
          }
        }
      }
    }
    stage.advance(end - begin);
  });
}

/// Components of {volume == value} that hold no voxel which at least half of the directions voted for, and that do not
/// reach the border of the grid where they are exterior. Exterior is 18-connected and interior 6-connected, as in the
/// isosurface.
void flip_islands(const Votes& votes, std::uint8_t value, int directions, BinaryVolume& volume, RunContext& context,
                  VoxelizeReport* report) {
  const GridFrame& frame = volume.frame;
  const Grid<std::uint8_t>& own = value != 0 ? votes.interior : votes.exterior;
  const Connectivity connectivity = value != 0 ? Connectivity::kFace : Connectivity::kEdge;
  const std::vector<Index3> offsets = neighbour_offsets(connectivity, frame.is_image());
  const auto is_vouched = [&](const Index3& v) { return 2 * own(v[0], v[1], v[2]) >= directions; };
  Grid<std::uint8_t> seen(frame);
  std::vector<Index3> island;
  for (std::int64_t k = 0; k < frame.dims[2]; ++k) {
    context.check_cancelled();
    for (std::int64_t j = 0; j < frame.dims[1]; ++j) {
      for (std::int64_t i = 0; i < frame.dims[0]; ++i) {
        if (volume(i, j, k) != value || seen(i, j, k) != 0 || is_vouched({i, j, k})) continue;
        // The whole of the part that is not vouched for, even once it proves grounded, so that it is seen only once.
        bool grounded = false;
        island.assign(1, Index3(i, j, k));
        seen(i, j, k) = 1;
        for (std::size_t next = 0; next < island.size(); ++next) {
          for (const Index3& offset : offsets) {
            const Index3 neighbour = island[next] + offset;
            if (!frame.contains(neighbour)) {
              grounded = grounded || value == 0;
            } else if (volume(neighbour[0], neighbour[1], neighbour[2]) == value) {
              if (is_vouched(neighbour)) {
                grounded = true;
              } else if (seen(neighbour[0], neighbour[1], neighbour[2]) == 0) {
                seen(neighbour[0], neighbour[1], neighbour[2]) = 1;
                island.push_back(neighbour);
              }
            }
          }
        }
        if (grounded) continue;
        for (const Index3& v : island) volume(v[0], v[1], v[2]) = static_cast<std::uint8_t>(1 - value);
        if (report == nullptr) continue;
        ++report->flipped_islands;
        report->flipped_voxels += static_cast<std::int64_t>(island.size());
      }
    }
  }
}

}  // namespace

Classifier classifier_from(std::string_view name) {
  if (name == "parity") return Classifier::kParity;
  if (name == "stabbing") return Classifier::kStabbing;
  throw ParameterError("there is no classifier '" + std::string(name) + "'; choose parity or stabbing");
}

std::vector<Point> voxelization_directions(int count, int axis) {
  if (count == 1) return {Point::Unit(axis)};
  if (count != 3 && count != 13) throw ParameterError("directions must be 1, 3 or 13");
  std::vector<Point> directions = {Point::UnitX(), Point::UnitY(), Point::UnitZ()};
  if (count == 3) return directions;
  // The face normals of a regular icosahedron are the vertices of its dual, the dodecahedron: (+-1, +-1, +-1) and the
  // cyclic shifts of (0, +-1/phi, +-phi), here one of every opposite pair.
  const double phi = (1 + std::sqrt(5.0)) / 2;
  for (const double y : {1.0, -1.0}) {
    for (const double z : {1.0, -1.0}) directions.push_back(Point(1, y, z).normalized());
  }
  for (const double sign : {1.0, -1.0}) {
    directions.push_back(Point(0, 1 / phi, sign * phi).normalized());
    directions.push_back(Point(1 / phi, sign * phi, 0).normalized());
    directions.push_back(Point(sign * phi, 0, 1 / phi).normalized());
  }
  return directions;
}

GridFrame voxel_frame(const Box& box, std::int64_t resolution) {
  if (resolution < 1) throw ParameterError("resolution must be at least 1");
  const Point extent = box.extent();
  const double longest = extent.maxCoeff();
  GridFrame frame;
  frame.voxel_size = longest / static_cast<double>(resolution);
  const double largest_coordinate = std::max(box.lower.cwiseAbs().maxCoeff(), box.upper.cwiseAbs().maxCoeff());
  constexpr double kDigits = 8 * std::numeric_limits<double>::epsilon();
  if (!(longest > 0) || frame.voxel_size < largest_coordinate * kDigits ||
      frame.voxel_size < std::numeric_limits<double>::min()) {
    throw InputError(
        "a voxel would be smaller than the last digits of the coordinates; move the model nearer to the origin or "
        "lower the resolution");
  }
  constexpr double kRounding = 1e-9;  // a side of 100.0000000001 voxels is 100 voxels
  for (int axis = 0; axis < 3; ++axis) {
    frame.dims[axis] =
        std::max<std::int64_t>(static_cast<std::int64_t>(std::ceil(extent[axis] / frame.voxel_size - kRounding)), 1);
  }
  frame.origin = box.center() - 0.5 * frame.voxel_size * frame.dims.cast<double>();
  return frame;
}

BinaryVolume voxelize(const TriangleSoup& soup, const GridFrame& frame, const VoxelizeOptions& options,
                      RunContext& context, VoxelizeReport* report) {
  const std::vector<Point> directions = voxelization_directions(options.directions, options.axis);
  const auto voxels = static_cast<std::uint64_t>(frame.voxels());
  const std::size_t axes = options.directions == 1 ? 1 : 3;
  const std::size_t oblique = directions.size() - axes;
  Stage stage(
      context, "voxelization",
      static_cast<std::int64_t>(axes * soup.triangles.size()) + static_cast<std::int64_t>(oblique) * frame.dims[2]);
  context.require_memory(4 * voxels + soup.positions.size() * 3 * sizeof(std::int64_t) + columns_across(frame, 2) * 8,
                         "voxelization");
  Votes votes(frame);
  {
    const LatticeSoup lattice(soup, frame);
    for (std::size_t d = 0; d < axes; ++d) {
      const int axis = options.directions == 1 ? options.axis : static_cast<int>(d);
      const auto vote = options.classifier == Classifier::kParity ? vote_parity : vote_stabbing;
      const VoxelizeReport::Axis met = vote(lattice, frame, axis, votes, stage, context);
      if (report != nullptr) report->axes.push_back(met);
    }
  }
  if (oblique > 0) {
    const TriangleSoup local = in_voxel_units(soup, frame);
    for (std::size_t d = axes; d < directions.size(); ++d) {
      const StabFrame direction = StabFrame::along(directions[d]);
      context.require_memory(4 * voxels + LineStabber::memory_estimate(local, direction, 1.0), "voxelization");
      const LineStabber stabber(local, direction, 1.0);
      vote_oblique(stabber, options, votes, stage, context);
    }
  }
  BinaryVolume volume(frame);
  std::ranges::transform(
      votes.interior.values, votes.exterior.values, volume.values.begin(), [&](std::uint8_t in, std::uint8_t out) {
        return static_cast<std::uint8_t>(options.classifier == Classifier::kStabbing ? out == 0 : in > out);
      });
  if (options.classifier == Classifier::kParity && options.flip_islands) {
    // Voids first: one inside an island must not outlive it.
    for (const std::uint8_t value : {std::uint8_t{0}, std::uint8_t{1}})
      flip_islands(votes, value, options.directions, volume, context, report);
  }
  return volume;
}

}  // namespace voxcarve
