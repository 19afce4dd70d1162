// meshoptimizer 0.18: reduction by edge collapse onto end points.
#include <meshoptimizer.h>

#include <limits>
#include <memory>

#include "experiments/benchmarks/peers.h"

namespace voxcarve::bench {

ReducingPeer meshoptimizer_reduction(const TriangleSoup& soup, std::int64_t triangles) {
  struct Input {
    std::vector<float> positions;
    std::vector<unsigned int> indices;
    TriangleSoup soup;
  };
  auto input = std::make_shared<Input>();
  for (const Point& p : soup.positions) {
    for (const double coordinate : p) input->positions.push_back(static_cast<float>(coordinate));
  }
  for (const Triangle& t : soup.triangles) input->indices.insert(input->indices.end(), t.begin(), t.end());
  input->soup.positions = soup.positions;
  return [input, triangles] {
    std::vector<unsigned int> reduced(input->indices.size());
    const auto made = timed([&] {
      return meshopt_simplify(reduced.data(), input->indices.data(), input->indices.size(), input->positions.data(),
                              input->positions.size() / 3, 3 * sizeof(float), static_cast<std::size_t>(3 * triangles),
                              std::numeric_limits<float>::max(), 0, nullptr);
    });
    TriangleSoup surface = input->soup;
    for (std::size_t i = 0; i < made.result; i += 3)
      surface.triangles.push_back({reduced[i], reduced[i + 1], reduced[i + 2]});
    remove_unused_vertices(surface);
    return Timed<TriangleSoup>{made.seconds, std::move(surface)};
  };
}

}  // namespace voxcarve::bench
