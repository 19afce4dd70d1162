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

namespace voxcarve {

namespace {

/// Votes of the directions on every voxel. For ray stabbing one vote "exterior" decides.
struct Votes {
  explicit Votes(const GridFrame& frame) : interior(frame), exterior(frame) {}
  Grid<std::uint8_t> interior;
  Grid<std::uint8_t> exterior;
};

/// Walks all columns along `axis` at once, a run of voxels along x at a time, so that memory is read in order:
/// start(columns) for the columns of a slab, a list of their indices v * rows + u; then step(grid index of the run,
/// position in the columns) for every run, front to back. Slabs go to threads; the state of one is a `State`.
template <class State, class Start, class Step>
void sweep_columns(const GridFrame& frame, int axis, RunContext& context, const Start& start, const Step& step) {
  const std::int64_t nx = frame.dims[0];
  const std::int64_t rows = frame.dims[(axis + 1) % 3];
  // Along x a run is a whole column; else slabs are cut across the remaining axis.
  const int slab_axis = axis == 2 ? 1 : 2;
  parallel_for(context, 0, frame.dims[slab_axis], 1, [&](std::int64_t begin, std::int64_t end) {
    State state;
    std::vector<std::size_t> columns;
    for (std::int64_t slab = begin; slab < end; ++slab) {
      const std::int64_t positions = axis == 0 ? frame.dims[1] : frame.dims[axis];
      for (std::int64_t position = 0; position < positions; ++position) {
        const std::int64_t j = axis == 2 ? slab : position;
        const std::int64_t k = axis == 2 ? position : slab;
        if (axis == 0 || position == 0) {
          columns.clear();
          for (std::int64_t i = 0; i < (axis == 0 ? 1 : nx); ++i) {
            const Index3 voxel(i, j, k);
            columns.push_back(static_cast<std::size_t>(voxel[(axis + 2) % 3] * rows + voxel[(axis + 1) % 3]));
          }
          start(columns, state);
        }
        step(static_cast<std::size_t>((k * frame.dims[1] + j) * nx), axis == 0 ? 0 : position, state);
      }
    }
  });
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
  struct Columns {
    std::vector<std::uint8_t> votes;   ///< 1 unless the column is invalid
    std::vector<std::uint8_t> parity;  ///< of the toggles so far
  };
  const auto nx = static_cast<std::size_t>(frame.dims[0]);
  sweep_columns<Columns>(
      frame, axis, context,
      [&](const std::vector<std::size_t>& columns, Columns& state) {
        state.parity.assign(columns.size(), 0);
        state.votes.resize(columns.size());
        std::ranges::transform(columns, state.votes.begin(), [&](std::size_t column) {
          return static_cast<std::uint8_t>(crossings[column] % 2 == 0);
        });
      },
      [&](std::size_t run, std::int64_t, Columns& state) {
        for (std::size_t i = 0; i < nx; ++i) {
          const std::size_t column = axis == 0 ? 0 : i;
          state.parity[column] ^= toggles.values[run + i];
          const std::uint8_t votes_here = state.votes[column];
          const std::uint8_t inside = state.parity[column] & votes_here;
          votes.interior.values[run + i] = static_cast<std::uint8_t>(votes.interior.values[run + i] + inside);
          votes.exterior.values[run + i] =
              static_cast<std::uint8_t>(votes.exterior.values[run + i] + votes_here - inside);
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
  const auto nx = static_cast<std::size_t>(frame.dims[0]);
  sweep_columns<std::vector<Span>>(
      frame, axis, context,
      [&](const std::vector<std::size_t>& columns, std::vector<Span>& state) {
        state.resize(columns.size());
        std::ranges::transform(columns, state.begin(), [&](std::size_t column) { return spans[column]; });
      },
      [&](std::size_t run, std::int64_t position, std::vector<Span>& state) {
        for (std::size_t i = 0; i < nx; ++i) {
          const Span span = state[axis == 0 ? 0 : i];
          const std::int64_t at = axis == 0 ? static_cast<std::int64_t>(i) : position;
          if (at < span.first || at >= span.last) votes.exterior.values[run + i] = 1;
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
        context.check_cancelled();
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

/// Of the 26 neighbours of a voxel, those that are interior; beyond the grid is exterior.
int interior_neighbours(const BinaryVolume& volume, const Index3& voxel) {
  int count = 0;
  for (std::int64_t dz = -1; dz <= 1; ++dz) {
    for (std::int64_t dy = -1; dy <= 1; ++dy) {
      for (std::int64_t dx = -1; dx <= 1; ++dx) count += volume.get(voxel[0] + dx, voxel[1] + dy, voxel[2] + dz, 0);
    }
  }
  return count - volume(voxel[0], voxel[1], voxel[2]);
}

/// Lets disputed voxels take the class of most of their neighbours, all at once, `sweeps` times. Returns how many ended
/// in another class than the votes gave them.
std::int64_t settle_disputes(const Votes& votes, const VoxelizeOptions& options, BinaryVolume& volume,
                             RunContext& context) {
  if (options.settle_sweeps == 0) return 0;
  const GridFrame& frame = volume.frame;
  const auto is_disputed = [&](std::size_t index) {
    const int in = votes.interior.values[index];
    const int out = votes.exterior.values[index];
    const bool split = (in > 0 && out > 0) || in + out == 0;
    return split && 2 * std::max(in, out) < options.directions;
  };
  std::size_t count = 0;
  for (std::size_t index = 0; index < volume.values.size(); ++index) count += is_disputed(index);
  context.require_memory(3 * volume.values.size() + count * (sizeof(Index3) + 2), "settling disputed votes");
  std::vector<Index3> disputed;
  disputed.reserve(count);
  for (std::int64_t k = 0; k < frame.dims[2]; ++k) {
    context.check_cancelled();
    for (std::int64_t j = 0; j < frame.dims[1]; ++j) {
      for (std::int64_t i = 0; i < frame.dims[0]; ++i) {
        if (is_disputed(volume.index(i, j, k))) disputed.emplace_back(i, j, k);
      }
    }
  }
  const auto value_of = [&](const Index3& v) -> std::uint8_t& { return volume(v[0], v[1], v[2]); };
  std::vector<std::uint8_t> voted(disputed.size());
  std::ranges::transform(disputed, voted.begin(), value_of);
  std::vector<std::uint8_t> next(disputed.size());
  for (std::int64_t sweep = 0; sweep < options.settle_sweeps; ++sweep) {
    parallel_for(context, 0, static_cast<std::int64_t>(disputed.size()), 1 << 14,
                 [&](std::int64_t begin, std::int64_t end) {
                   for (auto at = static_cast<std::size_t>(begin); at < static_cast<std::size_t>(end); ++at) {
                     const int interior = interior_neighbours(volume, disputed[at]);
                     next[at] = interior == 13 ? value_of(disputed[at]) : static_cast<std::uint8_t>(interior > 13);
                   }
                 });
    for (std::size_t at = 0; at < disputed.size(); ++at) value_of(disputed[at]) = next[at];
  }
  std::int64_t changed = 0;
  for (std::size_t at = 0; at < disputed.size(); ++at) changed += value_of(disputed[at]) != voted[at];
  return changed;
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
  // The layers of centres that the box holds, centred in it: none lies beyond it, and none is missing.
  for (int axis = 0; axis < 3; ++axis) {
    frame.dims[axis] = std::max<std::int64_t>(std::llround(extent[axis] / frame.voxel_size), 1);
  }
  frame.origin = box.center() - 0.5 * frame.voxel_size * frame.dims.cast<double>();
  if (frame.is_image()) frame.dims[2] = 2;  // a single slice would count as a 2D image; the second one stays empty
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
  // A single direction has no majority: what its invalid columns lose is lost [NT03, Fig. 4].
  if (options.classifier == Classifier::kParity && options.directions > 1) {
    const std::int64_t settled = settle_disputes(votes, options, volume, context);
    if (report != nullptr) report->settled_voxels = settled;
  }
  return volume;
}

}  // namespace voxcarve
