#include "experiments/render/offscreen_window.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkUnsignedCharArray.h>
#include <vtk_glew.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <string>
#include <string_view>

#include "common/run/errors.h"

namespace voxcarve {

namespace {

/// glewInit() ends with this code when everything but GLX was loaded, which is what happens without an X server.
constexpr GLenum kGlewNoGlxDisplay = 4;

[[noreturn]] void fail(const std::string& what) {
  throw ResourceError("cannot render: " + what +
                      " (on Debian the packages libegl1 and libgl1-mesa-dri hold the driver)");
}

/// The EGL display that needs no window system (EGL_MESA_platform_surfaceless), initialised.
EGLDisplay open_display() {
  const char* extensions = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
  if (extensions == nullptr || std::strstr(extensions, "EGL_MESA_platform_surfaceless") == nullptr) {
    fail("EGL has no surfaceless platform");
  }
  const auto get_display =
      reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(eglGetProcAddress("eglGetPlatformDisplayEXT"));
  if (get_display == nullptr) fail("EGL lacks eglGetPlatformDisplayEXT");
  EGLDisplay display = get_display(EGL_PLATFORM_SURFACELESS_MESA, nullptr, nullptr);
  if (display == EGL_NO_DISPLAY || eglInitialize(display, nullptr, nullptr) != EGL_TRUE) {
    fail("no driver for the surfaceless EGL platform");
  }
  return display;
}

/// An OpenGL 3.3 core context that is current while the object lives.
class EglContext {
 public:
  EglContext()
      : previous_api_(eglQueryAPI()),
        previous_display_(eglGetCurrentDisplay()),
        previous_context_(eglGetCurrentContext()),
        previous_draw_(eglGetCurrentSurface(EGL_DRAW)),
        previous_read_(eglGetCurrentSurface(EGL_READ)),
        display_(open_display()) {
    try {
      create();
      load_functions();
    } catch (...) {
      close();
      throw;
    }
  }
  ~EglContext() { close(); }
  EglContext(const EglContext&) = delete;
  EglContext& operator=(const EglContext&) = delete;

  void make_current() { eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_); }
  bool is_current() const { return eglGetCurrentContext() == context_; }

 private:
  void create() {
    if (eglBindAPI(EGL_OPENGL_API) != EGL_TRUE) fail("EGL has no OpenGL");
    // No surface is ever made: any kind that the configuration supports will do, and none at all too.
    const std::array<EGLint, 5> wanted = {EGL_SURFACE_TYPE, EGL_DONT_CARE, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT,
                                          EGL_NONE};
    EGLConfig config = nullptr;
    EGLint found = 0;
    if (eglChooseConfig(display_, wanted.data(), &config, 1, &found) != EGL_TRUE || found == 0) {
      fail("EGL has no configuration for OpenGL");
    }
    const std::array<EGLint, 7> version = {
        EGL_CONTEXT_MAJOR_VERSION,           3,       EGL_CONTEXT_MINOR_VERSION, 3, EGL_CONTEXT_OPENGL_PROFILE_MASK,
        EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT, EGL_NONE};
    context_ = eglCreateContext(display_, config, EGL_NO_CONTEXT, version.data());
    if (context_ == EGL_NO_CONTEXT) fail("the driver has no OpenGL 3.3 core profile");
    if (eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) != EGL_TRUE) {
      fail("the driver cannot use a context without a surface");
    }
  }

  static void load_functions() {
    glewExperimental = GL_TRUE;
    const GLenum code = glewInit();
    if (code != GLEW_OK && code != kGlewNoGlxDisplay) fail("GLEW cannot load the OpenGL functions");
  }

  void close() {
    if (context_ != EGL_NO_CONTEXT) {
      eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
      eglDestroyContext(display_, context_);
    }
    eglBindAPI(previous_api_);
    if (previous_context_ != EGL_NO_CONTEXT) {
      eglMakeCurrent(previous_display_, previous_draw_, previous_read_, previous_context_);
    }
  }

  EGLenum previous_api_;
  EGLDisplay previous_display_;
  EGLContext previous_context_;
  EGLSurface previous_draw_;
  EGLSurface previous_read_;
  EGLDisplay display_;
  EGLContext context_ = EGL_NO_CONTEXT;
};

/// VTK's window for contexts that others own. The stock class calls glewInit() itself and complains on every frame that
/// there is no GLX; here the functions are loaded before, and the window is only told so.
class SurfacelessRenderWindow : public vtkGenericOpenGLRenderWindow {
 public:
  static SurfacelessRenderWindow* New();
  SurfacelessRenderWindow(const SurfacelessRenderWindow&) = delete;
  void operator=(const SurfacelessRenderWindow&) = delete;

  void use(EglContext& context) { context_ = &context; }
  void MakeCurrent() override { context_->make_current(); }
  bool IsCurrent() override { return context_->is_current(); }
  int SupportsOpenGL() override { return 1; }
  vtkTypeBool IsDirect() override { return 1; }

  void OpenGLInitContext() override {
    if (Initialized) return;
    std::array<GLfloat, 2> widths = {1, 1};
    glGetFloatv(GL_ALIASED_LINE_WIDTH_RANGE, widths.data());
    MaximumHardwareLineWidth = widths[1];
    GlewInitValid = true;
    Initialized = true;
  }

 protected:
  SurfacelessRenderWindow() = default;
  ~SurfacelessRenderWindow() override = default;

 private:
  EglContext* context_ = nullptr;
};

vtkStandardNewMacro(SurfacelessRenderWindow)

    int largest_side() {
  GLint texture = 0;
  GLint renderbuffer = 0;
  std::array<GLint, 2> viewport = {0, 0};
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &texture);
  glGetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &renderbuffer);
  glGetIntegerv(GL_MAX_VIEWPORT_DIMS, viewport.data());
  return std::min({texture, renderbuffer, viewport[0], viewport[1]});
}

}  // namespace

class OffscreenWindow::Impl {
 public:
  Impl(int width, int height) : width_(width), height_(height) {
    const int limit = largest_side();
    if (width > limit || height > limit) {
      throw ResourceError("cannot render " + std::to_string(width) + " x " + std::to_string(height) +
                          " pixels: this machine's OpenGL can do " + std::to_string(limit) + " a side");
    }
    window_->use(context_);
    window_->SetOwnContext(0);
    window_->SetReadyForRendering(true);
    window_->SetMapped(1);
    window_->SetShowWindow(false);
    window_->SetUseOffScreenBuffers(true);
    // There is no framebuffer behind the off-screen one that the finished frame could be copied to.
    window_->SetFrameBlitModeToNoBlit();
    window_->SetMultiSamples(0);
    window_->SetSize(width, height);
  }
  // VTK's own resources go while the context is still current.
  ~Impl() { window_->Finalize(); }

  vtkRenderWindow& window() { return *window_; }

  std::vector<unsigned char> draw() {
    window_->Render();
    const vtkNew<vtkUnsignedCharArray> pixels;
    const bool read = window_->GetPixelData(0, 0, width_ - 1, height_ - 1, 0, pixels, 0) != VTK_ERROR;
    if (glGetError() == GL_OUT_OF_MEMORY) throw ResourceError("cannot render: OpenGL is out of memory");
    const auto size = 3 * static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
    if (!read || static_cast<std::size_t>(pixels->GetNumberOfValues()) != size) {
      throw ResourceError("cannot render: the pixels could not be read back");
    }
    return {pixels->GetPointer(0), pixels->GetPointer(0) + size};
  }

 private:
  EglContext context_;
  vtkNew<SurfacelessRenderWindow> window_;
  int width_, height_;
};

OffscreenWindow::OffscreenWindow(int width, int height) : impl_(std::make_unique<Impl>(width, height)) {}
OffscreenWindow::~OffscreenWindow() = default;
vtkRenderWindow& OffscreenWindow::window() {
  return impl_->window();
}
std::vector<unsigned char> OffscreenWindow::draw() {
  return impl_->draw();
}

}  // namespace voxcarve
