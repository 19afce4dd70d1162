// An OpenGL context without a window system, and a VTK render window that draws into it. Scenes, slices and charts are
// built elsewhere and added to the window.
#pragma once

#include <memory>
#include <vector>

class vtkRenderWindow;

namespace voxcarve {

/// A picture buffer of fixed size. While it lives its context is current on the constructing thread, where it must be
/// used and destroyed; afterwards the context that was current before is so again. The EGL display stays initialised
/// for the life of the process, since other users of it may exist.
class OffscreenWindow {
 public:
  /// Sizes in pixels. Throws ResourceError when there is no EGL, no driver with OpenGL 3.2, or the size exceeds what
  /// the driver can do.
  OffscreenWindow(int width, int height);
  ~OffscreenWindow();
  OffscreenWindow(const OffscreenWindow&) = delete;
  OffscreenWindow& operator=(const OffscreenWindow&) = delete;

  /// To add renderers to.
  vtkRenderWindow& window();

  /// Draws what the window holds. RGB, rows from bottom to top. Throws ResourceError when OpenGL reports a failure.
  std::vector<unsigned char> draw();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace voxcarve
