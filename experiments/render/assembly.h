// Many instances of one shape, each at the level of detail that its distance asks for [He95, Fig. 5]. Knows no graphics
// library.
#pragma once

#include <cstdint>
#include <vector>

#include "common/run/context.h"
#include "experiments/render/render.h"

namespace voxcarve {

/// A level of detail of the shape.
struct AssemblyLevel {
  TriangleSoup surface;  ///< empty: never drawn
  double detail = 0;     ///< model units: size of what the level leaves out; its voxel, or its filter's support
};

struct AssemblyOptions {
  int columns = 6;    ///< instances side by side
  int rows = 6;       ///< from the nearest to the farthest
  double pixels = 1;  ///< that a level's detail may take
  double gap = 0.25;  ///< between neighbours, in units of the wider side of an instance as it is seen
};

/// Where an instance stands and what is drawn there.
struct AssemblyInstance {
  int column = 0;
  int row = 0;
  Point offset = Point::Zero();
  double depth = 0;          ///< model units: distance along the view from the camera to its nearest corner
  std::int64_t level = 0;    ///< index into the levels
  double detail_pixels = 0;  ///< what the detail of this level takes there
};

struct Assembly {
  std::vector<AssemblyInstance> instances;  ///< row by row
  std::vector<Point> framed;                ///< corners of their boxes, for RenderOptions::framed
  std::int64_t triangles = 0;               ///< of all instances
  std::int64_t finest_triangles = 0;        ///< were all of them the finest level
};

/// Columns to the right of the view and rows away from it on the ground, all instances turned alike. `levels` run from
/// coarse to fine. An instance is drawn at the coarsest level whose detail, facing the camera at the nearest corner of
/// the instance's box, takes at most `pixels` pixels of a picture with a scene of this size; at the finest where none
/// does. So of two instances the farther one is never drawn finer. Throws ParameterError when there is no level with
/// triangles.
Assembly plan_assembly(const std::vector<AssemblyLevel>& levels, const AssemblyOptions& options,
                       const RenderOptions& render, SceneSize scene);

/// The triangles of all instances. Throws ResourceError when they exceed the memory budget, and Cancelled.
TriangleSoup assembly_surface(const std::vector<AssemblyLevel>& levels, const Assembly& assembly, RunContext& context);

}  // namespace voxcarve
