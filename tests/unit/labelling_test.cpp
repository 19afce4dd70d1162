// Component labelling by runs against its slow, obvious twin: flood fill, one voxel at a time.
#include "common/volume/labelling.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <random>
#include <vector>

#include "common/run/errors.h"
#include "common/volume/run_labelling.h"
#include "tests/support/shapes.h"

namespace voxcarve {
namespace {

using test::frame_of;
using test::random_volume;

constexpr Connectivity kConnectivities[] = {Connectivity::kFace, Connectivity::kEdge, Connectivity::kVertex};

std::vector<Index3> neighbour_offsets(Connectivity connectivity, bool image) {
  std::vector<Index3> offsets;
  const std::int64_t depth = image ? 0 : 1;
  for (std::int64_t z = -depth; z <= depth; ++z) {
    for (std::int64_t y = -1; y <= 1; ++y) {
      for (std::int64_t x = -1; x <= 1; ++x) {
        const std::int64_t differing = std::abs(x) + std::abs(y) + std::abs(z);
        if (differing > 0 && differing <= static_cast<std::int64_t>(connectivity)) offsets.emplace_back(x, y, z);
      }
    }
  }
  return offsets;
}

/// The twin of label_components.
Labelling flood_fill(const BinaryVolume& volume, std::uint8_t value, Connectivity connectivity) {
  Labelling result{Grid<std::int32_t>(volume.frame), 0};
  const std::vector<Index3> offsets = neighbour_offsets(connectivity, volume.frame.is_image());
  std::vector<Index3> front;
  for (std::int64_t k = 0; k < volume.nz(); ++k) {
    for (std::int64_t j = 0; j < volume.ny(); ++j) {
      for (std::int64_t i = 0; i < volume.nx(); ++i) {
        if (volume(i, j, k) != value || result.labels(i, j, k) != 0) continue;
        result.labels(i, j, k) = ++result.count;
        front.assign(1, Index3(i, j, k));
        while (!front.empty()) {
          const Index3 voxel = front.back();
          front.pop_back();
          for (const Index3& offset : offsets) {
            const Index3 next = voxel + offset;
            if (!volume.frame.contains(next) || volume(next[0], next[1], next[2]) != value) continue;
            std::int32_t& label = result.labels(next[0], next[1], next[2]);
            if (label != 0) continue;
            label = result.count;
            front.push_back(next);
          }
        }
      }
    }
  }
  return result;
}

/// The twin of count_exterior_components: with a margin of one voxel, through which the outside is connected.
std::int64_t flood_fill_exterior(const BinaryVolume& volume, Connectivity connectivity) {
  return flood_fill(resized(volume, padded(volume.frame, 1)), 0, connectivity).count;
}

BitVolume bits_of(const BinaryVolume& volume) {
  RunContext context;
  if (volume.values.empty()) return BitVolume(volume.frame.dims);
  return packed(volume, Index3::Zero(), false, context);
}

/// Runs are what the rows say, as long as they get, with the components of the twin.
void expect_runs(const RunLabelling& labelling, const Labelling& twin) {
  EXPECT_EQ(labelling.count(), twin.count);
  std::vector<std::int32_t> row;
  std::size_t runs_seen = 0;
  for (std::int64_t k = 0; k < twin.labels.nz(); ++k) {
    for (std::int64_t j = 0; j < twin.labels.ny(); ++j) {
      row.assign(static_cast<std::size_t>(twin.labels.nx()), 0);
      std::int32_t last_end = -1;
      for (const LabelledRun& run : labelling.runs_of_row(j, k)) {
        ASSERT_LT(last_end, run.begin);  // so that no run could have been longer
        ASSERT_LT(run.begin, run.end);
        ASSERT_LE(run.end, twin.labels.nx());
        std::fill(row.begin() + run.begin, row.begin() + run.end, run.component + 1);
        last_end = run.end;
        ++runs_seen;
      }
      ASSERT_TRUE(std::equal(row.begin(), row.end(), twin.labels.values.data() + twin.labels.index(0, j, k)))
          << "row " << j << ", " << k;
    }
  }
  EXPECT_EQ(labelling.runs().size(), runs_seen);
}

void expect_like_flood_fill(const BinaryVolume& volume, int threads) {
  RunContext context;
  context.threads = threads;
  for (const Connectivity connectivity : kConnectivities) {
    SCOPED_TRACE(testing::Message() << volume.frame.dims.transpose() << ", connectivity "
                                    << static_cast<int>(connectivity) << ", threads " << threads);
    const Labelling twin = flood_fill(volume, 1, connectivity);
    expect_runs(label_runs(bits_of(volume), connectivity, context), twin);
    const Labelling interior = label_components(volume, 1, connectivity, context);
    EXPECT_EQ(interior.count, twin.count);
    EXPECT_TRUE(interior.labels == twin.labels);
    const Labelling exterior_twin = flood_fill(volume, 0, connectivity);
    const Labelling exterior = label_components(volume, 0, connectivity, context);
    EXPECT_EQ(exterior.count, exterior_twin.count);
    EXPECT_TRUE(exterior.labels == exterior_twin.labels);
    EXPECT_EQ(count_interior_components(volume, connectivity, context), twin.count);
    EXPECT_EQ(count_exterior_components(volume, connectivity, context), flood_fill_exterior(volume, connectivity));
  }
}

/// Sets {i, j, k} for which `inside` says so.
template <class Inside>
BinaryVolume volume_of(const Index3& dims, const Inside& inside) {
  BinaryVolume volume(frame_of(dims));
  for (std::int64_t k = 0; k < volume.nz(); ++k) {
    for (std::int64_t j = 0; j < volume.ny(); ++j) {
      for (std::int64_t i = 0; i < volume.nx(); ++i) volume(i, j, k) = inside(i, j, k) ? 1 : 0;
    }
  }
  return volume;
}

std::int64_t components(const BinaryVolume& volume, Connectivity connectivity) {
  RunContext context;
  return count_interior_components(volume, connectivity, context);
}

// Sides lie around whole words along x and around the slabs (16 slices, 256 rows of an image) that threads share.
// Random volumes have the longest, most entangled components near the thresholds of percolation: 0.31, 0.14 and 0.10 in
// space by faces, edges and vertices, 0.59 and 0.41 in the plane.
constexpr double kFills[] = {0.03, 0.11, 0.14, 0.31, 0.45, 0.59, 0.7, 0.9, 0.99};

TEST(Labelling, AgreesWithFloodFillInSpace) {
  std::mt19937_64 random(1);
  const std::int64_t widths[] = {1, 2, 7, 63, 64, 65, 127, 128, 129};
  for (int trial = 0; trial < 150; ++trial) {
    const std::int64_t nx = widths[random() % std::size(widths)];
    const Index3 dims(nx, 1 + static_cast<std::int64_t>(random() % 9), 2 + static_cast<std::int64_t>(random() % 35));
    expect_like_flood_fill(random_volume(dims, kFills[random() % std::size(kFills)], random()), 1 + trial % 3);
    if (HasFailure()) break;
  }
}

TEST(Labelling, AgreesWithFloodFillInThePlane) {
  std::mt19937_64 random(2);
  const std::int64_t widths[] = {1, 2, 7, 63, 64, 65, 127, 128, 129, 192, 200};
  const std::int64_t heights[] = {1, 2, 3, 20, 60, 255, 256, 257, 513};
  for (int trial = 0; trial < 150; ++trial) {
    const Index3 dims(widths[random() % std::size(widths)], heights[random() % std::size(heights)], 1);
    expect_like_flood_fill(random_volume(dims, kFills[random() % std::size(kFills)], random()), 1 + trial % 3);
    if (HasFailure()) break;
  }
}

TEST(Labelling, AgreesWithFloodFillOnEverySmallVolume) {
  // All 2^9 images of 3 x 3 and all 2^12 volumes of 3 x 2 x 2.
  for (const Index3& dims : {Index3(3, 3, 1), Index3(3, 2, 2)}) {
    for (int pattern = 0; pattern < 1 << dims.prod(); ++pattern) {
      BinaryVolume volume(frame_of(dims));
      for (std::size_t i = 0; i < volume.values.size(); ++i) volume.values[i] = pattern >> i & 1;
      expect_like_flood_fill(volume, 1);
      if (HasFailure()) return;
    }
  }
}

TEST(Labelling, EmptyAndFullVolumes) {
  for (const Index3& dims : {Index3(1, 1, 1), Index3(64, 3, 1), Index3(65, 1, 40), Index3(128, 5, 33)}) {
    SCOPED_TRACE(dims.transpose());
    RunContext context;
    for (const Connectivity connectivity : kConnectivities) {
      const BinaryVolume empty(frame_of(dims), 0);
      EXPECT_EQ(count_interior_components(empty, connectivity, context), 0);
      EXPECT_EQ(count_exterior_components(empty, connectivity, context), 1);
      EXPECT_TRUE(label_runs(bits_of(empty), connectivity, context).runs().empty());
      const BinaryVolume full(frame_of(dims), 1);
      EXPECT_EQ(count_interior_components(full, connectivity, context), 1);
      EXPECT_EQ(count_exterior_components(full, connectivity, context), 1);
      const RunLabelling runs = label_runs(bits_of(full), connectivity, context);
      EXPECT_EQ(runs.runs().size(), static_cast<std::size_t>(dims[1] * dims[2]));
    }
    expect_like_flood_fill(BinaryVolume(frame_of(dims), 0), 2);
    expect_like_flood_fill(BinaryVolume(frame_of(dims), 1), 2);
  }
}

TEST(Labelling, GridsWithoutVoxels) {
  for (const Index3& dims : {Index3(0, 0, 0), Index3(0, 4, 3), Index3(4, 0, 3), Index3(4, 3, 0), Index3(0, 3, 1)}) {
    SCOPED_TRACE(dims.transpose());
    expect_like_flood_fill(BinaryVolume(frame_of(dims)), 1);
  }
}

TEST(Labelling, Checkerboards) {
  // No two voxels of a colour share a face; all of them are connected over edges. 66 * 6 * 34 / 2 = 6732 of each.
  const BinaryVolume board =
      volume_of({66, 6, 34}, [](std::int64_t i, std::int64_t j, std::int64_t k) { return (i + j + k) % 2 == 0; });
  EXPECT_EQ(components(board, Connectivity::kFace), 6732);
  EXPECT_EQ(components(board, Connectivity::kEdge), 1);
  EXPECT_EQ(components(board, Connectivity::kVertex), 1);
  RunContext context;
  // Each voxel of the other colour off the border is a component by itself: half of 64 * 4 * 32, which is 4096.
  EXPECT_EQ(count_exterior_components(board, Connectivity::kFace, context), 4097);
  EXPECT_EQ(count_exterior_components(board, Connectivity::kEdge, context), 1);
  expect_like_flood_fill(board, 2);

  // Voxels with all coordinates even or all odd touch at vertices alone: 33 * 3 * 17 of each kind.
  const BinaryVolume vertices = volume_of(
      {66, 6, 34}, [](std::int64_t i, std::int64_t j, std::int64_t k) { return i % 2 == j % 2 && j % 2 == k % 2; });
  EXPECT_EQ(components(vertices, Connectivity::kFace), 2 * 33 * 3 * 17);
  EXPECT_EQ(components(vertices, Connectivity::kEdge), 2 * 33 * 3 * 17);
  EXPECT_EQ(components(vertices, Connectivity::kVertex), 1);
}

/// A corridor one voxel wide that turns inwards until it has no room left, with walls as wide between its turns.
BinaryVolume spiral(std::int64_t side) {
  BinaryVolume image(frame_of({side, side, 1}));
  Index3 at(0, 0, 0);
  Index3 step(1, 0, 0);
  const auto free = [&](const Index3& place) {
    return image.frame.contains(place) && image(place[0], place[1], 0) == 0;
  };
  image(0, 0, 0) = 1;
  for (int turns = 0; turns < 2;) {
    // Walks on while the place after next is not the corridor itself.
    const Index3 next = at + step;
    const Index3 after = next + step;
    if (free(next) && (free(after) || !image.frame.contains(after))) {
      at = next;
      image(at[0], at[1], 0) = 1;
      turns = 0;
    } else {
      step = Index3(-step[1], step[0], 0);
      ++turns;
    }
  }
  return image;
}

TEST(Labelling, SpiralsAreOneComponentAndSoAreTheirWalls) {
  for (const std::int64_t side : {5, 63, 64, 65, 301}) {
    SCOPED_TRACE(side);
    const BinaryVolume image = spiral(side);
    // About half of the plane; the walls open to the outside at the beginning of the corridor.
    EXPECT_GT(count_interior(image), side * side * 2 / 5);
    EXPECT_EQ(components(image, Connectivity::kFace), 1);
    RunContext context;
    EXPECT_EQ(count_exterior_components(image, Connectivity::kFace, context), 1);
    expect_like_flood_fill(image, 2);
    // Through 40 slices, each of which is a component but for a passage at its end or its beginning, by turns.
    if (side > 65) continue;
    const Index3 dims(side, side, 81);
    const auto last = std::find(image.values.rbegin(), image.values.rend(), 1);  // some voxel of the spiral
    const std::int64_t place = image.values.rend() - last - 1;
    const BinaryVolume winding = volume_of(dims, [&](std::int64_t i, std::int64_t j, std::int64_t k) {
      if (k % 2 == 0) return image(i, j, 0) != 0;
      return k % 4 == 1 ? j * side + i == place : i == 0 && j == 0;
    });
    EXPECT_EQ(components(winding, Connectivity::kFace), 1);
    if (side <= 5) expect_like_flood_fill(winding, 2);
  }
}

TEST(Labelling, TeethMeetInTheLastRow) {
  // Teeth one voxel thick, four voxels apart, which become one in the last slice or row: across all slabs.
  const BinaryVolume comb = volume_of({130, 9, 70}, [](std::int64_t i, std::int64_t j, std::int64_t k) {
    return (i % 4 == 0 && j % 4 == 0) || k == 69;
  });
  const BinaryVolume rake =
      volume_of({130, 800, 1}, [](std::int64_t i, std::int64_t j, std::int64_t) { return i % 4 == 0 || j == 799; });
  for (const Connectivity connectivity : kConnectivities) {
    EXPECT_EQ(components(comb, connectivity), 1);
    EXPECT_EQ(components(rake, connectivity), 1);
  }
  expect_like_flood_fill(comb, 2);
  expect_like_flood_fill(rake, 2);
  // Without it they are 33 * 3 and 33 teeth.
  BinaryVolume teeth = comb;
  for (std::int64_t j = 0; j < 9; ++j) {
    for (std::int64_t i = 0; i < 130; ++i) teeth(i, j, 69) = 0;
  }
  EXPECT_EQ(components(teeth, Connectivity::kVertex), 99);
}

TEST(Labelling, ExteriorBeyondTheBorder) {
  // A cross through the whole image cuts the exterior of the grid into four, which are one outside it; a ring shuts in
  // one more.
  RunContext context;
  BinaryVolume image =
      volume_of({9, 9, 1}, [](std::int64_t i, std::int64_t j, std::int64_t) { return i == 4 || j == 4; });
  EXPECT_EQ(label_components(image, 0, Connectivity::kEdge, context).count, 4);
  EXPECT_EQ(count_exterior_components(image, Connectivity::kEdge, context), 1);
  for (const auto& [i, j] : {std::pair{5, 6}, {6, 6}, {6, 5}}) image(i, j, 0) = 1;
  EXPECT_EQ(count_exterior_components(image, Connectivity::kFace, context), 2);
  // The hole of a ring is open to the front and to the back in space, and shut in within its plane.
  const BinaryVolume ring =
      volume_of({3, 3, 2}, [](std::int64_t i, std::int64_t j, std::int64_t) { return i != 1 || j != 1; });
  EXPECT_EQ(count_exterior_components(ring, Connectivity::kFace, context), 1);
  const BinaryVolume flat_ring =
      volume_of({3, 3, 1}, [](std::int64_t i, std::int64_t j, std::int64_t) { return i != 1 || j != 1; });
  EXPECT_EQ(count_exterior_components(flat_ring, Connectivity::kFace, context), 2);
}

TEST(RunLabelling, SameForEveryNumberOfThreads) {
  const BitVolume bits = bits_of(random_volume({100, 40, 90}, 0.31, 5));
  for (const Connectivity connectivity : kConnectivities) {
    RunContext one;
    const RunLabelling expected = label_runs(bits, connectivity, one);
    for (const int threads : {2, 5}) {
      RunContext context;
      context.threads = threads;
      const RunLabelling found = label_runs(bits, connectivity, context);
      EXPECT_EQ(found.count(), expected.count());
      EXPECT_TRUE(std::ranges::equal(found.runs(), expected.runs(), [](const LabelledRun& a, const LabelledRun& b) {
        return a.begin == b.begin && a.end == b.end && a.component == b.component;
      }));
    }
  }
}

TEST(RunLabelling, DeclaresItsMemory) {
  // 3 runs in each of 20 rows of one word: 12 bytes a run, 4 a row and one more, 8 bytes a word.
  const BitVolume bits =
      bits_of(volume_of({6, 5, 4}, [](std::int64_t i, std::int64_t, std::int64_t) { return i % 2 == 0; }));
  constexpr std::uint64_t kHeld = 1000;
  constexpr std::uint64_t kOwn = 60 * 12 + 21 * 4;
  RunContext context;
  {
    const Stage stage(context, "labelling", 1);
    EXPECT_EQ(label_runs(bits, Connectivity::kFace, context, kHeld).memory(), kOwn);
  }
  EXPECT_EQ(context.timings().back().bytes, kHeld + kOwn + 20 * 8);
  context.memory_budget = kHeld + kOwn + 20 * 8;
  EXPECT_NO_THROW(label_runs(bits, Connectivity::kFace, context, kHeld));
  --context.memory_budget;
  EXPECT_THROW(label_runs(bits, Connectivity::kFace, context, kHeld), ResourceError);
}

TEST(RunLabelling, StopsOnRequest) {
  const BinaryVolume volume = random_volume({20, 20, 20}, 0.5, 1);
  RunContext context;
  std::stop_source source;
  context.cancellation = source.get_token();
  EXPECT_NO_THROW(label_components(volume, 1, Connectivity::kFace, context));
  source.request_stop();
  EXPECT_THROW(label_components(volume, 1, Connectivity::kFace, context), Cancelled);
  EXPECT_THROW(label_runs(bits_of(volume), Connectivity::kFace, context), Cancelled);
}

TEST(RunLabelling, BitsOfRuns) {
  constexpr std::int64_t kLength = 200;
  const BitVolume bits = bits_of(random_volume({kLength, 1, 1}, 0.5, 3));
  for (std::int64_t begin = 0; begin <= kLength; ++begin) {
    for (std::int64_t end = begin; end <= kLength; ++end) {
      BitVolume set = bits;
      BitVolume cleared = bits;
      set_bits(set.row(0, 0), begin, end);
      clear_bits(cleared.row(0, 0), begin, end);
      std::int64_t count = 0;
      bool right = true;
      for (std::int64_t i = 0; i < kLength; ++i) {
        const bool within = begin <= i && i < end;
        count += within && bits.get(i, 0, 0) ? 1 : 0;
        right = right && set.get(i, 0, 0) == (within || bits.get(i, 0, 0));
        right = right && cleared.get(i, 0, 0) == (!within && bits.get(i, 0, 0));
      }
      ASSERT_EQ(count_bits(bits.row(0, 0), begin, end), count) << begin << " " << end;
      ASSERT_TRUE(right) << begin << " " << end;
    }
  }
}

}  // namespace
}  // namespace voxcarve
