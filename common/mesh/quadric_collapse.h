// The loop of the quadric reduction: which edge collapses next, and onto which point.
#pragma once

#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "common/mesh/corner_table.h"
#include "common/mesh/cost_buckets.h"
#include "common/mesh/quadric.h"

namespace voxcarve {

/// What a collapse does, for whoever watches; positions in the units of the mesh.
template <int N>
struct QuadricCollapseEvent {
  std::uint32_t start = 0;  ///< vertex that stays
  std::uint32_t end = 0;    ///< vertex that goes
  typename Quadric<N>::Vector point;
  double cost = 0;
};

/// A manifold that loses edges one by one. The cost of an edge is the least value of the sum Q of the quadrics at its
/// ends. Edges come in the order of Q / sqrt(W), where W is the sum's trace, the weight of the planes in it: the order
/// of Q^2 / W, the fourth power of the distance summed over the weight. By Q alone small parts give way to large ones
/// however far they move.
///
/// Evaluation is lazy: a collapse only marks the edges around it, and a marked edge is evaluated and put back into the
/// queue when its turn comes. Q is a sum of functions that are nowhere negative, so it only rises, and but for W the
/// turn would come too early, never too late; W makes it late by no more than the square root of its growth. Edges that
/// were refused come back when one of their ends has changed and at the start of a round; in the last rounds also when
/// a vertex next to an end has.
///
/// Collapses run in rounds that each halve the triangles and then close the gaps in memory. The last rounds order
/// priorities to a sixteenth of an octave, the ones before, most of whose collapses any order would make, to half an
/// octave or four: edges that come at once come in the order of memory, which halves their time and leaves the error as
/// it is.
template <int N>
class QuadricCollapse {
 public:
  using Vector = typename Quadric<N>::Vector;

  /// Per vertex of `table`: a point (position, then attributes) and the quadric about it. Coordinates of the order
  /// of 1.
  QuadricCollapse(CornerTable table, std::vector<Vector> points, std::vector<Quadric<N>> quadrics);

  /// Per vertex: a colour that is interpolated along collapsed edges, without a part in the error. Empty by default.
  std::vector<Color> carried_colors;
  /// Called before each collapse. Vertices are those of the round; `table` is that of the round too.
  std::function<void(const CornerTable& table, const QuadricCollapseEvent<N>&)> watcher;

  /// Until at most so many triangles are left or none may go. A number that cannot be reached costs quality: every
  /// collapse that is still allowed is made then, whatever its error, and the rounds before are as coarse as the number
  /// lets them be where components alone (a triangle each, four of a closed one) do not tell. Throws Cancelled.
  void run(std::uint32_t triangles, Stage& stage);

  /// Bytes at the peak, the table and carried colours included.
  static std::uint64_t memory_estimate(std::size_t triangles, std::size_t vertices) {
    // Three edges to two triangles: in buckets that may be half full and, at worst, grow to twice their size while all
    // the edges of a sweep come back to them.
    constexpr std::size_t kQueued = 8;
    return CornerTable::memory(triangles, vertices) + CornerTable::compact_memory(triangles, vertices) +
           triangles * (1 + kQueued) * sizeof(std::uint32_t) +
           vertices * (sizeof(Vector) + sizeof(Quadric<N>) + sizeof(std::uint32_t) + sizeof(Color));
  }

  const CornerTable& table() const { return table_; }
  const Vector& point(std::uint32_t vertex) const { return points_[vertex]; }
  const Quadric<N>& quadric(std::uint32_t vertex) const { return quadrics_[vertex]; }
  /// The vertex that lay at first where this one lies now, or kNone where it moved.
  std::uint32_t vertex_source(std::uint32_t vertex) const { return vertex_source_[vertex]; }
  /// The number of the triangle at first.
  std::uint32_t triangle_source(std::uint32_t triangle) const { return triangle_source_[triangle]; }

 private:
  enum Mark : std::uint8_t {
    kQueued = 1,  ///< stands in a bucket
    kStale = 2,   ///< its priority is out of date
    kRefused = 4  ///< had its turn and was not allowed to collapse
  };
  /// The sum of two vertices' quadrics about the middle of their edge, and where the merged vertex goes.
  struct Merger {
    Quadric<N> sum;
    Vector half;   ///< from the middle to the end
    Vector step;   ///< from the middle to the merged vertex
    Vector point;  ///< the merged vertex
    double cost = 0;
  };

  Merger merger(std::uint32_t half_edge) const;
  double priority(std::uint32_t half_edge) const;
  Vector best_of_ends_and_middle(const Merger& merger) const;
  bool is_allowed(std::uint32_t half_edge, const Vector& point);
  bool turns_triangle(const CornerTable::Ring& ring, std::uint32_t other_end, const Vector& point) const;
  void collapse(std::uint32_t half_edge, const Merger& merger);
  void put_on_end(std::uint32_t half_edge, Merger& merger) const;
  void carry_color(std::uint32_t start, std::uint32_t end, const Vector& point);
  std::uint32_t least_triangles() const;
  void fill_queue(Stage& stage);
  void visit(std::uint32_t half_edge);
  void requeue(std::uint32_t edge);
  void requeue_around(std::uint32_t vertex);
  void requeue_refused();
  void requeue_refused_near(std::uint32_t vertex);
  void run_round(std::uint32_t goal, int coarseness, Stage& stage);
  void compact();

  CornerTable table_;
  std::vector<Vector> points_;
  std::vector<Quadric<N>> quadrics_;
  std::vector<std::uint32_t> vertex_source_;
  std::vector<std::uint32_t> triangle_source_;
  CostBuckets queue_;
  bool has_boundary_ = false;
  bool last_rounds_ = false;
  CornerTable::Ring start_ring_, end_ring_;  ///< of the edge that is looked at
};

extern template class QuadricCollapse<3>;
extern template class QuadricCollapse<6>;

}  // namespace voxcarve
