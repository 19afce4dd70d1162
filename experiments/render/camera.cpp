#include "experiments/render/camera.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace voxcarve {

namespace {

constexpr double kLeastDistance = 0.05;  ///< of the nearest point from the camera, in units of the scene

}  // namespace

ViewFrame ViewFrame::from_angles(double azimuth, double elevation, std::string_view up_axis) {
  const double a = azimuth * std::numbers::pi / 180;
  const double e = elevation * std::numbers::pi / 180;
  // With side, height and front for x, y and z: closed forms, which hold at the poles too.
  ViewFrame frame{{std::cos(a), 0, -std::sin(a)},
                  {-std::sin(a) * std::sin(e), std::cos(e), -std::cos(a) * std::sin(e)},
                  {std::sin(a) * std::cos(e), std::sin(e), std::cos(a) * std::cos(e)}};
  if (up_axis == "z") {
    for (Eigen::Vector3d* axis : {&frame.right, &frame.up, &frame.back}) *axis = {axis->x(), -axis->z(), axis->y()};
  }
  return frame;
}

void CameraFitter::add(const Eigen::Vector3d& point) {
  const double x = frame_.right.dot(point);
  const double y = frame_.up.dot(point);
  const double z = frame_.back.dot(point);
  // A point is seen from (cx, cy, d) when |x - cx| <= tangent_x * (d - z), and likewise for y.
  right_ = std::max(right_, x + tangent_x_ * z);
  left_ = std::max(left_, -x + tangent_x_ * z);
  top_ = std::max(top_, y + tangent_y_ * z);
  bottom_ = std::max(bottom_, -y + tangent_y_ * z);
  front_ = std::max(front_, z);
  rear_ = std::max(rear_, -z);
}

FittedCamera CameraFitter::fit() const {
  if (front_ == kNone) return {4 * frame_.back, 3, 5};
  const double distance =
      std::max({(right_ + left_) / (2 * tangent_x_), (top_ + bottom_) / (2 * tangent_y_), front_ + kLeastDistance});
  const Eigen::Vector3d position =
      (right_ - left_) / 2 * frame_.right + (top_ - bottom_) / 2 * frame_.up + distance * frame_.back;
  return {position, distance - front_, distance + rear_};
}

}  // namespace voxcarve
