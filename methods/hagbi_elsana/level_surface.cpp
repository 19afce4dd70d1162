// Cutting as in [GTLH98, 4] after gluing by wedges; see README.md.
#include "methods/hagbi_elsana/level_surface.h"

#include <algorithm>
#include <bit>

#include "methods/hagbi_elsana/tetrahedron.h"

namespace voxcarve {

namespace {

constexpr std::uint32_t kNone = 0xffffffffU;

/// Sides of the faces: side 3 k + e runs from corner e of face k to the next one.
std::uint32_t next_side(std::uint32_t side) {
  return side % 3 == 2 ? side - 2 : side + 1;
}

class SurfaceMaker {
 public:
  SurfaceMaker(const CarvedSolid& solid, const std::vector<std::uint32_t>& faces, FacePlaces& places,
               const RunContext& context)
      : solid_(solid), faces_(faces), places_(places), context_(context) {}

  TriangleSoup run() {
    find_corners();
    glue_wedges();
    number_fans();
    while (reglue_doubled_edges()) number_fans();
    return make_soup();
  }

 private:
  static constexpr std::int64_t kGrain = 1 << 13;

  std::uint32_t sides() const { return static_cast<std::uint32_t>(corner_.size()); }
  std::uint32_t start(std::uint32_t side) const { return corner_[side]; }
  std::uint32_t end(std::uint32_t side) const { return corner_[next_side(side)]; }

  void find_corners() {
    corner_.resize(3 * faces_.size());
    parallel_for(context_, 0, std::ssize(faces_), kGrain, [&](std::int64_t begin, std::int64_t end) {
      for (auto k = static_cast<std::size_t>(begin); k < static_cast<std::size_t>(end); ++k) {
        const Triangle corners = solid_.complement.face(faces_[k] / 4, static_cast<int>(faces_[k] % 4));
        std::ranges::copy(corners, corner_.begin() + static_cast<std::ptrdiff_t>(3 * k));
        places_[faces_[k]] = static_cast<std::uint32_t>(k);
      }
    });
  }

  /// The face that bounds the outside on the other end of the wedge at a side of a face.
  std::uint32_t across_wedge(std::uint32_t face, std::uint32_t u, std::uint32_t w, std::uint32_t third) const {
    const Complement& mesh = solid_.complement;
    std::uint32_t t = face / 4;
    std::uint32_t leaves = third;  // the corner opposite the face through which the wedge goes on
    for (;;) {
      const TetrahedronCorners& corners = mesh.corners[t];
      const auto i = static_cast<std::size_t>(std::ranges::find(corners, leaves) - corners.begin());
      if (solid_.ends_at(t, static_cast<int>(i))) return 4 * t + static_cast<std::uint32_t>(i);
      std::uint32_t apex = kNone;  // of the face in between, beside u and w; a ghost's may be kFar
      for (const std::uint32_t corner : corners) {
        if (corner != u && corner != w && corner != leaves) apex = corner;
      }
      t = mesh.neighbors[t][i];
      leaves = apex;
    }
  }

  void glue_wedges() {
    glued_.resize(corner_.size());
    parallel_for(context_, 0, std::ssize(faces_), kGrain, [&](std::int64_t begin, std::int64_t end) {
      for (auto k = static_cast<std::uint32_t>(begin); k < static_cast<std::uint32_t>(end); ++k) {
        for (std::uint32_t side = 3 * k; side < 3 * k + 3; ++side) {
          const std::uint32_t third = corner_[next_side(next_side(side))];
          const std::uint32_t other = 3 * places_[across_wedge(faces_[k], start(side), this->end(side), third)];
          std::uint32_t twin = other;
          while (start(twin) != this->end(side)) ++twin;  // sides of one wedge run against each other
          glued_[side] = twin;
        }
      }
    });
  }

  /// Vertices of the surface: corners that follow one another around a point.
  void number_fans() {
    fan_.assign(corner_.size(), kNone);
    fans_ = 0;
    for (std::uint32_t corner = 0; corner < sides(); ++corner) {
      if (fan_[corner] != kNone) continue;
      std::uint32_t around = corner;
      do {
        fan_[around] = fans_;
        around = next_side(glued_[around]);  // the glued side ends in the point; the one after it starts there
      } while (around != corner);
      ++fans_;
    }
  }

  /// Two pairs of sides between the same vertices of the surface make an edge with four triangles. Where one pair's
  /// wedge follows the other's, gluing across the solid between them instead cuts each end in two: as an end's fan
  /// passes the edge twice, it falls apart into what lies between. True when there was any.
  bool reglue_doubled_edges() {
    const std::size_t mask = std::bit_ceil(corner_.size() + 1) - 1;
    if (table_.size() != mask + 1) table_.assign(mask + 1, kNone);
    std::vector<std::uint8_t> is_cut(fans_, 0);  // looked at again in the next pass
    bool any = false;
    for (std::uint32_t side = 0; side < sides(); ++side) {
      if (fan_[side] > fan_[next_side(side)]) continue;  // its twin is looked at
      const std::uint64_t edge = std::uint64_t{fan_[side]} << 32 | fan_[next_side(side)];
      std::size_t slot = static_cast<std::size_t>((edge * 0x9e3779b97f4a7c15ULL) >> 20) & mask;
      std::uint32_t met = kNone;
      for (; table_[slot] != kNone; slot = (slot + 1) & mask) {
        const std::uint32_t other = table_[slot];
        if (fan_[other] == fan_[side] && fan_[next_side(other)] == fan_[next_side(side)]) {
          met = other;
          break;
        }
      }
      if (met == kNone) {
        table_[slot] = side;
        continue;
      }
      // Exchange partners: (side, twin), (met, its twin) become (side, twin of met), (met, twin of side).
      any = true;
      if (is_cut[fan_[side]] != 0 || is_cut[fan_[next_side(side)]] != 0) continue;
      std::swap(glued_[side], glued_[met]);
      glued_[glued_[side]] = side;
      glued_[glued_[met]] = met;
      is_cut[fan_[side]] = is_cut[fan_[next_side(side)]] = 1;
    }
    if (any) std::ranges::fill(table_, kNone);
    return any;
  }

  TriangleSoup make_soup() const {
    TriangleSoup soup;
    soup.positions.resize(fans_);
    soup.triangles.resize(faces_.size());
    for (std::size_t k = 0; k < faces_.size(); ++k) {
      for (std::size_t c = 0; c < 3; ++c) {
        soup.triangles[k][c] = fan_[3 * k + c];
        soup.positions[fan_[3 * k + c]] = solid_.complement.points[corner_[3 * k + c]];
      }
    }
    return soup;
  }

  const CarvedSolid& solid_;
  const std::vector<std::uint32_t>& faces_;
  FacePlaces& places_;
  const RunContext& context_;
  std::vector<std::uint32_t> corner_;  ///< point at which each side starts
  std::vector<std::uint32_t> glued_;   ///< the side that each side is glued to
  std::vector<std::uint32_t> fan_;     ///< vertex of the surface at which each side starts
  std::uint32_t fans_ = 0;
  std::vector<std::uint32_t> table_;
};

}  // namespace

TriangleSoup level_surface(const CarvedSolid& solid, const std::vector<std::uint32_t>& faces, FacePlaces& places,
                           const RunContext& context) {
  return SurfaceMaker(solid, faces, places, context).run();
}

}  // namespace voxcarve
