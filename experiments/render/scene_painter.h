// Draws meshes and volumes into the upper part of a panel, with VTK. A build without rendering has the same class,
// which refuses.
#pragma once

#include <memory>
#include <mutex>
#include <vector>

#include "experiments/render/render.h"

namespace voxcarve {

/// To be held by whoever uses VTK: it and GLEW keep process-wide state.
std::mutex& render_mutex();

class ScenePainter {
 public:
  /// Scenes of `width` x `height` pixels. A common camera holds all meshes and volumes among the items. The items and
  /// options must outlive the painter. Throws ResourceError when this build or this machine cannot render.
  ScenePainter(const std::vector<RenderItem>& items, const RenderOptions& options, int width, int height);
  ~ScenePainter();
  ScenePainter(const ScenePainter&) = delete;
  ScenePainter& operator=(const ScenePainter&) = delete;

  /// RGB, rows from top to bottom. Throws Cancelled when a stop was requested.
  std::vector<unsigned char> paint(const RenderContent& content);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace voxcarve
