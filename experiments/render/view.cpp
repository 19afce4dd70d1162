#include "experiments/render/view.h"

#include <cmath>
#include <numbers>

namespace voxcarve {

ViewFrame view_direction(const RenderOptions& options) {
  return ViewFrame::from_angles(options.azimuth, options.elevation, options.up_axis);
}

double half_angle_tangent(const RenderOptions& options) {
  return std::tan(options.view_angle / 2 * std::numbers::pi / 180);
}

double pixels_at_own_length(const RenderOptions& options, int height) {
  return height / (2 * half_angle_tangent(options));
}

}  // namespace voxcarve
