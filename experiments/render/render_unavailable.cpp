// The functions of render.h in a build without VTK or EGL.
#include "common/run/errors.h"
#include "experiments/render/layout.h"
#include "experiments/render/render.h"

namespace voxcarve {

bool rendering_available() {
  return false;
}

RenderedImage render_image(const std::vector<RenderItem>& items, const RenderOptions& options) {
  check_render_arguments(items, options);
  throw ResourceError("this build has no rendering: install the rendering packages (./dev setup) and build again");
}

void render_meshes(const std::vector<RenderItem>& items, const RenderOptions& options, const std::filesystem::path&) {
  render_image(items, options);
}

}  // namespace voxcarve
