// Cutting as in [GTLH98, 4] after gluing by wedges; see README.md.
#include "methods/hagbi_elsana/level_surface.h"

#include <algorithm>
#include <span>
#include <tuple>
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
    cut_doubled_edges();
    return make_soup();
  }

 private:
  static constexpr std::int64_t kGrain = 1 << 13;
  static constexpr std::size_t kCheckEvery = 1 << 14;

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
        around = next_around(around);
      } while (around != corner);
      ++fans_;
    }
  }

  /// Two pairs of sides between the same vertices of the surface make an edge with four triangles. Exchanging partners
  /// cuts each end in two: as its fan passes the edge twice, it falls apart into what lies between. That never makes
  /// another pair of edges double, so every edge is looked at once.
  void cut_doubled_edges() {
    std::erase_if(singular_, [&](std::uint32_t side) { return start(side) > end(side); });  // its twin stays
    std::ranges::sort(singular_, [&](std::uint32_t a, std::uint32_t b) {
      return std::tuple(start(a), end(a), a) < std::tuple(start(b), end(b), b);
    });
    for (std::size_t first = 0; first < singular_.size();) {
      std::size_t last = first;
      while (last < singular_.size() && start(singular_[last]) == start(singular_[first]) &&
             end(singular_[last]) == end(singular_[first])) {
        ++last;
      }
      if (first / kCheckEvery != last / kCheckEvery) context_.check_cancelled();
      const std::span<std::uint32_t> around(singular_.data() + first, last - first);
      while (cut_one(around)) {
      }
      first = last;
    }
  }

  /// Of the sides along one edge. True when two had the same ends and were cut apart.
  bool cut_one(std::span<std::uint32_t> around) {
    const auto ends = [&](std::uint32_t side) { return std::pair(fan_[side], fan_[next_side(side)]); };
    std::ranges::sort(around,
                      [&](std::uint32_t a, std::uint32_t b) { return std::pair(ends(a), a) < std::pair(ends(b), b); });
    const auto met = std::ranges::adjacent_find(around, [&](auto a, auto b) { return ends(a) == ends(b); });
    if (met == around.end()) return false;
    const std::uint32_t one = met[0];
    const std::uint32_t other = met[1];
    std::swap(glued_[one], glued_[other]);
    glued_[glued_[one]] = one;
    glued_[glued_[other]] = other;
    renumber_shorter(one, other);
    renumber_shorter(next_side(one), next_side(other));
    return true;
  }

  std::uint32_t next_around(std::uint32_t corner) const {
    return next_side(glued_[corner]);  // the glued side ends in the point; the one after it starts there
  }

  /// Gives the shorter of two fans that were one a number of its own.
  void renumber_shorter(std::uint32_t one, std::uint32_t other) {
    std::uint32_t shorter = one;
    for (std::uint32_t a = one, b = other;;) {
      a = next_around(a);
      b = next_around(b);
      if (a == one) break;
      if (b == other) {
        shorter = other;
        break;
      }
    }
    std::uint32_t corner = shorter;
    do {
      fan_[corner] = fans_;
      corner = next_around(corner);
    } while (corner != shorter);
    ++fans_;
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
