// Triangles found by their corners.
#pragma once

#include <algorithm>
#include <array>
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

/// The facets of a complex by their corners: those of one smallest corner lie side by side, so that the faces of a
/// tetrahedron are looked for in two places. Takes 4 bytes a point and 12 a facet.
class FacetTable {
 public:
  /// A facet and whether sorting its corners takes an odd permutation, in one number.
  struct Entry {
    std::uint32_t number = 0xffffffffU;

    bool exists() const { return number != 0xffffffffU; }
    std::uint32_t facet() const { return number >> 1; }
    bool odd() const { return (number & 1) != 0; }
  };

  /// Facets are fewer than 2^31, their corners below `points`.
  FacetTable(const std::vector<Triangle>& facets, std::size_t points)
      : first_(points + 2, 0), others_(facets.size()), entries_(facets.size()) {
    for (const Triangle& facet : facets) ++first_[std::min({facet[0], facet[1], facet[2]}) + 2];
    for (std::size_t p = 2; p < first_.size(); ++p) first_[p] += first_[p - 1];
    for (std::uint32_t f = 0; f < facets.size(); ++f) {
      const SortedTriangle sorted(facets[f]);
      const std::uint32_t place = first_[sorted.corners[0] + 1]++;
      others_[place] = others(sorted.corners[1], sorted.corners[2]);
      entries_[place] = {f << 1 | static_cast<std::uint32_t>(sorted.odd)};
    }
    for (std::size_t p = 0; p < points; ++p) {
      if (first_[p + 1] - first_[p] > kFew) sort(first_[p], first_[p + 1]);
    }
  }

  /// The facets between this smallest corner and pairs of others, none where there is none; of equal ones the first.
  /// In each pair the middle corner comes first.
  template <std::size_t N>
  std::array<Entry, N> find(std::uint32_t smallest, const std::array<std::array<std::uint32_t, 2>, N>& pairs) const {
    std::array<Entry, N> found{};
    const std::uint32_t begin = first_[smallest];
    const std::uint32_t end = first_[smallest + 1];
    if (end - begin > kFew) {
      for (std::size_t n = 0; n < N; ++n) found[n] = search(begin, end, others(pairs[n][0], pairs[n][1]));
      return found;
    }
    for (std::uint32_t place = end; place-- > begin;) {
      for (std::size_t n = 0; n < N; ++n) {
        if (others_[place] == others(pairs[n][0], pairs[n][1])) found[n] = entries_[place];
      }
    }
    return found;
  }

 private:
  static constexpr std::uint32_t kFew = 16;

  static std::uint64_t others(std::uint32_t middle, std::uint32_t largest) {
    return std::uint64_t{middle} << 32 | largest;
  }

  void sort(std::uint32_t begin, std::uint32_t end) {
    std::vector<std::pair<std::uint64_t, std::uint32_t>> sorted;
    for (std::uint32_t place = begin; place < end; ++place) sorted.emplace_back(others_[place], entries_[place].number);
    std::ranges::sort(sorted);
    for (std::uint32_t place = begin; place < end; ++place) {
      others_[place] = sorted[place - begin].first;
      entries_[place] = {sorted[place - begin].second};
    }
  }

  Entry search(std::uint32_t begin, std::uint32_t end, std::uint64_t wanted) const {
    const auto last = others_.begin() + end;
    const auto found = std::lower_bound(others_.begin() + begin, last, wanted);
    return found != last && *found == wanted ? entries_[static_cast<std::size_t>(found - others_.begin())] : Entry();
  }

  std::vector<std::uint32_t> first_;   ///< place of the first facet, by smallest corner
  std::vector<std::uint64_t> others_;  ///< the middle corner, then the largest, by place
  std::vector<Entry> entries_;         ///< by place
};

}  // namespace voxcarve
