// A perspective camera that holds a set of points as tightly as it can. Knows no graphics library.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <string_view>

namespace voxcarve {

/// The direction of a view as an orthonormal right-handed frame.
struct ViewFrame {
  Eigen::Vector3d right, up, back;  ///< `back` points from the scene to the camera

  /// From angles in degrees as in RenderOptions; `up_axis` is "y" or "z".
  static ViewFrame from_angles(double azimuth, double elevation, std::string_view up_axis);
};

struct FittedCamera {
  Eigen::Vector3d position;
  double nearest = 0;   ///< distance along the view of the nearest point, positive
  double farthest = 0;  ///< and of the farthest
};

/// Finds the closest camera of a given direction that sees all points. For a frustum of fixed direction and opening
/// each of the four side planes asks for the extreme point along its normal only, so that the answer is exact and takes
/// one pass over the points.
class CameraFitter {
 public:
  /// `tangent_x`, `tangent_y`: tangents of half the opening angles that the points may fill.
  CameraFitter(const ViewFrame& frame, double tangent_x, double tangent_y)
      : frame_(frame), tangent_x_(tangent_x), tangent_y_(tangent_y) {}

  void add(const Eigen::Vector3d& point);

  /// Without any point: a camera that looks at the origin from a distance of a few units.
  FittedCamera fit() const;

 private:
  static constexpr double kNone = -std::numeric_limits<double>::infinity();

  ViewFrame frame_;
  double tangent_x_, tangent_y_;
  double right_ = kNone, left_ = kNone, top_ = kNone, bottom_ = kNone;  ///< extremes along the side planes' normals
  double front_ = kNone, rear_ = kNone;  ///< greatest depth towards and away from the camera
};

}  // namespace voxcarve
