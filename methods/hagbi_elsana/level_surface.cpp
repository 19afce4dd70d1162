// Cutting as in [GTLH98, 4] after gluing by wedges; see README.md.
#include "methods/hagbi_elsana/level_surface.h"

#include <algorithm>
#include <span>
#include <utility>

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
    glue_pairs();
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

  /// Nearly all edges have two sides, which are one wedge's: glued by their ends alone. Sides of others are listed.
  void glue_pairs() {
    glued_.assign(corner_.size(), kNone);
    // Sides by the smaller of their ends, in buckets that begin where `counts` says once they are full.
    std::vector<std::uint32_t>& counts = places_.counts();
    std::vector<std::uint32_t> lows;
    for (std::uint32_t side = 0; side < sides(); ++side) {
      if (counts[low(side)]++ == 0) lows.push_back(low(side));
    }
    std::vector<std::uint32_t> begin(lows.size() + 1, 0);
    for (std::size_t l = 0; l < lows.size(); ++l) {
      begin[l + 1] = begin[l] + counts[lows[l]];
      counts[lows[l]] = begin[l];
    }
    std::vector<std::uint64_t> bucketed(corner_.size());  // the larger end and the side
    for (std::uint32_t side = 0; side < sides(); ++side) {
      const std::uint32_t high = std::max(start(side), end(side));
      bucketed[counts[low(side)]++] = std::uint64_t{high} << 32 | side;
    }
    for (const std::uint32_t point : lows) counts[point] = 0;
    parallel_for(context_, 0, std::ssize(lows), kGrain, [&](std::int64_t first, std::int64_t last) {
      for (auto l = static_cast<std::size_t>(first); l < static_cast<std::size_t>(last); ++l) {
        glue_bucket(std::span(bucketed).subspan(begin[l], begin[l + 1] - begin[l]));
      }
    });
    for (std::uint32_t side = 0; side < sides(); ++side) {
      if (glued_[side] == kNone) singular_.push_back(side);
    }
  }

  std::uint32_t low(std::uint32_t side) const { return std::min(start(side), end(side)); }

  void glue_bucket(std::span<std::uint64_t> bucket) {
    std::ranges::sort(bucket);
    for (std::size_t i = 0; i < bucket.size();) {
      std::size_t next = i + 1;
      while (next < bucket.size() && bucket[next] >> 32 == bucket[i] >> 32) ++next;
      if (next == i + 2) {
        const auto one = static_cast<std::uint32_t>(bucket[i]);
        const auto other = static_cast<std::uint32_t>(bucket[i + 1]);
        glued_[one] = other;
        glued_[other] = one;
      }
      i = next;
    }
  }

  void glue_wedges() {
    parallel_for(context_, 0, std::ssize(singular_), kGrain, [&](std::int64_t begin, std::int64_t end) {
      for (auto s = static_cast<std::size_t>(begin); s < static_cast<std::size_t>(end); ++s) {
        const std::uint32_t side = singular_[s];
        const std::uint32_t third = corner_[next_side(next_side(side))];
        std::uint32_t twin = 3 * places_[across_wedge(faces_[side / 3], start(side), this->end(side), third)];
        while (start(twin) != this->end(side)) ++twin;  // sides of one wedge run against each other
        glued_[side] = twin;
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
    const auto edge = [&](std::uint32_t side) { return std::pair(fan_[side], fan_[next_side(side)]); };
    std::ranges::sort(singular_,
                      [&](std::uint32_t a, std::uint32_t b) { return edge(a) != edge(b) ? edge(a) < edge(b) : a < b; });
    std::vector<std::uint8_t> is_cut(fans_, 0);  // looked at again in the next pass
    bool any = false;
    for (std::size_t s = 0; s + 1 < singular_.size(); ++s) {
      const std::uint32_t side = singular_[s];
      const std::uint32_t met = singular_[s + 1];
      if (edge(side) != edge(met)) continue;
      any = true;
      const auto [u, w] = edge(side);
      if (is_cut[u] != 0 || is_cut[w] != 0) continue;
      // Exchange partners: (side, twin), (met, its twin) become (side, twin of met), (met, twin of side).
      std::swap(glued_[side], glued_[met]);
      glued_[glued_[side]] = side;
      glued_[glued_[met]] = met;
      is_cut[u] = is_cut[w] = 1;
    }
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
  std::vector<std::uint32_t> singular_;  ///< sides at edges of more than two faces
};

}  // namespace

TriangleSoup level_surface(const CarvedSolid& solid, const std::vector<std::uint32_t>& faces, FacePlaces& places,
                           const RunContext& context) {
  return SurfaceMaker(solid, faces, places, context).run();
}

}  // namespace voxcarve
