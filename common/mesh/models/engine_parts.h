// The parts of the model `engine`, outside and inside. x runs along the crankshaft to the back, y to the left bank, z
// up; the crankshaft's axis is the x axis. One unit is about ten centimetres.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <vector>

#include "common/mesh/triangle_soup.h"

namespace voxcarve {

/// What the parts are added to.
class EngineAssembly {
 public:
  explicit EngineAssembly(double detail);

  /// Segments of a part that has `base` of them at detail 1; counts go with the square root of the detail.
  int segments(int base) const;
  void add(TriangleSoup part, const Color& color);

  TriangleSoup soup;
  /// The first triangle of every sheet-metal part, which gets T-joints and zero-area faces, and the number of
  /// triangles.
  std::vector<std::array<std::size_t, 2>> castings;
  /// As `add`, for a part that gets such defects.
  void add_casting(TriangleSoup part, const Color& color);

 private:
  double segment_factor_;
};

/// Where a bank's cylinders stand along x: one of four, for side 1 (left) or -1 (right, a little further back).
double cylinder_x(int cylinder, int side);

/// Puts a part of a bank in place: its local z is the cylinders' direction away from the crankshaft, 45 degrees off the
/// vertical, its local y points outward and down. The right bank is the mirror image.
Eigen::Affine3d bank_frame(int side);

/// A horizontal rounded rectangle of a `layered` part.
struct Layer {
  double z;
  double width;  ///< along x
  double depth;  ///< along y
  double rounding;
  double x = 0;  ///< of its centre
  double y = 0;
};

/// The loft through layers from bottom to top.
TriangleSoup layered(const std::vector<Layer>& layers, int corner_segments);

void add_block(EngineAssembly& engine);
void add_heads(EngineAssembly& engine);
void add_intake(EngineAssembly& engine);
void add_exhaust(EngineAssembly& engine);
void add_ignition(EngineAssembly& engine);
void add_front_drive(EngineAssembly& engine);
void add_accessories(EngineAssembly& engine);
void add_interior(EngineAssembly& engine);

}  // namespace voxcarve
