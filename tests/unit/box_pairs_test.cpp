#include "common/mesh/box_pairs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

#include "common/run/errors.h"
#include "tests/support/shapes.h"

namespace voxcarve {
namespace {

using Pairs = std::vector<std::array<std::uint32_t, 2>>;

/// By every two boxes and every axis.
Pairs slow_pairs(const std::vector<Box>& boxes) {
  Pairs pairs;
  for (std::uint32_t i = 0; i < boxes.size(); ++i) {
    for (std::uint32_t j = i + 1; j < boxes.size(); ++j) {
      bool overlap = true;
      for (const int axis : {0, 1, 2}) {
        if (boxes[i].upper[axis] < boxes[j].lower[axis] || boxes[j].upper[axis] < boxes[i].lower[axis]) overlap = false;
      }
      if (overlap) pairs.push_back({i, j});
    }
  }
  return pairs;
}

/// Sorted; a pair that is visited twice is in it twice.
Pairs visited_pairs(const std::vector<Box>& boxes) {
  const BoxPairs tree(boxes, RunContext());
  std::vector<std::uint32_t> order = tree.order();
  const RunContext context;
  Pairs pairs;
  for (std::size_t block = 0; block < tree.block_count(); ++block) {
    tree.visit_pairs(block, context, [&](std::size_t i, std::size_t j) {
      EXPECT_LT(i, j);
      EXPECT_EQ(i / BoxPairs::kBlockSize, block);
      pairs.push_back({std::min(order[i], order[j]), std::max(order[i], order[j])});
    });
  }
  std::sort(pairs.begin(), pairs.end());
  std::sort(order.begin(), order.end());
  for (std::uint32_t i = 0; i < boxes.size(); ++i) EXPECT_EQ(order.at(i), i);
  EXPECT_EQ(order.size(), boxes.size());
  return pairs;
}

Box box_around(const Point& center, const Point& half_size) {
  return {center - half_size, center + half_size};
}

/// Boxes of sizes over some powers of ten, in a cube; every fifth touches the one before.
std::vector<Box> random_boxes(std::size_t count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> share(0, 1);
  std::vector<Box> boxes;
  for (std::size_t i = 0; i < count; ++i) {
    const double size = std::pow(10, -3 * share(random));
    Box box = box_around(Point(share(random), share(random), share(random)),
                         size * Point(share(random), share(random), share(random)));
    if (i % 5 == 4) {
      box.lower[0] = boxes.back().upper[0];
      box.upper[0] = box.lower[0] + share(random);
    }
    boxes.push_back(box);
  }
  return boxes;
}

TEST(BoxPairs, EveryPairOnce) {
  // Around the sizes at which another block, node or level begins.
  for (const std::size_t count : {0, 1, 2, 7, 8, 9, 63, 64, 65, 66, 511, 512, 513, 520}) {
    SCOPED_TRACE(count);
    const std::vector<Box> boxes = random_boxes(count, count);
    ASSERT_EQ(visited_pairs(boxes), slow_pairs(boxes));
  }
  for (std::uint64_t seed = 0; seed < test::case_count(std::uint64_t{50}); ++seed) {
    SCOPED_TRACE(seed);
    const std::vector<Box> boxes = random_boxes(200 + seed, seed);
    ASSERT_EQ(visited_pairs(boxes), slow_pairs(boxes));
  }
}

TEST(BoxPairs, AtTheLimitsOfNumbers) {
  const double largest = std::numeric_limits<double>::max();
  const double least = std::numeric_limits<double>::denorm_min();
  std::mt19937_64 random(1);
  const auto draw = [&random](double scale) {
    return scale * (static_cast<double>(random() % 9) - 4);  // small multiples, so that many touch
  };
  for (const double scale : {least, 1e-300, 1e-150, 1e150, largest / 4}) {
    SCOPED_TRACE(scale);
    std::vector<Box> boxes;
    for (int i = 0; i < 100; ++i) {
      Box box;
      box.extend(Point(draw(scale), draw(scale), draw(scale)));
      box.extend(Point(draw(scale), draw(scale), draw(scale)));
      boxes.push_back(box);
    }
    ASSERT_EQ(visited_pairs(boxes), slow_pairs(boxes));
  }
  // One next to another by the least difference there is, and touching it.
  const std::vector<Box> boxes{box_around(Point(0, 0, 0), Point(1, 1, 1)),
                               {Point(std::nextafter(1.0, 2.0), 0, 0), Point(2, 1, 1)},
                               {Point(1, 0, 0), Point(1, 1, 1)},
                               {Point(least, 5, 5), Point(1, 6, 6)},
                               {Point(-1, 5, 5), Point(0, 6, 6)}};
  EXPECT_EQ(visited_pairs(boxes), (Pairs{{0, 2}}));
}

TEST(BoxPairs, EqualBoxes) {
  const std::vector<Box> boxes(30, box_around(Point(1, 2, 3), Point(1, 1, 1)));
  EXPECT_EQ(visited_pairs(boxes).size(), 30U * 29U / 2U);
}

TEST(BoxPairs, AClusterInACornerIsOrderedToo) {
  // Two boxes 1e30 apart, and at one of them a row of a thousand, 1e-30 apart. Along a straight row parallel to an axis
  // the codes grow with the coordinate; so does the order, if what falls into one cell is ordered by finer cells.
  std::vector<Box> boxes{box_around(Point(1e30, 1e30, 1e30), Point(1, 1, 1))};
  for (int i = 0; i < 1000; ++i) {
    boxes.push_back(box_around(Point(1e-30 * ((i * 7) % 1000), 0, 0), Point(0.6e-30, 0, 0)));
  }
  const BoxPairs tree(boxes, RunContext());
  double last = -1;
  for (std::size_t place = 0; place < 1000; ++place) {
    ASSERT_NE(tree.order()[place], 0U);
    const double x = boxes[tree.order()[place]].center()[0];
    ASSERT_GT(x, last);
    last = x;
  }
  EXPECT_EQ(visited_pairs(boxes).size(), 999U);  // each and the next
}

TEST(BoxPairs, AnyOverlap) {
  // Boxes of a fifth of a random size, and queries likewise: some hit, some do not.
  const auto small_boxes = [](std::uint64_t seed) {
    std::vector<Box> boxes = random_boxes(200, seed);
    for (Box& box : boxes) box = box_around(box.center(), 0.1 * box.extent());
    return boxes;
  };
  const std::vector<Box> boxes = small_boxes(3);
  const BoxPairs tree(boxes, RunContext());
  int hits = 0;
  for (const Box& query : small_boxes(4)) {
    const bool expected = std::any_of(boxes.begin(), boxes.end(), [&](const Box& box) {
      return !slow_pairs({query, box}).empty();
    });
    EXPECT_EQ(tree.any_overlaps(query), expected);
    hits += expected ? 1 : 0;
  }
  EXPECT_GT(hits, 30);
  EXPECT_LT(hits, 170);
  EXPECT_FALSE(BoxPairs({}, RunContext()).any_overlaps(boxes[0]));
}

TEST(BoxPairs, Cancels) {
  std::stop_source stop;
  RunContext context;
  context.cancellation = stop.get_token();
  stop.request_stop();
  const BoxPairs tree(std::vector<Box>(30, box_around(Point(0, 0, 0), Point(1, 1, 1))), RunContext());
  EXPECT_THROW(tree.visit_pairs(0, context, [](std::size_t, std::size_t) {}), Cancelled);
}

}  // namespace
}  // namespace voxcarve
