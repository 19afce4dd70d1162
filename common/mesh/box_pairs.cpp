// Boxes along Morton's curve, after Lauterbach et al., "Fast BVH construction on GPUs", 2009; differs in that blocks
// and nodes have a fixed number of members instead of a common code, and that boxes of one code are ordered by finer
// ones.
#include "common/mesh/box_pairs.h"

#include <numeric>

namespace voxcarve {

namespace {

constexpr int kBitsAnAxis = 18;
constexpr int kBitsADigit = 11;  // 3 * 18 bits are five of them
constexpr std::size_t kDigits = std::size_t{1} << kBitsADigit;

struct Coded {
  std::uint64_t code;
  std::uint32_t box;
};

/// Puts two zero bits after every bit.
std::uint64_t spread(std::uint64_t bits) {
  bits = (bits | bits << 32) & 0x001f00000000ffff;
  bits = (bits | bits << 16) & 0x001f0000ff0000ff;
  bits = (bits | bits << 8) & 0x100f00f00f00f00f;
  bits = (bits | bits << 4) & 0x10c30c30c30c30c3;
  return (bits | bits << 2) & 0x1249249249249249;
}

/// Halves first: the sum of two coordinates, or their difference, may be too large for a number.
Point center_of(const Box& box) {
  return 0.5 * box.lower + 0.5 * box.upper;
}

/// By code; items of one code stay in their order.
void sort_by_code(std::vector<Coded>& items, std::vector<Coded>& other) {
  other.resize(items.size());
  for (int shift = 0; shift < 3 * kBitsAnAxis; shift += kBitsADigit) {
    std::array<std::uint32_t, kDigits> place{};
    for (const Coded& item : items) ++place[(item.code >> shift) % kDigits];
    std::exclusive_scan(place.begin(), place.end(), place.begin(), 0U);
    for (const Coded& item : items) other[place[(item.code >> shift) % kDigits]++] = item;
    items.swap(other);
  }
}

/// Orders boxes along Morton's curve through the box of their centres; those in one of its cells along a finer one.
void sort_along_curve(const std::vector<Box>& boxes, std::uint32_t* order, std::size_t count,
                      const RunContext& context) {
  context.check_cancelled();
  Box range;
  for (std::size_t i = 0; i < count; ++i) range.extend(center_of(boxes[order[i]]));
  const double half_extent = (0.5 * range.upper - 0.5 * range.lower).maxCoeff();
  if (!(half_extent > 0)) return;
  constexpr double kCells = 1 << kBitsAnAxis;
  std::vector<Coded> items;
  items.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const Point share = (0.5 * center_of(boxes[order[i]]) - 0.5 * range.lower) / half_extent;
    std::uint64_t code = 0;
    for (const Eigen::Index axis : {0, 1, 2}) {
      code = code << 1 | spread(static_cast<std::uint64_t>(std::min(share[axis] * kCells, kCells - 1)));
    }
    items.push_back({code, order[i]});
  }
  {
    std::vector<Coded> other;
    sort_by_code(items, other);
  }
  std::vector<std::size_t> long_runs;  // begin and end of each
  for (std::size_t begin = 0, end = 0; begin < count; begin = end) {
    while (end < count && items[end].code == items[begin].code) order[end] = items[end].box, ++end;
    if (end - begin > BoxPairs::kBlockSize) long_runs.insert(long_runs.end(), {begin, end});
  }
  std::vector<Coded>().swap(items);  // assigning {} would keep the memory
  // The smallest and the largest centre along the widest axis have different codes, so runs are shorter than this.
  for (std::size_t i = 0; i < long_runs.size(); i += 2) {
    sort_along_curve(boxes, order + long_runs[i], long_runs[i + 1] - long_runs[i], context);
  }
}

}  // namespace

template <class BoxAt>
std::vector<BoxPairs::Group> BoxPairs::grouped(std::size_t count, const BoxAt& box_at) {
  std::vector<Group> groups((count + kBlockSize - 1) / kBlockSize);
  for (std::size_t i = 0; i < groups.size() * kBlockSize; ++i) {
    const Box box = i < count ? box_at(i) : Box();  // an empty one is infinitely far from all
    for (const std::size_t axis : {0U, 1U, 2U}) {
      groups[i / kBlockSize].lower[axis][i % kBlockSize] = box.lower[static_cast<Eigen::Index>(axis)];
      groups[i / kBlockSize].upper[axis][i % kBlockSize] = box.upper[static_cast<Eigen::Index>(axis)];
    }
  }
  return groups;
}

BoxPairs::BoxPairs(const std::vector<Box>& boxes, const RunContext& context) : order_(boxes.size()) {
  if (boxes.empty()) return;
  std::iota(order_.begin(), order_.end(), 0U);
  sort_along_curve(boxes, order_.data(), order_.size(), context);
  context.check_cancelled();
  const auto box_at = [&](std::size_t place) -> const Box& { return boxes[order_[place]]; };
  levels_.push_back(grouped(boxes.size(), box_at));
  do {
    std::vector<Box> around(levels_.back().size());
    for (std::size_t i = 0; i < around.size(); ++i) around[i] = levels_.back()[i].bounds();
    levels_.push_back(grouped(around.size(), [&](std::size_t i) -> const Box& { return around[i]; }));
  } while (levels_.back().size() > 1);
}

}  // namespace voxcarve
