// All crossings of a soup with lines of one direction, without luck: exact coverage, symbolic perturbation.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/mesh/triangle_soup.h"

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
/// Queries are const, allocate nothing beyond `out`, and may run on several threads at once. The soup is not kept.
class LineStabber {
 public:
  /// `cell_size`, in model units, is the size of the cells that triangles are binned in, rounded down to a power of two
  /// of lattice steps: about the distance of neighbouring lines when there are many, or 0 to derive it from the number
  /// of triangles. It changes only speed and memory. The soup must be finite. Throws ResourceError when the bins would
  /// hold 2^32 entries or more.
  explicit LineStabber(const TriangleSoup& soup, const StabFrame& frame = {}, double cell_size = 0);

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

  /// Bytes that a stabber of this soup holds at most while it is built, from the triangles' boxes.
  static std::uint64_t memory_estimate(const TriangleSoup& soup, const StabFrame& frame, double cell_size);

 private:
  /// A triangle with positive projected area, corners in counterclockwise order.
  struct Record {
    std::int32_t x[3];
    std::int32_t y[3];
    std::uint32_t triangle;
    std::int8_t sign;
    std::uint8_t bias[3];  ///< 1 when the perturbed line lies inside of side c although its edge function is zero
  };
  /// The lattice and the bins, known before any triangle is binned.
  struct Layout {
    double origin[2] = {0, 0};
    double step = 1;
    double limit[2] = {-1, -1};  ///< largest lattice coordinate; -1 without triangles
    int shift = 0;               ///< a cell has 2^shift lattice steps a side
    std::int64_t columns = 0;
    std::int64_t rows = 0;
  };

  static Layout make_layout(const TriangleSoup& soup, const StabFrame& frame, double cell_size);
  static std::int32_t quantise(double coordinate, double origin, double step);
  static bool misses_cell(const Record& record, std::int64_t x_low, std::int64_t y_low, std::int64_t size);
  void make_records(const TriangleSoup& soup);
  void fill_cells();
  /// Calls visit(cell) for every cell that lattice points covered by the triangle may lie in.
  template <class Visit>
  void for_each_cell(const Record& record, const Visit& visit) const;

  StabFrame frame_;
  Layout layout_;
  std::vector<Record> records_;
  std::vector<std::array<double, 3>> depths_;  ///< of the records' corners
  std::vector<std::uint32_t> cell_begin_;      ///< cells + 1 offsets into cell_items_
  std::vector<std::uint32_t> cell_items_;      ///< indices of records
};

}  // namespace voxcarve
