// Based on [HE10, 3]; the order of faces and the lists are ours.
#include "methods/hagbi_elsana/stream.h"

#include <algorithm>
#include <string>
#include <utility>

#include "common/mesh/topology.h"
#include "common/run/errors.h"
#include "common/volume/workspace_pool.h"
#include "methods/hagbi_elsana/level_surface.h"
#include "methods/hagbi_elsana/tetrahedron.h"

namespace voxcarve {

struct CarvingStream::ScratchPool {
  WorkspacePool<FacePlaces> places;
};

CarvingStream::CarvingStream(Complement complement, std::vector<std::uint32_t> step, std::string provenance,
                             RunContext& context)
    : complement_(std::move(complement)),
      step_(std::move(step)),
      provenance_(std::move(provenance)),
      pool_(std::make_shared<ScratchPool>()) {
  Stage stage(context, "stream", 3);
  constexpr std::size_t kMostTetrahedra = std::size_t{1} << 30;  // faces are numbered in 32 bits
  if (step_.size() >= kMostTetrahedra) throw ResourceError("a stream of 2^30 tetrahedra or more cannot be made");
  context.require_memory(memory(step_.size()), "the carving stream");
  check_steps();
  stage.advance(1);
  order_faces(context);
  stage.advance(1);
  count(context);
  keep_lists();
  stage.advance(1);
}

std::uint64_t CarvingStream::memory(std::size_t tetrahedra) {
  constexpr std::size_t kFaces = 4 * sizeof(std::uint32_t);
  return tetrahedra * (2 * kFaces + kFaces + 4 * sizeof(std::uint32_t));  // in order and in lists, places, counts
}

void CarvingStream::check_steps() const {
  if (step_.size() != complement_.size()) throw InputError("the stream has not one step a tetrahedron");
  for (std::uint32_t t = 0; t < complement_.size(); ++t) {
    if ((step_[t] == 0) != complement_.is_ghost(t)) {
      throw InputError("the stream carves tetrahedron " + std::to_string(t) + " at an impossible step");
    }
  }
}

void CarvingStream::order_faces(RunContext& context) {
  last_step_ = 0;
  for (const std::uint32_t step : step_) {
    if (step != kNeverCarved) last_step_ = std::max(last_step_, step);
  }
  if (last_step_ >= step_.size()) throw InputError("the stream has steps that carve nothing");
  const auto for_each_face = [&](const auto& visit) {
    for (std::uint32_t t = 0; t < step_.size(); ++t) {
      if (step_[t] == kNeverCarved) continue;
      for (std::uint32_t face = 4 * t; face < 4 * t + 4; ++face) {
        if (death(face) > step_[t]) visit(face);
      }
    }
  };
  first_of_step_.assign(std::size_t{last_step_} + 2, 0);
  for_each_face([&](std::uint32_t face) { ++first_of_step_[birth(face) + 1]; });
  for (std::size_t s = 0; s + 1 < first_of_step_.size(); ++s) first_of_step_[s + 1] += first_of_step_[s];
  context.check_cancelled();
  order_.resize(first_of_step_.back());
  std::vector<std::size_t> next(first_of_step_.begin(), first_of_step_.end() - 1);
  for_each_face([&](std::uint32_t face) { order_[next[birth(face)]++] = face; });
}

/// Vertices and triangles after each step, and the levels.
void CarvingStream::count(RunContext& context) {
  const std::size_t steps = std::size_t{last_step_} + 1;
  std::vector<std::size_t> first_death(steps + 1, 0);
  for (const std::uint32_t face : order_) {
    const std::uint32_t at = death(face);
    if (at <= last_step_) ++first_death[at + 1];
  }
  for (std::size_t s = 0; s < steps; ++s) first_death[s + 1] += first_death[s];
  std::vector<std::uint32_t> deaths(first_death.back());
  std::vector<std::size_t> next(first_death.begin(), first_death.end() - 1);
  for (const std::uint32_t face : order_) {
    if (death(face) <= last_step_) deaths[next[death(face)]++] = face;
  }
  context.check_cancelled();
  std::vector<std::uint32_t> uses(complement_.points.size(), 0);
  std::uint32_t vertices = 0;
  std::uint32_t triangles = 0;
  vertices_.resize(steps);
  triangles_.resize(steps);
  for (std::size_t s = 0; s < steps; ++s) {
    // What comes before what goes: a vertex that keeps a face is never without.
    for (std::size_t f = first_of_step_[s]; f < first_of_step_[s + 1]; ++f) {
      for (const std::uint32_t point : complement_.face(order_[f] / 4, static_cast<int>(order_[f] % 4))) {
        vertices += uses[point]++ == 0;
      }
    }
    for (std::size_t f = first_death[s]; f < first_death[s + 1]; ++f) {
      for (const std::uint32_t point : complement_.face(deaths[f] / 4, static_cast<int>(deaths[f] % 4))) {
        vertices -= --uses[point] == 0;
      }
    }
    triangles += static_cast<std::uint32_t>(first_of_step_[s + 1] - first_of_step_[s]);
    triangles -= static_cast<std::uint32_t>(first_death[s + 1] - first_death[s]);
    vertices_[s] = vertices;
    triangles_[s] = triangles;
  }
  levels_ = {0};
  for (std::uint32_t s = 1; s <= last_step_; ++s) {
    if (s == last_step_ || vertices_[s + 1] > vertices_[s]) levels_.push_back(s);
  }
}

/// A list of all faces whenever as many have come since the last as there are.
void CarvingStream::keep_lists() {
  std::vector<std::uint32_t> faces;
  std::uint32_t listed_step = 0;
  const auto keep = [&](std::uint32_t step) {
    std::erase_if(faces, [&](std::uint32_t face) { return death(face) <= step; });
    for (std::size_t f = first_of_step_[listed_step]; f < first_of_step_[step + 1]; ++f) {
      if (death(order_[f]) > step) faces.push_back(order_[f]);
    }
    lists_.push_back({step, listed_.size(), listed_.size() + faces.size()});
    listed_.insert(listed_.end(), faces.begin(), faces.end());
    listed_step = step + 1;
  };
  keep(0);
  for (std::uint32_t s = 1; s <= last_step_; ++s) {
    if (first_of_step_[s + 1] - first_of_step_[listed_step] >= triangles_[s]) keep(s);
  }
}

/// In the order in which they came.
std::vector<std::uint32_t> CarvingStream::faces_at(std::uint32_t step) const {
  const auto list = std::prev(std::ranges::upper_bound(lists_, step, {}, &List::step));
  std::vector<std::uint32_t> faces;
  faces.reserve(triangles_[step]);
  for (std::size_t f = list->begin; f < list->end; ++f) {
    if (death(listed_[f]) > step) faces.push_back(listed_[f]);
  }
  for (std::size_t f = first_of_step_[list->step + 1]; f < first_of_step_[step + 1]; ++f) {
    if (death(order_[f]) > step) faces.push_back(order_[f]);
  }
  return faces;
}

std::uint32_t CarvingStream::step_for_vertices(std::int64_t most) const {
  const auto above = std::ranges::find_if(vertices_, [&](std::uint32_t count) { return count > most; });
  return above == vertices_.begin() ? 0 : static_cast<std::uint32_t>(above - vertices_.begin()) - 1;
}

std::uint32_t CarvingStream::step_for_triangles(std::int64_t most) const {
  const auto above = std::ranges::find_if(triangles_, [&](std::uint32_t count) { return count > most; });
  return above == triangles_.begin() ? 0 : static_cast<std::uint32_t>(above - triangles_.begin()) - 1;
}

std::vector<std::uint32_t> CarvingStream::closed_components(const RunContext& context) const {
  // Backwards: what was carved last joins the model first.
  DisjointSets sets(complement_.points.size());
  std::vector<std::uint8_t> present(complement_.points.size(), 0);
  std::uint32_t components = 0;
  std::vector<std::uint32_t> first_of_solid(complement_.points.size(), Complement::kNone);
  const auto enter = [&](std::uint32_t point) {
    components += present[point] == 0;
    present[point] = 1;
  };
  const auto join = [&](std::uint32_t a, std::uint32_t b) {
    const std::uint32_t root = sets.find(a);
    const std::uint32_t other = sets.find(b);
    if (root == other) return;
    sets.join(root, other);
    --components;
  };
  for (std::uint32_t point = 0; point < complement_.points.size(); ++point) {
    const std::uint32_t solid = complement_.solid_of_point[point];
    if (solid == Complement::kNone) continue;
    enter(point);
    if (first_of_solid[solid] == Complement::kNone) first_of_solid[solid] = point;
    join(first_of_solid[solid], point);
  }
  // Counting sort by step; what is never carved comes last.
  const auto place = [&](std::uint32_t t) { return std::min(step_[t], last_step_ + 1); };
  std::vector<std::size_t> first(std::size_t{last_step_} + 3, 0);
  for (std::uint32_t t = 0; t < complement_.first_ghost; ++t) ++first[place(t) + 1];
  for (std::size_t s = 0; s + 1 < first.size(); ++s) first[s + 1] += first[s];
  context.check_cancelled();
  std::vector<std::uint32_t> by_step(complement_.first_ghost);
  for (std::uint32_t t = 0; t < complement_.first_ghost; ++t) by_step[first[place(t)]++] = t;
  std::ranges::reverse(by_step);
  context.check_cancelled();
  std::vector<std::uint32_t> result(std::size_t{last_step_} + 1);
  std::size_t next = 0;
  for (std::uint32_t s = last_step_ + 1; s-- > 0;) {
    for (; next < by_step.size() && step_[by_step[next]] > s; ++next) {
      const TetrahedronCorners& corners = complement_.corners[by_step[next]];
      for (const std::uint32_t corner : corners) enter(corner);
      for (const std::uint32_t corner : corners) join(corners[0], corner);
    }
    result[s] = components;
  }
  return result;
}

TriangleSoup CarvingStream::extract(std::uint32_t step, const RunContext* context) const {
  const RunContext alone;
  auto places = pool_->places.take([&] { return FacePlaces(complement_.size(), complement_.points.size()); });
  TriangleSoup surface = level_surface({complement_, step_, step}, faces_at(step), *places, context ? *context : alone);
  pool_->places.give(std::move(places));
  return surface;
}

}  // namespace voxcarve
