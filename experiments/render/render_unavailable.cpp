// What a build without VTK or EGL has in place of scenes and captions.
#include "common/run/errors.h"
#include "experiments/render/captions.h"
#include "experiments/render/scene_painter.h"

namespace voxcarve {

bool rendering_available() {
  return false;
}

bool captions_available() {
  return false;
}

CaptionBand set_captions(const std::vector<std::string>&, int, int) {
  return {};
}

class ScenePainter::Impl {};

ScenePainter::ScenePainter(const std::vector<RenderItem>&, const RenderOptions&, int, int) {
  throw ResourceError("this build has no rendering: install the rendering packages (./dev setup) and build again");
}
ScenePainter::~ScenePainter() = default;

std::vector<unsigned char> ScenePainter::paint(const RenderContent&) {
  return {};
}

}  // namespace voxcarve
