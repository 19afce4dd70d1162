// Triangles found by their corners.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "common/mesh/triangle_soup.h"

namespace voxcarve {

/// A triangle's corners in ascending order, and whether that took an odd permutation.
struct SortedTriangle {
  Triangle corners;
  bool odd = false;

  explicit SortedTriangle(const Triangle& triangle) : corners(triangle) {
    const auto order = [this](std::size_t a, std::size_t b) {
      if (corners[a] <= corners[b]) return;
      std::swap(corners[a], corners[b]);
      odd = !odd;
    };
    order(0, 1);
    order(1, 2);
    order(0, 1);
  }
};

/// The facets of a complex, which must outlive the table, by their corners.
class FacetTable {
 public:
  static constexpr std::uint32_t kNoFacet = 0xffffffffU;

  explicit FacetTable(const std::vector<Triangle>& facets)
      : slots_(std::bit_ceil(2 * facets.size() + 2), kNoFacet), mask_(slots_.size() - 1), facets_(facets) {
    for (std::uint32_t f = 0; f < facets.size(); ++f) {
      std::size_t slot = first_slot(SortedTriangle(facets[f]).corners);
      while (slots_[slot] != kNoFacet) slot = (slot + 1) & mask_;
      slots_[slot] = f;
    }
  }

  /// The facet with these corners, or kNoFacet.
  std::uint32_t find(const Triangle& sorted) const {
    for (std::size_t slot = first_slot(sorted); slots_[slot] != kNoFacet; slot = (slot + 1) & mask_) {
      if (SortedTriangle(facets_[slots_[slot]]).corners == sorted) return slots_[slot];
    }
    return kNoFacet;
  }

 private:
  std::size_t first_slot(const Triangle& sorted) const {
    std::uint64_t hash = 0;
    for (const std::uint32_t corner : sorted) hash = (hash ^ corner) * 0x9e3779b97f4a7c15ULL;
    return static_cast<std::size_t>(hash >> 24) & mask_;
  }

  std::vector<std::uint32_t> slots_;
  std::size_t mask_;
  const std::vector<Triangle>& facets_;
};

}  // namespace voxcarve
