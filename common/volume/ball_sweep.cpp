// Based on [MRH00], whose three passes take the axes apart; differs in stopping at the ball's radius. Beyond it nothing
// matters, so distances along y are bytes, squares in the plane 16 bits, and along z no distances are needed at all:
// a voxel whose nearest feature in its slice lies at d covers sqrt(r^2 - d^2) voxels before and behind it, and a sweep
// that counts down knows what is covered. Slices pass through a ring that holds as many of them as the radius asks for.
#include "common/volume/ball_sweep.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <vector>

#include "common/volume/vectorized.h"
#include "common/volume/workspace_pool.h"

namespace voxcarve {

namespace {

using Byte = std::uint8_t;
using Square = std::uint16_t;

constexpr std::int64_t kTile = 32;  ///< voxels of a row that are treated together
/// Rows of a slice are treated together up to this size, but no fewer than four radii: each band also counts a radius
/// of rows on either side, without which it would have to wait for its neighbours.
constexpr std::int64_t kBandBytes = 1 << 19;
/// Squares of a tile, as two registers of the widest kind.
using Lanes [[gnu::vector_size(32)]] = Square;
constexpr std::int64_t kLanes = kTile / 2;

/// Distances along a column grow by one from voxel to voxel, up to `limit`; `keep` is 0 at features and 255 elsewhere.
VOXCARVE_VECTORIZED void count_on(const Byte* before, const Byte* keep, Byte limit, std::int64_t length, Byte* count) {
  for (std::int64_t i = 0; i < length; ++i) {
    const auto next = static_cast<Byte>(before[i] + 1);
    count[i] = static_cast<Byte>((next < limit ? next : limit) & keep[i]);
  }
}

/// The same backwards: what was counted from the one side, or one more than the next voxel's.
VOXCARVE_VECTORIZED void count_back(const Byte* behind, std::int64_t length, Byte* count) {
  for (std::int64_t i = 0; i < length; ++i) {
    const auto next = static_cast<Byte>(behind[i] + 1);
    count[i] = next < count[i] ? next : count[i];
  }
}

/// Whether any count of a tile is not `far`.
bool is_occupied(const Byte* count, Byte far) {
  constexpr std::uint64_t kEveryByte = 0x0101010101010101U;
  std::array<std::uint64_t, kTile / 8> words;
  std::memcpy(words.data(), count, kTile);
  std::uint64_t others = 0;
  for (const std::uint64_t word : words) others |= word ^ (kEveryByte * far);
  return others != 0;
}

VOXCARVE_VECTORIZED void square(const Byte* count, std::int64_t length, Square* squares) {
  for (std::int64_t i = 0; i < length; ++i) squares[i] = static_cast<Square>(count[i] * count[i]);
}

/// The least of squares[x + d] + d^2 over 0 and from <= |d| <= to, for the voxels x of a tile. Stops at the first d
/// that no longer changes anything.
VOXCARVE_VECTORIZED void nearest_in_row(const Square* squares, std::int64_t from, std::int64_t to, Square* nearest) {
  Lanes first;
  Lanes second;
  std::memcpy(&first, squares, sizeof(first));
  std::memcpy(&second, squares + kLanes, sizeof(second));
  for (std::int64_t d = from; d <= to; ++d) {
    const Lanes step = Lanes{} + static_cast<Square>(d * d);
    if (d % 4 == 1 || d == from) {
      const auto more = (first > step) | (second > step);
      std::array<std::uint64_t, 4> words;
      std::memcpy(words.data(), &more, sizeof(words));
      if ((words[0] | words[1] | words[2] | words[3]) == 0) break;
    }
    Lanes left;
    Lanes right;
    std::memcpy(&left, squares - d, sizeof(left));
    std::memcpy(&right, squares + d, sizeof(right));
    Lanes least = (left < right ? left : right) + step;
    first = least < first ? least : first;
    std::memcpy(&left, squares - d + kLanes, sizeof(left));
    std::memcpy(&right, squares + d + kLanes, sizeof(right));
    least = (left < right ? left : right) + step;
    second = least < second ? least : second;
  }
  std::memcpy(nearest, &first, sizeof(first));
  std::memcpy(nearest + kLanes, &second, sizeof(second));
}

/// For every voxel of a tile, how many of `limits` are no less than its square.
VOXCARVE_VECTORIZED void count_limits(const Square* squares, const Square* limits, std::int64_t limit_count,
                                      Byte* result) {
  Lanes first;
  Lanes second;
  std::memcpy(&first, squares, sizeof(first));
  std::memcpy(&second, squares + kLanes, sizeof(second));
  Lanes first_count{};
  Lanes second_count{};
  for (std::int64_t l = 0; l < limit_count; ++l) {
    // A comparison gives -1 where it holds.
    first_count -= static_cast<Lanes>(first <= limits[l]);
    second_count -= static_cast<Lanes>(second <= limits[l]);
  }
  std::array<Square, kTile> counts;
  std::memcpy(counts.data(), &first_count, sizeof(first_count));
  std::memcpy(counts.data() + kLanes, &second_count, sizeof(second_count));
  for (std::size_t i = 0; i < counts.size(); ++i) result[i] = static_cast<Byte>(counts[i]);
}

/// The same by a table of what count belongs to which square: no slower with many limits.
void look_up(const Square* squares, const Byte* table, Byte* result) {
  for (std::int64_t eight = 0; eight < kTile; eight += 8) {
    std::uint64_t bytes = 0;  // together, since a byte stored might be one of the table's
    for (int i = 0; i < 8; ++i) bytes |= std::uint64_t{table[squares[eight + i]]} << 8 * i;
    std::memcpy(result + eight, &bytes, sizeof(bytes));
  }
}

/// What a slice covers of the next one: a voxel less, or what that one covers by itself.
VOXCARVE_VECTORIZED void cover(const Byte* before, std::int64_t length, Byte* covered) {
  for (std::int64_t i = 0; i < length; ++i) {
    const auto carried = static_cast<Byte>(before[i] - (before[i] != 0));
    covered[i] = carried > covered[i] ? carried : covered[i];
  }
}

/// The same backwards: what `down` carries is what the next slice covers.
VOXCARVE_VECTORIZED void cover_down(const Byte* slice, std::int64_t bytes, Byte* down) {
  for (std::int64_t i = 0; i < bytes; ++i) {
    const auto carried = static_cast<Byte>(down[i] - (down[i] != 0));
    down[i] = carried > slice[i] ? carried : slice[i];
  }
}

VOXCARVE_VECTORIZED void make_flags(const Byte* covered, std::int64_t length, Byte* flags) {
  for (std::int64_t i = 0; i < length; ++i) flags[i] = covered[i] != 0;
}

/// 255 for every bit that is 0, 0 for every bit that is 1.
constexpr auto kKeepOf = [] {
  std::array<std::array<Byte, 8>, 256> table{};
  for (std::size_t bits = 0; bits < table.size(); ++bits) {
    for (std::size_t i = 0; i < 8; ++i) table[bits][i] = (bits >> i & 1) != 0 ? 0 : 255;
  }
  return table;
}();

class BallSweep {
 public:
  BallSweep(const BitVolume& volume, const Features& features, std::int64_t squared_reach, bool inverted)
      : volume_(volume),
        features_(features),
        inverted_(inverted),
        dims_(volume.dims()),
        row_words_(volume.row_words()),
        row_bytes_(row_words_ * kWordBits),
        reach_(squared_reach),
        radius_(static_cast<std::int64_t>(std::sqrt(static_cast<double>(squared_reach) + 0.5))),
        far_(static_cast<Byte>(radius_ + 1)),
        block_(block_slices(radius_)),
        ring_(std::min(dims_[2], block_ + radius_)),
        band_(std::min(dims_[1], std::max(kBandBytes / row_bytes_, std::max<std::int64_t>(4 * radius_, 1)))),
        covered_(static_cast<std::size_t>(ring_ * dims_[1] * row_bytes_)),
        limits_(static_cast<std::size_t>(radius_ + 1)),
        covers_(static_cast<std::size_t>((radius_ + 1) * (radius_ + 1) + 1)) {
    for (std::int64_t z = 0; z <= radius_; ++z)
      limits_[static_cast<std::size_t>(z)] = static_cast<Square>(reach_ - z * z);
    for (const Square limit : limits_) {
      for (std::size_t square = 0; square <= limit; ++square) ++covers_[square];
    }
  }

  BitVolume run(RunContext& context) {
    BitVolume result(dims_);
    std::int64_t known = 0;  // slices whose cover is in the ring, carried on from below
    GridValues<Byte> carried(static_cast<std::size_t>(carried_bytes(dims_)));
    const std::int64_t bands = (dims_[1] + band_ - 1) / band_;
    const std::int64_t rows = std::max<std::int64_t>(1, (1 << 14) / row_bytes_);
    for (std::int64_t begin = 0; begin < dims_[2]; begin += block_) {
      const std::int64_t end = std::min(begin + block_, dims_[2]);
      const std::int64_t wanted = std::min(end + radius_, dims_[2]);
      parallel_for(context, known * bands, wanted * bands, 1, [&](std::int64_t first, std::int64_t last) {
        for (std::int64_t band = first; band < last; ++band) {
          const std::int64_t row = band % bands * band_;
          cover_within_slice(band / bands, row, std::min(row + band_, dims_[1]), context);
        }
      });
      parallel_for(context, 0, dims_[1], rows, [&](std::int64_t first, std::int64_t last) {
        if (dims_[2] == 1) {
          for (std::int64_t j = first; j < last; ++j) write(row(j, 0), result.row(j, 0));
        } else {
          sweep(first, last, known, begin, end, wanted, carried, result);
        }
      });
      known = wanted;
    }
    return result;
  }

  static std::uint64_t memory(const Index3& dims, std::int64_t squared_reach) {
    const auto radius = static_cast<std::int64_t>(std::sqrt(static_cast<double>(squared_reach) + 0.5));
    const std::int64_t ring = std::min(dims[2], block_slices(radius) + radius);
    return BitVolume::memory(dims) +
           static_cast<std::uint64_t>(ring * dims[1] * words_for(dims[0]) * kWordBits + carried_bytes(dims));
  }

 private:
  /// Slices of the result that are made between two waits for all threads.
  static std::int64_t block_slices(std::int64_t radius) { return std::max<std::int64_t>(16, radius); }

  /// Of a slice; an image has no other that it could cover.
  static std::int64_t carried_bytes(const Index3& dims) {
    return dims[2] == 1 ? 0 : dims[1] * words_for(dims[0]) * kWordBits;
  }

  Byte* row(std::int64_t j, std::int64_t k) { return covered_.data() + (k % ring_ * dims_[1] + j) * row_bytes_; }

  /// What features outside cover of the first and of the last slice, plus one.
  Byte outside_cover() const { return features_.outside && dims_[2] > 1 ? far_ : 0; }

  BitWord feature_word(BitWord word, std::int64_t w) const {
    if (features_.value) return word;
    return ~word & (w + 1 == row_words_ ? last_word_mask(dims_[0]) : kAllBits);
  }

  /// Buffers of one thread.
  struct Rows {
    std::vector<Byte> count;     ///< distances along y of the row before or behind
    std::vector<Byte> keep;      ///< 0 at features, else 255
    std::vector<char> occupied;  ///< of every tile: whether a feature is within reach along y
    std::vector<Square> squares;
    std::int64_t margin = 0;  ///< of `squares` before voxel 0
  };

  Rows make_rows() const {
    Rows rows;
    rows.count.resize(static_cast<std::size_t>(row_bytes_));
    rows.keep.resize(static_cast<std::size_t>(row_bytes_));
    rows.occupied.resize(static_cast<std::size_t>(row_bytes_ / kTile));
    rows.margin = radius_ + 1;
    // Outside the row nothing is near, but for its first voxel on either side when features lie there.
    rows.squares.assign(static_cast<std::size_t>(row_bytes_ + 2 * rows.margin), static_cast<Square>(far_ * far_));
    return rows;
  }

  /// Fills `keep` for row (j, k).
  void find_features(std::int64_t j, std::int64_t k, Byte* keep) const {
    const BitWord* words = volume_.row(j, k);
    for (std::int64_t w = 0; w < row_words_; ++w) {
      const BitWord word = feature_word(words[w], w);
      for (int byte = 0; byte < 8; ++byte)
        std::memcpy(keep + w * kWordBits + 8 * byte, kKeepOf[word >> 8 * byte & 0xff].data(), 8);
    }
  }

  bool has_features(std::int64_t first_row, std::int64_t last_row, std::int64_t k) const {
    for (std::int64_t j = first_row; j < last_row; ++j) {
      const BitWord* words = volume_.row(j, k);
      for (std::int64_t w = 0; w < row_words_; ++w) {
        if (feature_word(words[w], w) != 0) return true;
      }
    }
    return false;
  }

  /// What rows first_row <= j < last_row of slice k cover. Rows out of their reach do not matter, so that bands of rows
  /// need not wait for one another.
  void cover_within_slice(std::int64_t k, std::int64_t first_row, std::int64_t last_row, const RunContext& context) {
    std::unique_ptr<Rows> rows = pool_.take([this] { return make_rows(); });
    const std::int64_t above = std::max<std::int64_t>(first_row - radius_, 0);
    const std::int64_t below = std::min(last_row + radius_, dims_[1]);
    if (features_.outside || has_features(above, below, k)) {
      cover_occupied_band(k, first_row, last_row, above, below, *rows, context);
    } else {
      std::memset(row(first_row, k), 0, static_cast<std::size_t>((last_row - first_row) * row_bytes_));
    }
    pool_.give(std::move(rows));
  }

  /// The same where a row of `above` <= j < `below` holds a feature.
  void cover_occupied_band(std::int64_t k, std::int64_t first_row, std::int64_t last_row, std::int64_t above,
                           std::int64_t below, Rows& rows, const RunContext& context) {
    Byte* const count = rows.count.data();
    const auto start_from = [&](bool border) {
      std::ranges::fill(rows.count, border && features_.outside ? Byte{0} : far_);
    };
    const auto count_row = [&](std::int64_t j, const Byte* before, Byte* counts) {
      context.check_cancelled();
      find_features(j, k, rows.keep.data());
      count_on(before, rows.keep.data(), far_, row_bytes_, counts);
    };
    start_from(above == 0);
    for (std::int64_t j = above; j < first_row; ++j) count_row(j, count, count);
    const Byte* before = count;
    for (std::int64_t j = first_row; j < last_row; ++j) {
      count_row(j, before, row(j, k));
      before = row(j, k);
    }
    start_from(below == dims_[1]);
    for (std::int64_t j = below - 1; j >= last_row; --j) count_row(j, count, count);
    for (std::int64_t j = last_row - 1; j >= first_row; --j) {
      context.check_cancelled();
      Byte* counts = row(j, k);
      count_back(count, row_bytes_, counts);
      std::memcpy(count, counts, static_cast<std::size_t>(row_bytes_));
      // Past the row's end there is nothing, or a feature at once.
      std::memset(counts + dims_[0], far_, static_cast<std::size_t>(row_bytes_ - dims_[0]));
      cover_within_row(counts, rows);
    }
  }

  /// Replaces distances along y by what each voxel covers along z, plus one; 0 where it covers nothing.
  void cover_within_row(Byte* counts, Rows& rows) {
    const std::int64_t tiles = row_bytes_ / kTile;
    Square* squares = rows.squares.data() + rows.margin;
    for (std::int64_t t = 0; t < tiles; ++t)
      rows.occupied[static_cast<std::size_t>(t)] = is_occupied(counts + t * kTile, far_);
    square(counts, row_bytes_, squares);
    const auto none = static_cast<Square>(far_ * far_);
    squares[-1] = features_.outside ? 0 : none;
    if (features_.outside) squares[dims_[0]] = 0;
    const auto occupied = [&](std::int64_t t) { return rows.occupied[static_cast<std::size_t>(t)] != 0; };
    std::int64_t last = features_.outside ? -1 : -row_bytes_;  // position of the last tile's end with anything near
    std::int64_t next = -1;                                    // first voxel of the next such tile
    for (std::int64_t t = 0; t < tiles; ++t) {
      const std::int64_t x = t * kTile;
      std::array<Square, kTile> nearest;
      std::int64_t from = 1;  // the distance along x from which on there can be anything
      if (!occupied(t)) {
        if (next <= x) {
          std::int64_t ahead = t + 1;
          while (ahead < tiles && !occupied(ahead)) ++ahead;
          next = ahead < tiles ? ahead * kTile : features_.outside ? dims_[0] : 2 * row_bytes_;
        }
        from = std::max<std::int64_t>(1, std::min(x - last, next - (x + kTile - 1)));
      }
      if (!occupied(t) && from > radius_) {
        std::memset(counts + x, 0, kTile);
      } else {
        nearest_in_row(squares + x, from, radius_, nearest.data());
        constexpr std::size_t kFewLimits = 16;
        if (limits_.size() <= kFewLimits) {
          count_limits(nearest.data(), limits_.data(), radius_ + 1, counts + x);
        } else {
          look_up(nearest.data(), covers_.data(), counts + x);
        }
      }
      if (occupied(t)) last = x + kTile - 1;
    }
    if (features_.outside) std::fill(squares + dims_[0], squares + row_bytes_ + rows.margin, none);
  }

  /// Carries what slices cover upward through the new ones, then down again through the block, whose result it writes.
  void sweep(std::int64_t first_row, std::int64_t last_row, std::int64_t known, std::int64_t begin, std::int64_t end,
             std::int64_t wanted, GridValues<Byte>& carried, BitVolume& result) {
    const std::int64_t bytes = (last_row - first_row) * row_bytes_;
    Byte* running = carried.data() + first_row * row_bytes_;
    if (begin == 0) std::fill_n(running, bytes, outside_cover());
    for (std::int64_t k = known; k < wanted; ++k) {
      cover(running, bytes, row(first_row, k));
      std::memcpy(running, row(first_row, k), static_cast<std::size_t>(bytes));
    }
    std::vector<Byte> down(static_cast<std::size_t>(bytes), wanted == dims_[2] ? outside_cover() : Byte{0});
    for (std::int64_t k = wanted - 1; k >= begin; --k) {
      cover_down(row(first_row, k), bytes, down.data());
      if (k >= end) continue;
      for (std::int64_t j = first_row; j < last_row; ++j)
        write(down.data() + (j - first_row) * row_bytes_, result.row(j, k));
    }
  }

  /// A row of the result, from what covers its voxels.
  void write(const Byte* covered, BitWord* words) const {
    std::array<Byte, kWordBits> flags;
    for (std::int64_t w = 0; w < row_words_; ++w) {
      make_flags(covered + w * kWordBits, kWordBits, flags.data());
      const BitWord word = gather_bits(flags.data());
      words[w] = (inverted_ ? ~word : word) & (w + 1 == row_words_ ? last_word_mask(dims_[0]) : kAllBits);
    }
  }

  const BitVolume& volume_;
  Features features_;
  bool inverted_;
  Index3 dims_;
  std::int64_t row_words_;
  std::int64_t row_bytes_;  ///< of a row of bytes: whole words
  std::int64_t reach_;
  std::int64_t radius_;
  Byte far_;  ///< the count that stands for farther than the radius
  std::int64_t block_;
  std::int64_t ring_;         ///< slices that are held at once
  std::int64_t band_;         ///< rows of a slice that are treated together
  GridValues<Byte> covered_;  ///< of each voxel: how far along z it covers, plus one
  /// What a squared distance in the slice may be, to cover this voxel and 0, 1, 2, ... before and behind it.
  std::vector<Square> limits_;
  std::vector<Byte> covers_;  ///< by squared distance in the slice: how many of the limits are no less
  WorkspacePool<Rows> pool_;
};

}  // namespace

BitVolume within_reach(const BitVolume& volume, const Features& features, std::int64_t squared_reach, bool inverted,
                       RunContext& context) {
  if (volume.dims().prod() == 0) return BitVolume(volume.dims());
  return BallSweep(volume, features, squared_reach, inverted).run(context);
}

std::uint64_t within_reach_memory(const Index3& dims, std::int64_t squared_reach) {
  return BallSweep::memory(dims, squared_reach);
}

}  // namespace voxcarve
