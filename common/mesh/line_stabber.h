// All crossings of a soup with lines of one direction, without luck: exact coverage, symbolic perturbation.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "common/mesh/triangle_soup.h"
#include "common/run/context.h"

namespace voxcarve {

/// A right-handed orthonormal frame; lines run along w and are named by their (u, v).
struct StabFrame {
  Point u = Point::UnitX();
  Point v = Point::UnitY();
  Point w = Point::UnitZ();

  /// Lines along coordinate axis 0, 1 or 2: u and v are the next two axes in cyclic order, so (u, v, depth) are exact
  /// coordinates of the model.
  static StabFrame along_axis(int axis);
  /// Lines along `direction`, which need not have unit length but must not be zero. u and v are any two that fit,
  /// always the same ones for the same direction.
  static StabFrame along(const Point& direction);

  Point at(double along_u, double along_v, double depth) const { return along_u * u + along_v * v + depth * w; }
};

/// A line passing through the surface.
struct Crossing {
  double depth = 0;            ///< coordinate along w of the point, in model units
  std::uint32_t triangle = 0;  ///< index in the soup
  std::int8_t sign = 0;        ///< +1 entering: the normal points against w; -1 leaving
};

/// Sorts by depth, at equal depths by triangle.
void sort_crossings(std::vector<Crossing>& crossings);

/// Crossings of one soup with any line of one direction.
///
/// Vertices are projected to (u, v) and rounded, once per vertex, to a lattice whose step is a power of two, at most
/// 2^-27 of the larger extent (equal positions round equally, so soups with repeated vertices stay watertight;
/// coordinates that are short binary fractions are not rounded at all). A line is rounded to the same lattice and then
/// moved by (eps, eps^2), eps an infinitesimal, so it never meets an edge or a vertex: a closed surface is crossed an
/// even number of times with signs that sum to zero, a line through a shared edge or vertex counts once, and triangles
/// seen edge-on never count. All of this is decided in exact integer arithmetic (simulation of simplicity, [EM90]).
///
/// Triangles are binned in cells, those that are too large in larger ones: binning takes time and memory in proportion
/// to the number of triangles, however fine the cells. A line looks into one cell of each size.
///
/// Queries are const, allocate nothing beyond `out`, and may run on several threads at once. The soup is not kept.
class LineStabber {
 public:
  /// `cell_size`, in model units, is the size of the smallest cells that triangles are binned in, rounded down to a
  /// power of two of lattice steps: about the distance of neighbouring lines when there are many, or 0 to derive it
  /// from the number of triangles. It changes only speed and memory. The soup must be finite. Throws ResourceError when
  /// the bins would hold 2^32 entries or more, and Cancelled when the run that it belongs to, if any, is.
  explicit LineStabber(const TriangleSoup& soup, const StabFrame& frame = {}, double cell_size = 0,
                       const RunContext* run = nullptr);

  /// Appends the crossings of the line through u = along_u, v = along_v (model units, dot products with the frame), in
  /// no particular order. A line beyond the soup's box has none.
  void append_crossings(double along_u, double along_v, std::vector<Crossing>& out) const;

  /// Replaces `out` by the crossings, sorted.
  void crossings(double along_u, double along_v, std::vector<Crossing>& out) const {
    out.clear();
    append_crossings(along_u, along_v, out);
    sort_crossings(out);
  }

  const StabFrame& frame() const { return frame_; }

  /// Bytes that a stabber of this soup holds at most while it is built, from the triangles' boxes. Throws Cancelled.
  static std::uint64_t memory_estimate(const TriangleSoup& soup, const StabFrame& frame, double cell_size,
                                       const RunContext* run = nullptr);

 private:
  /// A triangle with positive projected area, corners in counterclockwise order.
  struct Record {
    std::int32_t x[3];
    std::int32_t y[3];
    std::uint32_t triangle;
    std::int8_t sign;
    std::uint8_t bias[3];  ///< 1 when the perturbed line lies inside of side c although its edge function is zero
  };
  /// A triangle's box, lattice coordinates.
  struct Extent {
    std::int32_t x_low, x_high, y_low, y_high;

    Extent(const std::int32_t (&x)[3], const std::int32_t (&y)[3]);
    std::int32_t span() const { return std::max(x_high - x_low, y_high - y_low); }
    /// The number of cells of 2^shift steps that it meets.
    std::uint64_t cells(int shift) const;
  };
  /// The cells of one size, over the boxes of the triangles that are binned in them.
  struct Cells {
    int shift = 0;  ///< a cell has 2^shift lattice steps a side
    std::int64_t first_column = 0;
    std::int64_t first_row = 0;
    std::int64_t columns = 0;
    std::int64_t rows = 0;
    std::vector<std::uint32_t> begin;  ///< columns * rows + 1 offsets into items
    std::vector<std::uint32_t> items;  ///< indices of records

    std::uint64_t count() const { return static_cast<std::uint64_t>(columns * rows); }
  };
  /// The lattice and the sizes of cells, known before any triangle is binned.
  struct Layout {
    double origin[2] = {0, 0};
    double step = 1;
    double limit[2] = {-1, -1};  ///< largest lattice coordinate; -1 without triangles
    int shift = 0;               ///< of the smallest cells
    int span_bits = 0;           ///< a triangle goes to the smallest cells of which it spans less than 2^span_bits

    /// The number of the cells that a triangle goes to.
    std::size_t size_of(const Extent& extent) const;
  };

  static Layout make_layout(const TriangleSoup& soup, const StabFrame& frame, double cell_size, const RunContext* run);
  /// The most that lets all triangles be binned within a budget; for_each_extent(visit) calls visit with their boxes.
  template <class ForEachExtent>
  static int find_span_bits(int shift, const ForEachExtent& for_each_extent);
  /// Cells for these triangles, without their bins. Completes the layout.
  template <class ForEachExtent>
  static std::vector<Cells> make_cells(Layout& layout, const ForEachExtent& for_each_extent);
  static std::int32_t quantise(double coordinate, double origin, double step);
  static bool misses_cell(const Record& record, std::int64_t x_low, std::int64_t y_low, std::int64_t size);
  void make_records(const TriangleSoup& soup, const RunContext* run);
  void fill_cells(const RunContext* run);
  /// Calls visit(cell) for every cell that lattice points covered by the triangle may lie in.
  template <class Visit>
  static void for_each_cell(const Cells& cells, const Record& record, const Visit& visit);

  void append_crossing(std::uint32_t record, std::int64_t x, std::int64_t y, std::vector<Crossing>& out) const;

  StabFrame frame_;
  Layout layout_;
  std::vector<Record> records_;
  std::vector<std::array<double, 3>> depths_;  ///< of the records' corners
  std::vector<Cells> cells_;                   ///< by size, each eight times the one before or more
};

}  // namespace voxcarve
