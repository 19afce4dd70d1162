// Which peers were built in, and stand-ins for those that were not. The definitions come from CMakeLists.txt.
#include "experiments/benchmarks/peers.h"

namespace voxcarve::bench {

PeersAtHand peers_at_hand() {
  PeersAtHand at_hand;
#ifdef VOXCARVE_PEER_VTK
  at_hand.vtk = true;
#endif
#ifdef VOXCARVE_PEER_OPENVDB
  at_hand.openvdb = true;
#endif
#ifdef VOXCARVE_PEER_ITK
  at_hand.itk = true;
#endif
#ifdef VOXCARVE_PEER_MESHOPTIMIZER
  at_hand.meshoptimizer = true;
#endif
  return at_hand;
}

#ifndef VOXCARVE_PEER_VTK
CountingPeer vtk_voxelization(const TriangleSoup&, const GridFrame&) {
  return {};
}

CountingPeer vtk_isosurface(const Grid<float>&, float, int) {
  return {};
}

std::string vtk_smp_backend() {
  return "";
}
#endif

#ifndef VOXCARVE_PEER_OPENVDB
CountingPeer openvdb_voxelization(const TriangleSoup&, const GridFrame&, int) {
  return {};
}
#endif

#ifndef VOXCARVE_PEER_ITK
FilteringPeer itk_opening(const BinaryVolume&, std::int64_t, int) {
  return {};
}

DistancePeer itk_squared_distance(const BinaryVolume&, int) {
  return {};
}

CountingPeer itk_labelling(const BinaryVolume&, int) {
  return {};
}

FieldPeer itk_gaussian(const Grid<float>&, double, int) {
  return {};
}
#endif

#ifndef VOXCARVE_PEER_MESHOPTIMIZER
ReducingPeer meshoptimizer_reduction(const TriangleSoup&, std::int64_t) {
  return {};
}
#endif

}  // namespace voxcarve::bench
