// Closed surfaces of known genus and volume: torus, genus-n and perforated-box.
#include <array>
#include <cmath>
#include <numbers>

#include "common/mesh/models/builders.h"
#include "common/mesh/models/primitives.h"
#include "common/run/errors.h"

namespace voxcarve {

namespace {

using std::numbers::pi;

/// The faceted torus of n segments and m tube segments has volume n sin(2 pi / n) * (m / 2) sin(2 pi / m) r^2 * R: each
/// of the n wedges is the section's area times its centroid's distance, swept along chords.
TriangleSoup build_torus(const Parameters& parameters) {
  return torus(parameters.real("major"), parameters.real("minor"), static_cast<int>(parameters.integer("segments")),
               static_cast<int>(parameters.integer("tube_segments")));
}

/// A plate of (2 n + 1) x 3 x 1 unit cubes less every second one of the middle row: genus n, volume 5 n + 3, and
/// 18 n + 14 exposed squares (top and bottom 5 n + 3 each, rim 4 n + 8, 4 a hole).
TriangleSoup build_genus_n(const Parameters& parameters) {
  const auto genus = static_cast<int>(parameters.integer("genus"));
  const auto filled = [](int i, int j, int /*k*/) { return j != 1 || i % 2 == 0; };
  return block_surface({2 * genus + 1, 3, 1}, filled, 1.0, static_cast<int>(parameters.integer("subdivision")));
}

/// The box with holes in rows of `holes`, each a prism of `sides` sides. Per cell there are the four corners that it
/// shares with its neighbours and the polygon of its hole, at the bottom (level 0) and at the top (level 1).
class PerforatedBox {
 public:
  explicit PerforatedBox(const Parameters& parameters)
      : holes_(static_cast<int>(parameters.integer("holes"))),
        sides_(static_cast<int>(parameters.integer("sides"))),
        apothem_(parameters.real("hole_width") / 2),
        thickness_(parameters.real("thickness")) {}

  TriangleSoup build() {
    add_vertices();
    for (int j = 0; j < holes_; ++j) {
      for (int i = 0; i < holes_; ++i) {
        add_faces(i, j);
        add_hole_wall(i, j);
        add_outer_walls(i, j);
      }
    }
    return std::move(soup_);
  }

 private:
  void add_vertices() {
    const double pitch = 1.0 / holes_;
    for (const double z : {0.0, thickness_}) {
      for (int j = 0; j <= holes_; ++j) {
        for (int i = 0; i <= holes_; ++i) soup_.positions.emplace_back(pitch * i, pitch * j, z);
      }
    }
    const double circumradius = apothem_ / std::cos(pi / sides_);
    for (int j = 0; j < holes_; ++j) {
      for (int i = 0; i < holes_; ++i) {
        for (const double z : {0.0, thickness_}) {
          for (int q = 0; q < sides_; ++q) {
            const double angle = (2 * q + 1) * pi / sides_;
            soup_.positions.emplace_back(pitch * (i + 0.5 + circumradius * std::cos(angle)),
                                         pitch * (j + 0.5 + circumradius * std::sin(angle)), z);
          }
        }
      }
    }
  }

  /// Corner k of a cell lies at 45 + 90 k degrees of its centre.
  std::uint32_t corner(int i, int j, int k, int level) const {
    const int column = i + (k % 4 == 0 || k % 4 == 3 ? 1 : 0);
    const int row = j + (k % 4 < 2 ? 1 : 0);
    const int row_length = holes_ + 1;
    return static_cast<std::uint32_t>((level * row_length + row) * row_length + column);
  }
  std::uint32_t rim(int i, int j, int q, int level) const {
    const int corners = 2 * (holes_ + 1) * (holes_ + 1);
    return static_cast<std::uint32_t>(corners + ((j * holes_ + i) * 2 + level) * sides_ + q % sides_);
  }
  /// The corner that faces edge q of the polygon: the one in the quadrant of the edge's middle, 2 pi (q + 1) / sides.
  int facing_corner(int q) const { return 4 * (q + 1) / sides_ % 4; }

  /// A triangle of the top, and its mirror image at the bottom.
  void add_pair(const Triangle& top, const Triangle& bottom) {
    soup_.triangles.push_back(top);
    soup_.triangles.push_back({bottom[0], bottom[2], bottom[1]});
  }

  /// The ring between the square and the polygon: one triangle an edge of either, sides + 4 in all. They do not overlap
  /// because the polygon's edges are nearer to the centre than half the pitch (its apothem is at most 0.4 of it), so
  /// that a facing corner sees its edge from outside, and its vertices lie within the square.
  void add_faces(int i, int j) {
    for (int q = 0; q < sides_; ++q) {
      const int k = facing_corner(q);
      const int before = facing_corner((q + sides_ - 1) % sides_);
      if (k != before) {
        add_pair({corner(i, j, before, 1), corner(i, j, k, 1), rim(i, j, q, 1)},
                 {corner(i, j, before, 0), corner(i, j, k, 0), rim(i, j, q, 0)});
      }
      add_pair({rim(i, j, q, 1), corner(i, j, k, 1), rim(i, j, q + 1, 1)},
               {rim(i, j, q, 0), corner(i, j, k, 0), rim(i, j, q + 1, 0)});
    }
  }

  void add_quad(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    soup_.triangles.push_back({a, b, c});
    soup_.triangles.push_back({a, c, d});
  }
  void add_hole_wall(int i, int j) {
    for (int q = 0; q < sides_; ++q) {
      add_quad(rim(i, j, q, 1), rim(i, j, q + 1, 1), rim(i, j, q + 1, 0), rim(i, j, q, 0));
    }
  }
  void add_outer_walls(int i, int j) {
    const std::array<bool, 4> outer = {j == holes_ - 1, i == 0, j == 0, i == holes_ - 1};  // between corners k, k + 1
    for (int k = 0; k < 4; ++k) {
      if (!outer[static_cast<std::size_t>(k)]) continue;
      add_quad(corner(i, j, k + 1, 1), corner(i, j, k, 1), corner(i, j, k, 0), corner(i, j, k + 1, 0));
    }
  }

  TriangleSoup soup_;
  int holes_;
  int sides_;
  double apothem_;  // share of the pitch
  double thickness_;
};

}  // namespace

ProceduralModel torus_model() {
  ModelInfo info{"torus", "a ring torus about the z axis: genus 1", "", {}};
  info.parameters.specs = {
      ParameterSpec::real("major", "model", 1e-3, 1e6, 1, "from the centre to the middle of the tube"),
      ParameterSpec::real("minor", "model", 1e-4, 1e6, 0.4, "radius of the tube; less than major"),
      ParameterSpec::integer("segments", "segments", 3, 100'000, 64, "segments around the axis"),
      ParameterSpec::integer("tube_segments", "segments", 3, 100'000, 32, "segments around the tube")};
  info.parameters.check = [](const Parameters& parameters) {
    if (parameters.real("minor") >= parameters.real("major"))
      throw ParameterError("torus: minor must be less than major");
    require_triangles_within_limit("torus", 2.0 * static_cast<double>(parameters.integer("segments")) *
                                                static_cast<double>(parameters.integer("tube_segments")));
  };
  return {std::move(info), build_torus};
}

ProceduralModel genus_n_model() {
  ModelInfo info{"genus-n", "a plate of unit cubes with a row of square holes: any genus, volume 5 genus + 3", "", {}};
  info.parameters.specs = {
      ParameterSpec::integer("genus", "holes", 0, 500'000, 3, "number of holes"),
      ParameterSpec::integer("subdivision", "squares", 1, 1000, 4, "squares along the edge of a cube")};
  info.parameters.check = [](const Parameters& parameters) {
    const auto genus = static_cast<double>(parameters.integer("genus"));
    const auto subdivision = static_cast<double>(parameters.integer("subdivision"));
    require_triangles_within_limit("genus-n", 2 * (18 * genus + 14) * subdivision * subdivision);
  };
  return {std::move(info), build_genus_n};
}

ProceduralModel perforated_box_model() {
  ModelInfo info{
      "perforated-box", "a flat box of side 1 with holes x holes through-holes: genus holes^2", "NT section 1", {}};
  info.parameters.specs = {
      ParameterSpec::integer("holes", "holes", 1, 2000, 10, "holes along each side"),
      ParameterSpec::integer("sides", "sides", 4, 10'000, 4, "sides of a hole: 4 is square, many are round"),
      ParameterSpec::real("hole_width", "pitch", 0.01, 0.8, 0.5,
                          "between opposite sides of a hole (the inscribed circle)"),
      ParameterSpec::real("thickness", "model", 1e-3, 10, 0.2, "height of the box")};
  info.parameters.check = [](const Parameters& parameters) {
    const auto holes = static_cast<double>(parameters.integer("holes"));
    const auto sides = static_cast<double>(parameters.integer("sides"));
    // Per hole two rings of sides + 4 and a wall of 2 sides; 8 an outer cell edge.
    require_triangles_within_limit("perforated-box", holes * holes * (4 * sides + 8) + 8 * holes);
  };
  return {std::move(info), [](const Parameters& parameters) { return PerforatedBox(parameters).build(); }};
}

}  // namespace voxcarve
