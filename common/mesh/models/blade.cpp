// blade: a turbine blade with cooling channels and film-cooling holes, stand-in for the CT scan of [NT03, Fig. 6]
// (1,726,892 faces; 643 x 300 x 382 voxels; "fine interior detail, and complex topology (small holes, thin tunnels)").
// One closed 2-manifold. The long axis is z: a resolution of 643 gives 382 x 300 x 643 voxels, each one unit wide.
//
// Outer surface and channel walls are grids of quads with the same rows from root to tip; a point of a channel's wall
// belongs to the point of the outer surface that it lies behind. A hole takes a patch of quads out of two walls and
// puts in each a ring of quads between the patch's outline and a round rim; a tube joins the two rims. The end faces at
// root and tip are rings of quads between the outline of a channel's cell (its stretch of the outer surface and the
// ribs' middle lines) and the channel.
//
// Genus. A block with c parallel channels from end to end has genus c. A hole joins two walls by a tube, which takes
// two discs away and adds a cylinder: one more each. So the genus is channels + holes: 5 + 252 film holes (9 rows of
// 28)
// + 30 slots in the trailing edge + 20 crossover holes through the first rib = 307.
//
// Film holes are 2.4, crossovers 3 and slots 1.8 voxels wide, channels at most 17 voxels high: a closing by 10 voxels
// fills all of them, as in [NT03, Fig. 6c].
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "common/mesh/models/blade_shape.h"
#include "common/mesh/models/builders.h"
#include "common/run/errors.h"

namespace voxcarve {

namespace {

using std::numbers::pi;

constexpr int kBeltsInCap = 18;  // between the outline of a cell and its channel, at detail 1

/// A row of holes along the span.
struct HoleRow {
  double chord;  ///< share of the chord where it lies on the outer surface
  int side;      ///< 1 suction, -1 pressure, 0 leading edge
  int holes;
  double radius;  ///< voxels
  double drop;    ///< how much lower than outside it ends in the channel, voxels
};

constexpr std::array<HoleRow, 10> kHoleRows = {{{0, 0, 28, 1.2, 0},
                                                {0.02, 1, 28, 1.2, 6},
                                                {0.02, -1, 28, 1.2, 6},
                                                {0.11, 1, 28, 1.2, 8},
                                                {0.12, -1, 28, 1.2, 8},
                                                {0.3, 1, 28, 1.2, 10},
                                                {0.3, -1, 28, 1.2, 10},
                                                {0.5, -1, 28, 1.2, 10},
                                                {0.7, -1, 28, 1.2, 10},
                                                {0.93, -1, 30, 0.9, 0}}};
constexpr int kCrossovers = 20;
constexpr double kCrossoverRadius = 1.5;
constexpr double kHolesStart = 275;  // height of the lowest hole of a row
constexpr double kHolesEnd = 612;

/// A wall: a grid of quads, closed around, from the root's end face (row 0) to the tip.
struct Wall {
  std::uint32_t first = 0;  ///< vertex of column 0 in row 0
  int columns = 0;
  bool faces_out = true;     ///< do its quads face out, seen with the columns counterclockwise? Channels' face in
  std::vector<bool> is_cut;  ///< quads that holes replace
};

/// A rectangle of quads on a wall, where a hole starts or ends.
struct Patch {
  int wall = 0;
  int column = 0;
  int row = 0;
  bool mirrored = false;  ///< its columns are counted downward from its far end
};

class BladeMesh {
 public:
  explicit BladeMesh(double detail) : factor_(std::sqrt(detail)) {
    lay_out_columns();
    lay_out_rows();
    patch_columns_ = segments(5, 1);
    patch_rows_ = segments(3, 1);
    tube_belts_ = segments(6, 1);
    cap_belts_ = segments(kBeltsInCap, 1);
  }

  TriangleSoup build() {
    add_walls();
    for (const HoleRow& row : kHoleRows) cut_film_holes(row);
    cut_crossovers();
    for (Wall& wall : walls_) add_quads_of(wall);
    add_cap(0);
    add_cap(rows() - 1);
    remove_unused_vertices(soup_);  // inside the patches
    return std::move(soup_);
  }

 private:
  int segments(int base, int least) const { return std::max(least, static_cast<int>(std::lround(base * factor_))); }
  int rows() const { return static_cast<int>(stations_.size()); }

  /// Columns of the outer wall: from the trailing edge over the suction side to the leading edge and back, with one at
  /// either end of every rib.
  void lay_out_columns() {
    constexpr std::array<int, kBladeChannels> kSegments = {96, 70, 66, 70, 88};  // of a cell's arc on one side
    std::vector<double> suction = {0};
    for (int channel = kBladeChannels - 1; channel >= 0; --channel) {
      const auto c = static_cast<std::size_t>(channel);
      const double end = channel == 0 ? pi : std::acos(2 * kBladeRibs[c - 1] - 1);
      const double start = suction.back();
      const int count = segments(kSegments[c], 4);
      for (int k = 1; k <= count; ++k) suction.push_back(start + (end - start) * k / count);
      if (channel > 0) rib_column_[c - 1] = static_cast<int>(suction.size()) - 1;
    }
    angles_ = suction;
    for (std::size_t k = suction.size() - 2; k > 0; --k) angles_.push_back(2 * pi - suction[k]);
    rib_points_ = segments(18, 6);
  }

  void lay_out_rows() {
    const std::vector<BladeStation>& keys = blade_stations();
    stations_ = {keys.front()};
    for (std::size_t k = 1; k < keys.size(); ++k) {
      const int belts = segments(keys[k].belts, 1);
      for (int b = 1; b <= belts; ++b) {
        stations_.push_back(between(keys[k - 1], keys[k], static_cast<double>(b) / belts));
      }
    }
  }

  int opposite(int column) const {
    return (static_cast<int>(angles_.size()) - column) % static_cast<int>(angles_.size());
  }

  /// One point of a cell's outline: a column of the outer wall, or a point on a rib.
  struct CellPoint {
    int column = -1;
    int rib = -1;
    int step = 0;  ///< on a rib: 1 to rib_points_, from the suction side
  };

  /// Counterclockwise: the suction side's arc, down the rib towards the leading edge, the pressure side's arc, up the
  /// other rib. The first and the last cell have one arc, around an edge.
  std::vector<CellPoint> cell_outline(int channel) const {
    const auto count = static_cast<int>(angles_.size());
    std::vector<CellPoint> outline;
    const auto add_arc = [&](int from, int to) {
      for (int k = from;; k = (k + 1) % count) {
        outline.push_back({k, -1, 0});
        if (k == to) break;
      }
    };
    const auto add_rib = [&](int rib, bool down) {
      for (int step = 1; step <= rib_points_; ++step) {
        outline.push_back({-1, rib, down ? step : rib_points_ + 1 - step});
      }
    };
    const auto rib_column = [&](int rib) { return rib_column_[static_cast<std::size_t>(rib)]; };
    if (channel == kBladeChannels - 1) {
      add_arc(opposite(rib_column(channel - 1)), rib_column(channel - 1));
      add_rib(channel - 1, true);
    } else if (channel == 0) {
      add_arc(rib_column(0), opposite(rib_column(0)));
      add_rib(0, false);
    } else {
      add_arc(rib_column(channel), rib_column(channel - 1));
      add_rib(channel - 1, true);
      add_arc(opposite(rib_column(channel - 1)), opposite(rib_column(channel)));
      add_rib(channel, false);
    }
    return outline;
  }

  Point channel_position(int channel, const CellPoint& point, double z) const {
    const auto [start, end] = channel_ends(channel);
    if (point.rib >= 0) {
      const double angle = angles_[static_cast<std::size_t>(rib_column_[static_cast<std::size_t>(point.rib)])];
      const double height = channel_half_height(angle) * (1 - 2.0 * point.step / (rib_points_ + 1));
      return blade_interior(z, point.rib == channel ? end : start, height);
    }
    const auto c = static_cast<std::size_t>(channel);
    const double cell_start = channel == 0 ? 0 : kBladeRibs[c - 1];
    const double cell_end = channel + 1 == kBladeChannels ? 1 : kBladeRibs[c];
    const double angle = angles_[static_cast<std::size_t>(point.column)];
    const double share = ((1 + std::cos(angle)) / 2 - cell_start) / (cell_end - cell_start);
    return blade_interior(z, start + share * (end - start), channel_half_height(angle));
  }

  void add_walls() {
    const auto quads = [&](int columns) { return std::vector<bool>(static_cast<std::size_t>(columns * (rows() - 1))); };
    const auto columns = static_cast<int>(angles_.size());
    walls_.push_back({0, columns, true, quads(columns)});
    for (const BladeStation& station : stations_) {
      for (const double angle : angles_) soup_.positions.push_back(blade_surface(station, angle));
    }
    for (int channel = 0; channel < kBladeChannels; ++channel) {
      const auto first = static_cast<std::uint32_t>(soup_.positions.size());
      outlines_.push_back(cell_outline(channel));
      walls_.push_back(
          {first, static_cast<int>(outlines_.back().size()), false, quads(static_cast<int>(outlines_.back().size()))});
      for (const BladeStation& station : stations_) {
        for (const CellPoint& point : outlines_.back()) {
          soup_.positions.push_back(channel_position(channel, point, station.channel_z));
        }
      }
    }
  }

  std::uint32_t vertex(const Wall& wall, int column, int row) const {
    return wall.first + static_cast<std::uint32_t>(row * wall.columns + (column + wall.columns) % wall.columns);
  }

  void add_quad(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    soup_.triangles.push_back({a, b, c});
    soup_.triangles.push_back({a, c, d});
  }

  void add_quads_of(const Wall& wall) {
    for (int row = 0; row + 1 < rows(); ++row) {
      for (int column = 0; column < wall.columns; ++column) {
        if (wall.is_cut[static_cast<std::size_t>(row * wall.columns + column)]) continue;
        const std::uint32_t a = vertex(wall, column, row);
        const std::uint32_t b = vertex(wall, column + 1, row);
        const std::uint32_t c = vertex(wall, column + 1, row + 1);
        const std::uint32_t d = vertex(wall, column, row + 1);
        wall.faces_out ? add_quad(a, b, c, d) : add_quad(a, d, c, b);
      }
    }
  }

  /// The end face at row 0 or at the last row.
  void add_cap(int row) {
    const bool faces_up = row > 0;
    // The ribs' middle lines, from the suction side.
    std::array<std::uint32_t, kBladeChannels - 1> first_of_rib{};
    for (std::size_t rib = 0; rib < first_of_rib.size(); ++rib) {
      first_of_rib[rib] = static_cast<std::uint32_t>(soup_.positions.size());
      const Point from = soup_.positions[vertex(walls_[0], rib_column_[rib], row)];
      const Point to = soup_.positions[vertex(walls_[0], opposite(rib_column_[rib]), row)];
      for (int step = 1; step <= rib_points_; ++step) {
        soup_.positions.emplace_back(from + (to - from) * (static_cast<double>(step) / (rib_points_ + 1)));
      }
    }
    for (std::size_t channel = 0; channel < kBladeChannels; ++channel) {
      const Wall& wall = walls_[channel + 1];
      std::vector<std::uint32_t> outer;
      std::vector<std::uint32_t> channel_ring;
      for (int k = 0; k < wall.columns; ++k) {
        const CellPoint& point = outlines_[channel][static_cast<std::size_t>(k)];
        outer.push_back(point.rib < 0 ? vertex(walls_[0], point.column, row)
                                      : first_of_rib[static_cast<std::size_t>(point.rib)] +
                                            static_cast<std::uint32_t>(point.step - 1));
        channel_ring.push_back(vertex(wall, k, row));
      }
      join_rings(outer, channel_ring, cap_belts_, faces_up);
    }
  }

  /// A band of quads between two closed rings, `belts` wide. From the side that it faces, the first ring runs
  /// counterclockwise about the second, or clockwise when not `forward`.
  void join_rings(const std::vector<std::uint32_t>& from, const std::vector<std::uint32_t>& to, int belts,
                  bool forward) {
    std::vector<std::uint32_t> last = from;
    for (int belt = 1; belt <= belts; ++belt) {
      std::vector<std::uint32_t> next = to;
      if (belt < belts) {
        for (std::size_t k = 0; k < next.size(); ++k) {
          next[k] = static_cast<std::uint32_t>(soup_.positions.size());
          const Point start = soup_.positions[from[k]];
          const Point end = soup_.positions[to[k]];
          soup_.positions.emplace_back(start + (end - start) * (static_cast<double>(belt) / belts));
        }
      }
      for (std::size_t k = 0; k < next.size(); ++k) {
        const std::size_t after = (k + 1) % next.size();
        forward ? add_quad(last[k], last[after], next[after], next[k])
                : add_quad(last[k], next[k], next[after], last[after]);
      }
      last = std::move(next);
    }
  }

  /// Takes a patch out of its wall and puts a ring of quads with a round rim there. Returns the rim, counterclockwise
  /// in the patch's columns and rows.
  std::vector<std::uint32_t> cut_rim(const Patch& patch, double radius) {
    Wall& wall = walls_[static_cast<std::size_t>(patch.wall)];
    const auto column_of = [&](int u) { return patch.column + (patch.mirrored ? patch_columns_ - u : u); };
    const auto position = [&](double u, double v) {
      const int i = std::clamp(static_cast<int>(u), 0, patch_columns_ - 1);
      const int j = std::clamp(static_cast<int>(v), 0, patch_rows_ - 1);
      const auto at = [&](int a, int b) { return soup_.positions[vertex(wall, column_of(i + a), patch.row + j + b)]; };
      const double s = u - i;
      const double t = v - j;
      return Point((1 - s) * (1 - t) * at(0, 0) + s * (1 - t) * at(1, 0) + s * t * at(1, 1) + (1 - s) * t * at(0, 1));
    };
    for (int v = 0; v < patch_rows_; ++v) {
      for (int u = 0; u < patch_columns_; ++u) {
        const int column = ((patch.column + u) % wall.columns + wall.columns) % wall.columns;
        const auto quad = static_cast<std::size_t>((patch.row + v) * wall.columns + column);
        if (wall.is_cut[quad]) throw ParameterError("blade: holes overlap at this detail; raise it");
        wall.is_cut[quad] = true;
      }
    }
    std::vector<std::array<int, 2>> outline;
    for (int u = 0; u < patch_columns_; ++u) outline.push_back({u, 0});
    for (int v = 0; v < patch_rows_; ++v) outline.push_back({patch_columns_, v});
    for (int u = patch_columns_; u > 0; --u) outline.push_back({u, patch_rows_});
    for (int v = patch_rows_; v > 0; --v) outline.push_back({0, v});

    const double half_u = patch_columns_ / 2.0;
    const double half_v = patch_rows_ / 2.0;
    const double length_u = (position(2 * half_u, half_v) - position(0, half_v)).norm() / 2;
    const double length_v = (position(half_u, 2 * half_v) - position(half_u, 0)).norm() / 2;
    const double r = std::min(radius, 0.8 * std::min(length_u, length_v));
    std::vector<std::uint32_t> ring;
    std::vector<std::uint32_t> rim;
    for (const auto& [u, v] : outline) {
      ring.push_back(vertex(wall, column_of(u), patch.row + v));
      const double angle = std::atan2((v / half_v - 1) * length_v, (u / half_u - 1) * length_u);
      rim.push_back(static_cast<std::uint32_t>(soup_.positions.size()));
      const Point on_rim =
          position(half_u * (1 + r / length_u * std::cos(angle)), half_v * (1 + r / length_v * std::sin(angle)));
      soup_.positions.push_back(on_rim);
    }
    join_rings(ring, rim, 1, wall.faces_out != patch.mirrored);
    return rim;
  }

  /// Joins two patches by a tube. Of walls and mirroring, exactly one is turned over between the two.
  void cut_hole(const Patch& from, const Patch& to, double radius) {
    const std::vector<std::uint32_t> start = cut_rim(from, radius);
    const std::vector<std::uint32_t> end = cut_rim(to, radius);
    join_rings(start, end, tube_belts_, true);
  }

  /// The rows that start the patches of a row of holes.
  std::vector<int> hole_rows(int holes) const {
    std::vector<int> rows_of;
    for (int k = 0; k < holes; ++k) {
      const double z = kHolesStart + (kHolesEnd - kHolesStart) * k / (holes - 1);
      const auto after = std::ranges::lower_bound(stations_, z, {}, &BladeStation::z);
      rows_of.push_back(static_cast<int>(after - stations_.begin()) - (patch_rows_ + 1) / 2);
    }
    return rows_of;
  }

  void cut_film_holes(const HoleRow& row) {
    const double angle = std::acos(2 * row.chord - 1);
    const auto nearest = std::ranges::lower_bound(angles_, row.side < 0 ? 2 * pi - angle : angle - 1e-9);
    const int column = static_cast<int>(nearest - angles_.begin()) - patch_columns_ / 2;
    const auto channel = static_cast<int>(std::ranges::upper_bound(kBladeRibs, row.chord) - kBladeRibs.begin());
    const std::vector<CellPoint>& outline = outlines_[static_cast<std::size_t>(channel)];
    const auto behind = std::ranges::find(outline, column, &CellPoint::column);
    const auto behind_column = static_cast<int>(behind - outline.begin());
    const double row_height = stations_.back().z - stations_[stations_.size() - 2].z;
    const auto drop = static_cast<int>(std::lround(row.drop / row_height));
    for (const int start : hole_rows(row.holes)) {
      cut_hole({0, column, start, false}, {channel + 1, behind_column, start - drop, false}, row.radius);
    }
  }

  /// Between the walls of the first rib, in its middle.
  void cut_crossovers() {
    const auto first_rib_column = [&](int channel) {
      const std::vector<CellPoint>& outline = outlines_[static_cast<std::size_t>(channel)];
      return static_cast<int>(std::ranges::find(outline, 0, &CellPoint::rib) - outline.begin());
    };
    const int margin = (rib_points_ - 1 - patch_columns_) / 2;
    for (const int start : hole_rows(kCrossovers)) {
      // Up the rib in channel 0, down in channel 1.
      const int far = rib_points_ - 1 - margin - patch_columns_;
      cut_hole({2, first_rib_column(1) + far, start, true}, {1, first_rib_column(0) + margin, start, false},
               kCrossoverRadius);
    }
  }

  double factor_;
  std::vector<double> angles_;                        // of the outer wall's columns
  std::array<int, kBladeChannels - 1> rib_column_{};  // on the suction side
  std::vector<BladeStation> stations_;                // of the rows
  int rib_points_ = 0;
  int patch_columns_ = 0;
  int patch_rows_ = 0;
  int tube_belts_ = 0;
  int cap_belts_ = 0;
  std::vector<Wall> walls_;  // the outer one, then the channels'
  std::vector<std::vector<CellPoint>> outlines_;
  TriangleSoup soup_;
};

/// Splits the last `count` triangles, which belong to the tip's end face, in three each.
void split_last(TriangleSoup& soup, std::size_t count) {
  const std::size_t end = soup.triangles.size();
  for (std::size_t t = end - std::min(count, end); t < end; ++t) {
    const auto [a, b, c] = soup.triangles[t];
    const auto middle = static_cast<std::uint32_t>(soup.positions.size());
    soup.positions.emplace_back((soup.positions[a] + soup.positions[b] + soup.positions[c]) / 3);
    soup.triangles[t] = {a, b, middle};
    soup.triangles.push_back({b, c, middle});
    soup.triangles.push_back({c, a, middle});
  }
}

}  // namespace

ProceduralModel blade_model() {
  ModelInfo info{
      "blade", "a turbine blade with 5 cooling channels and 302 fine holes: one surface of genus 307", "NT Fig. 6", {}};
  info.parameters.specs = {
      ParameterSpec::real("detail", "times", 0.05, 10, 1, "factor on the number of triangles, about"),
      ParameterSpec::integer("splits", "triangles", 0, 1000, 794,
                             "triangles of the tip's end face split in three, which makes up the paper's number")};
  return {std::move(info), [](const Parameters& parameters) {
            TriangleSoup soup = BladeMesh(parameters.real("detail")).build();
            split_last(soup, static_cast<std::size_t>(parameters.integer("splits")));
            return soup;
          }};
}

}  // namespace voxcarve
