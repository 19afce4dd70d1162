// The part of the model that a picture shows, and the camera that holds it. Knows no graphics library.
#pragma once

#include "experiments/render/camera.h"
#include "experiments/render/display_mesh.h"
#include "experiments/render/render.h"

namespace voxcarve {

struct View {
  UnitFrame frame;
  FittedCamera camera;  ///< in the unit frame

  /// Distance of a point of the model from the camera along the view, in model units.
  double depth(const Point& point, const ViewFrame& direction) const {
    return frame.half_extent * direction.back.dot(camera.position - frame.to_unit(point));
  }
};

/// The direction of the view that the options ask for.
ViewFrame view_direction(const RenderOptions& options);

/// Tangent of half the vertical opening angle.
double half_angle_tangent(const RenderOptions& options);

/// Pixels that a length facing the camera takes in a scene of `height` pixels, at a distance along the view that is as
/// long as itself.
double pixels_at_own_length(const RenderOptions& options, int height);

/// The closest camera for scenes of `width` x `height` pixels that holds the points which `for_each(visit)` passes to
/// `visit`, twice.
template <class ForEach>
View fit_view(const RenderOptions& options, int width, int height, const ForEach& for_each) {
  constexpr double kFilledShare = 0.92;  ///< of the scene's width or height, by the points
  Box box;
  for_each([&box](const Point& point) { box.extend(point); });
  const UnitFrame frame = UnitFrame::of(box);
  const double tangent = kFilledShare * half_angle_tangent(options);
  CameraFitter fitter(view_direction(options), tangent * width / height, tangent);
  for_each([&](const Point& point) { fitter.add(frame.to_unit(point)); });
  return {frame, fitter.fit()};
}

}  // namespace voxcarve
