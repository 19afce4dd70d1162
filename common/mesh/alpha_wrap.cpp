// Based on CGAL 5.5's Alpha_wrap_3 [AW22]; differs in lengths as shares of the diagonal, in moving the model to the
// unit box first, and in being cancellable.
#include "common/mesh/alpha_wrap.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/alpha_wrap_3.h>

#include <algorithm>
#include <array>
#include <string>

#include "common/run/errors.h"

namespace voxcarve {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using CgalMesh = CGAL::Surface_mesh<Kernel::Point_3>;

/// Lets a run be cancelled and reports the facets that the wrapping front looked at.
class WrapVisitor : public CGAL::Alpha_wraps_3::internal::Wrapping_default_visitor {
 public:
  WrapVisitor(Stage& stage, std::int64_t expected) : stage_(&stage), expected_(expected) {}

  template <class Wrapper, class Gate>
  void before_facet_treatment(const Wrapper&, const Gate&) {
    if (++seen_ % kInterval != 0) return;
    // How many facets there will be is not known: the bar nears its end without reaching it.
    if (seen_ + kInterval >= expected_) stage_->set_total(expected_ *= 2);
    stage_->advance(kInterval);
  }

 private:
  static constexpr std::int64_t kInterval = 1024;
  Stage* stage_;
  std::int64_t expected_;
  std::int64_t seen_ = 0;
};

TriangleSoup to_soup(const CgalMesh& mesh, const Point& center, double scale) {
  TriangleSoup soup;
  std::vector<std::uint32_t> index_of(mesh.num_vertices() + mesh.number_of_removed_vertices());
  for (const auto vertex : mesh.vertices()) {
    index_of[vertex.idx()] = static_cast<std::uint32_t>(soup.positions.size());
    const auto& p = mesh.point(vertex);
    soup.positions.push_back(center + scale * Point(p.x(), p.y(), p.z()));
  }
  for (const auto face : mesh.faces()) {
    Triangle triangle{};
    std::size_t corner = 0;
    for (const auto vertex : mesh.vertices_around_face(mesh.halfedge(face)))
      triangle.at(corner++) = index_of[vertex.idx()];
    soup.triangles.push_back(triangle);
  }
  return soup;
}

}  // namespace

TriangleSoup alpha_wrap(const TriangleSoup& soup, double alpha, double offset, RunContext& context) {
  const Box box = bounds(soup);
  const double scale = box.diagonal();
  std::vector<Kernel::Point_3> points;
  for (const Point& position : soup.positions) {
    const Point p = (position - box.center()) / scale;
    points.emplace_back(p[0], p[1], p[2]);
  }
  std::vector<std::array<std::size_t, 3>> faces;
  for (const Triangle& t : soup.triangles) {
    if (!is_degenerate(soup, t)) faces.push_back({t[0], t[1], t[2]});
  }
  if (faces.empty()) throw MethodFailure("alpha-wrap needs a triangle with an area");
  // Vertices of the wrap lie about alpha apart on a surface of a few squared diagonals; each takes its tetrahedra
  // along.
  constexpr double kBytesPerVertex = 4000;
  constexpr std::int64_t kFirstGuess = 1 << 16;
  Stage stage(context, "alpha wrap", kFirstGuess);
  context.require_memory(static_cast<std::uint64_t>(kBytesPerVertex * 4 / (alpha * alpha)) + 400 * faces.size(),
                         "alpha-wrap");
  WrapVisitor visitor(stage, kFirstGuess);
  CgalMesh mesh;
  try {
    CGAL::alpha_wrap_3(points, faces, alpha, offset, mesh, CGAL::parameters::default_values(),
                       CGAL::parameters::visitor(visitor));
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {
    throw MethodFailure(std::string("CGAL's Alpha_wrap_3 failed: ") + error.what());
  }
  context.check_cancelled();  // the visitor looks only once in a while
  return to_soup(mesh, box.center(), scale);
}

}  // namespace voxcarve
