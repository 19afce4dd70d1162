// Based on OpenMesh's DecimaterT and ModQuadricT; differs in a flip check of its own (ModNormalFlippingT did not finish
// on a million triangles) and in cutting non-manifold input first.
#include "common/mesh/reduction.h"

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Core/System/omstream.hh>
#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModQuadricT.hh>
#include <OpenMesh/Tools/Decimater/Observer.hh>
#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include "common/mesh/topology.h"
#include "common/run/errors.h"

namespace voxcarve {

namespace {

struct DoubleTraits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
  using Normal = OpenMesh::Vec3d;
};
using HalfEdgeMesh = OpenMesh::TriMesh_ArrayKernelT<DoubleTraits>;
using Decimater = OpenMesh::Decimater::DecimaterT<HalfEdgeMesh>;

/// Forbids collapses that turn a triangle by more than a right angle or take its area.
template <class MeshT>
class FlipCheck : public OpenMesh::Decimater::ModBaseT<MeshT> {
 public:
  DECIMATING_MODULE(FlipCheck, MeshT, FlipCheck);
  explicit FlipCheck(MeshT& mesh) : Base(mesh, true) {}

  float collapse_priority(const CollapseInfo& collapse) override {
    const MeshT& mesh = Base::mesh();
    for (auto corner = mesh.cvoh_iter(collapse.v0); corner.is_valid(); ++corner) {
      const auto face = mesh.face_handle(*corner);
      if (!face.is_valid() || face == collapse.fl || face == collapse.fr) continue;
      const OpenMesh::Vec3d b = mesh.point(mesh.to_vertex_handle(*corner));
      const OpenMesh::Vec3d c = mesh.point(mesh.to_vertex_handle(mesh.next_halfedge_handle(*corner)));
      const OpenMesh::Vec3d before = OpenMesh::cross(b - collapse.p0, c - collapse.p0);
      const OpenMesh::Vec3d after = OpenMesh::cross(b - collapse.p1, c - collapse.p1);
      const bool was_degenerate = before.sqrnorm() == 0;
      if (after.sqrnorm() == 0 || (!was_degenerate && OpenMesh::dot(before, after) <= 0))
        return float(Base::ILLEGAL_COLLAPSE);
    }
    return float(Base::LEGAL_COLLAPSE);
  }
};

/// Passes progress on and stops the decimater on request.
class ProgressObserver : public OpenMesh::Decimater::Observer {
 public:
  ProgressObserver(Stage& stage, const RunContext& context)
      : OpenMesh::Decimater::Observer(kInterval), stage_(stage), context_(context) {}
  void notify(std::size_t) override {
    if (!abort()) stage_.advance(2 * static_cast<std::int64_t>(kInterval));  // a collapse removes two triangles
  }
  bool abort() const override { return context_.cancellation.stop_requested(); }

 private:
  static constexpr std::size_t kInterval = 256;
  Stage& stage_;
  const RunContext& context_;
};

/// Moves the soup to the unit box, so that quadrics of models of any size and place have their digits.
HalfEdgeMesh to_half_edges(const TriangleSoup& soup, const Point& center, double scale) {
  HalfEdgeMesh mesh;
  mesh.reserve(soup.positions.size(), soup.triangles.size() * 3 / 2, soup.triangles.size());
  for (const Point& position : soup.positions) {
    const Point p = (position - center) / scale;
    mesh.add_vertex(OpenMesh::Vec3d(p[0], p[1], p[2]));
  }
  for (const Triangle& t : soup.triangles) {
    const auto face = mesh.add_face(HalfEdgeMesh::VertexHandle(static_cast<int>(t[0])),
                                    HalfEdgeMesh::VertexHandle(static_cast<int>(t[1])),
                                    HalfEdgeMesh::VertexHandle(static_cast<int>(t[2])));
    if (!face.is_valid()) throw MethodFailure("the surface could not be made a half-edge mesh for its reduction");
  }
  return mesh;
}

TriangleSoup to_soup(HalfEdgeMesh& mesh, const Point& center, double scale) {
  mesh.garbage_collection();
  TriangleSoup soup;
  soup.positions.reserve(mesh.n_vertices());
  for (const auto vertex : mesh.vertices()) {
    const OpenMesh::Vec3d& p = mesh.point(vertex);
    soup.positions.push_back(center + scale * Point(p[0], p[1], p[2]));
  }
  for (const auto face : mesh.faces()) {
    Triangle triangle{};
    std::size_t corner = 0;
    for (const auto vertex : face.vertices()) triangle.at(corner++) = static_cast<std::uint32_t>(vertex.idx());
    soup.triangles.push_back(triangle);
  }
  remove_unused_vertices(soup);
  return soup;
}

}  // namespace

TriangleSoup reduce_openmesh(const TriangleSoup& soup, std::int64_t triangles, RunContext& context) {
  const auto before = static_cast<std::int64_t>(soup.triangles.size());
  if (before <= triangles) return soup;
  Stage stage(context, "reduction", before - triangles);
  omerr().disable();
  const TriangleSoup manifold = cut_to_manifold(soup);
  if (manifold.positions.size() > soup.positions.size()) {
    context.notice("the surface was cut at singular edges and vertices before its reduction: " +
                   std::to_string(soup.positions.size()) + " vertices became " +
                   std::to_string(manifold.positions.size()));
  }
  // Roughly what half-edge connectivity, status, quadrics and the heap take for a triangle.
  constexpr std::uint64_t kBytesPerTriangle = 400;
  context.require_memory(manifold.triangles.size() * kBytesPerTriangle, "the reduction");

  const Box box = bounds(manifold);
  const double scale = std::max(box.diagonal(), std::numeric_limits<double>::min());
  HalfEdgeMesh mesh = to_half_edges(manifold, box.center(), scale);
  ProgressObserver observer(stage, context);
  Decimater decimater(mesh);
  OpenMesh::Decimater::ModQuadricT<HalfEdgeMesh>::Handle quadric;
  decimater.add(quadric);
  decimater.module(quadric).unset_max_err();
  FlipCheck<HalfEdgeMesh>::Handle flip_check;
  decimater.add(flip_check);
  decimater.set_observer(&observer);
  if (!decimater.initialize()) throw MethodFailure("OpenMesh's decimater refused the surface");
  decimater.decimate_to_faces(0, static_cast<std::size_t>(triangles));
  context.check_cancelled();

  TriangleSoup reduced = to_soup(mesh, box.center(), scale);
  if (static_cast<std::int64_t>(reduced.triangles.size()) > triangles) {
    context.notice("the reduction stopped at " + std::to_string(reduced.triangles.size()) + " triangles, above the " +
                   std::to_string(triangles) +
                   " asked for: no further edge may collapse without changing the topology or flipping a triangle");
  }
  return reduced;
}

}  // namespace voxcarve
