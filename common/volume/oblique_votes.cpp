// A ray of every direction through every voxel that is still open, each looked up in a LineStabber. Parity count knows
// most of them before: the parities of a row of voxels follow from those along x (see Curtains).
#include "common/volume/oblique_votes.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <optional>

#include "common/mesh/line_stabber.h"

namespace voxcarve {

namespace {

/// The soup in voxel units, the lower corner of the grid at the origin: projections on oblique directions keep their
/// digits however far from the origin the model lies.
TriangleSoup in_voxel_units(const TriangleSoup& soup, const GridFrame& frame) {
  TriangleSoup local;
  local.triangles = soup.triangles;
  local.positions.reserve(soup.positions.size());
  for (const Point& position : soup.positions) {
    local.positions.emplace_back((position - frame.origin) / frame.voxel_size);
  }
  return local;
}

/// In voxels. The projections of oblique directions are rounded, so there a centre on the surface is moved in earnest,
/// a thousandth of a voxel the way that the axes move it infinitesimally.
const Point kObliqueShift(0x1p-10, 0x1p-13, 0x1p-16);

constexpr VoteCount kInterior = 1;
constexpr VoteCount kExterior = 16;

/// No vote to come changes the class.
bool is_decided(VoteCount count, const ObliqueVoteOptions& options) {
  if (options.stabbing) return exterior_votes(count) > 0;
  return 2 * std::max(interior_votes(count), exterior_votes(count)) > options.directions;
}

/// What a line with crossings `in_front` of a voxel centre and `total` in all adds to the voxel's count.
VoteCount vote_of(std::ptrdiff_t in_front, std::ptrdiff_t total, const ObliqueVoteOptions& options) {
  if (options.odd_abstain && total % 2 != 0) return 0;
  const bool interior = options.stabbing ? in_front > 0 && in_front < total : in_front % 2 != 0;
  return interior ? kInterior : kExterior;
}

/// For every eight bits a byte each, `value` where the bit is set.
template <VoteCount value>
constexpr auto kCountsOf = [] {
  std::array<std::array<VoteCount, 8>, 256> table{};
  for (std::size_t bits = 0; bits < table.size(); ++bits) {
    for (std::size_t i = 0; i < 8; ++i) table[bits][i] = (bits >> i & 1) != 0 ? value : 0;
  }
  return table;
}();

}  // namespace

void count_row(const RowVotes& votes, std::int64_t voxels, VoteCount* counts) {
  for (std::int64_t word = 0; word < words_for(voxels); ++word) {
    for (std::int64_t byte = 0; byte < 8; ++byte) {
      const std::int64_t first = word * kWordBits + byte * 8;
      if (first >= voxels) return;
      std::uint64_t sum = 0;  // eight counts, which never reach into one another
      for (std::size_t axis = 0; axis < 3; ++axis) {
        if (votes.interior[axis] == nullptr) continue;
        const BitWord voting = ~votes.abstains[axis][word];
        std::uint64_t interior = 0;
        std::uint64_t exterior = 0;
        std::memcpy(&interior, kCountsOf<kInterior>[(votes.interior[axis][word] & voting) >> 8 * byte & 0xff].data(),
                    8);
        std::memcpy(&exterior, kCountsOf<kExterior>[(~votes.interior[axis][word] & voting) >> 8 * byte & 0xff].data(),
                    8);
        sum += interior + exterior;
      }
      const auto bytes = static_cast<std::size_t>(std::min<std::int64_t>(8, voxels - first));
      std::uint64_t before = 0;
      std::memcpy(&before, counts + first, bytes);
      sum += before;
      std::memcpy(counts + first, &sum, bytes);
    }
  }
}

namespace {

/// The voters of one direction.
class Lines {
 public:
  Lines(const TriangleSoup& local, const Point& direction, double cell_size, const ObliqueVoteOptions& options,
        const RunContext& context)
      : options_(options), stabber_(local, StabFrame::along(direction), cell_size, &context) {}

  /// Adds the vote of a voxel that is still open.
  void vote(const Index3& voxel, VoteCount& count, std::vector<Crossing>& crossings) const {
    if (is_decided(count, options_)) return;
    const StabFrame& frame = stabber_.frame();
    const Point center = voxel.cast<double>() + Point::Constant(0.5) + kObliqueShift;
    const double depth = center.dot(frame.w);
    crossings.clear();
    stabber_.append_crossings(center.dot(frame.u), center.dot(frame.v), crossings);
    const auto in_front = std::ranges::count_if(crossings, [&](const Crossing& c) { return c.depth <= depth; });
    count = static_cast<VoteCount>(count + vote_of(in_front, std::ssize(crossings), options_));
  }

 private:
  const ObliqueVoteOptions& options_;
  LineStabber stabber_;
};

/// A word of running parities along a row; `before` holds, in all bits, the parity up to this word.
BitWord running_parity(BitWord toggles, BitWord& before) {
  const BitWord parity = prefix_parity(toggles) ^ before;
  before = spread(parity >> (kWordBits - 1) != 0);
  return parity;
}

/// Votes of one direction on a slice where they are known; the voxels marked do not vote.
void count_known(const KnownParities& known, const Point& direction, const Index3& dims, std::int64_t k,
                 std::int64_t slice, const BitVolume& marks, VoteCount* counts) {
  const std::int64_t words = marks.row_words();
  std::vector<BitWord> in_front(static_cast<std::size_t>(words * dims[1]), 0);
  std::vector<BitWord> total(in_front.size(), 0);
  known.curtains.toggle_slice(direction, dims, k, in_front, total);
  for (std::int64_t j = 0; j < dims[1]; ++j) {
    BitWord* interior = in_front.data() + j * words;
    BitWord* abstains = total.data() + j * words;
    BitWord front_before = 0;
    BitWord total_before = 0;
    for (std::int64_t word = 0; word < words; ++word) {
      interior[word] = running_parity(interior[word], front_before) ^ known.along_x.row(j, slice)[word];
      abstains[word] = running_parity(abstains[word], total_before) | marks.row(j, slice)[word];
    }
    count_row({{interior, nullptr, nullptr}, {abstains, nullptr, nullptr}}, dims[0], counts + j * dims[0]);
  }
}

}  // namespace

void vote_oblique(const TriangleSoup& soup, const GridFrame& frame, IndexRange slices,
                  const std::vector<Point>& directions, const ObliqueVoteOptions& options, const KnownParities* known,
                  std::uint64_t held, GridValues<VoteCount>& counts, Stage& stage, RunContext& context) {
  const Index3 dims(frame.dims[0], frame.dims[1], slices.size());
  held += soup.triangles.size() * sizeof(Triangle) + soup.positions.size() * sizeof(Point);
  if (known != nullptr) held += 2 * BitVolume::memory(dims);
  context.require_memory(held, "voxelization");
  const TriangleSoup local = in_voxel_units(soup, frame);
  BitVolume near_surface;
  BitVolume marks;
  if (known != nullptr) {
    near_surface = BitVolume(dims);
    near_surface.clear();
    known->curtains.mark_surface(frame.dims, slices, near_surface, context);
  }
  // In voxels. Where all voxels ask, the distance of neighbouring lines; where few do, binning would take longer.
  const double cell_size = known == nullptr ? 1 : 4;
  for (const Point& direction : directions) {
    if (known != nullptr) {
      marks = near_surface;
      known->curtains.mark_curtains(direction, frame.dims, slices, marks, context);
    }
    std::optional<Lines> lines;
    if (known == nullptr || count_set(marks, context) > 0) {
      context.require_memory(
          held + LineStabber::memory_estimate(local, StabFrame::along(direction), cell_size, &context), "voxelization");
      lines.emplace(local, direction, cell_size, options, context);
    }
    parallel_for(context, slices.first, slices.last + 1, 1, [&](std::int64_t k, std::int64_t) {
      std::vector<Crossing> crossings;
      const std::int64_t slice = k - slices.first;
      VoteCount* of_slice = counts.data() + slice * dims[1] * dims[0];
      if (known != nullptr) count_known(*known, direction, dims, k, slice, marks, of_slice);
      for (std::int64_t j = 0; j < dims[1]; ++j) {
        context.check_cancelled();
        VoteCount* of_row = of_slice + j * dims[0];
        if (known == nullptr) {
          for (std::int64_t i = 0; i < dims[0]; ++i) lines->vote({i, j, k}, of_row[i], crossings);
          continue;
        }
        for (std::int64_t word = 0; word < marks.row_words(); ++word) {
          for (BitWord marked = marks.row(j, slice)[word]; marked != 0; marked &= marked - 1) {
            const std::int64_t i = word * kWordBits + std::countr_zero(marked);
            lines->vote({i, j, k}, of_row[i], crossings);
          }
        }
      }
      stage.advance(1);
    });
  }
}

}  // namespace voxcarve
