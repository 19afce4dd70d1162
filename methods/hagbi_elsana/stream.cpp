// Based on [HE10, 3]; the order of faces and the lists are ours.
#include "methods/hagbi_elsana/stream.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "common/mesh/topology.h"
#include "common/run/errors.h"
#include "common/volume/workspace_pool.h"
#include "methods/hagbi_elsana/level_surface.h"
#include "methods/hagbi_elsana/tetrahedron.h"

namespace voxcarve {

struct CarvingStream::ScratchPool {
  WorkspacePool<LevelWorkspace> levels;
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
  follow_steps(context);
  stage.advance(1);
  keep_lists();
  stage.advance(1);
}

std::uint64_t CarvingStream::memory(std::size_t tetrahedra) {
  constexpr std::size_t kFaces = 4 * sizeof(Face);
  constexpr std::size_t kCounts = 6 * sizeof(std::uint32_t);
  return tetrahedra * (2 * kFaces + LevelWorkspace::kBytesATetrahedron + kCounts);  // faces in order and in lists
}

void CarvingStream::check_steps() const {
  if (step_.size() != complement_.size()) throw InputError("the stream has not one step a tetrahedron");
  for (std::uint32_t t = 0; t < complement_.size(); ++t) {
    if ((step_[t] == 0) != complement_.is_ghost(t)) {
      throw InputError("the stream carves tetrahedron " + std::to_string(t) + " at an impossible step");
    }
  }
}

/// Tetrahedra by their steps, without those that are never carved; equal steps go by number.
std::vector<std::uint32_t> CarvingStream::carved_in_order(std::vector<std::uint32_t>& first_of_step) const {
  first_of_step.assign(std::size_t{last_step_} + 2, 0);
  for (const std::uint32_t step : step_) {
    if (step != kNeverCarved) ++first_of_step[step + 1];
  }
  for (std::size_t s = 0; s + 1 < first_of_step.size(); ++s) first_of_step[s + 1] += first_of_step[s];
  std::vector<std::uint32_t> order(first_of_step.back());
  std::vector<std::uint32_t> next(first_of_step.begin(), first_of_step.end() - 1);
  for (std::uint32_t t = 0; t < step_.size(); ++t) {
    if (step_[t] != kNeverCarved) order[next[step_[t]]++] = t;
  }
  return order;
}

/// Faces in the order in which they come, vertices and triangles after each step, and the levels.
void CarvingStream::follow_steps(RunContext& context) {
  last_step_ = 0;
  for (const std::uint32_t step : step_) {
    if (step != kNeverCarved) last_step_ = std::max(last_step_, step);
  }
  if (last_step_ >= step_.size()) throw InputError("the stream has steps that carve nothing");
  std::vector<std::uint32_t> first;
  const std::vector<std::uint32_t> carved = carved_in_order(first);
  context.check_cancelled();
  constexpr std::size_t kAhead = 16;  // tetrahedra that come so much later are fetched
  constexpr std::uint32_t kCheckEvery = 1 << 16;
  const std::size_t steps = std::size_t{last_step_} + 1;
  first_of_step_.assign(steps + 1, 0);
  vertices_.resize(steps);
  triangles_.resize(steps);
  std::size_t barriers = 0;  // come from either side, other faces from one
  for (std::uint32_t face = 0; face < 4 * step_.size(); ++face) {
    barriers += complement_.is_barrier(face / 4, static_cast<int>(face % 4));
  }
  order_.resize(2 * step_.size() + barriers / 2 + 4);
  std::size_t faces = 0;
  std::vector<std::uint32_t> uses(complement_.points.size(), 0);  // by faces that are there
  std::uint32_t vertices = 0;
  std::uint32_t triangles = 0;
  for (std::uint32_t s = 0; s <= last_step_; ++s) {
    if (s % kCheckEvery == 0) context.check_cancelled();
    for (std::size_t k = first[s]; k < first[s + 1]; ++k) {
      const std::uint32_t ahead = carved[std::min(k + kAhead, carved.size() - 1)];
      __builtin_prefetch(&complement_.neighbors[ahead]);
      __builtin_prefetch(&complement_.corners[ahead]);
      const std::uint32_t t = carved[k];
      const TetrahedronCorners& corners = complement_.corners[t];
      if (order_.size() < faces + 4) throw InputError("the complement has neighbours that are not mutual");
      // +1 for a face that comes, -1 for the one of its neighbour that goes; without a branch.
      std::array<std::uint32_t, 4> change{};
      std::uint32_t sum = 0;
      for (std::uint32_t i = 0; i < 4; ++i) {
        const std::uint32_t until = death(4 * t + i);
        order_[faces] = {4 * t + i, until};
        faces += until > s;
        change[i] = static_cast<std::uint32_t>(until > s) - static_cast<std::uint32_t>(until < s);
        sum += change[i];
      }
      triangles += sum;
      for (std::size_t c = 0; c < 4; ++c) {  // a corner is on all faces but the one opposite
        if (corners[c] == Complement::kFar) continue;
        std::uint32_t& count = uses[corners[c]];
        vertices -= count != 0;
        count += sum - change[c];
        vertices += count != 0;
      }
    }
    first_of_step_[s + 1] = faces;
    vertices_[s] = vertices;
    triangles_[s] = triangles;
  }
  order_.resize(faces);
  levels_ = {0};
  for (std::uint32_t s = 1; s <= last_step_; ++s) {
    if (s == last_step_ || vertices_[s + 1] > vertices_[s]) levels_.push_back(s);
  }
}

/// A list of all faces whenever as many have come since the last as there are.
void CarvingStream::keep_lists() {
  const auto keep = [&](std::uint32_t step) {
    const std::size_t begin = listed_.size();
    listed_.resize(begin + triangles_[step] + 1);
    const std::size_t end = copy_faces(step, [&](std::size_t f, const Face& face) { listed_[begin + f] = face; });
    listed_.resize(begin + end);
    lists_.push_back({step, begin, begin + end});
  };
  keep(0);
  for (std::uint32_t s = 1; s <= last_step_; ++s) {
    if (first_of_step_[s + 1] - first_of_step_[lists_.back().step + 1] >= triangles_[s]) keep(s);
  }
}

/// put(f, face) for the faces after a step, in the order in which they came, with f from 0 on; returns how many they
/// are. May put something after the last one that is none of them.
template <class Put>
std::size_t CarvingStream::copy_faces(std::uint32_t step, const Put& put) const {
  std::size_t faces = 0;
  const auto copy = [&](const std::vector<Face>& from, std::size_t begin, std::size_t end) {
    for (std::size_t f = begin; f < end; ++f) {  // without a branch: what has gone follows no pattern
      const Face face = from[f];
      put(faces, face);
      faces += face.death > step;
    }
  };
  const auto after = std::ranges::upper_bound(lists_, step, {}, &List::step);
  if (after == lists_.begin()) {
    copy(order_, 0, first_of_step_[step + 1]);
  } else {
    const List& list = after[-1];
    copy(listed_, list.begin, list.end);
    copy(order_, first_of_step_[list.step + 1], first_of_step_[step + 1]);
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
  auto workspace = pool_->levels.take([&] { return LevelWorkspace(complement_.points.size()); });
  std::vector<std::uint32_t>& faces = workspace->faces;
  faces.resize(triangles_[step] + std::size_t{1});
  faces.resize(copy_faces(step, [&](std::size_t f, const Face& face) { faces[f] = face.face; }));
  TriangleSoup surface = level_surface({complement_, step_, step}, faces, *workspace, context ? *context : alone);
  pool_->levels.give(std::move(workspace));
  return surface;
}

}  // namespace voxcarve
