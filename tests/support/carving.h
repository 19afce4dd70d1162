// From a soup to a carved stream, as the method does it.
#pragma once

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

}  // namespace voxcarve::test
