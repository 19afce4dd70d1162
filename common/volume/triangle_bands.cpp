// A counting sort over fixed chunks of triangles, so that chunks go to threads and the lists stay in order.
#include "common/volume/triangle_bands.h"

#include <limits>

namespace voxcarve {

namespace {

constexpr std::int64_t kChunk = 1 << 15;  // triangles

/// First and last band of a triangle; first > last for none.
struct BandRange {
  std::uint16_t first = 1;
  std::uint16_t last = 0;
};

}  // namespace

TriangleBands::TriangleBands(const LatticeSoup& soup, const Index3& dims, std::size_t axis, std::int64_t thickness,
                             const std::array<bool, 3>& rays, std::uint64_t held, RunContext& context)
    : layers_(dims[static_cast<Eigen::Index>(axis)]) {
  constexpr std::int64_t kMostBands = std::numeric_limits<std::uint16_t>::max();
  thickness_ = std::max(thickness, layers_ / kMostBands + 1);
  bands_ = (layers_ + thickness_ - 1) / thickness_;
  const auto bands = static_cast<std::size_t>(bands_);
  const bool has_rays = rays[0] || rays[1] || rays[2];
  const std::int64_t triangles = has_rays ? static_cast<std::int64_t>(soup.triangles().size()) : 0;
  const auto chunks = static_cast<std::size_t>((triangles + kChunk - 1) / kChunk);
  const std::uint64_t needed =
      held + soup.triangles().size() * sizeof(BandRange) + chunks * bands * sizeof(std::size_t);
  context.require_memory(needed, "voxelization");

  std::vector<BandRange> ranges(soup.triangles().size());
  std::vector<std::size_t> offsets(chunks * bands, 0);  // of a chunk in a band; counts at first
  parallel_for(context, 0, triangles, kChunk, [&](std::int64_t begin, std::int64_t end) {
    std::size_t* counts = offsets.data() + static_cast<std::size_t>(begin / kChunk) * bands;
    for (auto t = static_cast<std::size_t>(begin); t < static_cast<std::size_t>(end); ++t) {
      const Triangle& triangle = soup.triangles()[t];
      const std::array<LatticePoint, 3> corners = {soup.points()[triangle[0]], soup.points()[triangle[1]],
                                                   soup.points()[triangle[2]]};
      std::array<IndexRange, 3> centers;
      for (std::size_t a = 0; a < 3; ++a) {
        centers[a] = centers_between(corners, a, soup.bits(), {0, dims[static_cast<Eigen::Index>(a)] - 1});
      }
      bool has_samples = false;
      for (std::size_t a = 0; a < 3; ++a) {
        has_samples |= rays[a] && !centers[(a + 1) % 3].empty() && !centers[(a + 2) % 3].empty();
      }
      if (!has_samples) continue;
      ranges[t].first = static_cast<std::uint16_t>(centers[axis].first / thickness_);
      ranges[t].last = static_cast<std::uint16_t>(centers[axis].last / thickness_);
      for (std::size_t band = ranges[t].first; band <= ranges[t].last; ++band) ++counts[band];
    }
  });

  begin_.resize(bands + 1);
  std::size_t sum = 0;
  for (std::size_t band = 0; band < bands; ++band) {
    begin_[band] = sum;
    for (std::size_t chunk = 0; chunk < chunks; ++chunk) {
      const std::size_t count = offsets[chunk * bands + band];
      offsets[chunk * bands + band] = sum;
      sum += count;
    }
  }
  begin_[bands] = sum;
  context.require_memory(needed + sum * sizeof(std::uint32_t), "voxelization");
  items_.resize(sum);
  parallel_for(context, 0, triangles, kChunk, [&](std::int64_t begin, std::int64_t end) {
    std::size_t* next = offsets.data() + static_cast<std::size_t>(begin / kChunk) * bands;
    for (auto t = static_cast<std::size_t>(begin); t < static_cast<std::size_t>(end); ++t) {
      for (std::size_t band = ranges[t].first; band <= ranges[t].last; ++band) {
        items_[next[band]++] = static_cast<std::uint32_t>(t);
      }
    }
  });
}

}  // namespace voxcarve
