// Cutting as in [GTLH98, 4] after gluing by wedges; see README.md.
#include "methods/hagbi_elsana/fan_cutting.h"

#include <algorithm>
#include <span>
#include <utility>

#include "methods/hagbi_elsana/tetrahedron.h"

namespace voxcarve {

namespace {

constexpr std::uint32_t kNone = LevelWorkspace::kNone;

/// Sides of the faces: side 3 k + e runs from corner e of face k to the next one. A corner has the number of the side
/// that starts there.
std::uint32_t next_side(std::uint32_t side) {
  return side % 3 == 2 ? side - 2 : side + 1;
}
std::uint32_t previous_side(std::uint32_t side) {
  return side % 3 == 0 ? side + 2 : side - 1;
}

/// Glues sides that start in singular vertices; only these are ever asked for what they are glued to.
class FanCutter {
 public:
  FanCutter(const CarvedSolid& solid, const std::vector<std::uint32_t>& faces, LevelWorkspace& workspace,
            const RunContext& context, TriangleSoup& soup)
      : solid_(solid), faces_(faces), workspace_(workspace), context_(context), soup_(soup) {}

  void run() {
    gather_corners();
    glue_pairs();
    glue_wedges();
    number_fans();
    cut_doubled_edges();
    take_fans();
  }

 private:
  static constexpr std::int64_t kGrain = 1 << 10;
  static constexpr std::size_t kCheckEvery = 1 << 14;

  std::uint32_t sides() const { return static_cast<std::uint32_t>(3 * faces_.size()); }
  std::uint32_t vertex(std::uint32_t side) const { return soup_.triangles[side / 3][side % 3]; }
  bool is_singular(std::uint32_t side) const { return workspace_.singular[vertex(side)] != 0; }
  std::uint32_t start(std::uint32_t side) const { return corner_[side]; }
  std::uint32_t end(std::uint32_t side) const { return corner_[next_side(side)]; }

  /// The corners at singular vertices, vertex by vertex, and the places of their faces.
  void gather_corners() {
    const std::size_t vertices = workspace_.point_of.size();
    std::vector<std::uint32_t> next(vertices, 0);
    std::uint32_t count = 0;
    for (std::size_t v = 0; v < vertices; ++v) {
      if (workspace_.singular[v] == 0) continue;
      next[v] = count;
      first_.push_back(count);
      count += workspace_.first[v + 1] - workspace_.first[v];
    }
    first_.push_back(count);
    corners_.resize(count);
    workspace_.place.resize(4 * std::size_t{solid_.complement.size()});
    corner_.resize(sides());
    for (std::uint32_t k = 0; k < faces_.size(); ++k) {
      for (std::uint32_t c = 0; c < 3; ++c) {
        const std::uint32_t v = soup_.triangles[k][c];
        corner_[3 * k + c] = workspace_.point_of[v];
        if (workspace_.singular[v] == 0) continue;
        corners_[next[v]++] = 3 * k + c;
        workspace_.place[faces_[k]] = k;
      }
    }
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
    glued_.assign(sides(), kNone);
    parallel_for(context_, 0, std::ssize(first_) - 1, kGrain, [&](std::int64_t begin, std::int64_t end) {
      std::vector<std::uint64_t> around;
      for (auto v = static_cast<std::size_t>(begin); v < static_cast<std::size_t>(end); ++v) {
        glue_around(std::span(corners_).subspan(first_[v], first_[v + 1] - first_[v]), around);
      }
    });
    for (const std::uint32_t corner : corners_) {
      if (glued_[corner] == kNone) singular_.push_back(corner);
    }
  }

  /// Glues the two sides of every edge at a vertex that has no third one, from the edge's smaller end or its only
  /// singular one.
  void glue_around(std::span<const std::uint32_t> corners, std::vector<std::uint64_t>& around) {
    around.clear();  // the other end of each side, and the side
    const std::uint32_t here = start(corners[0]);
    const auto add = [&](std::uint32_t other_end, std::uint32_t side) {
      const std::uint32_t there = start(other_end);
      if (there > here || !is_singular(other_end)) around.push_back(std::uint64_t{there} << 32 | side);
    };
    for (const std::uint32_t corner : corners) {
      add(next_side(corner), corner);
      add(previous_side(corner), previous_side(corner));
    }
    std::ranges::sort(around);
    for (std::size_t i = 0; i < around.size();) {
      std::size_t next = i + 1;
      while (next < around.size() && around[next] >> 32 == around[i] >> 32) ++next;
      if (next == i + 2) {
        const auto one = static_cast<std::uint32_t>(around[i]);
        const auto other = static_cast<std::uint32_t>(around[i + 1]);
        glued_[one] = other;
        glued_[other] = one;
      }
      i = next;
    }
  }

  /// The other side of a wedge runs against the one: from the smaller end to the larger one all wedges are met, once.
  void glue_wedges() {
    parallel_for(context_, 0, std::ssize(singular_), kGrain, [&](std::int64_t begin, std::int64_t end) {
      for (auto s = static_cast<std::size_t>(begin); s < static_cast<std::size_t>(end); ++s) {
        const std::uint32_t side = singular_[s];
        if (start(side) > this->end(side)) continue;
        const std::uint32_t third = start(previous_side(side));
        std::uint32_t twin = 3 * workspace_.place[across_wedge(faces_[side / 3], start(side), this->end(side), third)];
        while (start(twin) != this->end(side)) ++twin;
        glued_[side] = twin;
        glued_[twin] = side;
      }
    });
  }

  /// Vertices of the surface: corners that follow one another around a point.
  void number_fans() {
    fan_.assign(sides(), kNone);
    std::vector<std::uint32_t> whole(workspace_.point_of.size(), kNone);  // of vertices that are one fan
    for (std::uint32_t corner = 0; corner < sides(); ++corner) {
      if (!is_singular(corner)) {
        std::uint32_t& fan = whole[vertex(corner)];
        if (fan == kNone) fan = new_fan(corner);
        fan_[corner] = fan;
        continue;
      }
      if (fan_[corner] != kNone) continue;
      number_fan(corner);
    }
  }

  std::uint32_t new_fan(std::uint32_t corner) {
    soup_.positions.push_back(solid_.complement.points[start(corner)]);
    return static_cast<std::uint32_t>(soup_.positions.size()) - 1;
  }

  /// Gives the fan of a corner a number of its own.
  void number_fan(std::uint32_t corner) {
    const std::uint32_t fan = new_fan(corner);
    std::uint32_t around = corner;
    do {
      fan_[around] = fan;
      around = next_around(around);
    } while (around != corner);
  }

  /// Two pairs of sides between the same vertices of the surface make an edge with four triangles. Exchanging partners
  /// cuts each end in two: as its fan passes the edge twice, it falls apart into what lies between. That never makes
  /// another pair of edges double, so every edge is looked at once.
  void cut_doubled_edges() {
    struct Side {
      std::uint64_t edge = 0;
      std::uint32_t side = 0;
      auto operator<=>(const Side&) const = default;
    };
    std::vector<Side> sorted;  // by their edges, from the smaller end; their twins stay out
    for (const std::uint32_t side : singular_) {
      if (start(side) < end(side)) sorted.push_back({std::uint64_t{start(side)} << 32 | end(side), side});
    }
    std::ranges::sort(sorted);
    std::vector<std::uint32_t> around;
    for (std::size_t first = 0; first < sorted.size();) {
      around.clear();
      std::size_t last = first;
      for (; last < sorted.size() && sorted[last].edge == sorted[first].edge; ++last) {
        around.push_back(sorted[last].side);
      }
      if (first / kCheckEvery != last / kCheckEvery) context_.check_cancelled();
      while (cut_one(around)) {
      }
      first = last;
    }
  }

  /// Of the sides along one edge. True when two had the same ends and were cut apart.
  bool cut_one(std::span<std::uint32_t> around) {
    if (around.size() < 2) return false;
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
    number_fan(shorter);
  }

  void take_fans() {
    for (std::uint32_t corner = 0; corner < sides(); ++corner) {
      soup_.triangles[corner / 3][corner % 3] = fan_[corner];
    }
  }

  const CarvedSolid& solid_;
  const std::vector<std::uint32_t>& faces_;
  LevelWorkspace& workspace_;
  const RunContext& context_;
  TriangleSoup& soup_;
  std::vector<std::uint32_t> corner_;    ///< point at which each side starts
  std::vector<std::uint32_t> corners_;   ///< at singular vertices
  std::vector<std::uint32_t> first_;     ///< of each singular vertex, in corners_
  std::vector<std::uint32_t> glued_;     ///< the side that each side is glued to
  std::vector<std::uint32_t> fan_;       ///< vertex of the surface at which each side starts
  std::vector<std::uint32_t> singular_;  ///< sides at edges of more than two faces
};

}  // namespace

void cut_fans(const CarvedSolid& solid, const std::vector<std::uint32_t>& faces, LevelWorkspace& workspace,
              const RunContext& context, TriangleSoup& soup) {
  FanCutter(solid, faces, workspace, context, soup).run();
}

}  // namespace voxcarve
