// From a soup to a carved stream, as the method does it, and soups for it.
#pragma once

#include <cstdint>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "methods/hagbi_elsana/carving.h"
#include "methods/hagbi_elsana/complement.h"
#include "methods/hagbi_elsana/stream.h"
#include "methods/hagbi_elsana/valid_complex.h"

namespace voxcarve::test {

inline Classification classified(const TriangleSoup& soup, RunContext& context, bool box = false,
                                 InsideRule rule = InsideRule::kWinding) {
  ComplexOptions options;
  options.box = box;
  const ValidComplex valid = make_valid_complex(soup, options, context);
  return classify(valid.tetrahedralization, valid.complex, valid.multiplicity, rule, context);
}

inline CarvingStream carved(const TriangleSoup& soup, const CarvingOptions& options = {}, bool box = false) {
  RunContext context;
  Classification made = classified(soup, context, box);
  std::vector<std::uint32_t> steps = carve(made.complement, made.voids, options, context);
  return CarvingStream(std::move(made.complement), std::move(steps), "test", context);
}

/// Triangles that pass through each other, in any orientation.
inline TriangleSoup crossing_triangles(int triangles, std::uint64_t seed) {
  std::mt19937_64 generator(seed);
  const auto coordinate = [&] { return static_cast<double>(generator() >> 11) * 0x1p-53; };
  TriangleSoup soup;
  for (int t = 0; t < triangles; ++t) {
    const Point center(coordinate(), coordinate(), coordinate());
    const auto first = static_cast<std::uint32_t>(soup.positions.size());
    for (int c = 0; c < 3; ++c) {
      soup.positions.push_back(center + 0.3 * (Point(coordinate(), coordinate(), coordinate()) - Point(.5, .5, .5)));
    }
    soup.triangles.push_back({first, first + 1, first + 2});
  }
  return soup;
}

}  // namespace voxcarve::test
