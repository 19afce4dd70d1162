#include "common/volume/column_votes.h"

#include <algorithm>
#include <optional>

#include "common/volume/column_block.h"
#include "common/volume/triangle_bands.h"
#include "common/volume/workspace_pool.h"

namespace voxcarve {

namespace {

/// Layers whose toggles fill half a megabyte, a second-level cache's share; enough of them that few triangles reach
/// into several bands, and few enough that threads share the work evenly.
std::int64_t band_thickness(std::int64_t layers, std::int64_t words_per_layer) {
  constexpr std::int64_t kCached = 1 << 16;  // words
  const std::int64_t thickness = std::clamp<std::int64_t>(kCached / words_per_layer, 4, 64);
  constexpr std::int64_t kFewestBands = 16;
  return std::min(thickness, std::max<std::int64_t>(layers / kFewestBands, 1));
}

/// The part of `total` that piece `index` of `count` stands for in a progress report.
std::int64_t share(std::int64_t total, std::int64_t index, std::int64_t count) {
  return total * (index + 1) / count - total * index / count;
}

/// Calls add(corners, ranges of the triangle's box) for the triangles of a band; add returns the samples it looked at.
template <class Add>
void for_each_triangle(const LatticeSoup& soup, const Index3& dims, std::span<const std::uint32_t> triangles,
                       const RunContext& context, const Add& add) {
  constexpr std::int64_t kCheckEvery = 1 << 20;  // samples and triangles
  std::int64_t unchecked = 0;
  for (const std::uint32_t t : triangles) {
    const Triangle& triangle = soup.triangles()[t];
    const std::array<LatticePoint, 3> corners = {soup.points()[triangle[0]], soup.points()[triangle[1]],
                                                 soup.points()[triangle[2]]};
    std::array<IndexRange, 3> centers;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      centers[axis] = centers_between(corners, axis, soup.bits(), {0, dims[static_cast<Eigen::Index>(axis)] - 1});
    }
    unchecked += 1 + add(corners, centers);
    if (unchecked > kCheckEvery) {
      context.check_cancelled();
      unchecked = 0;
    }
  }
}

}  // namespace

/// The slabs of slices and what threads need to classify one.
struct ColumnVotes::Slabs {
  struct Workspace {
    std::optional<ColumnBlock<0>> along_x;
    std::optional<ColumnBlock<1>> along_y;
    std::vector<BitWord> x_interior;  ///< of one row
    std::vector<BitWord> x_abstains;
    std::vector<BitWord> y_interior;  ///< running parity, handed on from row to row
  };

  explicit Slabs(TriangleBands bands) : triangles(std::move(bands)) {}

  TriangleBands triangles;
  WorkspacePool<Workspace> pool;

  static std::uint64_t memory_of_workspace(const Index3& dims, std::int64_t layers, const ColumnVoteOptions& options) {
    return (options.axes[0] ? ColumnBlock<0>::memory(dims, layers, options.stabbing) : 0) +
           (options.axes[1] ? ColumnBlock<1>::memory(dims, layers, options.stabbing) : 0) +
           3 * static_cast<std::uint64_t>(words_for(dims[0])) * sizeof(BitWord);
  }
  Workspace make_workspace(const Index3& dims, const ColumnVoteOptions& options) const {
    const std::int64_t layers = triangles.layers(0).size();
    const auto words = static_cast<std::size_t>(words_for(dims[0]));
    Workspace workspace;
    if (options.axes[0]) workspace.along_x.emplace(dims, layers, options.stabbing);
    if (options.axes[1]) workspace.along_y.emplace(dims, layers, options.stabbing);
    workspace.x_interior.resize(words);
    workspace.x_abstains.resize(words);
    workspace.y_interior.resize(words);
    return workspace;
  }
};

ColumnVotes::ColumnVotes(const LatticeSoup& soup, BitVolume& volume, const ColumnVoteOptions& options,
                         std::uint64_t held, Stage& stage, RunContext& context)
    : soup_(soup), volume_(volume), options_(options), stage_(stage), context_(context) {
  const Index3& dims = volume.dims();
  held_ = held + BitVolume::memory(dims) + soup.points().size() * sizeof(LatticePoint);
  nobody_.assign(static_cast<std::size_t>(volume.row_words()), 0);
  if (options.axes[2]) classify_along_z();
  const std::int64_t words = volume.row_words() * dims[1] * (options.axes[0] + options.axes[1]);
  const std::int64_t thickness = band_thickness(dims[2], std::max<std::int64_t>(words, 1));
  const std::array<bool, 3> rays = {options.axes[0], options.axes[1], false};
  slabs_ = std::make_unique<Slabs>(TriangleBands(soup, dims, 2, thickness, rays, held_, context));
  held_ += slabs_->triangles.memory() +
           workspaces_at_once(context, slabs()) * Slabs::memory_of_workspace(dims, slices(0).size(), options);
  context.require_memory(held_, "voxelization");
}

ColumnVotes::~ColumnVotes() = default;

std::int64_t ColumnVotes::slabs() const {
  return slabs_->triangles.count();
}

IndexRange ColumnVotes::slices(std::int64_t slab) const {
  return slabs_->triangles.layers(slab);
}

void ColumnVotes::classify_along_z() {
  const Index3& dims = volume_.dims();
  const std::int64_t row_words = volume_.row_words();
  const std::int64_t thickness = band_thickness(dims[1], row_words * dims[2]);
  const TriangleBands bands(soup_, dims, 1, thickness, {false, false, true}, held_, context_);
  z_odd_.resize(static_cast<std::size_t>(dims[1] * row_words));
  held_ += z_odd_.size() * sizeof(BitWord);
  const std::int64_t layers_at_most = bands.layers(0).size();
  context_.require_memory(
      held_ + bands.memory() +
          workspaces_at_once(context_, bands.count()) * ColumnBlock<2>::memory(dims, layers_at_most, options_.stabbing),
      "voxelization");
  WorkspacePool<ColumnBlock<2>> pool;
  parallel_for(context_, 0, bands.count(), 1, [&](std::int64_t band, std::int64_t) {
    auto block = pool.take([&] { return ColumnBlock<2>(dims, layers_at_most, options_.stabbing); });
    const IndexRange rows = bands.layers(band);
    for_each_triangle(soup_, dims, bands.triangles(band), context_, [&](const auto& corners, const auto& centers) {
      return block->add(corners, soup_.bits(), centers, rows);
    });
    block->finish();
    const std::int64_t words = rows.size() * row_words;
    std::vector<BitWord> interior(static_cast<std::size_t>(words), 0);
    for (std::int64_t k = 0; k < dims[2]; ++k) {
      BitWord* toggles = block->toggles(0, k);
      BitWord* out = volume_.row(rows.first, k);
      for (std::int64_t w = 0; w < words; ++w) {
        out[w] = interior[static_cast<std::size_t>(w)] ^= toggles[w];
        toggles[w] = 0;
      }
    }
    std::copy_n(block->odd(0), words, z_odd_.begin() + rows.first * row_words);
    const auto counts = block->counts();
    columns_[2] += counts.met;
    odd_columns_[2] += counts.odd;
    block->clear();
    pool.give(std::move(block));
    stage_.advance(share(static_cast<std::int64_t>(soup_.triangles().size()), band, bands.count()));
  });
}

void ColumnVotes::classify_slab(std::int64_t slab, const RowConsumer& consume) {
  const Index3& dims = volume_.dims();
  const std::int64_t row_words = volume_.row_words();
  auto space = slabs_->pool.take([&] { return slabs_->make_workspace(dims, options_); });
  const IndexRange layers = slices(slab);
  for_each_triangle(soup_, dims, slabs_->triangles.triangles(slab), context_,
                    [&](const auto& corners, const auto& centers) {
                      std::int64_t samples = 0;
                      if (space->along_x) samples += space->along_x->add(corners, soup_.bits(), centers, layers);
                      if (space->along_y) samples += space->along_y->add(corners, soup_.bits(), centers, layers);
                      return samples;
                    });
  if (space->along_x) space->along_x->finish();
  if (space->along_y) space->along_y->finish();
  RowVotes votes;
  for (std::int64_t layer = 0; layer < layers.size(); ++layer) {
    const std::int64_t k = layers.first + layer;
    if (space->along_y) {
      std::ranges::fill(space->y_interior, 0);
      votes.interior[1] = space->y_interior.data();
      votes.abstains[1] = options_.odd_abstain ? space->along_y->odd(layer) : nobody_.data();
    }
    for (std::int64_t j = 0; j < dims[1]; ++j) {
      if (space->along_x) {
        BitWord* toggles = space->along_x->toggles(layer, j);
        BitWord before = 0;  // all bits: the parity of the row up to this word
        for (std::int64_t w = 0; w < row_words; ++w) {
          BitWord interior = before;
          if (toggles[w] != 0) {
            interior ^= prefix_parity(toggles[w]);
            before = spread(interior >> (kWordBits - 1) != 0);
            toggles[w] = 0;
          }
          space->x_interior[static_cast<std::size_t>(w)] = interior;
        }
        const bool abstains = options_.odd_abstain && space->along_x->is_odd(j, layer);
        if (abstains) std::ranges::fill(space->x_abstains, kAllBits);
        votes.interior[0] = space->x_interior.data();
        votes.abstains[0] = abstains ? space->x_abstains.data() : nobody_.data();
      }
      if (space->along_y) {
        BitWord* toggles = space->along_y->toggles(layer, j);
        for (std::int64_t w = 0; w < row_words; ++w) {
          space->y_interior[static_cast<std::size_t>(w)] ^= toggles[w];
          toggles[w] = 0;
        }
      }
      if (options_.axes[2]) {
        votes.interior[2] = volume_.row(j, k);
        votes.abstains[2] = options_.odd_abstain ? z_odd_.data() + j * row_words : nobody_.data();
      }
      consume(j, k, votes);
    }
  }
  const auto add_counts = [&](std::size_t axis, auto& block) {
    if (!block) return;
    const auto counts = block->counts();
    columns_[axis] += counts.met;
    odd_columns_[axis] += counts.odd;
    block->clear();
  };
  add_counts(0, space->along_x);
  add_counts(1, space->along_y);
  slabs_->pool.give(std::move(space));
  const auto triangles = static_cast<std::int64_t>(soup_.triangles().size());
  stage_.advance(share(triangles * (options_.axes[0] + options_.axes[1]), slab, slabs()));
}

}  // namespace voxcarve
