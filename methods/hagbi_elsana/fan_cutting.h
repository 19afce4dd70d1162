// Where the boundary of a carved solid is no manifold.
#pragma once

#include <cstdint>
#include <vector>

#include "common/run/context.h"
#include "methods/hagbi_elsana/level_surface.h"

namespace voxcarve {

/// Cuts singular vertices of a surface into one copy a fan of triangles. `soup` has its triangles, one a face, with a
/// vertex for every point; positions are made here. `workspace.point_of` says which points these are,
/// `workspace.singular` which vertices may have more than one fan: those of edges with more than two triangles, at
/// least.
void cut_fans(const CarvedSolid& solid, const std::vector<std::uint32_t>& faces, LevelWorkspace& workspace,
              const RunContext& context, TriangleSoup& soup);

}  // namespace voxcarve
