// Based on [WR05, abstract and 3.3], which defines stability in two ways and computes neither. Differs in its balls,
// those about voxels. Where a ball of the largest radius fits is a dilation; everywhere else balls are painted, the
// larger ones first, and of all those only the few that no ball next to them holds and that have anything left to
// paint.
#include "common/volume/stability.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>
#include <vector>

#include "common/run/errors.h"
#include "common/volume/ball_painter.h"
#include "common/volume/bit_morphology.h"
#include "common/volume/bit_volume.h"
#include "common/volume/distance_transform.h"

namespace voxcarve {

namespace {

constexpr std::int64_t kVoxelsPerChunk = 1 << 16;
constexpr std::uint64_t kBytesPerVoxel = sizeof(std::int32_t) + 1;  ///< of a distance transform and what it is made of

/// The volume on `frame`, which has as many more voxels on either side along each axis; these are `outside`.
BinaryVolume widened(const BinaryVolume& volume, const GridFrame& frame, bool outside, RunContext& context) {
  const Index3 margin = (frame.dims - volume.frame.dims) / 2;
  return expanded(packed(volume, margin, outside, context), frame, context);
}

/// Of every voxel of `frame` the squared radius of the largest ball about it that lies on its side, up to `cap`.
/// `frame` is that of `volume` with a margin of at least one voxel, all `outside`.
Grid<std::int32_t> fitting_reaches(const BinaryVolume& volume, const GridFrame& frame, std::int32_t cap, bool outside,
                                   RunContext& context) {
  const auto outer = static_cast<std::uint8_t>(outside);
  const auto inner = static_cast<std::uint8_t>(!outside);
  const GridFrame tight = padded(volume.frame, 1);  // the nearest voxel outside the grid is always next to it
  const Grid<std::int32_t> depths = squared_distance(widened(volume, tight, outside, context), outer, context);
  Grid<std::int32_t> reaches = squared_distance(widened(volume, frame, outside, context), inner, context);
  const Index3 margin = (frame.dims - tight.dims) / 2;
  parallel_for(context, 0, frame.dims[1] * frame.dims[2], std::max<std::int64_t>(1, kVoxelsPerChunk / frame.dims[0]),
               [&](std::int64_t begin, std::int64_t end) {
                 for (std::int64_t row = begin; row < end; ++row) {
                   std::int32_t* reach = reaches.values.data() + row * frame.dims[0];
                   const Index3 from(0, row % frame.dims[1] - margin[1], row / frame.dims[1] - margin[2]);
                   if (tight.contains(from)) {
                     const std::int32_t* depth = depths.values.data() + depths.index(0, from[1], from[2]);
                     for (std::int64_t i = 0; i < tight.dims[0]; ++i)
                       reach[i + margin[0]] = std::max(reach[i + margin[0]], depth[i]);  // one of them is 0
                   }
                   for (std::int64_t i = 0; i < frame.dims[0]; ++i) reach[i] = std::min(reach[i] - 1, cap);
                 }
               });
  return reaches;
}

/// Which voxels satisfy a test, as bits: test(index, i, j, k).
template <class Test>
BitVolume voxels_where(const Index3& dims, RunContext& context, const Test& test) {
  BitVolume bits(dims);
  for_each_row(bits, context, [&](BitWord* words, std::int64_t row_words, std::int64_t j, std::int64_t k) {
    std::fill_n(words, row_words, BitWord{0});
    auto index = static_cast<std::size_t>((k * dims[1] + j) * dims[0]);
    for (std::int64_t i = 0; i < dims[0]; ++i, ++index) {
      if (test(index, i, j, k)) words[i / kWordBits] |= bit_of(i);
    }
  });
  return bits;
}

/// Which balls are held by a ball about a neighbour of their center.
class NeighborBalls {
 public:
  /// For balls of squared radii below `cap` within a grid of `dims`.
  NeighborBalls(const Index3& dims, std::int32_t cap, const RunContext& context) : dims_(dims) {
    const bool image = dims[2] == 1;
    tabulate(cap, image, context);
    for (std::int32_t z = image ? 0 : -1; z <= (image ? 0 : 1); ++z) {
      for (std::int32_t y = -1; y <= 1; ++y) {
        for (std::int32_t x = -1; x <= 1; ++x) {
          if (x == 0 && y == 0 && z == 0) continue;
          steps_.push_back(
              {{x, y, z}, (z * dims[1] + y) * dims[0] + x, static_cast<std::size_t>(x * x + y * y + z * z - 1)});
        }
      }
    }
    // Most balls are held by one across a face.
    std::ranges::stable_sort(steps_, {}, &Step::kind);
  }

  /// Does a neighbour's ball hold that of voxel (i, j, k), and is it as large or larger? The ball may then be left out:
  /// a ball that holds another one about another center has more voxels, so that the way from holder to holder ends,
  /// at a ball that is kept and that holds them all; and neither side's balls are held by those of the other one.
  bool hold(const std::int32_t* reaches, std::int64_t i, std::int64_t j, std::int64_t k) const {
    const std::int64_t index = (k * dims_[1] + j) * dims_[0] + i;
    const auto reach = static_cast<std::size_t>(reaches[index]);
    const Index3 voxel(i, j, k);
    const bool on_border = (voxel.array() == 0).any() || (voxel.array() == dims_.array() - 1).any();
    for (const Step& step : steps_) {
      if (on_border && !within_grid(i + step.by[0], j + step.by[1], k + step.by[2])) continue;
      if (reaches[index + step.offset] >= holding_[step.kind][reach]) return true;
    }
    return false;
  }

  static std::uint64_t memory(std::int32_t cap) { return 3 * static_cast<std::uint64_t>(cap) * sizeof(std::int32_t); }

 private:
  struct Step {
    std::array<std::int32_t, 3> by;
    std::int64_t offset;
    std::size_t kind;  ///< 0 across a face, 1 across an edge, 2 across a corner
  };

  bool within_grid(std::int64_t i, std::int64_t j, std::int64_t k) const {
    return i >= 0 && j >= 0 && k >= 0 && i < dims_[0] && j < dims_[1] && k < dims_[2];
  }

  /// holding_[kind][t] is the greatest |x + step|^2 over the x of the ball of squared radius t, or t if that is more:
  /// the least squared radius about a neighbour that is no smaller and holds the ball. By symmetry the greatest lies
  /// where x >= y >= z >= 0 and the step goes along the leading coordinates.
  void tabulate(std::int32_t cap, bool image, const RunContext& context) {
    constexpr std::int32_t kRowsPerPoll = 256;  // of z
    for (auto& table : holding_) table.assign(static_cast<std::size_t>(cap), 0);
    for (std::int32_t x = 0; x * x < cap; ++x) {
      for (std::int32_t y = 0; y <= x && x * x + y * y < cap; ++y) {
        if (y % kRowsPerPoll == 0) context.check_cancelled();
        for (std::int32_t z = 0; z <= (image ? 0 : y) && x * x + y * y + z * z < cap; ++z) {
          const std::int32_t squared = x * x + y * y + z * z;
          std::int32_t along = 0;
          for (std::size_t kind = 0; kind < 3; ++kind) {
            along += std::array{x, y, z}[kind];
            std::int32_t& entry = holding_[kind][static_cast<std::size_t>(squared)];
            entry = std::max(entry, squared + 2 * along + static_cast<std::int32_t>(kind) + 1);
          }
        }
      }
    }
    for (auto& table : holding_) {
      std::int32_t greatest = 0;
      for (std::size_t t = 0; t < table.size(); ++t) {
        if (t % kVoxelsPerChunk == 0) context.check_cancelled();
        greatest = std::max({greatest, table[t], static_cast<std::int32_t>(t)});
        table[t] = greatest;
      }
    }
  }

  Index3 dims_;
  std::vector<Step> steps_;
  std::array<std::vector<std::int32_t>, 3> holding_;
};

/// Square of the distance from voxel `center` to a grid of `dims`.
std::int64_t squared_distance_to_grid(const Index3& center, const Index3& dims) {
  const Index3 nearest = center.cwiseMax(0).cwiseMin(dims - Index3::Ones());
  return (center - nearest).squaredNorm();
}

/// The balls below the cap that may matter to a grid of `dims` within the one of `reaches`, from the largest to the
/// smallest; none of a single voxel. `reaches` is no longer needed then, and let go. `held` are the caller's bytes.
std::vector<Ball> needed_balls(Grid<std::int32_t> reaches, const Index3& dims, std::int32_t cap, std::uint64_t held,
                               RunContext& context) {
  const Index3 margin = (reaches.frame.dims - dims) / 2;
  BitVolume needed(Index3::Zero());
  {
    const NeighborBalls neighbors(reaches.frame.dims, cap, context);
    needed = voxels_where(reaches.frame.dims, context,
                          [&](std::size_t index, std::int64_t i, std::int64_t j, std::int64_t k) {
                            const std::int32_t reach = reaches.values[index];
                            return reach > 0 && reach < cap && !neighbors.hold(reaches.values.data(), i, j, k) &&
                                   squared_distance_to_grid(Index3(i, j, k) - margin, dims) <= reach;
                          });
  }
  const auto visit = [&](const auto& take) {
    for (std::int64_t k = 0; k < reaches.nz(); ++k) {
      context.check_cancelled();
      for (std::int64_t j = 0; j < reaches.ny(); ++j) {
        const BitWord* words = needed.row(j, k);
        for (std::int64_t w = 0; w < needed.row_words(); ++w) {
          for (BitWord word = words[w]; word != 0; word &= word - 1) {
            const std::int64_t i = w * kWordBits + std::countr_zero(word);
            take(Index3(i, j, k), reaches(i, j, k));
          }
        }
      }
    }
  };
  // Beside the balls: what is here, and the result with its blank voxels.
  held += reaches.values.size() * sizeof(std::int32_t) + BitVolume::memory(reaches.frame.dims) +
          static_cast<std::uint64_t>(dims.prod()) * kBytesPerVoxel +
          static_cast<std::uint64_t>(cap) * sizeof(std::size_t);
  context.require_memory(held, "the stability map's balls");
  std::vector<std::size_t> place(static_cast<std::size_t>(cap), 0);  // of the next ball of every squared radius
  visit([&](const Index3&, std::int32_t reach) { ++place[static_cast<std::size_t>(reach)]; });
  std::size_t before = 0;
  for (std::size_t reach = place.size(); reach-- > 0;) {
    if (reach % kVoxelsPerChunk == 0) context.check_cancelled();
    before += std::exchange(place[reach], before);
  }
  context.require_memory(held + before * sizeof(Ball), "the stability map's balls");
  std::vector<Ball> balls(before);
  visit([&](const Index3& voxel, std::int32_t reach) {
    const Index3 center = voxel - margin;
    balls[place[static_cast<std::size_t>(reach)]++] = {
        {static_cast<std::int32_t>(center[0]), static_cast<std::int32_t>(center[1]),
         static_cast<std::int32_t>(center[2])},
        reach};
  });
  return balls;
}

/// Paints `balls`, which come from the largest to the smallest and lie about voxels of `frame`. Most of them hold
/// nothing that a larger one does not: so before each round all that hold no blank voxel are dropped.
void paint_in_rounds(const std::vector<Ball>& balls, const GridFrame& frame, BitVolume& blank,
                     Grid<std::int32_t>& result, std::uint64_t held, RunContext& context) {
  constexpr std::int64_t kVoxelsPerBall = 20;  // where a round's distances cost about as much as its painting
  const auto round = static_cast<std::size_t>(frame.voxels() / kVoxelsPerBall + 1);
  const Index3 margin = (frame.dims - result.frame.dims) / 2;
  context.require_memory(held + (balls.size() + std::min(balls.size(), round)) * sizeof(Ball) +
                             kBytesPerVoxel * static_cast<std::uint64_t>(frame.voxels() + 2 * result.frame.voxels()) +
                             paint_balls_memory(result.frame.dims, balls.empty() ? 0 : balls.front().reach),
                         "the stability map's balls");
  std::vector<Ball> kept;
  for (std::size_t begin = 0; begin < balls.size(); begin += round) {
    const std::size_t end = std::min(begin + round, balls.size());
    kept.clear();
    {
      const BinaryVolume unpainted = widened(expanded(blank, result.frame, context), frame, false, context);
      const Grid<std::int32_t> distance = squared_distance(unpainted, 1, context);
      std::copy_if(balls.begin() + static_cast<std::ptrdiff_t>(begin), balls.begin() + static_cast<std::ptrdiff_t>(end),
                   std::back_inserter(kept), [&](const Ball& ball) {
                     return distance(ball.center[0] + margin[0], ball.center[1] + margin[1],
                                     ball.center[2] + margin[2]) <= ball.reach;
                   });
    }
    paint_balls(kept, blank, result, context);
  }
}

/// The greatest float below `bound`.
float float_below(double bound) {
  const auto nearest = static_cast<float>(bound);
  return static_cast<double>(nearest) < bound ? nearest : std::nextafter(nearest, -1.0F);
}

/// The voxels of the mortar, on the grid of `bits`, which has the ball's margin.
BitVolume mortar(const BitVolume& bits, std::int64_t reach, bool outside, RunContext& context) {
  // A ball that lies wholly on one side keeps to it, so both openings dilate at once.
  BitVolume centers = bits;
  const auto flip = [&](BitVolume& volume) {
    for_each_row(volume, context, [&](BitWord* words, std::int64_t row_words, std::int64_t, std::int64_t) {
      for (std::int64_t w = 0; w < row_words; ++w) words[w] = ~words[w];
      words[row_words - 1] &= last_word_mask(volume.dims()[0]);
    });
  };
  flip(centers);
  centers = erode(centers, reach, !outside, context);
  {
    const BitVolume others = erode(bits, reach, outside, context);
    for_each_row(centers, context, [&](BitWord* words, std::int64_t row_words, std::int64_t j, std::int64_t k) {
      const BitWord* more = others.row(j, k);
      for (std::int64_t w = 0; w < row_words; ++w) words[w] |= more[w];
    });
  }
  BitVolume result = dilate(centers, reach, false, context);
  flip(result);
  return result;
}

}  // namespace

Grid<std::int32_t> squared_stability(const BinaryVolume& volume, double largest, bool outside, RunContext& context,
                                     std::uint64_t held) {
  const auto cap = static_cast<std::int32_t>(squared_reach(largest));
  if (cap == 0 || volume.frame.voxels() == 0) return Grid<std::int32_t>(volume.frame);
  const auto margin = static_cast<std::int64_t>(std::ceil(largest));
  const GridFrame frame = padded(volume.frame, margin);
  const auto voxels = static_cast<std::uint64_t>(frame.voxels());
  context.require_memory(held +
                             kBytesPerVoxel * (voxels + static_cast<std::uint64_t>(padded(volume.frame, 1).voxels())) +
                             NeighborBalls::memory(cap),
                         "the stability map");
  // Where the largest ball fits: reaches, the centers of such balls, and their dilation in the making.
  context.require_memory(
      held + voxels * sizeof(std::int32_t) + BitVolume::memory(frame.dims) + morphology_memory(frame.dims, cap),
      "the stability map");
  Grid<std::int32_t> reaches = fitting_reaches(volume, frame, cap, outside, context);

  // What a ball of the largest radius fits into; it may lie on either side, which it does not leave.
  BitVolume settled = dilate(voxels_where(frame.dims, context,
                                          [&](std::size_t index, std::int64_t, std::int64_t, std::int64_t) {
                                            return reaches.values[index] == cap;
                                          }),
                             cap, false, context);
  const Index3 offset = (frame.dims - volume.frame.dims) / 2;
  auto result = Grid<std::int32_t>::uninitialized(volume.frame);
  BitVolume blank =
      voxels_where(volume.frame.dims, context, [&](std::size_t index, std::int64_t i, std::int64_t j, std::int64_t k) {
        const bool done = settled.get(i + offset[0], j + offset[1], k + offset[2]);
        result.values[index] = done ? cap : 0;
        return !done;
      });
  settled = BitVolume();
  const std::vector<Ball> balls = needed_balls(std::move(reaches), volume.frame.dims, cap, held, context);
  paint_in_rounds(balls, frame, blank, result, held, context);
  return result;
}

Grid<float> stability_radii(const Grid<std::int32_t>& squared, double largest, RunContext& context,
                            std::uint64_t held) {
  const auto cap = static_cast<std::int32_t>(squared_reach(largest));
  constexpr std::int32_t kLargestTable = 1 << 16;
  const std::size_t known = cap <= kLargestTable ? static_cast<std::size_t>(cap) : 0;  // radii that are tabulated
  context.require_memory(held + squared.values.size() * (sizeof(std::int32_t) + sizeof(float)) + known * sizeof(float),
                         "stability radii");
  // A threshold at the largest radius may come as a double or rounded to a float, in either direction: the value where
  // its ball fits is not below either, and every other value is below both.
  const auto rounded = static_cast<float>(largest);
  const float settled = static_cast<double>(rounded) < largest
                            ? std::nextafter(rounded, std::numeric_limits<float>::infinity())
                            : rounded;
  const double bound = std::min(largest, static_cast<double>(rounded));
  const auto radius_of = [&](std::int32_t value) {
    // The root is exact enough: a float's square that is no integer differs from one by more than 1 in 2^48.
    return value >= cap ? settled : float_below(std::min(std::sqrt(static_cast<double>(value) + 1), bound));
  };
  std::vector<float> table(known);
  for (std::size_t value = 0; value < known; ++value) table[value] = radius_of(static_cast<std::int32_t>(value));
  auto radii = Grid<float>::uninitialized(squared.frame);
  parallel_for(context, 0, squared.frame.voxels(), kVoxelsPerChunk, [&](std::int64_t begin, std::int64_t end) {
    std::transform(squared.values.begin() + begin, squared.values.begin() + end, radii.values.begin() + begin,
                   [&](std::int32_t value) {
                     const auto at = static_cast<std::size_t>(value);
                     return at < known ? table[at] : radius_of(value);
                   });
  });
  return radii;
}

Grid<float> first_mortar(const BinaryVolume& volume, std::span<const double> radii, bool outside, RunContext& context,
                         std::uint64_t held) {
  for (std::size_t r = 1; r < radii.size(); ++r) {
    if (!(radii[r] > radii[r - 1])) throw ParameterError("the radii of a stability map must increase");
  }
  held += static_cast<std::uint64_t>(volume.frame.voxels()) * sizeof(float);
  context.require_memory(held, "the first mortar");
  auto result = Grid<float>::uninitialized(volume.frame);
  parallel_for(context, 0, volume.frame.voxels(), kVoxelsPerChunk, [&](std::int64_t begin, std::int64_t end) {
    std::fill(result.values.begin() + begin, result.values.begin() + end, 0.0F);
  });
  for (const double radius : radii) {
    const std::int64_t reach = squared_reach(radius);
    if (reach == 0 || volume.frame.voxels() == 0) continue;  // every voxel is a ball of its own
    const Index3 margin = ball_margin(volume.frame.dims, radius);
    const Index3 dims = volume.frame.dims + 2 * margin;
    constexpr std::uint64_t kVolumesOfBits = 2;  // the volume's and the centers of balls, beside what is in the making
    context.require_memory(held + kVolumesOfBits * BitVolume::memory(dims) + morphology_memory(dims, reach),
                           "the first mortar");
    const BitVolume irregular = mortar(packed(volume, margin, outside, context), reach, outside, context);
    parallel_for(context, 0, volume.nz() * volume.ny(), std::max<std::int64_t>(1, kVoxelsPerChunk / volume.nx()),
                 [&](std::int64_t begin, std::int64_t end) {
                   for (std::int64_t row = begin; row < end; ++row) {
                     float* values = result.values.data() + row * volume.nx();
                     for (std::int64_t i = 0; i < volume.nx(); ++i) {
                       if (values[i] == 0 &&
                           irregular.get(i + margin[0], row % volume.ny() + margin[1], row / volume.ny() + margin[2]))
                         values[i] = static_cast<float>(radius);
                     }
                   }
                 });
  }
  return result;
}

std::span<const double> default_stability_radii() {
  static constexpr std::array<double, 12> kRadii = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};
  return kRadii;
}

}  // namespace voxcarve
