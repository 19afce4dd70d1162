// Marching cubes [LC87, NT03 5.1] in the passes of flying edges [SMG15]: classify, count by rows, and make vertices and
// triangles where the counts put them. Differs in rows of bits instead of trimmed rows of edge cases, so that a word
// operation passes over 64 cells that the surface misses, and in the table, which leaves the surface manifold.
#include "common/volume/isosurface.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <utility>

#include "common/run/errors.h"
#include "common/volume/isosurface_table.h"

namespace voxcarve {

namespace {

/// Voxels that are left between a crossing and a sample: 2^-10, or more where coordinates are so large that rounding a
/// crossing could put it on the sample. Rounding moves each of the two by less than a last digit, epsilon times the
/// largest coordinate; a quarter of a voxel is enough as long as a voxel has eight of these.
double clearance_of(const GridFrame& frame) {
  constexpr double kClearance = 1.0 / 1024;
  const Point lower = frame.origin - Point::Constant(frame.voxel_size);  // samples beyond the grid
  const Point upper = frame.origin + frame.voxel_size * (frame.dims.cast<double>() + Point::Ones());
  const double largest = lower.cwiseAbs().cwiseMax(upper.cwiseAbs()).maxCoeff();
  const double last_digit = std::numeric_limits<double>::epsilon() * largest / frame.voxel_size;
  return std::clamp(2 * last_digit, kClearance, 0.25);
}

constexpr std::int64_t kWordBits = 64;
constexpr std::int64_t kPrefetchRows = 2;  ///< how far the voxels are fetched ahead of use

struct BinarySamples {
  using Value = std::uint8_t;
  static constexpr bool kReadsValues = false;
  const BinaryVolume& grid;

  static bool inside(Value value) { return value != 0; }
  static double share(const Value*, const Value*) { return 0.5; }
};

struct FieldSamples {
  using Value = float;
  static constexpr bool kReadsValues = true;
  const Grid<float>& grid;
  float iso_value;
  bool zero_outside;  ///< the field is 0 beyond the grid; otherwise it mirrors, so that the surface closes midway
  double clearance = clearance_of(grid.frame);

  bool inside(Value value) const { return value >= iso_value; }
  /// Where the surface crosses from sample a to sample b, as a share of the way; null is a sample beyond the grid.
  double share(const Value* a, const Value* b) const {
    if (!zero_outside && (a == nullptr || b == nullptr)) return 0.5;
    const double value_a = a != nullptr ? *a : 0.0;
    const double value_b = b != nullptr ? *b : 0.0;
    const double crossing = (static_cast<double>(iso_value) - value_a) / (value_b - value_a);
    return std::clamp(crossing, clearance, 1 - clearance);
  }
};

// The edges of a cell that belong to its own row; every other edge belongs to a row or a cell further on.
constexpr unsigned kOwnX = 0, kOwnY = 5, kOwnZ = 9;

constexpr bool is_crossed(unsigned crossed, unsigned edge) {
  return (crossed >> edge & 1U) != 0;
}

/// Counts of vertices on x-, y- and z-edges and of triangles, 16 bits each: a word of cells fills at most 640.
using PackedCounts = std::uint64_t;

const std::array<PackedCounts, 256>& packed_counts() {
  static const std::array<PackedCounts, 256> kCounts = [] {
    std::array<PackedCounts, 256> counts{};
    for (unsigned mask = 0; mask < 256; ++mask) {
      const CubeCase& cube = cube_cases()[mask];
      const auto owned = [&cube](unsigned edge) { return PackedCounts{is_crossed(cube.crossed_edges, edge)}; };
      counts[mask] = owned(kOwnX) | owned(kOwnY) << 16 | owned(kOwnZ) << 32 | PackedCounts{cube.triangle_count} << 48;
    }
    return counts;
  }();
  return kCounts;
}

/// First how many, then the index of the first: vertices of a row on x-, y- and z-edges, and its triangles.
struct RowEntry {
  std::uint64_t triangles = 0;
  std::uint32_t x = 0, y = 0, z = 0;
};

/// The vertices to come while the cells of a row are passed: on the x-edges of the four rows of samples around it, and
/// on the y- and z-edges of two. Those y- and z-edges lie at the upper x of one cell and at the lower x of the next;
/// both are cut where such an edge is crossed, so skipping the other cells loses none.
struct RowCursor {
  std::array<std::uint32_t, 4> x;
  std::array<std::uint32_t, 2> y;
  std::array<std::uint32_t, 2> z;

  /// The vertices on the crossed edges of the next cut cell, by cube edge.
  std::array<std::uint32_t, 12> pass(unsigned crossed) {
    const auto next = [crossed](std::uint32_t& vertex, unsigned edge) {
      const std::uint32_t current = vertex;
      vertex += crossed >> edge & 1U;
      return current;
    };
    std::array<std::uint32_t, 12> vertices;
    for (unsigned e = 0; e < 4; ++e) vertices[e] = next(x[e], e);
    for (unsigned e = 0; e < 2; ++e) {
      vertices[4 + 2 * e] = next(y[e], 4 + 2 * e);
      vertices[5 + 2 * e] = y[e];
      vertices[8 + 2 * e] = next(z[e], 8 + 2 * e);
      vertices[9 + 2 * e] = z[e];
    }
    return vertices;
  }
};

/// Rows run along x, one for every (j, k) from the layer of exterior samples below the grid on: row r is that of voxels
/// (., r % stride - 1, r / stride - 1). The exterior layer above the grid is the one below its next slice. A row of
/// samples holds the edges that start at them; a row of cells has its lowest samples in the row of the same number.
template <class Samples>
class IsosurfaceBuilder {
 public:
  IsosurfaceBuilder(const Samples& samples, RunContext& context)
      : samples_(samples),
        frame_(samples.grid.frame),
        context_(context),
        stride_(frame_.dims[1] + 1),
        rows_(stride_ * (frame_.dims[2] + 1)),
        stored_rows_(rows_ + stride_ + 1),
        words_(frame_.dims[0] / kWordBits + 1) {}

  TriangleSoup run() {
    Stage stage(context_, "isosurface", stored_rows_ + 2 * rows_);
    const auto stored_rows = static_cast<std::size_t>(stored_rows_);
    const auto stored_words = stored_rows * static_cast<std::size_t>(words_);
    const std::uint64_t table_bytes = stored_rows * sizeof(RowEntry) + stored_words * sizeof(std::uint64_t);
    context_.require_memory(table_bytes, "marching cubes");
    inside_.resize(stored_words);
    entries_.resize(stored_rows);

    for_rows(stored_rows_, stage, [this](std::int64_t row) { classify(row); });
    for_rows(rows_, stage, [this](std::int64_t row) { count(row); });
    make_surface(table_bytes);
    for_rows(rows_, stage, [this](std::int64_t row) {
      prefetch(std::min(row + kPrefetchRows, rows_ - 1));
      build(row);
    });
    return std::move(surface_);
  }

 private:
  using Value = typename Samples::Value;

  /// Writes the positions of the vertices that belong to a row.
  class VertexMaker {
   public:
    VertexMaker(IsosurfaceBuilder& builder, std::int64_t row)
        : samples_(builder.samples_),
          frame_(builder.frame_),
          positions_(builder.surface_.positions.data()),
          here_(builder.voxels(row)),
          next_y_(builder.voxels(row + 1)),
          next_z_(builder.voxels(row + builder.stride_)),
          y_(static_cast<double>(row % builder.stride_ - 1) + 0.5),
          z_(static_cast<double>(row / builder.stride_ - 1) + 0.5) {}

    void operator()(std::int64_t i, unsigned crossed, const std::array<std::uint32_t, 12>& vertices) const {
      const double x = static_cast<double>(i) + 0.5;
      const Value* here = at(here_, i);
      if (is_crossed(crossed, kOwnX)) {
        const Value* before = i > 0 ? here_ + i - 1 : nullptr;
        const double share = samples_.share(before, i < frame_.dims[0] ? here : nullptr);
        positions_[vertices[kOwnX]] = position(x - 1 + share, y_, z_);
      }
      if (is_crossed(crossed, kOwnY))
        positions_[vertices[kOwnY]] = position(x, y_ + samples_.share(here, at(next_y_, i)), z_);
      if (is_crossed(crossed, kOwnZ))
        positions_[vertices[kOwnZ]] = position(x, y_, z_ + samples_.share(here, at(next_z_, i)));
    }

   private:
    static const Value* at(const Value* row, std::int64_t i) { return row != nullptr ? row + i : nullptr; }
    Point position(double x, double y, double z) const { return frame_.origin + frame_.voxel_size * Point(x, y, z); }

    const Samples samples_;
    const GridFrame frame_;
    Point* positions_;
    const Value* here_;
    const Value* next_y_;
    const Value* next_z_;
    double y_, z_;
  };

  template <class Body>
  void for_rows(std::int64_t rows, Stage& stage, const Body& body) const {
    constexpr std::int64_t kChunk = std::int64_t{1} << 17;  // samples, some tenths of a millisecond
    parallel_for(context_, 0, rows, kChunk / (words_ * kWordBits), [&](std::int64_t first, std::int64_t last) {
      for (std::int64_t row = first; row < last; ++row) body(row);
      stage.advance(last - first);
    });
  }

  const std::uint64_t* inside_row(std::int64_t row) const { return inside_.data() + row * words_; }

  /// The voxels of a row, or null in the exterior layers.
  const Value* voxels(std::int64_t row) const {
    const std::int64_t j = row % stride_ - 1;
    const std::int64_t k = row / stride_ - 1;
    const bool in_grid = j >= 0 && k >= 0 && k < frame_.dims[2];
    return in_grid ? samples_.grid.values.data() + samples_.grid.index(0, j, k) : nullptr;
  }

  /// Bit i of the result: value i is interior.
  std::uint64_t inside_word(const Value* values) const {
    std::array<std::uint8_t, kWordBits> inside;
    for (std::size_t i = 0; i < kWordBits; ++i) inside[i] = samples_.inside(values[i]);
    // The product has the byte of voxel i at bit 56 + i, and nothing that carries into it.
    constexpr std::uint64_t kGather =
        std::endian::native == std::endian::little ? 0x0102040810204080U : 0x8040201008040201U;
    std::uint64_t word = 0;
    for (std::size_t i = 0; i < kWordBits; i += 8) {
      std::uint64_t eight = 0;
      std::memcpy(&eight, inside.data() + i, sizeof eight);
      word |= (eight * kGather >> 56) << i;
    }
    return word;
  }

  void classify(std::int64_t row) {
    std::uint64_t* words = inside_.data() + row * words_;
    const Value* values = voxels(row);
    if (values == nullptr) {
      std::fill(words, words + words_, 0);
      return;
    }
    const std::int64_t full_words = words_ - 1;
    for (std::int64_t w = 0; w < full_words; ++w) words[w] = inside_word(values + w * kWordBits);
    const std::int64_t rest = frame_.dims[0] - full_words * kWordBits;
    std::array<Value, kWordBits> last{};
    std::copy_n(values + full_words * kWordBits, rest, last.begin());
    words[full_words] = inside_word(last.data()) & ((std::uint64_t{1} << rest) - 1);
  }

  /// Calls visit(i, mask) for the cells of a row that the surface passes through, in order, and after_word() after
  /// those of a word. Cell i lies between voxels i - 1 and i.
  template <class Visit, class AfterWord>
  void for_each_cut_cell(std::int64_t row, const Visit& visit, const AfterWord& after_word) const {
    const std::uint64_t* row0 = inside_row(row);
    const std::uint64_t* row1 = inside_row(row + 1);
    const std::uint64_t* row2 = inside_row(row + stride_);
    const std::uint64_t* row3 = inside_row(row + stride_ + 1);
    std::uint64_t before0 = 0, before1 = 0, before2 = 0, before3 = 0;
    for (std::int64_t w = 0; w < words_; ++w) {
      const std::uint64_t right0 = row0[w], right1 = row1[w], right2 = row2[w], right3 = row3[w];
      const std::uint64_t left0 = right0 << 1 | before0, left1 = right1 << 1 | before1;
      const std::uint64_t left2 = right2 << 1 | before2, left3 = right3 << 1 | before3;
      before0 = right0 >> 63, before1 = right1 >> 63, before2 = right2 >> 63, before3 = right3 >> 63;
      const std::uint64_t any = (left0 | right0) | (left1 | right1) | (left2 | right2) | (left3 | right3);
      const std::uint64_t all = (left0 & right0) & (left1 & right1) & (left2 & right2) & (left3 & right3);
      std::uint64_t cut = any & ~all;
      if (cut == 0) continue;
      for (; cut != 0; cut &= cut - 1) {
        const int bit = std::countr_zero(cut);
        const auto column = [bit](std::uint64_t left, std::uint64_t right) {
          return static_cast<unsigned>((left >> bit & 1U) | (right >> bit & 1U) << 1);
        };
        visit(w * kWordBits + bit, column(left0, right0) | column(left1, right1) << 2 | column(left2, right2) << 4 |
                                       column(left3, right3) << 6);
      }
      after_word();
    }
  }

  void count(std::int64_t row) {
    const auto& counts = packed_counts();
    RowEntry entry;
    PackedCounts sum = 0;
    for_each_cut_cell(
        row, [&](std::int64_t, unsigned mask) { sum += counts[mask]; },
        [&] {
          entry.x += static_cast<std::uint16_t>(sum);
          entry.y += static_cast<std::uint16_t>(sum >> 16);
          entry.z += static_cast<std::uint16_t>(sum >> 32);
          entry.triangles += sum >> 48;
          sum = 0;
        });
    entries_[static_cast<std::size_t>(row)] = entry;
  }

  /// Turns the counts into the indices that the rows begin at and makes room for the surface.
  void make_surface(std::uint64_t table_bytes) {
    std::fill(entries_.begin() + rows_, entries_.end(), RowEntry{});
    std::uint64_t vertices = 0;
    std::uint64_t triangles = 0;
    for (RowEntry& entry : entries_) {
      const auto begin = [&vertices](std::uint32_t& number) {
        const std::uint64_t first = vertices;
        vertices += number;
        number = static_cast<std::uint32_t>(first);
      };
      begin(entry.x);
      begin(entry.y);
      begin(entry.z);
      triangles += std::exchange(entry.triangles, triangles);
    }
    context_.require_memory(triangles * sizeof(Triangle) + vertices * sizeof(Point) + table_bytes, "marching cubes");
    if (vertices > std::numeric_limits<std::uint32_t>::max())
      throw ResourceError("the isosurface has more vertices than 32-bit indices reach; lower the resolution");
    surface_.positions.resize(vertices);
    surface_.triangles.resize(triangles);
  }

  // Always inlined: g++ takes a function that only prefetches for one without effect and drops its calls.
  [[gnu::always_inline]] static void fetch(const Value* voxels, std::uint64_t wanted) {
    constexpr std::int64_t kLine = 64 / sizeof(Value);
    constexpr std::uint64_t kLineBits = ~std::uint64_t{0} >> (kWordBits - kLine);
    for (std::int64_t i = 0; i < kWordBits; i += kLine) {
      if ((wanted & kLineBits << i) != 0) __builtin_prefetch(voxels + i);
    }
  }

  /// Fetches the voxels on both sides of the crossings of a row: they wait in memory, a miss for almost every vertex.
  [[gnu::always_inline]] void prefetch(std::int64_t row) const {
    if (!Samples::kReadsValues || is_empty(row)) return;
    const Value* here = voxels(row);
    const Value* next_y = voxels(row + 1);
    const Value* next_z = voxels(row + stride_);
    for (std::int64_t w = 0; w < words_; ++w) {
      const std::uint64_t inside = inside_row(row)[w];
      const std::uint64_t crossed_y = inside ^ inside_row(row + 1)[w];
      const std::uint64_t crossed_z = inside ^ inside_row(row + stride_)[w];
      const std::int64_t i = w * kWordBits;
      if (here != nullptr) fetch(here + i, crossed_y | crossed_z);
      if (next_y != nullptr) fetch(next_y + i, crossed_y);
      if (next_z != nullptr) fetch(next_z + i, crossed_z);
    }
  }

  void build(std::int64_t row) {
    if (is_empty(row)) return;
    const RowEntry& own = entry(row);
    const RowEntry& next_y = entry(row + 1);
    const RowEntry& next_z = entry(row + stride_);
    RowCursor cursor{{own.x, next_y.x, next_z.x, entry(row + stride_ + 1).x}, {own.y, next_z.y}, {own.z, next_y.z}};
    Triangle* triangle = surface_.triangles.data() + own.triangles;
    const VertexMaker make_vertices(*this, row);
    const auto& cases = cube_cases();
    for_each_cut_cell(
        row,
        [&](std::int64_t i, unsigned mask) {
          const CubeCase& cube = cases[mask];
          const std::array<std::uint32_t, 12> vertices = cursor.pass(cube.crossed_edges);
          for (std::size_t t = 0; t < cube.triangle_count; ++t) {
            const auto& edges = cube.triangles[t];
            *triangle++ = {vertices[edges[0]], vertices[edges[1]], vertices[edges[2]]};
          }
          make_vertices(i, cube.crossed_edges, vertices);
        },
        [] {});
  }

  bool is_empty(std::int64_t row) const { return entry(row).triangles == entry(row + 1).triangles; }
  const RowEntry& entry(std::int64_t row) const { return entries_[static_cast<std::size_t>(row)]; }

  const Samples& samples_;
  const GridFrame& frame_;
  RunContext& context_;
  std::int64_t stride_;
  std::int64_t rows_;         ///< of cells
  std::int64_t stored_rows_;  ///< of samples: also the neighbours of the last rows of cells
  std::int64_t words_;        ///< a row: at least one bit more than voxels, as there is one cell more
  GridValues<std::uint64_t> inside_;
  GridValues<RowEntry> entries_;
  TriangleSoup surface_;
};

}  // namespace

TriangleSoup isosurface(const DensityVolume& volume, float iso_value, RunContext& context) {
  if (!(iso_value > 0)) throw ParameterError("iso_value must be more than 0, the density outside the grid");
  const FieldSamples samples{volume, iso_value, true};
  return IsosurfaceBuilder(samples, context).run();
}

TriangleSoup isosurface(const BinaryVolume& volume, RunContext& context) {
  const BinarySamples samples{volume};
  return IsosurfaceBuilder(samples, context).run();
}

TriangleSoup scalar_isosurface(const Grid<float>& field, float iso_value, RunContext& context) {
  const FieldSamples samples{field, iso_value, false};
  return IsosurfaceBuilder(samples, context).run();
}

}  // namespace voxcarve
