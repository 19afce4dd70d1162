// CGAL 5.5: Garland-Heckbert reduction.
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Bounded_normal_change_placement.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Count_stop_predicate.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/GarlandHeckbert_plane_policies.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>

#include <memory>

#include "experiments/benchmarks/peers.h"

namespace voxcarve::bench {

namespace {

namespace simplification = CGAL::Surface_mesh_simplification;
using Kernel = CGAL::Simple_cartesian<double>;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;

Mesh to_cgal(const TriangleSoup& soup) {
  Mesh mesh;
  for (const Point& p : soup.positions) mesh.add_vertex({p[0], p[1], p[2]});
  for (const Triangle& t : soup.triangles) {
    mesh.add_face(Mesh::Vertex_index(t[0]), Mesh::Vertex_index(t[1]), Mesh::Vertex_index(t[2]));
  }
  return mesh;
}

TriangleSoup to_soup(Mesh& mesh) {
  mesh.collect_garbage();
  TriangleSoup soup;
  for (const auto vertex : mesh.vertices()) {
    const auto& p = mesh.point(vertex);
    soup.positions.emplace_back(p.x(), p.y(), p.z());
  }
  for (const auto face : mesh.faces()) {
    Triangle triangle{};
    std::size_t corner = 0;
    for (const auto vertex : mesh.vertices_around_face(mesh.halfedge(face))) triangle.at(corner++) = vertex;
    soup.triangles.push_back(triangle);
  }
  return soup;
}

}  // namespace

ReducingPeer cgal_reduction(const TriangleSoup& soup, std::int64_t triangles) {
  auto input = std::make_shared<const Mesh>(to_cgal(soup));
  return [input, triangles] {
    using Policies = simplification::GarlandHeckbert_plane_policies<Mesh, Kernel>;
    using Placement = simplification::Bounded_normal_change_placement<Policies::Get_placement>;
    Mesh mesh = *input;
    // Of a closed surface every edge belongs to two triangles, and every triangle has three edges.
    const simplification::Count_stop_predicate<Mesh> stop(static_cast<std::size_t>(triangles + triangles / 2 + 1));
    const auto made = timed([&] {
      const Policies policies(mesh);
      return simplification::edge_collapse(
          mesh, stop,
          CGAL::parameters::get_cost(policies.get_cost()).get_placement(Placement(policies.get_placement())));
    });
    return Timed<TriangleSoup>{made.seconds, to_soup(mesh)};
  };
}

}  // namespace voxcarve::bench
