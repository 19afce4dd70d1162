// Edge functions on an integer lattice with a tie rule, after [Pin88] and the simulation of simplicity of [EM90].
#include "common/mesh/line_stabber.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>

#include "common/run/errors.h"
#include "common/run/text.h"

namespace voxcarve {

namespace {

// Lattice coordinates stay below 2^28 + 2, differences to cell corners below 2^29, so each product of the edge
// functions below stays under 2^58 and their sums fit 64 bits with room to spare.
constexpr int kLatticeBits = 28;
constexpr std::int64_t kMaxCells = std::int64_t{1} << 26;
constexpr std::uint64_t kMaxItems = 0xffffffffULL;

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

LineStabber::Layout LineStabber::make_layout(const TriangleSoup& soup, const StabFrame& frame, double cell_size) {
  Layout layout;
  if (soup.empty()) return layout;
  double low[2] = {HUGE_VAL, HUGE_VAL};
  double high[2] = {-HUGE_VAL, -HUGE_VAL};
  for (const Triangle& triangle : soup.triangles) {
    for (const std::uint32_t vertex : triangle) {
      const Projected p = project(frame, soup.positions[vertex]);
      low[0] = std::min(low[0], p.u);
      low[1] = std::min(low[1], p.v);
      high[0] = std::max(high[0], p.u);
      high[1] = std::max(high[1], p.v);
    }
  }
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
  for (;; ++layout.shift) {
    layout.columns = (static_cast<std::int64_t>(layout.limit[0]) >> layout.shift) + 1;
    layout.rows = (static_cast<std::int64_t>(layout.limit[1]) >> layout.shift) + 1;
    if (layout.columns * layout.rows <= kMaxCells) break;
  }
  return layout;
}

LineStabber::LineStabber(const TriangleSoup& soup, const StabFrame& frame, double cell_size)
    : frame_(frame), layout_(make_layout(soup, frame, cell_size)) {
  make_records(soup);
  fill_cells();
}

void LineStabber::make_records(const TriangleSoup& soup) {
  struct Vertex {
    std::int32_t x, y;
    double depth;
  };
  std::vector<Vertex> vertices(soup.positions.size(), Vertex{0, 0, 0});
  for (const Triangle& triangle : soup.triangles) {  // unused vertices may lie off the lattice
    for (const std::uint32_t i : triangle) {
      const Projected p = project(frame_, soup.positions[i]);
      vertices[i] = {quantise(p.u, layout_.origin[0], layout_.step), quantise(p.v, layout_.origin[1], layout_.step),
                     p.w};
    }
  }
  records_.reserve(soup.triangles.size());
  depths_.reserve(soup.triangles.size());
  for (std::uint32_t t = 0; t < soup.triangles.size(); ++t) {
    const Vertex& a = vertices[soup.triangles[t][0]];
    Vertex b = vertices[soup.triangles[t][1]];
    Vertex c = vertices[soup.triangles[t][2]];
    const std::int64_t area = edge_function(a.x, a.y, b.x, b.y, c.x, c.y);
    if (area == 0) continue;  // edge-on: the moved line cannot lie strictly inside
    if (area < 0) std::swap(b, c);
    const std::int8_t sign = area < 0 ? 1 : -1;  // the normal's component along w has the sign of the area
    records_.push_back({{a.x, b.x, c.x},
                        {a.y, b.y, c.y},
                        t,
                        sign,
                        {tie_bias(b.x, b.y, c.x, c.y), tie_bias(c.x, c.y, a.x, a.y), tie_bias(a.x, a.y, b.x, b.y)}});
    depths_.push_back({a.depth, b.depth, c.depth});
  }
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
void LineStabber::for_each_cell(const Record& r, const Visit& visit) const {
  const auto [x_low, x_high] = std::minmax({r.x[0], r.x[1], r.x[2]});
  const auto [y_low, y_high] = std::minmax({r.y[0], r.y[1], r.y[2]});
  const std::int64_t size = std::int64_t{1} << layout_.shift;
  const std::int64_t last_row = y_high >> layout_.shift;
  const std::int64_t last_column = x_high >> layout_.shift;
  for (std::int64_t row = y_low >> layout_.shift; row <= last_row; ++row) {
    for (std::int64_t column = x_low >> layout_.shift; column <= last_column; ++column) {
      if (!misses_cell(r, column * size, row * size, size)) {
        visit(static_cast<std::size_t>(row * layout_.columns + column));
      }
    }
  }
}

void LineStabber::fill_cells() {
  const auto cells = static_cast<std::size_t>(layout_.columns * layout_.rows);
  cell_begin_.assign(cells + 1, 0);
  std::uint64_t items = 0;
  for (const Record& record : records_) {
    for_each_cell(record, [&](std::size_t cell) {
      ++cell_begin_[cell];
      ++items;
    });
    if (items > kMaxItems) {
      throw ResourceError("stabbing lines: more than " + format_bytes(4 * kMaxItems) +
                          " of bins are needed; use larger cells");
    }
  }
  // Offsets become the ends of the cells; filling from the last record down turns them into the beginnings.
  std::uint32_t sum = 0;
  for (std::uint32_t& entry : cell_begin_) entry = sum += entry;
  cell_items_.resize(items);
  for (std::size_t i = records_.size(); i-- > 0;) {
    for_each_cell(records_[i],
                  [&](std::size_t cell) { cell_items_[--cell_begin_[cell]] = static_cast<std::uint32_t>(i); });
  }
}

void LineStabber::append_crossings(double along_u, double along_v, std::vector<Crossing>& out) const {
  const double x_real = std::floor((along_u - layout_.origin[0]) / layout_.step + 0.5);
  const double y_real = std::floor((along_v - layout_.origin[1]) / layout_.step + 0.5);
  if (!(x_real >= 0 && y_real >= 0 && x_real <= layout_.limit[0] && y_real <= layout_.limit[1])) return;
  const auto x = static_cast<std::int64_t>(x_real);
  const auto y = static_cast<std::int64_t>(y_real);
  const auto cell = static_cast<std::size_t>((y >> layout_.shift) * layout_.columns + (x >> layout_.shift));
  for (std::uint32_t item = cell_begin_[cell]; item < cell_begin_[cell + 1]; ++item) {
    const Record& r = records_[cell_items_[item]];
    const std::int64_t e0 = edge_function(r.x[1], r.y[1], r.x[2], r.y[2], x, y);
    if (e0 + r.bias[0] <= 0) continue;
    const std::int64_t e1 = edge_function(r.x[2], r.y[2], r.x[0], r.y[0], x, y);
    if (e1 + r.bias[1] <= 0) continue;
    const std::int64_t e2 = edge_function(r.x[0], r.y[0], r.x[1], r.y[1], x, y);
    if (e2 + r.bias[2] <= 0) continue;
    const auto& z = depths_[cell_items_[item]];
    // e0 + e1 + e2 is twice the area, exactly. Equal depths give exactly that depth; rounding never leaves their range.
    const auto area = static_cast<double>(e0 + e1 + e2);
    const double depth =
        z[0] + (static_cast<double>(e1) * (z[1] - z[0]) + static_cast<double>(e2) * (z[2] - z[0])) / area;
    out.push_back({std::clamp(depth, std::min({z[0], z[1], z[2]}), std::max({z[0], z[1], z[2]})), r.triangle, r.sign});
  }
}

std::uint64_t LineStabber::memory_estimate(const TriangleSoup& soup, const StabFrame& frame, double cell_size) {
  const Layout layout = make_layout(soup, frame, cell_size);
  std::uint64_t items = 0;
  const double cell = std::ldexp(layout.step, layout.shift);
  for (const Triangle& triangle : soup.triangles) {
    std::uint64_t cells = 1;
    for (const Point& axis : {frame.u, frame.v}) {
      const double a = axis.dot(soup.positions[triangle[0]]);
      const double b = axis.dot(soup.positions[triangle[1]]);
      const double c = axis.dot(soup.positions[triangle[2]]);
      cells *= static_cast<std::uint64_t>((std::max({a, b, c}) - std::min({a, b, c})) / cell) + 2;
    }
    items += cells;
  }
  return items * sizeof(std::uint32_t) +
         static_cast<std::uint64_t>(layout.columns * layout.rows) * sizeof(std::uint32_t) +
         soup.triangles.size() * (sizeof(Record) + sizeof(std::array<double, 3>)) + soup.positions.size() * 16;
}

}  // namespace voxcarve
