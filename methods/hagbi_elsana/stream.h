// The multiresolution stream of a carved complement [HE10, 3]: any level, in time linear in its size.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/run/context.h"
#include "methods/hagbi_elsana/carving.h"
#include "methods/hagbi_elsana/complement.h"

namespace voxcarve {

/// What is left of the hull after each step: C_0, the hull, to C_n, the model with the folds of its open parts and the
/// voids that were left shut. Queries are const and may run on several threads at once.
///
/// A face of a tetrahedron lies on the boundary of C_i, seen from within the tetrahedron, from the step that carves it
/// until the one that carves its neighbour; for ever, if it lies in the model. Faces are kept in the order in which
/// they come; lists of all faces at some steps, one whenever as many have come since the last as there are, make
/// extraction linear in what is extracted and take no more memory than the faces themselves.
class CarvingStream {
 public:
  /// `step` is what `carve` gives; `provenance` is any text, kept with the stream. Throws InputError when `step`
  /// has not one entry a tetrahedron, is not 0 of ghosts and only of these, or is too large; ResourceError and
  /// Cancelled.
  CarvingStream(Complement complement, std::vector<std::uint32_t> step, std::string provenance, RunContext& context);

  /// Number of C_n; steps run from 0 to it.
  std::uint32_t last_step() const { return last_step_; }
  /// Distinct positions of C_i's vertices.
  std::uint32_t vertices(std::uint32_t step) const { return vertices_[step]; }
  std::uint32_t triangles(std::uint32_t step) const { return triangles_[step]; }
  /// Components of the closed set C_i, of which those that touch in a vertex are one, for every step. They never grow
  /// fewer. In O(s) for s tetrahedra.
  std::vector<std::uint32_t> closed_components(const RunContext& context) const;

  /// The last steps before another vertex comes, with the first and the last: 0 = levels()[0] < ... < last_step().
  const std::vector<std::uint32_t>& levels() const { return levels_; }
  /// The last step before there are more vertices, or triangles, than that for the first time; 0 where even the hull
  /// has more. Triangles may grow fewer again later on.
  std::uint32_t step_for_vertices(std::int64_t most) const;
  std::uint32_t step_for_triangles(std::int64_t most) const;

  /// The boundary of C_i as a closed, oriented 2-manifold. Where more than two faces meet in an edge, two that bound
  /// the same wedge of the outside are joined: so folds hold together along their walls. Then vertices are cut into one
  /// copy a fan [GTLH98]. Where two pairs still have both ends in common, they exchange partners, which cuts these
  /// ends: two bodies that touch in an edge come apart, and so do the triangles of a sheet that is one triangle wide,
  /// for no closed simplicial surface has both their sides.
  TriangleSoup extract(std::uint32_t step, const RunContext* context = nullptr) const;

  const Complement& complement() const { return complement_; }
  const std::vector<std::uint32_t>& steps() const { return step_; }
  const std::string& provenance() const { return provenance_; }

  /// Bytes that a stream takes at most, beside what it is made of.
  static std::uint64_t memory(std::size_t tetrahedra);

 private:
  static constexpr std::uint32_t kForEver = 0xffffffffU;
  struct ScratchPool;

  /// Face i of tetrahedron t is 4 t + i.
  struct Face {
    std::uint32_t face = 0;
    std::uint32_t death = 0;  ///< the step with which it goes
  };

  std::uint32_t death(std::uint32_t face) const {
    const std::uint32_t t = face / 4;
    const auto i = static_cast<int>(face % 4);
    return complement_.is_barrier(t, i) ? kForEver : step_[complement_.neighbors[t][static_cast<std::size_t>(i)]];
  }
  void check_steps() const;
  std::vector<std::uint32_t> carved_in_order(std::vector<std::uint32_t>& first_of_step) const;
  void follow_steps(RunContext& context);
  void keep_lists();
  template <class Put>
  std::size_t copy_faces(std::uint32_t step, const Put& put) const;

  Complement complement_;
  std::vector<std::uint32_t> step_;
  std::string provenance_;
  std::uint32_t last_step_ = 0;
  std::vector<Face> order_;                 ///< in the order in which they come
  std::vector<std::size_t> first_of_step_;  ///< in order_; last_step_ + 2 of them
  std::vector<std::uint32_t> vertices_;
  std::vector<std::uint32_t> triangles_;
  std::vector<std::uint32_t> levels_;
  /// All faces of a step.
  struct List {
    std::uint32_t step = 0;
    std::size_t begin = 0, end = 0;  ///< in listed_
  };
  std::vector<List> lists_;
  std::vector<Face> listed_;
  std::shared_ptr<ScratchPool> pool_;
};

}  // namespace voxcarve
