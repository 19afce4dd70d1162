// OpenVDB 10: solid voxelization through a level set.
#include <openvdb/openvdb.h>
#include <openvdb/tools/Dense.h>
#include <openvdb/tools/LevelSetUtil.h>
#include <openvdb/tools/MeshToVolume.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <memory>

#include "experiments/benchmarks/peers.h"

namespace voxcarve::bench {

namespace {

/// A mesh in index space, where voxel (i, j, k) is at (i, j, k): what meshToVolume asks for.
struct IndexSpaceMesh {
  std::vector<openvdb::Vec3d> points;
  std::vector<Triangle> triangles;

  std::size_t polygonCount() const { return triangles.size(); }
  std::size_t pointCount() const { return points.size(); }
  std::size_t vertexCount(std::size_t) const { return 3; }
  void getIndexSpacePoint(std::size_t polygon, std::size_t corner, openvdb::Vec3d& point) const {
    point = points[triangles[polygon][corner]];
  }
};

}  // namespace

CountingPeer openvdb_voxelization(const TriangleSoup& soup, const GridFrame& frame, int threads) {
  openvdb::initialize();
  auto mesh = std::make_shared<IndexSpaceMesh>();
  mesh->triangles = soup.triangles;
  for (const Point& position : soup.positions) {
    const Point p = (position - frame.center(Index3::Zero())) / frame.voxel_size;
    mesh->points.emplace_back(p[0], p[1], p[2]);
  }
  return [mesh, frame, threads] {
    constexpr float kBandWidth = 1;
    const openvdb::math::Transform::Ptr transform = openvdb::math::Transform::createLinearTransform(1.0);
    using Mask = openvdb::tools::Dense<unsigned char, openvdb::tools::LayoutXYZ>;
    const Index3 last = frame.dims - Index3::Ones();
    const openvdb::CoordBBox box({0, 0, 0},
                                 {static_cast<int>(last[0]), static_cast<int>(last[1]), static_cast<int>(last[2])});
    tbb::task_arena arena(threads);
    const auto made = timed([&] {
      return arena.execute([&] {
        const auto distances =
            openvdb::tools::meshToVolume<openvdb::FloatGrid>(*mesh, *transform, kBandWidth, kBandWidth);
        const auto interior = openvdb::tools::sdfInteriorMask(*distances);
        auto mask = std::make_unique<Mask>(box);
        openvdb::tools::copyToDense(*interior, *mask);
        return mask;
      });
    });
    const unsigned char* voxels = made.result->data();
    return Timed<std::int64_t>{made.seconds, std::count(voxels, voxels + frame.voxels(), 1)};
  };
}

}  // namespace voxcarve::bench
