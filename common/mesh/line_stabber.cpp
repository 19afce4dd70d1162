// Edge functions on an integer lattice with a tie rule, after [Pin88] and the simulation of simplicity of [EM90].
#include "common/mesh/line_stabber.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cmath>
#include <string>

#include "common/run/errors.h"
#include "common/run/text.h"

namespace voxcarve {

namespace {

// Lattice coordinates stay below 2^28 + 2, differences to cell corners below 2^29, so each product of the edge
// functions below stays under 2^58 and their sums fit 64 bits with room to spare.
constexpr int kLatticeBits = 28;
constexpr std::uint64_t kMaxCells = std::uint64_t{1} << 26;
constexpr std::uint64_t kMaxItems = 0xffffffffULL;
constexpr int kSizeBits = 3;        ///< cells of the next size are 2^3 as large
constexpr int kFewestSpanBits = 3;  ///< a triangle may always span 2^3 cells and one more, 81 in all

/// Cells that may be looked at to bin so many triangles: 2^18 take about a millisecond.
std::uint64_t cell_budget(std::uint64_t triangles) {
  return (std::uint64_t{1} << 18) + 128 * triangles;
}

/// Twice the signed area of (a, b, p): positive when p lies left of a -> b.
constexpr std::int64_t edge_function(std::int64_t ax, std::int64_t ay, std::int64_t bx, std::int64_t by,
                                     std::int64_t px, std::int64_t py) {
  return (bx - ax) * (py - ay) - (by - ay) * (px - ax);
}

/// Whether p + (eps, eps^2) lies left of the line a -> b when p lies on it: the sign of the first derivative of the
/// edge function that is not zero.
constexpr std::uint8_t tie_bias(std::int64_t ax, std::int64_t ay, std::int64_t bx, std::int64_t by) {
  return by != ay ? (by < ay ? 1 : 0) : (bx > ax ? 1 : 0);
}

struct Projected {
  double u, v, w;
};

Projected project(const StabFrame& frame, const Point& point) {
  return {frame.u.dot(point), frame.v.dot(point), frame.w.dot(point)};
}

/// Calls body(i) for i from 0 to count - 1 and looks for cancellation on the way.
template <class Body>
void for_each_index(std::size_t count, const RunContext* run, const Body& body) {
  constexpr std::size_t kCheckEvery = 1024;
  for (std::size_t i = 0; i < count; ++i) {
    if (run != nullptr && i % kCheckEvery == 0) run->check_cancelled();
    body(i);
  }
}

}  // namespace

StabFrame StabFrame::along_axis(int axis) {
  return {Point::Unit((axis + 1) % 3), Point::Unit((axis + 2) % 3), Point::Unit(axis)};
}

StabFrame StabFrame::along(const Point& direction) {
  StabFrame frame;
  frame.w = direction.stableNormalized();
  Eigen::Index smallest = 0;
  frame.w.cwiseAbs().minCoeff(&smallest);
  frame.u = Point::Unit(smallest).cross(frame.w).normalized();
  frame.v = frame.w.cross(frame.u);
  return frame;
}

void sort_crossings(std::vector<Crossing>& crossings) {
  std::sort(crossings.begin(), crossings.end(), [](const Crossing& a, const Crossing& b) {
    return a.depth != b.depth ? a.depth < b.depth : a.triangle < b.triangle;
  });
}

std::int32_t LineStabber::quantise(double coordinate, double origin, double step) {
  return static_cast<std::int32_t>(std::floor((coordinate - origin) / step + 0.5));
}

LineStabber::Extent::Extent(const std::int32_t (&x)[3], const std::int32_t (&y)[3])
    : x_low(std::min({x[0], x[1], x[2]})),
      x_high(std::max({x[0], x[1], x[2]})),
      y_low(std::min({y[0], y[1], y[2]})),
      y_high(std::max({y[0], y[1], y[2]})) {}

std::uint64_t LineStabber::Extent::cells(int shift) const {
  const std::int64_t columns = (x_high >> shift) - (x_low >> shift) + 1;
  const std::int64_t rows = (y_high >> shift) - (y_low >> shift) + 1;
  return static_cast<std::uint64_t>(columns * rows);
}

std::size_t LineStabber::Layout::size_of(const Extent& extent) const {
  std::size_t size = 0;
  for (std::int32_t cells = extent.span() >> shift; cells >> span_bits != 0; cells >>= kSizeBits) ++size;
  return size;
}

LineStabber::Layout LineStabber::make_layout(const TriangleSoup& soup, const StabFrame& frame, double cell_size,
                                             const RunContext* run) {
  Layout layout;
  if (soup.empty()) return layout;
  double low[2] = {HUGE_VAL, HUGE_VAL};
  double high[2] = {-HUGE_VAL, -HUGE_VAL};
  for_each_index(soup.triangles.size(), run, [&](std::size_t t) {
    for (const std::uint32_t vertex : soup.triangles[t]) {
      const Projected p = project(frame, soup.positions[vertex]);
      low[0] = std::min(low[0], p.u);
      low[1] = std::min(low[1], p.v);
      high[0] = std::max(high[0], p.u);
      high[1] = std::max(high[1], p.v);
    }
  });
  const double extent = std::max(high[0] - low[0], high[1] - low[1]);
  // extent < 2^(exponent + 1), so extent / step < 2^kLatticeBits. The exponent stays in the range of normal numbers.
  const int exponent = extent > 0 ? std::max(std::ilogb(extent), -960) : 0;
  layout.step = std::ldexp(1.0, exponent + 1 - kLatticeBits);
  for (int i = 0; i < 2; ++i) {
    layout.origin[i] = std::floor(low[i] / layout.step) * layout.step;
    layout.limit[i] = quantise(high[i], layout.origin[i], layout.step);
  }
  if (!(cell_size > 0)) cell_size = extent / std::sqrt(static_cast<double>(soup.triangles.size()));
  const double steps = std::clamp(cell_size / layout.step, 1.0, std::ldexp(1.0, kLatticeBits));
  layout.shift = std::ilogb(steps);
  return layout;
}

template <class ForEachExtent>
int LineStabber::find_span_bits(int shift, const ForEachExtent& for_each_extent) {
  // By the digits of a triangle's span in the smallest cells: the number of triangles and of cells in their boxes.
  std::array<std::uint64_t, kLatticeBits + 2> triangles{};
  std::array<std::uint64_t, kLatticeBits + 2> boxes{};
  std::uint64_t all = 0;
  for_each_extent([&](const Extent& extent) {
    const auto digits = static_cast<std::size_t>(std::bit_width(static_cast<std::uint32_t>(extent.span() >> shift)));
    ++all;
    ++triangles[digits];
    boxes[digits] += extent.cells(shift);
  });
  const auto budget = static_cast<double>(cell_budget(all));
  for (int bits = kLatticeBits;; --bits) {
    double total = 0;
    for (std::size_t digits = 0; digits < boxes.size(); ++digits) {
      total += static_cast<int>(digits) <= bits ? static_cast<double>(boxes[digits])
                                                : std::ldexp(static_cast<double>(triangles[digits]), 2 * bits);
    }
    if (total <= budget || bits == kFewestSpanBits) return bits;
  }
}

template <class ForEachExtent>
std::vector<LineStabber::Cells> LineStabber::make_cells(Layout& layout, const ForEachExtent& for_each_extent) {
  layout.span_bits = find_span_bits(layout.shift, for_each_extent);
  struct Size {
    std::uint64_t triangles = 0;
    std::int64_t x_low = 0, x_high = 0, y_low = 0, y_high = 0;
  };
  std::vector<Size> sizes;
  for_each_extent([&](const Extent& extent) {
    const std::size_t size = layout.size_of(extent);
    if (size >= sizes.size()) sizes.resize(size + 1);
    Size& s = sizes[size];
    const bool first = s.triangles++ == 0;
    s.x_low = first ? extent.x_low : std::min<std::int64_t>(s.x_low, extent.x_low);
    s.x_high = first ? extent.x_high : std::max<std::int64_t>(s.x_high, extent.x_high);
    s.y_low = first ? extent.y_low : std::min<std::int64_t>(s.y_low, extent.y_low);
    s.y_high = first ? extent.y_high : std::max<std::int64_t>(s.y_high, extent.y_high);
  });
  std::vector<Cells> all(sizes.size());
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    const Size& size = sizes[i];
    if (size.triangles == 0) continue;
    Cells& cells = all[i];
    const std::uint64_t most = std::min(kMaxCells, cell_budget(size.triangles));
    for (cells.shift = layout.shift + kSizeBits * static_cast<int>(i);; ++cells.shift) {
      cells.first_column = size.x_low >> cells.shift;
      cells.first_row = size.y_low >> cells.shift;
      cells.columns = (size.x_high >> cells.shift) - cells.first_column + 1;
      cells.rows = (size.y_high >> cells.shift) - cells.first_row + 1;
      if (cells.count() <= most) break;
    }
  }
  return all;
}

LineStabber::LineStabber(const TriangleSoup& soup, const StabFrame& frame, double cell_size, const RunContext* run)
    : frame_(frame), layout_(make_layout(soup, frame, cell_size, run)) {
  make_records(soup, run);
  fill_cells(run);
}

void LineStabber::make_records(const TriangleSoup& soup, const RunContext* run) {
  struct Vertex {
    std::int32_t x, y;
    double depth;
  };
  std::vector<Vertex> vertices(soup.positions.size(), Vertex{0, 0, 0});
  for_each_index(soup.triangles.size(), run, [&](std::size_t t) {  // unused vertices may lie off the lattice
    for (const std::uint32_t i : soup.triangles[t]) {
      const Projected p = project(frame_, soup.positions[i]);
      vertices[i] = {quantise(p.u, layout_.origin[0], layout_.step), quantise(p.v, layout_.origin[1], layout_.step),
                     p.w};
    }
  });
  records_.reserve(soup.triangles.size());
  depths_.reserve(soup.triangles.size());
  for_each_index(soup.triangles.size(), run, [&](std::size_t t) {
    const Vertex& a = vertices[soup.triangles[t][0]];
    Vertex b = vertices[soup.triangles[t][1]];
    Vertex c = vertices[soup.triangles[t][2]];
    const std::int64_t area = edge_function(a.x, a.y, b.x, b.y, c.x, c.y);
    if (area == 0) return;  // edge-on: the moved line cannot lie strictly inside
    if (area < 0) std::swap(b, c);
    const std::int8_t sign = area < 0 ? 1 : -1;  // the normal's component along w has the sign of the area
    records_.push_back({{a.x, b.x, c.x},
                        {a.y, b.y, c.y},
                        static_cast<std::uint32_t>(t),
                        sign,
                        {tie_bias(b.x, b.y, c.x, c.y), tie_bias(c.x, c.y, a.x, a.y), tie_bias(a.x, a.y, b.x, b.y)}});
    depths_.push_back({a.depth, b.depth, c.depth});
  });
}

/// True when some side has every lattice point of the cell on its outer side.
bool LineStabber::misses_cell(const Record& r, std::int64_t x_low, std::int64_t y_low, std::int64_t size) {
  for (int c = 0; c < 3; ++c) {
    const int from = c == 2 ? 0 : c + 1;
    const int to = c == 0 ? 2 : c - 1;
    const std::int64_t dx = std::int64_t{r.x[to]} - r.x[from];
    const std::int64_t dy = std::int64_t{r.y[to]} - r.y[from];
    const std::int64_t px = dy > 0 ? x_low : x_low + size - 1;  // the corner furthest inside
    const std::int64_t py = dx > 0 ? y_low + size - 1 : y_low;
    if (edge_function(r.x[from], r.y[from], r.x[to], r.y[to], px, py) + r.bias[c] <= 0) return true;
  }
  return false;
}

template <class Visit>
void LineStabber::for_each_cell(const Cells& cells, const Record& r, const Visit& visit) {
  const Extent extent(r.x, r.y);
  const std::int64_t size = std::int64_t{1} << cells.shift;
  const std::int64_t last_row = extent.y_high >> cells.shift;
  const std::int64_t last_column = extent.x_high >> cells.shift;
  for (std::int64_t row = extent.y_low >> cells.shift; row <= last_row; ++row) {
    for (std::int64_t column = extent.x_low >> cells.shift; column <= last_column; ++column) {
      if (!misses_cell(r, column * size, row * size, size)) {
        visit(static_cast<std::size_t>((row - cells.first_row) * cells.columns + column - cells.first_column));
      }
    }
  }
}

void LineStabber::fill_cells(const RunContext* run) {
  cells_ = make_cells(layout_, [&](const auto& visit) {
    for_each_index(records_.size(), run, [&](std::size_t i) { visit(Extent(records_[i].x, records_[i].y)); });
  });
  const auto cells_of = [&](const Record& record) -> Cells& {
    return cells_[layout_.size_of(Extent(record.x, record.y))];
  };
  for (Cells& cells : cells_) cells.begin.assign(cells.count() + 1, 0);
  for_each_index(records_.size(), run, [&](std::size_t i) {
    Cells& cells = cells_of(records_[i]);
    for_each_cell(cells, records_[i], [&](std::size_t cell) { ++cells.begin[cell]; });
  });
  // Offsets become the ends of the cells; filling from the last record down turns them into the beginnings.
  for (Cells& cells : cells_) {
    std::uint64_t sum = 0;
    for (std::uint32_t& entry : cells.begin) {
      sum += entry;
      entry = static_cast<std::uint32_t>(sum);
    }
    if (sum > kMaxItems)
      throw ResourceError("stabbing lines: more than " + format_bytes(4 * kMaxItems) + " of bins are needed");
    cells.items.resize(sum);
  }
  for_each_index(records_.size(), run, [&](std::size_t number) {
    const std::size_t i = records_.size() - 1 - number;
    Cells& cells = cells_of(records_[i]);
    for_each_cell(cells, records_[i],
                  [&](std::size_t cell) { cells.items[--cells.begin[cell]] = static_cast<std::uint32_t>(i); });
  });
}

void LineStabber::append_crossings(double along_u, double along_v, std::vector<Crossing>& out) const {
  const double x_real = std::floor((along_u - layout_.origin[0]) / layout_.step + 0.5);
  const double y_real = std::floor((along_v - layout_.origin[1]) / layout_.step + 0.5);
  if (!(x_real >= 0 && y_real >= 0 && x_real <= layout_.limit[0] && y_real <= layout_.limit[1])) return;
  const auto x = static_cast<std::int64_t>(x_real);
  const auto y = static_cast<std::int64_t>(y_real);
  for (const Cells& cells : cells_) {
    const std::int64_t column = (x >> cells.shift) - cells.first_column;
    const std::int64_t row = (y >> cells.shift) - cells.first_row;
    if (column < 0 || row < 0 || column >= cells.columns || row >= cells.rows) continue;
    const std::uint32_t* begin = cells.begin.data() + row * cells.columns + column;
    for (std::uint32_t item = begin[0]; item < begin[1]; ++item) append_crossing(cells.items[item], x, y, out);
  }
}

/// Appends the crossing of the moved line through a lattice point with a triangle, if there is one.
void LineStabber::append_crossing(std::uint32_t record, std::int64_t x, std::int64_t y,
                                  std::vector<Crossing>& out) const {
  const Record& r = records_[record];
  const std::int64_t e0 = edge_function(r.x[1], r.y[1], r.x[2], r.y[2], x, y);
  if (e0 + r.bias[0] <= 0) return;
  const std::int64_t e1 = edge_function(r.x[2], r.y[2], r.x[0], r.y[0], x, y);
  if (e1 + r.bias[1] <= 0) return;
  const std::int64_t e2 = edge_function(r.x[0], r.y[0], r.x[1], r.y[1], x, y);
  if (e2 + r.bias[2] <= 0) return;
  const auto& z = depths_[record];
  // e0 + e1 + e2 is twice the area, exactly. Equal depths give exactly that depth; rounding never leaves their range.
  const auto area = static_cast<double>(e0 + e1 + e2);
  const double depth =
      z[0] + (static_cast<double>(e1) * (z[1] - z[0]) + static_cast<double>(e2) * (z[2] - z[0])) / area;
  out.push_back({std::clamp(depth, std::min({z[0], z[1], z[2]}), std::max({z[0], z[1], z[2]})), r.triangle, r.sign});
}

std::uint64_t LineStabber::memory_estimate(const TriangleSoup& soup, const StabFrame& frame, double cell_size,
                                           const RunContext* run) {
  Layout layout = make_layout(soup, frame, cell_size, run);
  const auto for_each_extent = [&](const auto& visit) {
    for_each_index(soup.triangles.size(), run, [&](std::size_t t) {
      std::int32_t x[3];
      std::int32_t y[3];
      for (std::size_t c = 0; c < 3; ++c) {
        const Projected p = project(frame, soup.positions[soup.triangles[t][c]]);
        x[c] = quantise(p.u, layout.origin[0], layout.step);
        y[c] = quantise(p.v, layout.origin[1], layout.step);
      }
      visit(Extent(x, y));
    });
  };
  const std::vector<Cells> all = make_cells(layout, for_each_extent);
  std::uint64_t entries = 0;
  for (const Cells& cells : all) entries += cells.count() + 1;
  for_each_extent([&](const Extent& extent) { entries += extent.cells(all[layout.size_of(extent)].shift); });
  return entries * sizeof(std::uint32_t) + soup.triangles.size() * (sizeof(Record) + sizeof(std::array<double, 3>)) +
         soup.positions.size() * 16;
}

}  // namespace voxcarve
