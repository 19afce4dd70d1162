// What models grown at random need: a seeded sequence, and room that is kept free.
#pragma once

#include <cstdint>
#include <functional>
#include <unordered_map>
#include <vector>

#include "common/mesh/triangle_soup.h"

namespace voxcarve {

/// Numbers that are the same on every machine: integers, and doubles by + and * alone. The sequence is that of
/// splitmix64 [SLF14].
class SeededSequence {
 public:
  explicit SeededSequence(std::uint64_t seed) : state_(seed) {}

  /// Uniform in [low, high).
  double uniform(double low, double high);

 private:
  std::uint64_t state_;
};

/// Pieces of surface that do not cross each other, as far as there is room. Two triangles cross when an edge of one
/// passes through the other; touching is not looked for, nor are coplanar triangles.
class FreeSpace {
 public:
  /// `cell_size`: of the grid that finds neighbours, about the size of the pieces; only speed depends on it.
  explicit FreeSpace(double cell_size) : cell_size_(cell_size) {}

  bool crosses(const TriangleSoup& piece) const;
  void occupy(const TriangleSoup& piece);

  /// Asks `make` for a piece until it crosses nothing that is there, or the last of `attempts` is taken as it is; then
  /// occupies its room. `crowding` says how many attempts failed, from 0 for none to 1: reason to stray further.
  TriangleSoup place(const std::function<TriangleSoup(double crowding)>& make, int attempts);

 private:
  struct Corners {
    Point a, b, c;
  };
  void visit_cells(const Box& box, const std::function<bool(std::uint64_t cell)>& stop) const;

  double cell_size_;
  std::vector<Corners> triangles_;
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> triangles_of_cell_;
};

}  // namespace voxcarve
