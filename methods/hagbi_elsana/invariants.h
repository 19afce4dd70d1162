// What carving promises, checked on one stream.
#pragma once

#include <vector>

#include "methods/hagbi_elsana/stream.h"
#include "methods/method.h"

namespace voxcarve {

/// The invariants of a stream, exactly: the first level is convex, of genus 0 and one component; every carved
/// tetrahedron has a positive volume, so the solids are nested and shrink; vertices of the model and components of the
/// closed set never grow fewer; on all levels, or 64 of them, every triangle of the model lies on the surface or under
/// it, so that level contains the model and its silhouettes cover the model's; the last level is made of the model's
/// triangles.
std::vector<InvariantCheck> check_stream(const CarvingStream& stream, RunContext& context);

}  // namespace voxcarve
